//! What voids a result in the cache: a change of what code does, and of nothing else in it.

#[path = "../build/source.rs"]
mod source;

use source::{add, meaning};
use std::path::Path;

const CODE: &str = r#"
use std::fmt;

fn area(side: f64) -> f64 {
    assert!(side >= 0.0, "a side");
    side * side
}
"#;

fn rust(text: &str) -> Vec<u8> {
    meaning(Path::new("x.rs"), text.as_bytes().to_vec())
}

#[test]
fn comments_documentation_layout_and_test_modules_do_not_count() {
    let same = [
        format!("//! What it is.\n{CODE}"),
        CODE.replace("fn area", "/// Of a square.\n// Why so.\n#[doc(hidden)]\nfn area"),
        CODE.replace("    side * side", "\n\n\tside  /* squared */  *\n side"),
        format!(
            "{CODE}\n#[cfg(test)]\nmod tests {{\n    use super::*;\n    #[test]\n    fn none() {{}}\n}}\n"
        ),
        format!("{CODE}\n#[cfg(test)]\n#[expect(unused, reason = \"x\")]\npub(crate) mod tests;\n"),
    ];
    for text in same {
        assert_eq!(rust(&text), rust(CODE), "{text}");
    }
}

#[test]
fn whatever_changes_what_code_does_counts() {
    let others = [
        CODE.replace("side * side", "side + side"),
        CODE.replace("0.0", "0.5"),
        CODE.replace("a side", "a  side"),
        CODE.replace("area", "areas"),
        CODE.replace("(side: f64)", "[side: f64]"),
        CODE.replace("use std::fmt;", "use std::fmt; use std::io;"),
        CODE.replace(">=", "> ="),
        CODE.replace("fn area", "#[inline]\nfn area"),
        CODE.replace("fn area", "#[cfg(test)]\nfn area"),
        CODE.replace("fn area", "#[cfg(unix)]\nmod a {}\nfn area"),
        format!("{CODE}mod tests {{}}"),
        "no { rust".to_owned(),
    ];
    let mut seen = vec![rust(CODE)];
    for text in others {
        let meaning = rust(&text);
        assert!(!seen.contains(&meaning), "{text}");
        seen.push(meaning);
    }
}

#[test]
fn settings_count_line_by_line_and_other_files_by_every_byte() {
    let of = |name: &str, text: &str| meaning(Path::new(name), text.as_bytes().to_vec());
    assert_eq!(of("Cargo.toml", "# why\n\n[a]\nb = 1\n"), of("Cargo.toml", "[a]\n  b = 1"));
    assert_ne!(of("Cargo.toml", "[a]\nb = 1\n"), of("Cargo.toml", "[a]\nb = 2\n"));
    assert_ne!(of("x.wgsl", "// why\na"), of("x.wgsl", "a"));
}

#[test]
fn of_a_folder_every_file_counts_by_name_but_those_of_tests() {
    let folder = tempfile::tempdir().unwrap();
    let hash = || {
        let mut hasher = blake3::Hasher::new();
        add(&mut hasher, folder.path()).unwrap();
        hasher.finalize()
    };
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir_all(at("deep/tests")).unwrap();
    std::fs::write(at("deep/a.rs"), CODE).unwrap();
    let before = hash();
    std::fs::write(at("deep/tests/b.rs"), CODE).unwrap();
    std::fs::write(at("deep/a.rs"), format!("// why\n{CODE}")).unwrap();
    assert_eq!(hash(), before);
    std::fs::rename(at("deep/a.rs"), at("deep/c.rs")).unwrap();
    assert_ne!(hash(), before);
    assert!(add(&mut blake3::Hasher::new(), &at("none")).is_err());
}

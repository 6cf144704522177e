//! Text -> a checked value, or every reason why not.

use super::range::Ranges;
use super::words::Words;
use super::{MAX_BYTES, SceneFileError};
use garde::Validate;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use std::io::ErrorKind;
use std::path::Path;
use vantage_dataset::store::read_regular;

/// Reads and checks a scene file of any shape `T`. It has to be a regular file, of which no more than [`MAX_BYTES`] are ever read.
pub fn read<T>(path: &Path) -> Result<T, SceneFileError>
where
    T: DeserializeOwned + JsonSchema + Validate<Context = ()>,
{
    parse(&text(path)?, path)
}

/// The text of a scene file.
pub(super) fn text(path: &Path) -> Result<String, SceneFileError> {
    let bytes = read_regular(path, MAX_BYTES).map_err(|source| match source.kind() {
        ErrorKind::FileTooLarge => SceneFileError::TooLarge { path: path.to_owned() },
        _ => SceneFileError::Unreadable { path: path.to_owned(), source },
    })?;
    String::from_utf8(bytes).map_err(|error| SceneFileError::NotText {
        path: path.to_owned(),
        offset: error.utf8_error().valid_up_to(),
    })
}

/// Checks the text of a scene file; `path` is for messages only.
///
/// Unknown and doubled keys, NaN and infinities anywhere, aliases that explode and more than one document are refused.
/// Of the ranges, all that are violated are reported at once.
pub fn parse<T>(text: &str, path: &Path) -> Result<T, SceneFileError>
where
    T: DeserializeOwned + JsonSchema + Validate<Context = ()>,
{
    let checked = serde_saphyr::from_str_with_options_valid::<T>(text, options()).and_then(|scene| {
        // Typed numbers take `.nan`, and ranges let it pass. Where a field has no rule against it, this is the wall:
        // read untyped, the file may hold no number that is not finite.
        serde_saphyr::from_str_with_options::<serde_json::Value>(text, options()).map(|_| scene)
    });
    checked.map_err(|error| {
        let name = path.to_string_lossy();
        let ranges = Ranges::of::<T>();
        let formatter = Words(&ranges);
        let render = serde_saphyr::render_options! {
            formatter: &formatter,
            source_name: Some(name.as_ref()),
        };
        SceneFileError::Invalid { path: path.to_owned(), message: error.render_with_options(render) }
    })
}

pub(super) fn options() -> serde_saphyr::Options {
    serde_saphyr::options! {
        budget: serde_saphyr::budget! { max_nodes: 20_000, max_depth: 32, max_aliases: 100 },
        duplicate_keys: serde_saphyr::options::DuplicateKeyPolicy::Error,
        non_finite_float_policy: serde_saphyr::options::NonFiniteFloatPolicy::Reject,
        reject_unsupported_tags: true,
        strict_booleans: true,
    }
}

#[cfg(test)]
mod tests {
    use super::super::{EvaluationSpec, hash, is_file_name, is_known_version};
    use super::*;
    use serde::{Deserialize, Serialize};

    const GOOD: &str = "version: 1\nname: tabletop\npurpose: To show it.\nevaluation:\n  seeds: 10\n";

    /// The head of a scene, without the sections of the other rooms.
    #[derive(Clone, Debug, Serialize, Deserialize, JsonSchema, Validate)]
    #[serde(deny_unknown_fields)]
    struct Head {
        #[garde(custom(is_known_version))]
        version: u32,
        #[garde(custom(is_file_name))]
        name: String,
        #[garde(length(min = 1, max = 1000))]
        purpose: String,
        #[garde(dive)]
        evaluation: EvaluationSpec,
    }

    /// A section such as the other rooms define.
    #[derive(Debug, Serialize, Deserialize, JsonSchema, Validate)]
    #[serde(deny_unknown_fields)]
    struct World {
        #[garde(range(min = 0.01, max = 10.0))]
        mass: f64,
        #[garde(dive)]
        shapes: Vec<Shape>,
        #[serde(default)]
        #[garde(dive)]
        surface: Option<Surface>,
    }

    /// A choice that the YAML names by a key, and the path of a violation does not.
    #[derive(Debug, Serialize, Deserialize, JsonSchema, Validate)]
    #[serde(rename_all = "snake_case", deny_unknown_fields)]
    enum Surface {
        Table {
            #[garde(range(min = 0.1))]
            height: f64,
            #[serde(default)]
            #[garde(range(min = -1.0, max = 2.0))]
            width: f64,
        },
        Board {
            #[garde(range(min = -1.0, max = 3.0))]
            width: f64,
        },
    }

    #[derive(Debug, Serialize, Deserialize, JsonSchema, Validate)]
    #[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
    enum Shape {
        Box {
            #[garde(range(min = 0.0))]
            side: f64,
        },
    }

    fn error<T: DeserializeOwned + JsonSchema + Validate<Context = ()> + std::fmt::Debug>(
        yaml: &str,
    ) -> String {
        parse::<T>(yaml, Path::new("scenes/x.yaml")).unwrap_err().to_string()
    }

    #[test]
    fn a_scene_is_read_and_its_hash_ignores_comments_only() {
        let scene: Head = parse(GOOD, Path::new("x")).unwrap();
        assert_eq!(scene.evaluation.seeds.as_slice().len(), 10);
        let same: Head = parse(&format!("# why\n{GOOD}"), Path::new("y")).unwrap();
        let other: Head = parse(&GOOD.replace("10", "11"), Path::new("x")).unwrap();
        assert_eq!(hash(&scene).unwrap(), hash(&same).unwrap());
        assert_ne!(hash(&scene).unwrap(), hash(&other).unwrap());
    }

    #[test]
    fn each_fault_is_named_with_file_line_and_column() {
        let cases = [
            (GOOD.replace("purpose", "purposes"), "purposes", ":3:1"),
            (format!("{GOOD}name: again\n"), "name", ":6:1"),
            (GOOD.replace("seeds: 10", "seeds: ten"), "a number of seeds", ":5:"),
            (GOOD.replace("version: 1", "version: one"), "a whole number, 0 or more", ":1:10"),
            (GOOD.replace("version: 1", "version: -1"), "a whole number, 0 or more", ":1:10"),
            (GOOD.replace("version: 1", "version: [1]"), "a single value, no list or mapping", ":1:10"),
            (GOOD.replace("version: 1", "version:"), "a whole number", ":1:"),
            (GOOD.replace("name: tabletop", "name: [tabletop"), "", ":"),
            (GOOD.replace("  seeds", "\tseeds"), "tab", ":5:"),
            (GOOD.replace("seeds: 10", "seeds: .nan"), ".nan", ":5:10"),
            (format!("{GOOD}---\n{GOOD}"), "document", ":"),
            (GOOD.replace("evaluation:\n  seeds: 10\n", ""), "evaluation", ":"),
        ];
        for (yaml, names, position) in cases {
            let message = error::<Head>(&yaml);
            assert!(message.contains(names), "{names:?} not in: {message}");
            assert!(message.contains(&format!("scenes/x.yaml{position}")), "{position} not in: {message}");
        }
        assert!(error::<Head>("").contains("end of file"));
    }

    #[test]
    fn all_violations_are_reported_at_once() {
        let yaml = GOOD.replace("version: 1", "version: 3").replace("tabletop", "../../etc");
        let message = error::<Head>(&yaml);
        assert!(message.contains("format 3 is unknown") && message.contains(":1:10"), "{message}");
        assert!(message.contains("is no scene name") && message.contains(":2:7"), "{message}");
    }

    #[test]
    fn violations_inside_lists_of_tagged_shapes_have_their_place() {
        let yaml = "mass: 0\nshapes:\n  - kind: box\n    side: 1\n  - kind: box\n    side: -2\n";
        let message = error::<World>(yaml);
        assert!(message.contains(":1:7"), "{message}");
        assert!(message.contains("shapes[1].side"), "{message}");
        let message = error::<World>("mass: 1\nshapes: []\nsurface:\n  table:\n    height: 0\n");
        assert!(message.contains(":4:3") && message.contains("surface.height"), "{message}");
        for mass in [".nan", "-.inf", ".inf", "1e999"] {
            let message = error::<World>(&format!("mass: {mass}\nshapes: []\n"));
            assert!(message.contains(":1:7"), "{message}");
        }
        assert!(error::<World>("mass: 1\nshapes: [{kind: ball}]\n").contains("ball"));
        assert!(error::<World>("mass: heavy\nshapes: []\n").contains("expected a number"));
        let both = "mass: 1\nshapes: []\nsurface: { table: { height: 1 }, board: { width: 1 } }\n";
        let message = error::<World>(both);
        assert!(message.contains("expected one choice") && message.contains(":3:"), "{message}");
    }

    #[test]
    fn a_number_that_is_out_of_its_range_is_told_both_ends() {
        let table = |width: &str| {
            format!("mass: 1\nshapes: []\nsurface:\n  table: {{ height: 1, width: {width} }}\n")
        };
        let board = |width: &str| table(width).replace("table: { height: 1, ", "board: { ");
        let cases = [
            ("mass: 11\nshapes: []\n".to_owned(), "greater than 10 for `mass`, expected 0.01 to 10"),
            ("mass: 0\nshapes: []\n".to_owned(), "lower than 0.01 for `mass`, expected 0.01 to 10"),
            (table("2.5"), "greater than 2 for `surface.width`, expected -1 to 2"),
            (board("4"), "greater than 3 for `surface.width`, expected -1 to 3"),
        ];
        for (yaml, words) in cases {
            let message = error::<World>(&yaml);
            assert!(message.contains(words), "{words:?} not in: {message}");
        }
        // Of two variants with ranges that begin alike there is no telling which it is, nor of a rule with one end what the other is.
        for yaml in [table("-2"), table("1").replace("height: 1", "height: 0")] {
            let message = error::<World>(&yaml);
            assert!(message.contains("lower than") && !message.contains("expected"), "{message}");
        }
    }

    #[test]
    fn bombs_are_refused_without_being_read_or_expanded() {
        let mut bomb = String::from("a: &a [x, x, x, x, x, x, x, x, x]\n");
        for (name, inner) in
            [("b", "a"), ("c", "b"), ("d", "c"), ("e", "d"), ("f", "e"), ("g", "f"), ("h", "g")]
        {
            let aliases = vec![format!("*{inner}"); 9].join(", ");
            bomb += &format!("{name}: &{name} [{aliases}]\n");
        }
        let start = std::time::Instant::now();
        assert!(!error::<Head>(&bomb).is_empty());
        assert!(!error::<Head>(&"[".repeat(100_000)).is_empty());
        assert!(start.elapsed().as_secs() < 5);

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("large.yaml");
        std::fs::write(&path, vec![b'#'; MAX_BYTES as usize + 1]).unwrap();
        assert!(matches!(read::<Head>(&path), Err(SceneFileError::TooLarge { .. })));
        std::fs::write(&path, [b'a', 0xff]).unwrap();
        assert!(matches!(read::<Head>(&path), Err(SceneFileError::NotText { offset: 1, .. })));
        #[cfg(unix)]
        {
            let pipe = folder.path().join("pipe.yaml");
            assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
            assert!(read::<Head>(&pipe).unwrap_err().to_string().contains("not a regular file"));
        }
        let missing = read::<Head>(&folder.path().join("missing.yaml")).unwrap_err();
        assert!(missing.to_string().contains("missing.yaml"));
        assert!(matches!(read::<Head>(folder.path()), Err(SceneFileError::Unreadable { .. })));
    }
}

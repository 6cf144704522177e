//! What a command says in the end: where which of its files lie.

use std::path::Path;

/// A line for each file, under the word for its kind.
pub fn places<'a>(folder: &Path, kinds: impl IntoIterator<Item = (&'a str, Vec<&'a str>)>) -> String {
    let mut text = String::new();
    for (kind, files) in kinds {
        for (index, file) in files.iter().enumerate() {
            let word = if index == 0 { kind } else { "" };
            text += &format!("{word:<14}{}\n", folder.join(file).display());
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_has_its_path_and_every_kind_is_named_once() {
        let text =
            places(Path::new("out/x"), [("tables", vec!["t.md"]), ("pictures", vec!["a.svg", "b.svg"])]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "tables        out/x/t.md");
        assert_eq!(lines[1..], ["pictures      out/x/a.svg", "              out/x/b.svg"]);
    }
}

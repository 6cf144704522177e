//! The files of a finished run: results, tables, rows, manifest.

use crate::error::BenchError;
use crate::manifest::{self, Manifest};
use crate::output::OutputFolder;
use crate::render::{Style, csv, tables};
use crate::results::{self, Results};
use std::path::Path;

/// Writes `<scene>/results.json`, `<scene>/tables.md` and `<scene>/<table>.csv`, and, last, `<scene>/manifest.json`.
pub fn write(out: &OutputFolder, results: &Results, manifest: &Manifest) -> Result<(), BenchError> {
    let folder = Path::new(&results.scene);
    let mut markdown = format!("# {}\n", results.scene);
    if let Some(caveat) = &manifest.caveat {
        markdown += &format!("\n{caveat}\n");
    }
    for table in &results.tables {
        markdown += &format!("\n{}", tables(table, Style::Markdown));
        out.write(folder.join(format!("{}.csv", table.name())), &csv(table)?)?;
    }
    out.write(folder.join("tables.md"), markdown.as_bytes())?;
    out.write(folder.join(results::FILE_NAME), results.to_json()?.as_bytes())?;
    out.write(folder.join(manifest::FILE_NAME), manifest.to_json()?.as_bytes())?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::tests::{runs, table};
    use vantage_dataset::Seed;

    #[test]
    fn equal_inputs_write_equal_bytes_but_for_the_manifest() {
        let folder = tempfile::tempdir().unwrap();
        let files = |name: &str, runs| {
            let out = OutputFolder::probe(&folder.path().join(name)).unwrap();
            let results = Results::new("tabletop", "abc", vec![table(runs).unwrap()]);
            write(&out, &results, &Manifest::new("abc", &[Seed(0)])).unwrap();
            ["results.json", "tables.md", "trajectory.csv"]
                .map(|file| std::fs::read(out.path().join("tabletop").join(file)).unwrap())
        };
        let mut reversed = runs();
        reversed.reverse();
        assert_eq!(files("a", runs()), files("b", reversed));
        let manifest = Manifest { caveat: Some("Mind this.".into()), ..Manifest::new("abc", &[Seed(0)]) };
        let out = OutputFolder::probe(&folder.path().join("c")).unwrap();
        write(&out, &Results::new("tabletop", "abc", vec![table(runs()).unwrap()]), &manifest).unwrap();
        let text = std::fs::read_to_string(folder.path().join("c/tabletop/tables.md")).unwrap();
        assert!(text.starts_with("# tabletop\n\nMind this.\n\n"), "{text}");
        assert_eq!(Results::read(&folder.path().join("a/tabletop")).unwrap().tables.len(), 1);
    }
}

//! What a result is made of: raw scores and tables.

use super::error::SaveError;
use crate::result::folder::ResultFolder;
use crate::result::gains_text::gains;
use crate::result::grid::Style;
use crate::result::manifest::Manifest;
use crate::result::results_file::{self, Results};
use crate::result::summary_text;
use crate::result::table::Table;
use crate::result::table_text::tables;
use crate::score::trajectory_scores::TRAJECTORIES;

/// Name of the file of all tables.
pub const TABLES: &str = "tables.md";

/// All tables as Markdown, each with its gains over the reference, under the hash of the model that was scored, what a reader has to
/// know of it, and what it does to the ATE.
pub fn markdown(results: &Results, model: Option<&str>, caveat: Option<&str>) -> String {
    let model = model.map(|hash| format!("\nScored model: {hash}\n")).unwrap_or_default();
    let caveat = caveat.map(|caveat| format!("\n{caveat}\n")).unwrap_or_default();
    let answers = results.table(TRAJECTORIES).map(summary_text::answers).unwrap_or_default();
    let answers: String = answers.iter().map(|answer| format!("\n{answer}\n")).collect();
    let text = |table: &Table| format!("\n{}{}", tables(table, Style::Markdown), gains(table));
    let tables = results.tables.iter().map(text);
    format!("# {}\n{model}{caveat}{answers}{}", results.scene, tables.collect::<String>())
}

/// Writes `results.json` and `tables.md`.
pub fn write(folder: &ResultFolder, results: &Results, manifest: &Manifest) -> Result<(), SaveError> {
    let text = markdown(results, manifest.model_hash.as_deref(), manifest.caveat.as_deref());
    folder.write(TABLES, text.as_bytes())?;
    Ok(folder.write(results_file::FILE_NAME, results.to_json()?.as_bytes())?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Progress;
    use crate::result::kind::ResultKind;
    use crate::result::output_folder::OutputFolder;
    use crate::result::table::tests::{runs, table};
    use vantage_dataset::Seed;

    #[test]
    fn equal_inputs_write_equal_bytes_but_for_the_manifest() {
        let folder = tempfile::tempdir().unwrap();
        let written = |name: &str, runs, manifest: &Manifest| {
            let out = OutputFolder::probe(&folder.path().join(name)).unwrap();
            let results = Results::new("tabletop", "abc", vec![table(runs).unwrap()]);
            let place = ResultFolder::open(&out, "tabletop", ResultKind::Scene, &Progress::detect()).unwrap();
            write(&place, &results, manifest).unwrap();
            place.finish(manifest).unwrap();
            out.path().join("scenes/tabletop")
        };
        let plain = Manifest::new("abc", &[Seed(0)]);
        let files = |name: &str, runs| {
            let place = written(name, runs, &plain);
            ["results.json", "tables.md"].map(|file| std::fs::read(place.join(file)).unwrap())
        };
        let mut reversed = runs();
        reversed.reverse();
        assert_eq!(files("a", runs()), files("b", reversed));
        let manifest = Manifest {
            model_hash: Some("def".into()),
            caveat: Some("Mind this.".into()),
            ..Manifest::new("abc", &[Seed(0)])
        };
        let text = std::fs::read_to_string(written("c", runs(), &manifest).join("tables.md")).unwrap();
        assert!(text.starts_with("# tabletop\n\nScored model: def\n\nMind this.\n\n"), "{text}");
        assert_eq!(Results::read(&folder.path().join("a/scenes/tabletop")).unwrap().tables.len(), 1);
    }
}

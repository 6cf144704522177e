//! `bench index RESULTS_DIR`: the index of a folder of results, what scenes gave, and which maps and studies there are.

mod associations;
mod consistency;
mod online;
mod scene_table;

pub use scene_table::scene_table;

use associations::{ASSOCIATIONS, associations};
use consistency::{CONSISTENCIES, consistencies};
use online::{ONLINES, onlines};

use super::cli::IndexArgs;
use super::error::BenchError;
use super::folder::is_there;
use super::map::{MAP_FILE, map_pages};
use super::study_pages::{STUDY_FILE, study_pages};
use crate::exit::Exit;
use crate::progress::Progress;
use crate::result::kind::ResultKind;
use crate::result::manifest;
use crate::result::metric::Metric;
use crate::result::output_folder::OutputFolder;
use crate::result::report::TABLES;
use crate::result::results_file::{FILE_NAME, Results, ResultsError};
use crate::result::standing::Standing;
use crate::result::statistics::{Mean, quantile};
use crate::result::step_errors::STEP_ERRORS;
use crate::result::table::Table;
use crate::scene_file;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use vantage_dataset::store::read_regular;

/// Name of the index.
pub const INDEX: &str = "README.md";

const UNDEFINED: &str = "-";
const LARGEST_PAGE: u64 = 16 << 20;

/// Writes the tables of all finished results anew from their raw scores, and the index into the folder; prints its table of scenes
/// with links from here.
pub fn write_index(args: &IndexArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let folder = &args.results;
    is_there(folder)?;
    for of in [ResultKind::Scene, ResultKind::Study] {
        folders(folder, of).iter().try_for_each(|result| renew_tables(result))?;
    }
    folders(folder, ResultKind::Study).iter().try_for_each(|result| renew_study(result))?;
    folders(folder, ResultKind::Map).iter().try_for_each(|result| renew_map(result))?;
    let text = index(folder)?;
    let root = OutputFolder::probe(folder)?;
    root.write(INDEX, text.as_bytes())?;
    for (name, page) in pages(&scenes(folder)?) {
        page.map(|page| root.write(name, page.as_bytes())).transpose()?;
    }
    let here = format!("{}/", folder.to_string_lossy().trim_end_matches('/'));
    write!(stdout, "{}", scene_table(folder, &here)?)?;
    Ok(Exit::Success)
}

/// Pages on which scenes stand side by side, by name; none where no scene has what a page is about.
pub fn pages(scenes: &[Results]) -> [(&'static str, Option<String>); 3] {
    [(ASSOCIATIONS, associations(scenes)), (CONSISTENCIES, consistencies(scenes)), (ONLINES, onlines(scenes))]
}

/// The finished results of scenes.
pub fn scenes(root: &Path) -> Result<Vec<Results>, ResultsError> {
    folders(root, ResultKind::Scene).iter().map(|folder| Results::read(folder)).collect()
}

/// Tables as they are said today; those of a result that is not finished are left alone.
fn renew_tables(result: &Path) -> Result<(), BenchError> {
    let Some(standing) = Standing::read(result) else { return Ok(()) };
    let text = standing.markdown(&Results::read(result)?);
    Ok(OutputFolder::probe(result)?.write(TABLES, text.as_bytes())?)
}

/// Likewise of a map, with its figures; one without its map is left alone, which is said.
fn renew_map(result: &Path) -> Result<(), BenchError> {
    let file = result.join(MAP_FILE);
    if Standing::read(result).is_none() {
        return Ok(());
    }
    if !file.exists() {
        let note = format!("note: {} has no {MAP_FILE}; its tables stay as they are", result.display());
        Progress::detect().note(&note);
        return Ok(());
    }
    let folder = OutputFolder::probe(result)?;
    for (name, bytes) in map_pages(&scene_file::read(&file)?, &Results::read(result)?)? {
        folder.write(name, &bytes)?;
    }
    Ok(())
}

/// The figures of a study that has some; one without the study is left alone.
fn renew_study(result: &Path) -> Result<(), BenchError> {
    let file = result.join(STUDY_FILE);
    if Standing::read(result).is_none() || !file.exists() {
        return Ok(());
    }
    let folder = OutputFolder::probe(result)?;
    for (name, bytes) in study_pages(&scene_file::read(&file)?, &Results::read(result)?)? {
        folder.write(name, &bytes)?;
    }
    Ok(())
}

/// The whole index, Markdown, with links from `root`.
pub fn index(root: &Path) -> Result<String, ResultsError> {
    let mut text = format!(
        "# Results\n\nMade by `bench index`, from the files beside it.\n\n## Scenes\n\n\
         Mean error of the trajectory (ATE) in metres, first poses aligned.\n\
         The paired difference is *learned* less *geometric* on the same seed, with its 95% BCa interval.\n\
         `p` is Wilcoxon's, after Holm's correction over all rows of this table.\n\
         A gain or a harm is told where the interval, a sign test and `p` agree.\n\n{}\n",
        scene_table(root, "")?
    );
    for folder in folders(root, ResultKind::Scene) {
        text += &line(root, &folder, "");
    }
    let scenes = scenes(root)?;
    if associations(&scenes).is_some() {
        text += &format!("\nWho is who, of all scenes: [{ASSOCIATIONS}]({ASSOCIATIONS})\n");
    }
    if consistencies(&scenes).is_some() {
        text += &format!("\nWhat is promised, and what is kept: [{CONSISTENCIES}]({CONSISTENCIES})\n");
    }
    if onlines(&scenes).is_some() {
        text += &format!("\nAfter every step: [{ONLINES}]({ONLINES})\n");
    }
    let maps = folders(root, ResultKind::Map);
    if !maps.is_empty() {
        text += "\n## Maps\n\n";
    }
    text.extend(maps.iter().map(|folder| line(root, folder, "")));
    text += "\n## Studies\n\n";
    for folder in folders(root, ResultKind::Study) {
        text += &line(root, &folder, &format!(": {}", title(&folder)));
    }
    Ok(text)
}

/// `- name: title [tables](..), [raw scores](..), [origin](..), [picture](..)`, as far as there are such files.
fn line(root: &Path, folder: &Path, title: &str) -> String {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    let place = folder.strip_prefix(root).unwrap_or(folder).to_string_lossy().replace('\\', "/");
    let known = [
        (TABLES, "tables"),
        (FILE_NAME, "raw scores"),
        (manifest::FILE_NAME, "origin"),
        (STEP_ERRORS, "errors by step"),
    ];
    let known = known.into_iter().map(|(file, label)| (file.to_owned(), label.to_owned()));
    let pictures = pictures(folder).into_iter().map(|file| (file.clone(), file));
    let links = known.chain(pictures).filter(|(file, _)| folder.join(file).exists());
    let links: Vec<String> = links.map(|(file, label)| format!("[{label}]({place}/{file})")).collect();
    let name = match folder.join(INDEX).exists() {
        true => format!("[{name}]({place}/{INDEX})"),
        false => name.into_owned(),
    };
    format!("- {name}{title}\n  ({})\n", links.join(", "))
}

/// What a study is about: the title of its README or, without one, its purpose.
fn title(folder: &Path) -> String {
    let bytes = |file: &str| read_regular(&folder.join(file), LARGEST_PAGE).unwrap_or_default();
    let read = |file: &str| String::from_utf8(bytes(file)).unwrap_or_default();
    let first = read(INDEX).lines().find_map(|line| line.strip_prefix("# ").map(str::to_owned));
    first.unwrap_or_else(|| read("variants.md").lines().nth(2).unwrap_or_default().to_owned())
}

fn pictures(folder: &Path) -> Vec<String> {
    let is_picture = |name: &String| name.ends_with(".svg") || name.ends_with(".png");
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> =
        entries.filter_map(|entry| entry.file_name().into_string().ok()).filter(is_picture).collect();
    names.sort();
    names
}

/// A row's score on each seed that has it.
fn scores(table: &Table, row: &str, metric: Metric) -> Vec<f64> {
    table.runs_of(row).iter().filter_map(|run| run.scores.get(&metric).copied()).collect()
}

/// ` (median, most)` of a score over seeds; nothing where none has it.
fn spread(table: &Table, row: &str, metric: Metric) -> String {
    let mut scores = scores(table, row, metric);
    scores.sort_by(f64::total_cmp);
    match (quantile(&scores, 0.5), scores.last()) {
        (Some(median), Some(most)) => format!(" ({median:.1}, {most:.1})"),
        _ => String::new(),
    }
}

/// The folders of finished results of a kind, by name.
pub fn folders(root: &Path, of: ResultKind) -> Vec<PathBuf> {
    let place = of.place(root, "");
    let entries = fs::read_dir(place).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut folders: Vec<PathBuf> = entries.filter(|path| path.join(FILE_NAME).exists()).collect();
    folders.sort();
    folders
}

/// To a millimetre, zero without sign.
fn metres(value: f64) -> String {
    let text = format!("{value:.3}");
    if text == "-0.000" { "0.000".to_owned() } else { text }
}

fn with_interval(mean: &Mean) -> String {
    let half = mean.half_width.map(|half| format!(" +- {}", metres(half))).unwrap_or_default();
    metres(mean.mean) + &half
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::manifest::Manifest;
    use crate::result::metric::Metric;
    use crate::result::report::markdown;
    use crate::result::table::Table;
    use crate::result::table::tests::{METHODS, run, runs, table};
    use vantage_dataset::Seed;

    fn write(root: &Path, of: ResultKind, name: &str, table: Table) -> PathBuf {
        let folder = of.place(root, name);
        fs::create_dir_all(&folder).unwrap();
        let results = Results::new(name, "abc", vec![table]);
        fs::write(folder.join(FILE_NAME), results.to_json().unwrap()).unwrap();
        folder
    }

    #[test]
    fn scenes_are_compared_studies_are_told_of_and_tables_are_renewed() {
        let root = tempfile::tempdir().unwrap();
        let root = root.path();
        write(root, ResultKind::Scene, "gains", table(runs()).unwrap());
        let mut worse = runs();
        for run in worse.iter_mut().filter(|run| run.method == METHODS[2]) {
            *run.scores.get_mut(&Metric::Ate).unwrap() += 0.0999;
        }
        write(root, ResultKind::Scene, "a_loss", table(worse).unwrap());
        let latents = vec![run("a", 0, &[(Metric::Ari, 0.5)])];
        let latents = Table::new("latents", &["a"], None, &[Metric::Ari], &[Seed(0)], latents).unwrap();
        let study = write(root, ResultKind::Study, "mine", latents);
        fs::write(study.join("variants.md"), "# mine\n\nWhat it shows.\n").unwrap();
        fs::write(study.join("latents.png"), "").unwrap();
        fs::create_dir_all(root.join("studies/unfinished")).unwrap();

        let table = scene_table(root, "results/").unwrap();
        let lines: Vec<&str> = table.lines().skip(2).collect();
        assert_eq!(lines.len(), 2, "{table}");
        assert_eq!(
            lines[0],
            "| [gains](results/scenes/gains/tables.md) | 4 | 1.000 | 0.650 | 0.550 | -0.100 [-0.100, -0.100] | 4 of 4 | 0.2500 | undecided |"
        );
        assert!(
            lines[1].contains("| 0.650 | 0.000 [0.000, 0.000] | 4 of 4 | 0.2500 | undecided |"),
            "{table}"
        );
        let text = index(root).unwrap();
        assert!(
            text.contains(
                "- mine: What it shows.\n  ([raw scores](studies/mine/results.json), [latents.png]"
            )
        );
        assert!(!text.contains("unfinished") && text.contains("](scenes/gains/tables.md)"), "{text}");

        let finished = root.join("scenes/gains");
        let manifest = Manifest { model_hash: Some("def".into()), ..Manifest::new("abc", &[Seed(0)]) };
        fs::write(finished.join(manifest::FILE_NAME), manifest.to_json().unwrap()).unwrap();
        fs::write(finished.join(TABLES), "of another version").unwrap();
        write_index(&IndexArgs { results: root.to_owned() }, &mut Vec::new()).unwrap();
        let renewed = fs::read_to_string(finished.join(TABLES)).unwrap();
        assert_eq!(renewed, markdown(&Results::read(&finished).unwrap(), Some("def"), None));
        assert!(!root.join("scenes/a_loss").join(TABLES).exists(), "it has no manifest");
        assert_eq!(fs::read_to_string(root.join(INDEX)).unwrap(), index(root).unwrap());
        fs::write(study.join("README.md"), "# A title\n").unwrap();
        assert!(index(root).unwrap().contains("- [mine](studies/mine/README.md): A title\n"));
    }
}

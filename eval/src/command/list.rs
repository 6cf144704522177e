//! `bench list`: scenes, models, studies and maps that come with the program.

use crate::command::error::BenchError;
use crate::exit::Exit;
use crate::scene_file::map::MapFile;
use crate::scene_file::study::StudyFile;
use crate::scene_file::{FileKind, SceneFile, parse};
use crate::supplied;
use std::io::Write;
use std::path::Path;
use vantage_dataset::Split;

/// Prints each with its size and the first sentence of its purpose.
pub fn list(stdout: &mut impl Write) -> Result<Exit, BenchError> {
    writeln!(stdout, "Scenes, each run by `bench NAME`:\n")?;
    for file in supplied::of_kind(FileKind::Scene) {
        let scene: SceneFile = parse(file.text, Path::new(file.path))?;
        let seeds = scene.evaluation.seeds.as_slice().len();
        let model = match scene.training.reference.as_deref().and_then(Path::file_name) {
            Some(model) => format!("model {}", model.display()),
            None => "no model yet".to_owned(),
        };
        item(stdout, file.name(), &format!("{seeds} seeds, {model}"), &scene.purpose)?;
    }
    writeln!(stdout, "Scenes of studies, for commands such as `bench train NAME`:\n")?;
    for file in supplied::scenes_for_studies() {
        let scene: SceneFile = parse(file.text, Path::new(file.path))?;
        let instances = scene.views.instances(Split::Train);
        item(stdout, file.name(), &format!("{instances} training instances"), &scene.purpose)?;
    }
    writeln!(
        stdout,
        "Reference models, which the scenes name; `--model DIR` puts another in their place:\n"
    )?;
    for (name, kind) in supplied::models() {
        writeln!(stdout, "  {name:24} {kind}")?;
    }
    writeln!(stdout, "\nStudies, each run by `bench study NAME`:\n")?;
    for file in supplied::of_kind(FileKind::Study) {
        let study: StudyFile = parse(file.text, Path::new(file.path))?;
        let size = format!("{} variants, {} seeds", study.variants.len(), study.seeds);
        item(stdout, file.name(), &size, &study.purpose)?;
    }
    writeln!(stdout, "\nMaps, each run by `bench map NAME`:\n")?;
    for file in supplied::of_kind(FileKind::Map) {
        let map: MapFile = parse(file.text, Path::new(file.path))?;
        let size = format!("{} panels of {} cells", map.panels.len(), map.across.over.len());
        item(stdout, file.name(), &size, &map.purpose)?;
    }
    Ok(Exit::Success)
}

fn item(stdout: &mut impl Write, name: &str, size: &str, purpose: &str) -> std::io::Result<()> {
    writeln!(stdout, "  {name:24} {size}\n{}", wrapped(first_sentence(purpose)))
}

/// Up to the first full stop that a space follows; "Fig. 2" and "Eq. 15" do not end a sentence.
fn first_sentence(text: &str) -> &str {
    let text = text.trim();
    let ends = |rest: &str| {
        rest.starts_with(char::is_whitespace)
            && !rest.trim_start().starts_with(|next: char| next.is_ascii_digit())
    };
    let end = text.char_indices().find(|&(at, mark)| mark == '.' && ends(&text[at + 1..]));
    end.map_or(text, |(at, _)| &text[..=at])
}

/// Indented lines of at most [`WIDTH`] columns, and an empty one.
fn wrapped(text: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        if lines.last().is_some_and(|line| line.len() + word.len() >= WIDTH - INDENT) {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            line.push_str(if line.is_empty() { "" } else { " " });
            line.push_str(word);
        }
    }
    lines.iter().map(|line| format!("{:INDENT$}{line}\n", "")).collect()
}

const WIDTH: usize = 100;
const INDENT: usize = 4;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_to_a_figure_ends_no_sentence() {
        assert_eq!(
            first_sentence(" The setting of Fig. 2a, once. And more. "),
            "The setting of Fig. 2a, once."
        );
        assert_eq!(first_sentence("By Eq. 15"), "By Eq. 15");
    }

    #[test]
    fn all_is_listed_in_lines_that_fit() {
        let mut text = Vec::new();
        assert_eq!(list(&mut text).unwrap(), Exit::Success);
        let text = String::from_utf8(text).unwrap();
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH), "{text}");
        let of_kinds =
            [FileKind::Scene, FileKind::Study, FileKind::Map].into_iter().flat_map(supplied::of_kind);
        for file in of_kinds.chain(supplied::scenes_for_studies()) {
            assert!(text.contains(&format!("\n  {:24} ", file.name())), "{} not in {text}", file.name());
        }
        assert!(text.contains("  predictive               viewpoint_predictive\n"), "{text}");
        assert!(text.contains("10 seeds, model objects\n    Dense clutter: a dozen objects"), "{text}");
    }

    #[test]
    fn a_sentence_ends_at_its_full_stop_and_not_in_a_number() {
        assert_eq!(first_sentence(" At 0.5 m. More.\n"), "At 0.5 m.");
        assert_eq!(first_sentence("No end"), "No end");
    }
}

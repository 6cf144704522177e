//! What a run leaves of associations: the object of each detection, and how long steps took.

use super::line::Scored;
use crate::command::error::BenchError;
use crate::result::folder::ResultFolder;
use crate::result::grid::Style;
use crate::result::step_times::step_times;
use crate::score::association_entry::HEAD;
use std::fmt::Write as _;
use std::time::Duration;

/// The file of times.
pub const ASSOCIATION_TIMES: &str = "association_times.md";

/// Writes `<seed>/<row>.association.csv`, in the form that `--associations` takes, and the times.
pub fn write(folder: &ResultFolder, scored: &Scored) -> Result<(), BenchError> {
    if scored.associations.is_empty() {
        return Ok(());
    }
    for (seed, answers) in &scored.associations {
        for (row, answer) in scored.association_rows.iter().zip(answers) {
            let Ok(associated) = answer else { continue };
            let mut lines = format!("{HEAD}\n");
            for (detection, object) in associated.objects.iter().enumerate() {
                let object = object.map_or_else(String::new, |object| object.to_string());
                let _ = writeln!(lines, "{detection},{object}");
            }
            folder.write(&format!("{}/{row}.association.csv", seed.0), lines.as_bytes())?;
        }
    }
    folder.write(ASSOCIATION_TIMES, step_times(&times(scored), Style::Markdown).as_bytes())?;
    Ok(())
}

/// The times of all steps by row, of those that have any.
pub fn times(scored: &Scored) -> Vec<(&str, Vec<Duration>)> {
    let of_row = |(index, name): (usize, _)| {
        let answers = scored.associations.iter().filter_map(|(_, answers)| answers.get(index)?.as_ref().ok());
        (name, answers.flat_map(|associated| associated.times.iter().copied()).collect::<Vec<_>>())
    };
    let names = scored.association_rows.iter().map(String::as_str).enumerate();
    names.map(of_row).filter(|(_, times)| !times.is_empty()).collect()
}

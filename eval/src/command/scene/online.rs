//! What a run leaves of estimates after every step: newest poses as TUM files, their errors by step and drawn, and how long
//! steps took.

use super::line::Scored;
use crate::command::error::BenchError;
use crate::figure::online::online_svg;
use crate::pipeline::OnlineRun;
use crate::result::folder::ResultFolder;
use crate::result::grid::Style;
use crate::result::step_errors::{STEP_ERRORS, StepErrors, over_seeds, step_errors};
use crate::result::step_times::{STEP_TIMES, step_times};
use crate::result::trajectory::Trajectory;
use crate::score::online::newest_errors;
use std::collections::BTreeMap;
use std::time::Duration;
use vantage_dataset::Observations;
use vantage_dataset::store::{read_observations, read_truth};

/// Name of the picture.
const PICTURE: &str = "online.svg";

/// Writes them; returns the picture's name, where there is one.
pub fn write(folder: &ResultFolder, scored: &Scored) -> Result<Option<&'static str>, BenchError> {
    let mut errors: Vec<(&str, Vec<Vec<f64>>)> =
        scored.methods.iter().map(|name| (&**name, Vec::new())).collect();
    let mut by_detections: BTreeMap<(usize, usize), Vec<Duration>> = BTreeMap::new();
    for ((seed, episode), (_, runs)) in scored.episodes.iter().zip(&scored.online) {
        let Ok(episode) = episode else { continue };
        let truth = read_truth(&episode.folder)?;
        let Observations { timestamps, detections, .. } = read_observations(&episode.folder)?;
        let mut seen = vec![0; timestamps.len()];
        detections.iter().for_each(|detection| seen[detection.step] += 1);
        for (row, ((name, of_row), run)) in errors.iter_mut().zip(runs).enumerate() {
            let Some(Ok(OnlineRun { newest, times, .. })) = run else { continue };
            for (&seen, &time) in seen.iter().zip(times) {
                by_detections.entry((row, seen)).or_default().push(time);
            }
            of_row.push(newest_errors(&truth.world_from_robot, newest)?);
            let trajectory = Trajectory::new(timestamps.clone(), newest.clone())?;
            folder.write_trajectory(&format!("{}/{name}.online.tum", seed.0), &trajectory)?;
        }
    }
    errors.retain(|(_, seeds)| !seeds.is_empty());
    let errors: Vec<StepErrors<'_>> = errors.iter().map(|(name, seeds)| (*name, over_seeds(seeds))).collect();
    if errors.is_empty() {
        return Ok(None);
    }
    let title = format!("{}: where the robot takes itself to be, step by step", scored.results.scene);
    folder.write(PICTURE, online_svg(&title, &errors)?.as_bytes())?;
    folder.write(STEP_ERRORS, &step_errors(&errors)?)?;
    let named = |((row, seen), times)| (format!("{}, {seen} seen", scored.methods[row]), times);
    let by_detections: Vec<(String, Vec<Duration>)> = by_detections.into_iter().map(named).collect();
    let tables =
        [times(scored), by_detections.iter().map(|(name, times)| (&**name, times.clone())).collect()];
    let tables = tables.map(|rows| step_times(&rows, Style::Markdown)).join("\n\n") + "\n";
    folder.write(STEP_TIMES, tables.as_bytes())?;
    Ok(Some(PICTURE))
}

/// The times of all steps by row, of those that have any.
pub fn times(scored: &Scored) -> Vec<(&str, Vec<Duration>)> {
    let of_row = |(index, name): (usize, _)| {
        let runs = scored.online.iter().filter_map(|(_, runs)| runs.get(index)?.as_ref()?.as_ref().ok());
        (name, runs.flat_map(|run| run.times.iter().copied()).collect::<Vec<_>>())
    };
    let names = scored.methods.iter().map(String::as_str).enumerate();
    names.map(of_row).filter(|(_, times)| !times.is_empty()).collect()
}

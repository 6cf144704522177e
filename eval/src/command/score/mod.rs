//! `bench score TRUTH ESTIMATE`: how far two trajectories of anybody's are apart, as evo tells it, or what a submission to a task is worth.

pub mod error;
mod evo;
mod labels;
mod map;
mod submission;

use crate::command::cli::ScoreArgs;
use crate::command::error::BenchError;
use crate::command::folder::is_there;
use crate::exit::Exit;
use crate::progress::Progress;
use crate::result::grid::{Style, draw};
use crate::result::output_folder::OutputFolder;
use crate::result::trajectory::{Trajectory, TumError};
use crate::score::alignment::{Alignment, Laid};
use crate::score::embedding::Scores as MapScores;
use crate::score::entry::text;
use crate::score::pairs::Pairs;
use crate::score::pose_error::{ErrorStatistics, PoseErrors, Spacing, Unit};
use error::ScoreError;
use serde::Serialize;
use std::io::Write;
use std::path::{Component, Path};
use vantage_dataset::Pose;
use vantage_formats::PoseText;

/// Paths whose lengths differ by this factor may be in different units.
const UNIT: f64 = 30.0;

/// What is told of two trajectories.
#[derive(Serialize)]
struct Scores {
    #[serde(skip)]
    laid: Laid,
    #[serde(skip)]
    aligned: Aligned,
    alignment: Alignment,
    spacing: Spacing,
    truth_poses: usize,
    estimate_poses: usize,
    /// Poses of one that meet one of the other in time.
    pairs: usize,
    errors: Vec<Scored>,
}

/// All that is told.
#[derive(Serialize)]
struct Said {
    #[serde(flatten)]
    scores: Scores,
    #[serde(skip_serializing_if = "Option::is_none")]
    object_map: Option<MapScores>,
}

/// The poses that met, the estimate laid on the truth.
struct Aligned {
    pairs: Pairs,
    /// Of each pair, seconds; of KITTI's, its number.
    times: Vec<f64>,
}

#[derive(Serialize)]
struct Scored {
    error: &'static str,
    unit: &'static str,
    count: usize,
    #[serde(skip)]
    errors: Vec<f64>,
    #[serde(skip)]
    at: Vec<usize>,
    /// Absent where there is none.
    #[serde(flatten)]
    statistics: Option<ErrorStatistics>,
}

/// Prints the errors of poses and of motions.
pub fn score(args: &ScoreArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    if args.truth.is_dir() {
        return submission::score(args, stdout);
    }
    if args.task.is_some() {
        if !args.truth.is_file() {
            is_there(&args.truth)?;
        }
        return Err(ScoreError::Option { option: "--task", of: "two trajectories" }.into());
    }
    let Spacing { delta, unit, .. } = args.spacing();
    if unit == Unit::Frames && delta.fract() != 0.0 {
        return Err(ScoreError::Frames { delta }.into());
    }
    let out = args.evo.as_deref().map(OutputFolder::probe).transpose()?;
    let scores = scores(args)?;
    let map = map::scores(args, &scores.laid)?;
    if let Some(out) = out {
        let named = |path: &Path| {
            let path = path.with_extension("");
            let parts = path.components().filter(|part| matches!(part, Component::Normal(_)));
            parts.map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("-")
        };
        let [truth, estimate] = [&args.truth, &args.estimate].map(|path| named(path));
        let estimate = if truth == estimate { format!("{estimate}-estimate") } else { estimate };
        evo::write(&out, &scores, [&truth, &estimate])?;
    }
    if args.json {
        serde_json::to_writer_pretty(&mut *stdout, &Said { scores, object_map: map })?;
        writeln!(stdout)?;
    } else {
        writeln!(
            stdout,
            "{} pairs of {} true and {} estimated poses\n\n{}",
            scores.pairs,
            scores.truth_poses,
            scores.estimate_poses,
            table(&scores.errors)
        )?;
        if let Some(map) = map {
            writeln!(stdout, "\n{}", map::text(&map))?;
        }
    }
    Ok(Exit::Success)
}

fn scores(args: &ScoreArgs) -> Result<Scores, ScoreError> {
    let (truth, of_truth) = read(&args.truth, Trajectory::recorded_from_tum)?;
    let (estimate, of_estimate) = read(&args.estimate, Trajectory::from_tum)?;
    if (of_truth == PoseText::Kitti) != (of_estimate == PoseText::Kitti) {
        return Err(ScoreError::Untimed);
    }
    if of_truth == PoseText::Kitti && truth.len() != estimate.len() {
        return Err(ScoreError::Numbers { truth: truth.len(), estimate: estimate.len() });
    }
    if of_truth == PoseText::Kitti && args.max_difference.is_some() {
        let of = "two trajectories of KITTI's, which have no times";
        return Err(ScoreError::Option { option: "--max-difference", of });
    }
    let pairs = Pairs::by_time(&truth, &estimate, args.nearness());
    if pairs.truth().is_empty() {
        let span = |of: &Trajectory| [0, of.len() - 1].map(|i| of.timestamps()[i]);
        let (max_difference, truth, estimate) = (args.nearness(), span(&truth), span(&estimate));
        return Err(ScoreError::Apart { max_difference, truth, estimate });
    }
    let (met, shorter) = (pairs.truth().len(), truth.len().min(estimate.len()));
    if met < shorter || 2 * met < truth.len() {
        Progress::detect().note(&format!(
            "note: errors are of {met} pairs alone, of {} true and {} estimated poses",
            truth.len(),
            estimate.len()
        ));
    }
    let frees_scale = matches!(args.alignment(), Alignment::Sim3 | Alignment::Scale);
    if let Some(times) = other_unit(&pairs).filter(|_| !frees_scale) {
        Progress::detect().note(&format!(
            "note: the estimate's path is {times:.3} times as long as the true one: are both in metres? `--align sim3` frees the scale"
        ));
    }
    let (alignment, spacing) = (args.alignment(), args.spacing());
    let (laid, aligned) = (alignment.of(&pairs)?, alignment.apply(&pairs)?);
    let of = |kind: [&'static str; 2], errors: PoseErrors| {
        let at = errors.at;
        let scored = |error, unit, errors: Vec<f64>| Scored {
            error,
            unit,
            count: errors.len(),
            statistics: ErrorStatistics::of(&errors),
            errors,
            at: at.clone(),
        };
        [scored(kind[0], "m", errors.translation), scored(kind[1], "deg", errors.rotation)]
    };
    let absolute = of(["APE translation", "APE rotation"], PoseErrors::absolute(&aligned));
    let relative = of(["RPE translation", "RPE rotation"], PoseErrors::relative(&aligned, spacing));
    Ok(Scores {
        alignment,
        spacing,
        truth_poses: truth.len(),
        estimate_poses: estimate.len(),
        pairs: pairs.truth().len(),
        errors: absolute.into_iter().chain(relative).collect(),
        laid,
        aligned: Aligned { pairs: aligned, times: pairs.times().to_vec() },
    })
}

/// How many times as long the estimated path is, where one of the two may be in another unit.
fn other_unit(pairs: &Pairs) -> Option<f64> {
    let path = |poses: &[Pose]| -> f64 {
        poses.windows(2).map(|step| (step[1].translation.vector - step[0].translation.vector).norm()).sum()
    };
    let times = path(pairs.estimate()) / path(pairs.truth());
    (times.is_finite() && !(1.0 / UNIT..UNIT).contains(&times)).then_some(times)
}

fn read(
    path: &Path,
    parse: impl FnOnce(&str) -> Result<Trajectory, TumError>,
) -> Result<(Trajectory, PoseText), ScoreError> {
    let path = path.to_owned();
    let text = match text(&path) {
        Ok(text) => text,
        Err(source) => return Err(ScoreError::Read { path, source }),
    };
    let format = PoseText::of(&text);
    let read = match format {
        PoseText::Tum => {
            return Ok((parse(&text).map_err(|source| ScoreError::Tum { path, source })?, format));
        }
        PoseText::Kitti => Trajectory::from_kitti(&text),
        PoseText::Euroc => Trajectory::from_euroc(&text),
    };
    Ok((read.map_err(|source| ScoreError::Text { path, source })?, format))
}

fn table(errors: &[Scored]) -> String {
    let head = ["Error", "Count", "RMSE", "Mean", "Median", "Std", "Min", "Max"].map(String::from);
    let row = |scored: &Scored| {
        let name = format!("{} [{}]", scored.error, scored.unit);
        let numbers = match &scored.statistics {
            Some(of) => [of.rmse, of.mean, of.median, of.std, of.min, of.max].map(|x| format!("{x:.6}")),
            None => [0; 6].map(|_| "-".to_owned()),
        };
        [vec![name, scored.count.to_string()], numbers.to_vec()].concat()
    };
    draw(Style::terminal(), &head, errors.iter().map(row).collect())
}

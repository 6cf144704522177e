//! `--evo DIR`: the errors as evo's result archives.

use super::{Scored, Scores};
use crate::command::error::BenchError;
use crate::result::output_folder::OutputFolder;
use crate::score::alignment::Alignment;
use crate::score::pose_error::{Spacing, Unit};
use serde_json::json;
use std::fmt::Write as _;
use std::io;
use vantage_dataset::Pose;
use vantage_dataset::store::pose_fields;
use vantage_formats::npz::{Elements, Npz};

/// Writes an archive for each error that there is; `names` are those of the truth and the estimate.
pub fn write(out: &OutputFolder, scores: &Scores, names: [&str; 2]) -> Result<(), BenchError> {
    for scored in scores.errors.iter().filter(|scored| !scored.errors.is_empty()) {
        let name = scored.error.to_lowercase().replace(' ', "_");
        out.write_npz(format!("{name}.zip"), |npz| archive(npz, scores, scored, names))?;
    }
    Ok(())
}

/// Of a motion, times, paths and poses are of its later end; the first pose stands before them.
fn archive(
    npz: &mut Npz,
    scores: &Scores,
    scored: &Scored,
    [truth_name, estimate_name]: [&str; 2],
) -> io::Result<()> {
    let (pairs, times) = (&scores.aligned.pairs, &scores.aligned.times);
    let is_of_motions = scored.error.starts_with("RPE");
    let first: &[usize] = if is_of_motions { &[0] } else { &[] };
    let kept: Vec<usize> = first.iter().chain(&scored.at).copied().collect();
    let poses = |of: &[Pose]| kept.iter().map(|&i| of[i]).collect::<Vec<Pose>>();
    let (truth, estimate) = (poses(pairs.truth()), poses(pairs.estimate()));
    let times: Vec<f64> = kept.iter().map(|&i| times[i]).collect();
    let since: Vec<f64> = times.iter().map(|time| time - times[0]).collect();

    let (relation, unit) = match scored.unit {
        "deg" => ("rotation angle in degrees", "deg"),
        _ => ("translation part", "m"),
    };
    let kind = &scored.error[..3];
    let spaced = if is_of_motions { spaced(&scores.spacing) } else { String::new() };
    let title = format!("{kind} w.r.t. {relation} ({unit}){spaced}\n({})", aligned(scores.alignment));
    let info = json!({ "title": title, "label": format!("{kind} ({unit})"), "ref_name": truth_name, "est_name": estimate_name });
    npz.file("info.json", &serde_json::to_vec(&info)?)?;
    npz.file("stats.json", &serde_json::to_vec(&scored.statistics)?)?;
    let skipped = first.len();
    for (name, numbers) in [
        ("error_array", &scored.errors[..]),
        ("seconds_from_start", &since[skipped..]),
        ("timestamps", &times[skipped..]),
        ("distances_from_start", &travelled(&truth)[skipped..]),
        ("distances", &travelled(&estimate)[skipped..]),
    ] {
        npz.array(name, &[numbers.len()], Elements::F64(numbers))?;
    }
    for (name, poses) in [(truth_name, truth), (estimate_name, estimate)] {
        let mut text = String::new();
        for (time, pose) in times.iter().zip(&poses) {
            let numbers: Vec<String> = pose_fields(pose).iter().map(f64::to_string).collect();
            let _ = writeln!(text, "{time} {}", numbers.join(" "));
        }
        npz.file(&format!("{name}.tum"), text.as_bytes())?;
    }
    Ok(())
}

/// Length of the path up to each pose, metres.
fn travelled(poses: &[Pose]) -> Vec<f64> {
    let mut path = vec![0.0; poses.len()];
    for (i, step) in poses.windows(2).enumerate() {
        path[i + 1] = path[i] + (step[1].translation.vector - step[0].translation.vector).norm();
    }
    path
}

fn aligned(alignment: Alignment) -> &'static str {
    match alignment {
        Alignment::None => "not aligned",
        Alignment::Origin => "with origin alignment",
        Alignment::Se3 => "with SE(3) Umeyama alignment",
        Alignment::Sim3 => "with Sim(3) Umeyama alignment",
        Alignment::Scale => "scale corrected",
        Alignment::Yaw => "with alignment of heading and position",
    }
}

fn spaced(spacing: &Spacing) -> String {
    let unit = match spacing.unit {
        Unit::Frames => "frames",
        Unit::Metres => "m",
        Unit::Degrees => "deg",
    };
    let pairs = if spacing.all_pairs { "all" } else { "consecutive" };
    format!("\nfor delta = {} ({unit}) using {pairs} pairs", spacing.delta)
}

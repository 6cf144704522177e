//! What a run leaves to look at, and every trajectory as a TUM file.

use super::line::{Scored, mean_likelihood};
use crate::command::error::BenchError;
use crate::command::figures::looks::Looks;
use crate::command::figures::{PREDICTIONS, VIEWPOINTS};
use crate::figure::crop_table::{Block, crop_table_png};
use crate::figure::gains::gains_svg;
use crate::figure::likelihood::likelihood_svg;
use crate::figure::nees::{Curve, nees_svg};
use crate::figure::trajectory::{TopView, region, trajectory_svg};
use crate::pipeline::{Answer, ScoredViews};
use crate::result::folder::ResultFolder;
use crate::result::metric::Metric;
use crate::result::paired::Paired;
use crate::result::table::Table;
use crate::result::trajectory::Trajectory;
use crate::scene_file::row::Row;
use crate::scene_file::row_name::TRUTH;
use crate::scene_file::row_name::is_learned;
use crate::score::consistency::pose_consistency;
use crate::score::pairs::Pairs;
use crate::score::trajectory_scores::TRAJECTORIES;
use nalgebra::Matrix6;
use std::collections::BTreeMap;
use vantage_dataset::store::{read_observations, read_truth};
use vantage_dataset::{Crop, Detection, Observations, Pose, Seed, Truth};

/// Crops of an object on the sheet.
const COLUMNS: usize = 16;
/// Paths that are nowhere farther apart look like one, metres; so do errors, relative to them.
const ALIKE: f64 = 0.001;

/// Writes `<seed>/*.tum` for every seed, and the pictures; those of an episode are of the seed in the middle of the paired
/// differences or, where there are none, of the first that has one. Returns the names of the pictures.
pub fn write(folder: &ResultFolder, scored: &Scored) -> Result<Vec<&'static str>, BenchError> {
    let mut written = Vec::new();
    let mut picture = |name: &'static str, bytes: &[u8]| {
        written.push(name);
        folder.write(name, bytes)
    };
    let trajectories = scored.results.table(TRAJECTORIES);
    let gains: Vec<(&str, Paired)> = trajectories.map(gains).unwrap_or_default();
    if let (Some(reference), false) = (trajectories.and_then(Table::reference), gains.is_empty()) {
        picture("gains.svg", gains_svg(&scored.results.scene, reference, &gains)?.as_bytes())?;
    }
    let middle = gains.first().and_then(|(_, paired)| Some((paired.median_seed()?, paired.seeds())));
    let first = scored.episodes.iter().find_map(|(seed, episode)| episode.as_ref().ok().map(|_| *seed));
    let pictured = middle.map(|(seed, _)| seed).or(first);
    let mut nees: Vec<Curve<'_>> = scored.methods.iter().map(|name| (&**name, Vec::new())).collect();
    for ((seed, episode), (_, answers)) in scored.episodes.iter().zip(&scored.answers) {
        let Ok(episode) = episode else { continue };
        let observations = read_observations(&episode.folder)?;
        let truth = read_truth(&episode.folder)?;
        for ((_, seeds), answer) in nees.iter_mut().zip(answers) {
            seeds.extend(pose_nees(&truth, answer)?);
        }
        let mut rows: Vec<(&str, Path)> = scored
            .methods
            .iter()
            .zip(answers)
            .filter(|(_, answer)| !answer.world_from_robot.is_empty())
            .map(|(name, answer)| (name.as_str(), Path::of(answer)))
            .collect();
        for entry in &scored.entries {
            rows.extend(
                entry
                    .run(*seed, &observations.timestamps)
                    .ok()
                    .map(|poses| (entry.name.as_str(), Path::bare(poses))),
            );
        }
        let true_path = (TRUTH, Path::bare(truth.world_from_robot.clone()));
        for (name, path) in std::iter::once(&true_path).chain(&rows) {
            let trajectory = Trajectory::new(observations.timestamps.clone(), path.poses.clone())?;
            folder.write_trajectory(&format!("{}/{name}.tum", seed.0), &trajectory)?;
        }
        if Some(*seed) == pictured {
            let title = title(&scored.results.scene, *seed, middle.map(|(_, seeds)| seeds));
            picture("trajectory.svg", top_view(&title, &truth, rows)?.as_bytes())?;
            if !observations.detections.is_empty() && !scored.recorded {
                picture("crops.png", &sheet(&observations, &truth)?)?;
            }
        }
    }
    nees.retain(|(_, seeds)| !seeds.is_empty());
    without_twin(&mut nees, |control, geometric| {
        let apart = |(a, b): (&f64, &f64)| (a - b).abs() > ALIKE * a.max(*b);
        !control.iter().flatten().zip(geometric.iter().flatten()).any(apart)
    });
    if !nees.is_empty() {
        let title = format!("{}: errors of poses against their covariances", scored.results.scene);
        picture("nees.svg", nees_svg(&title, &nees)?.as_bytes())?;
    }
    let curves = scored.unseen.iter().map(|(model, unseen)| (model.as_str(), mean_likelihood(unseen)));
    let curves: Vec<_> = curves.filter(|(_, curve)| !curve.is_empty()).collect();
    if !curves.is_empty() {
        let title = "Log-likelihood of a crop against azimuth, unseen asymmetric instances";
        picture("likelihood.svg", likelihood_svg(title, &curves)?.as_bytes())?;
    }
    if let (Some(ScoredViews { set, .. }), Some(model)) = (scored.views.first(), scored.models.first()) {
        let looks = Looks::new(set, model.viewing())?;
        if looks.any() {
            for (name, png) in [(PREDICTIONS, looks.predictions()?), (VIEWPOINTS, looks.viewpoints()?)] {
                png.map(|png| picture(name, &png)).transpose()?;
            }
        }
    }
    Ok(written)
}

/// What rows with a model, and those of others, change of the reference's ATE.
fn gains(table: &Table) -> Vec<(&str, Paired)> {
    let learned = table.methods().iter().map(String::as_str).filter(|method| is_learned(method));
    learned.filter_map(|method| Some((method, table.paired(method, Metric::Ate)?))).collect()
}

fn title(scene: &str, seed: Seed, compared: Option<usize>) -> String {
    let seed = seed.0;
    match compared {
        Some(seeds) if seeds > 1 => {
            format!("{scene}, seed {seed}: the median of the differences on {seeds} seeds")
        }
        _ => format!("{scene}, seed {seed}"),
    }
}

/// An estimated path.
struct Path {
    poses: Vec<Pose>,
    /// Of each pose's right perturbation, rotation first; empty where there are none.
    covariances: Vec<Matrix6<f64>>,
}

impl Path {
    fn of(answer: &Answer) -> Self {
        let covariances = answer.pose_covariances.clone().unwrap_or_default();
        Self { poses: answer.world_from_robot.clone(), covariances }
    }

    fn bare(poses: Vec<Pose>) -> Self {
        Self { poses, covariances: Vec::new() }
    }
}

/// All paths, with the 95% regions of their positions after each quarter, but a control that runs where the geometric estimate does.
fn top_view(title: &str, truth: &Truth, mut rows: Vec<(&str, Path)>) -> Result<String, BenchError> {
    without_twin(&mut rows, |control, geometric| alike(&control.poses, &geometric.poses));
    let (mut estimates, mut regions) = (Vec::new(), Vec::new());
    for (index, (name, Path { poses, covariances })) in rows.into_iter().enumerate() {
        let alignment = Pairs::by_step(&truth.world_from_robot, &poses)?.true_world_from_estimate_world();
        let poses: Vec<Pose> = poses.iter().map(|pose| alignment * pose).collect();
        let quarters = (1..=4).filter_map(|quarter| (quarter * poses.len() / 4).checked_sub(1));
        regions.extend(quarters.filter_map(|i| Some((index, region(poses.get(i)?, covariances.get(i)?)?))));
        estimates.push((name, poses));
    }
    let objects: Vec<(&str, [f64; 2], f64)> = truth
        .objects
        .iter()
        .map(|object| {
            let center = object.world_from_object.translation.vector;
            (object.family.as_str(), [center.x, center.y], object.size / 2.0)
        })
        .collect();
    let (truth, estimates) = (&truth.world_from_robot, &estimates);
    let view = TopView { title, truth, estimates, regions: &regions, objects: &objects };
    Ok(trajectory_svg(&view)?)
}

/// Leaves out the control where it is like the geometric row.
fn without_twin<T>(rows: &mut Vec<(&str, T)>, alike: impl Fn(&T, &T) -> bool) {
    let [control, geometric] = [Row::Uninformative, Row::Geometric].map(|row| row.to_string());
    let of = |row: &str| rows.iter().find(|(name, _)| *name == row).map(|(_, of)| of);
    if of(&control).zip(of(&geometric)).is_some_and(|(control, geometric)| alike(control, geometric)) {
        rows.retain(|(name, _)| *name != control);
    }
}

/// NEES / dof of a pose at each step after the first; none of an answer without covariances.
fn pose_nees(truth: &Truth, answer: &Answer) -> Result<Option<Vec<f64>>, BenchError> {
    let Some(covariances) = answer.pose_covariances.as_deref() else { return Ok(None) };
    let pairs = Pairs::by_step(&truth.world_from_robot, &answer.world_from_robot)?;
    Ok(pose_consistency(&pairs, covariances).map(|found| found.pose.nees))
}

fn alike(a: &[Pose], b: &[Pose]) -> bool {
    let apart = |(a, b): (&Pose, &Pose)| (a.translation.vector - b.translation.vector).norm();
    a.len() == b.len() && a.iter().zip(b).map(apart).all(|distance| distance < ALIKE)
}

/// A block for each track, masked crops above boxed ones, evenly spread over the track.
fn sheet(observations: &Observations, truth: &Truth) -> Result<Vec<u8>, BenchError> {
    let mut tracks: BTreeMap<usize, Vec<&Detection>> = BTreeMap::new();
    for detection in &observations.detections {
        tracks.entry(detection.track).or_default().push(detection);
    }
    let block = |(track, seen): (&usize, &Vec<&Detection>)| {
        let columns = COLUMNS.min(seen.len());
        let picked: Vec<&Detection> =
            (0..columns).map(|column| seen[column * seen.len() / columns]).collect();
        let family = truth.objects.get(*track).map_or("no object", |object| object.family.as_str());
        let crops = |crop: fn(&Detection) -> &Crop| picked.iter().map(|seen| crop(seen).clone()).collect();
        Block {
            name: format!("{track} {family}"),
            captions: picked.iter().map(|seen| format!("step {}", seen.step)).collect(),
            rows: vec![
                ("masked".to_owned(), crops(|seen| &seen.masked_crop)),
                ("boxed".to_owned(), crops(|seen| &seen.boxed_crop)),
            ],
        }
    };
    Ok(crop_table_png(&tracks.iter().map(block).collect::<Vec<_>>())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_control_is_left_out_where_it_runs_with_the_geometric_estimate_alone() {
        let path = |off: f64| -> Vec<Pose> {
            (0..5).map(|i| Pose::translation(f64::from(i), off * f64::from(i), 0.0)).collect()
        };
        let truth = Truth {
            world_from_robot: path(0.0),
            objects: Vec::new(),
            landmarks: Vec::new(),
            detections: Vec::new(),
        };
        let drawn = |off: f64| {
            let rows = vec![("geometric", Path::bare(path(0.0))), ("uninformative", Path::bare(path(off)))];
            top_view("s", &truth, rows).unwrap().contains("uninformative")
        };
        assert!(!drawn(0.0) && !drawn(0.000_1) && drawn(0.1));
    }

    #[test]
    fn the_title_says_which_of_the_seeds_is_shown() {
        assert_eq!(title("s", Seed(3), Some(40)), "s, seed 3: the median of the differences on 40 seeds");
        assert_eq!([title("s", Seed(3), Some(1)), title("s", Seed(3), None)], ["s, seed 3", "s, seed 3"]);
    }
}

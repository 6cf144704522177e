//! What a run leaves to look at, and every trajectory as a TUM file.

use super::line::{Scored, mean_likelihood};
use crate::command::error::BenchError;
use crate::figure::contact_sheet::contact_sheet_png;
use crate::figure::likelihood::likelihood_svg;
use crate::figure::trajectory::{TopView, trajectory_svg};
use crate::result::folder::ResultFolder;
use crate::result::trajectory::Trajectory;
use crate::scene_file::row::Row;
use crate::scene_file::row_name::TRUTH;
use crate::score::pairs::Pairs;
use std::collections::BTreeMap;
use vantage_dataset::store::{read_observations, read_truth};
use vantage_dataset::{Crop, Observations, Pose, Truth};

/// Crops of an object on the sheet.
const COLUMNS: usize = 16;

/// Writes `<seed>/*.tum` for every seed, and the pictures of the first seed that has an episode.
pub fn write(folder: &ResultFolder, scored: &Scored) -> Result<(), BenchError> {
    let mut pictured = false;
    for ((seed, episode), (_, answers)) in scored.episodes.iter().zip(&scored.answers) {
        let Ok(episode) = episode else { continue };
        let observations = read_observations(&episode.folder)?;
        let truth = read_truth(&episode.folder)?;
        let mut rows: Vec<(&str, Vec<Pose>)> = scored
            .methods
            .iter()
            .zip(answers)
            .filter(|(_, answer)| !answer.world_from_robot.is_empty())
            .map(|(name, answer)| (name.as_str(), answer.world_from_robot.clone()))
            .collect();
        for entry in &scored.entries {
            rows.extend(
                entry.run(*seed, &observations.timestamps).ok().map(|poses| (entry.name.as_str(), poses)),
            );
        }
        let true_path = (TRUTH, truth.world_from_robot.clone());
        for (name, poses) in std::iter::once(&true_path).chain(&rows) {
            let trajectory = Trajectory::new(observations.timestamps.clone(), poses.clone())?;
            folder.write_trajectory(&format!("{}/{name}.tum", seed.0), &trajectory)?;
        }
        if !pictured {
            pictured = true;
            let mut estimates = Vec::new();
            for (name, poses) in rows {
                let alignment =
                    Pairs::by_step(&truth.world_from_robot, &poses)?.true_world_from_estimate_world();
                estimates.push((name, poses.iter().map(|pose| alignment * pose).collect::<Vec<_>>()));
            }
            let title = format!("{}, seed {}", scored.results.scene, seed.0);
            folder.write("trajectory.svg", top_view(&title, &truth, &estimates)?.as_bytes())?;
            if !observations.detections.is_empty() {
                folder.write("crops.png", &sheet(&observations)?)?;
            }
        }
    }
    let curves = scored.unseen.iter().map(|(model, unseen)| (model.as_str(), mean_likelihood(unseen)));
    let curves: Vec<_> = curves.filter(|(_, curve)| !curve.is_empty()).collect();
    if !curves.is_empty() {
        let title = "Log-likelihood of a crop against azimuth, unseen asymmetric instances";
        let likelihood = likelihood_svg(title, &curves)?;
        folder.write("likelihood.svg", likelihood.as_bytes())?;
    }
    Ok(())
}

fn top_view(title: &str, truth: &Truth, estimates: &[(&str, Vec<Pose>)]) -> Result<String, BenchError> {
    let objects: Vec<(&str, [f64; 2], f64)> = truth
        .objects
        .iter()
        .map(|object| {
            let center = object.world_from_object.translation.vector;
            (object.family.as_str(), [center.x, center.y], object.size / 2.0)
        })
        .collect();
    // The control runs where the geometric estimate does.
    let dashed = &Row::Uninformative.to_string();
    Ok(trajectory_svg(&TopView {
        title,
        truth: &truth.world_from_robot,
        estimates,
        dashed,
        objects: &objects,
    })?)
}

/// One row an object, masked crops above boxed ones, evenly spread over the track.
fn sheet(observations: &Observations) -> Result<Vec<u8>, BenchError> {
    let mut tracks: BTreeMap<usize, Vec<(&Crop, &Crop)>> = BTreeMap::new();
    for detection in &observations.detections {
        tracks.entry(detection.track).or_default().push((&detection.masked_crop, &detection.boxed_crop));
    }
    let mut rows = Vec::new();
    for crops in tracks.values() {
        let picked: Vec<_> = (0..COLUMNS.min(crops.len()))
            .map(|column| crops[column * crops.len() / COLUMNS.min(crops.len())])
            .collect();
        rows.push(picked.iter().map(|(masked, _)| *masked).collect());
        rows.push(picked.iter().map(|(_, boxed)| *boxed).collect());
    }
    Ok(contact_sheet_png(&rows)?)
}

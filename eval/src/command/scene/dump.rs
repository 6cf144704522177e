//! `--dump`: what scores are made of, as NumPy arrays, so that anybody can compute them anew.

use super::line::Scored;
use crate::command::error::BenchError;
use crate::pipeline::{Answer, OnlineRun, ScoredViews, StageError, StoredObject, embedded, methods};
use crate::result::folder::ResultFolder;
use crate::score::embedded_set::EmbeddedSet;
use nalgebra::{DVector, Matrix3, Matrix6};
use std::io;
use vantage_dataset::store::{read_observations, read_truth};
use vantage_dataset::{Observations, Pose, Symmetry, Truth};
use vantage_formats::npz::{Elements, Npz};
use vantage_learn::Latent;

/// Writes `<seed>/truth.npz`, `<seed>/<row>.npz`, `<seed>/<row>.online.npz` and `<seed>/<model>.latents.npz`, array by array.
pub fn write(folder: &ResultFolder, scored: &Scored) -> Result<(), BenchError> {
    let methods = methods(&scored.rows, &scored.models);
    for ((seed, episode), (_, answers)) in scored.episodes.iter().zip(&scored.answers) {
        let Ok(episode) = episode else { continue };
        let observations = read_observations(&episode.folder).map_err(StageError::from)?;
        let truth = read_truth(&episode.folder).map_err(StageError::from)?;
        let seed = seed.0;
        folder.write_npz(&format!("{seed}/truth.npz"), |npz| of_truth(npz, &truth, &observations))?;
        for (method, answer) in methods.iter().zip(answers).filter(|(_, a)| !a.world_from_robot.is_empty()) {
            let (name, latent) = (method.name(), method.model.model.manifest().latent);
            let objects = truth.objects.len();
            folder.write_npz(&format!("{seed}/{name}.npz"), |npz| of_answer(npz, answer, objects, latent))?;
        }
    }
    for (seed, runs) in &scored.online {
        for (name, run) in scored.methods.iter().zip(runs) {
            let Some(Ok(run)) = run else { continue };
            folder.write_npz(&format!("{}/{name}.online.npz", seed.0), |npz| of_newest(npz, run))?;
        }
    }
    for ScoredViews { seed, set, .. } in &scored.views {
        for of in embedded(&scored.models, set)? {
            let name = format!("{}/{}.latents.npz", seed.0, of.name);
            folder.write_npz(&name, |npz| of_embeddings(npz, &of))?;
        }
    }
    Ok(())
}

fn of_truth(npz: &mut Npz, truth: &Truth, observations: &Observations) -> io::Result<()> {
    let objects = &truth.objects;
    npz.array("timestamps", &[observations.timestamps.len()], Elements::F64(&observations.timestamps))?;
    poses(npz, "world_from_robot", truth.world_from_robot.iter())?;
    poses(npz, "world_from_object", objects.iter().map(|object| &object.world_from_object))?;
    let instances: Vec<String> = objects.iter().map(|object| object.instance.to_string()).collect();
    let instances: Vec<&str> = instances.iter().map(String::as_str).collect();
    npz.array("object_instance", &[objects.len()], Elements::Text(&instances))?;
    let families: Vec<&str> = objects.iter().map(|object| object.family.as_str()).collect();
    npz.array("object_family", &[objects.len()], Elements::Text(&families))?;
    let symmetries: Vec<i64> = objects.iter().map(|object| turns(object.symmetry)).collect();
    npz.array("object_symmetry", &[objects.len()], Elements::I64(&symmetries))?;
    let numbered = observations.detections.iter().enumerate();
    let shown = numbered.map(|(i, detection)| truth.shown(i, detection).map(|_| detection.track));
    let shown: Vec<i64> = shown.map(number).collect();
    npz.array("detection_object", &[shown.len()], Elements::I64(&shown))
}

/// Turns about z that leave the look unchanged: 1 for none but the whole one, 0 for all.
fn turns(symmetry: Symmetry) -> i64 {
    match symmetry {
        Symmetry::None => 1,
        Symmetry::Cyclic { order } => i64::from(order),
        Symmetry::Revolution => 0,
    }
}

/// The newest pose after each step.
fn of_newest(npz: &mut Npz, run: &OnlineRun) -> io::Result<()> {
    poses(npz, "world_from_robot", run.newest.iter())?;
    run.covariances.as_ref().map_or(Ok(()), |of| covariances(npz, of))
}

/// What is not known is NaN; an array of which nothing is known is left out.
fn of_answer(npz: &mut Npz, answer: &Answer, objects: usize, latent: Latent) -> io::Result<()> {
    poses(npz, "world_from_robot", answer.world_from_robot.iter())?;
    answer.pose_covariances.as_ref().map_or(Ok(()), |of| covariances(npz, of))?;
    let stored: Vec<Option<&StoredObject>> =
        (0..objects).map(|i| answer.objects.get(i).and_then(Option::as_ref)).collect();
    let mut of_each = |name: &str, shape: &[usize], of: &dyn Fn(&StoredObject) -> Option<Vec<f64>>| {
        let found: Vec<Option<Vec<f64>>> = stored.iter().map(|object| of((*object)?)).collect();
        if found.iter().all(Option::is_none) {
            return Ok(());
        }
        let width: usize = shape.iter().product();
        let numbers: Vec<f64> =
            found.into_iter().flat_map(|numbers| numbers.unwrap_or_else(|| vec![f64::NAN; width])).collect();
        npz.array(name, &[&[objects], shape].concat(), Elements::F64(&numbers))
    };
    let matrix = |m: &Matrix3<f64>| rows(m).collect::<Vec<f64>>();
    of_each("object_center", &[3], &|o| Some(o.position.coords.as_slice().to_vec()))?;
    of_each("object_center_covariance", &[3, 3], &|o| o.position_covariance.as_ref().map(matrix))?;
    of_each("object_rotation", &[3, 3], &|o| Some(matrix(o.rotation?.to_rotation_matrix().matrix())))?;
    of_each("object_rotation_covariance", &[3, 3], &|o| o.rotation_covariance.as_ref().map(matrix))?;
    let length = |of: &dyn Fn(&StoredObject) -> Option<usize>| stored.iter().flatten().find_map(|o| of(o));
    let whole = length(&|o| Some(o.latent.as_ref()?[0].len())).unwrap_or(0);
    of_each("object_latent", &[whole], &|o| Some(o.latent.as_ref()?[0].clone()))?;
    of_each("object_latent_variance", &[whole], &|o| Some(o.latent.as_ref()?[1].clone()))?;
    let classes = length(&|o| Some(o.classes.as_ref()?.len())).unwrap_or(0);
    of_each("object_class_probability", &[classes], &|o| o.classes.clone())?;
    let steady = |o: &StoredObject| Some(latent.steady(&DVector::from_column_slice(&o.latent.as_ref()?[0])));
    let part = length(&|o| Some(steady(o)?.len())).unwrap_or(0);
    of_each("object_latent_steady", &[part], &steady)
}

fn of_embeddings(npz: &mut Npz, of: &EmbeddedSet) -> io::Result<()> {
    let n = of.embeddings.len();
    let numbers: Vec<f32> = of.embeddings.iter().flatten().copied().collect();
    npz.array("embedding", &[n, numbers.len() / n.max(1)], Elements::F32(&numbers))?;
    let mut labels = |name: &str, labels: Vec<i64>| npz.array(name, &[n], Elements::I64(&labels));
    let whole = |numbers: &[usize]| numbers.iter().map(|&label| label as i64).collect();
    labels("instance", whole(&of.labels.instances))?;
    labels("session", whole(&of.labels.sessions))?;
    labels("class", whole(&of.labels.classes))?;
    if let Some(given) = &of.clusters.given {
        labels("ward", whole(given))?;
    }
    if let Some(found) = &of.clusters.found {
        labels("hdbscan", found.found.iter().copied().map(number).collect())?;
    }
    Ok(())
}

fn number(of: Option<usize>) -> i64 {
    of.map_or(-1, |number| number as i64)
}

fn poses<'a>(npz: &mut Npz, name: &str, poses: impl ExactSizeIterator<Item = &'a Pose>) -> io::Result<()> {
    let shape = [poses.len(), 4, 4];
    let numbers: Vec<f64> =
        poses.flat_map(|pose| rows::<4>(&pose.to_homogeneous()).collect::<Vec<_>>()).collect();
    npz.array(name, &shape, Elements::F64(&numbers))
}

fn covariances(npz: &mut Npz, of: &[Matrix6<f64>]) -> io::Result<()> {
    let numbers: Vec<f64> = of.iter().flat_map(rows).collect();
    npz.array("pose_covariance", &[of.len(), 6, 6], Elements::F64(&numbers))
}

fn rows<const N: usize>(matrix: &nalgebra::SMatrix<f64, N, N>) -> impl Iterator<Item = f64> {
    let matrix = *matrix;
    (0..N * N).map(move |i| matrix[(i / N, i % N)])
}

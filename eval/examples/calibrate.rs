//! How much a crop is worth once its neighbours have been counted: ATE and consistency against
//! `estimator.semantic_information_scale`, on episodes with *validation* objects and seeds that no table uses.
//!
//! `cargo run --release -p vantage-eval --example calibrate -- scenes/sparse_loop.yaml 10`
//!
//! First line: what the box says, for `estimator.bearing_noise` and `estimator.size_over_box_side`: the root mean square
//! offset of the box centre from the object's centre in box sides, and the median of the object's size over the box
//! side at the object's distance; over boxes that the border does not cut.
//!
//! Columns then: the scale; mean ATE of `geometric` and `viewpoint_dependent`, metres; their mean paired difference and half
//! its 95% interval; the mean normalised estimation error squared (NEES, 1 where consistent) of position and rotation
//! over all poses of `viewpoint_dependent`.

use nalgebra::Point3;
use std::error::Error;
use std::path::Path;
use vantage_dataset::store::{read_observations, read_truth};
use vantage_dataset::{Observations, Pose, Seed, Split, Truth, se3};
use vantage_eval::cli::RendererChoice;
use vantage_eval::pipeline::{Pipeline, episodes, model};
use vantage_eval::score::ate::ate;
use vantage_eval::score::pairs::Pairs;
use vantage_eval::statistics::{Mean, quantile};
use vantage_slam::{Estimate, EstimatorSpec, Row, estimate};

/// First seed: far from those of scenes.
const FIRST_SEED: u64 = 1_000_000;
const SCALES: [f64; 7] = [1.0, 0.5, 0.25, 0.1, 0.05, 0.02, 0.01];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, count] = arguments.as_slice() else { return Err("usage: calibrate SCENE SEEDS".into()) };
    let pipeline = Pipeline::open(Path::new(scene), Path::new("cache"), RendererChoice::Auto)?;
    let folder = pipeline.file.training.reference.as_ref().map(|path| pipeline.folder.join(path));
    let loaded = model(&pipeline, folder.as_deref())?;
    let seeds: Vec<Seed> = (0..count.parse()?).map(|i| Seed(FIRST_SEED + i)).collect();
    let mut stored = Vec::new();
    for (_, episode) in episodes(&pipeline, &seeds, Split::Validation)? {
        let folder = episode?.folder;
        stored.push((read_observations(&folder)?, read_truth(&folder)?));
    }
    let (offset, size) = boxes(&stored);
    println!("box centre: {offset:.4} box sides; size over box side: {size:.3}");
    println!("scale  geometric  viewpoint  difference  half width  NEES position  NEES rotation");
    for scale in SCALES {
        let spec = EstimatorSpec {
            semantic_information_scale: scale,
            covariances: true,
            ..pipeline.file.estimator.clone()
        };
        let (mut errors, mut nees) = ([Vec::new(), Vec::new()], [Vec::new(), Vec::new()]);
        for (observations, truth) in &stored {
            for (row, errors) in [Row::Geometric, Row::ViewpointDependent].into_iter().zip(&mut errors) {
                let answer = estimate(observations, row, Some(&loaded.model), &spec)?;
                let pairs = Pairs::by_step(&truth.world_from_robot, &answer.world_from_robot)?;
                errors.push(ate(&pairs).ok_or("no ATE")?);
                if row == Row::ViewpointDependent {
                    for (nees, of_block) in nees.iter_mut().zip(consistency(&answer, &truth.world_from_robot))
                    {
                        nees.extend(of_block);
                    }
                }
            }
        }
        let mean = |values: &[f64]| Mean::of(values).map_or(f64::NAN, |mean| mean.mean);
        let differences: Vec<f64> = errors[1].iter().zip(&errors[0]).map(|(a, b)| a - b).collect();
        let half = Mean::of(&differences).and_then(|mean| mean.half_width).unwrap_or(f64::NAN);
        println!(
            "{scale:5}  {:9.4}  {:9.4}  {:10.4}  {half:10.4}  {:13.2}  {:13.2}",
            mean(&errors[0]),
            mean(&errors[1]),
            mean(&differences),
            mean(&nees[1]),
            mean(&nees[0])
        );
    }
    Ok(())
}

/// Root mean square of either coordinate of the box centre's offset, in box sides, and the median of size over side.
fn boxes(episodes: &[(Observations, Truth)]) -> (f64, f64) {
    let (mut squares, mut ratios) = (Vec::new(), Vec::new());
    for (observations, truth) in episodes {
        let camera = &observations.camera;
        for detection in &observations.detections {
            let seen = &detection.bounding_box;
            if seen.is_truncated(camera) {
                continue;
            }
            let object = &truth.objects[detection.track];
            let world_from_camera = truth.world_from_robot[detection.step] * observations.robot_from_camera;
            let center =
                world_from_camera.inverse() * Point3::from(object.world_from_object.translation.vector);
            if let Some(pixel) = camera.project(&center) {
                squares.extend(((seen.center() - pixel) / seen.side()).iter().map(|offset| offset * offset));
                ratios.push(object.size / (seen.side() / camera.fx * center.coords.norm()));
            }
        }
    }
    ratios.sort_by(f64::total_cmp);
    let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    (mean.sqrt(), quantile(&ratios, 0.5).unwrap_or(f64::NAN))
}

/// NEES over 3 of the rotation and of the translation, of each pose but the first.
fn consistency(answer: &Estimate, truth: &[Pose]) -> [Vec<f64>; 2] {
    let mut nees = [Vec::new(), Vec::new()];
    let (Some(covariances), Some(first)) = (&answer.pose_covariances, truth.first()) else { return nees };
    for ((pose, covariance), true_pose) in answer.world_from_robot.iter().zip(covariances).zip(truth).skip(1)
    {
        let error = se3::log(&(pose.inverse() * (first.inverse() * true_pose)));
        for (block, nees) in nees.iter_mut().enumerate() {
            let part = error.fixed_rows::<3>(3 * block).into_owned();
            if let Some(inverse) =
                covariance.fixed_view::<3, 3>(3 * block, 3 * block).into_owned().try_inverse()
            {
                nees.push((part.transpose() * inverse * part)[0] / 3.0);
            }
        }
    }
    nees
}

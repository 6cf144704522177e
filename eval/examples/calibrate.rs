//! The estimator's settings, fitted on episodes with *validation* objects and seeds that no table uses.
//!
//! `cargo run --release -p vantage-eval --example calibrate -- scenes/sparse_loop.yaml 30`
//!
//! First what boxes say, over those that the border does not cut: for `estimator.bearing_noise`, the root mean square of
//! the offset of the box centre from the object's centre, whole and in box sides; for `estimator.size_over_box_side`,
//! the median of the object's size over the box side at the object's distance.
//!
//! Then how much a crop is worth once its neighbours have been counted, by `estimator.semantic_information_scale`: mean
//! ATE, metres; its paired difference to `geometric` and half the 95% interval; and the mean normalised estimation
//! error squared of all poses (NEES over 6: 1 where consistent).

mod support;

use nalgebra::Point3;
use std::error::Error;
use support::{Episode, arguments, columns, scored, validation_episodes};
use vantage_dataset::{Pose, se3};
use vantage_eval::pipeline::model;
use vantage_eval::result::statistics::quantile;
use vantage_slam::{Estimate, Estimator, Geometric, Semantic};

const SCALES: [f64; 5] = [1.0, 0.5, 0.25, 0.1, 0.05];

fn main() -> Result<(), Box<dyn Error>> {
    let (pipeline, count) = arguments()?;
    let folder = pipeline.file.training.reference.as_ref().map(|path| pipeline.folder.join(path));
    let loaded = model(&pipeline, folder.as_deref())?;
    let episodes = validation_episodes(&pipeline, count)?;

    let boxes = Boxes::of(&episodes);
    println!("box centre off by {:.5} of the focal length, {:.4} box sides", boxes.offset, boxes.in_sides);
    println!("size over box side: {:.3}", boxes.size_over_side);

    println!("scale        ATE  difference  half width   NEES");
    let mut settings = pipeline.file.estimator.settings();
    settings.solver.covariances = true;
    let of =
        |estimator: &dyn Estimator| scored(&episodes, |episode| estimator.estimate(&episode.observations));
    let errors = |answers: &[(Estimate, f64)]| answers.iter().map(|(_, error)| *error).collect::<Vec<_>>();
    let geometric = of(&Geometric::new(&settings))?;
    let reference = errors(&geometric);
    println!("    -   {}  {:5.2}", columns(&reference, &reference), mean_nees(&geometric, &episodes));
    for scale in SCALES {
        settings.semantics.information_scale = scale;
        let answers = of(&Semantic::new(&settings, loaded.viewing()))?;
        println!(
            "{scale:5}   {}  {:5.2}",
            columns(&errors(&answers), &reference),
            mean_nees(&answers, &episodes)
        );
    }
    Ok(())
}

/// What boxes say of objects.
struct Boxes {
    offset: f64,
    in_sides: f64,
    size_over_side: f64,
}

impl Boxes {
    fn of(episodes: &[Episode]) -> Self {
        let (mut offsets, mut in_sides, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
        for Episode { observations, truth } in episodes {
            let camera = &observations.camera;
            for detection in &observations.detections {
                let seen = &detection.bounding_box;
                if seen.is_truncated(camera) {
                    continue;
                }
                let object = &truth.objects[detection.track];
                let world_from_camera =
                    truth.world_from_robot[detection.step] * observations.robot_from_camera;
                let center =
                    world_from_camera.inverse() * Point3::from(object.world_from_object.translation.vector);
                if let Some(pixel) = camera.project(&center) {
                    let offset = seen.center() - pixel;
                    offsets.extend(offset.iter().map(|pixels| (pixels / camera.fx).powi(2)));
                    in_sides.extend(offset.iter().map(|pixels| (pixels / seen.side()).powi(2)));
                    ratios.push(object.size / (seen.side() / camera.fx * center.coords.norm()));
                }
            }
        }
        ratios.sort_by(f64::total_cmp);
        let root_mean = |squares: &[f64]| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        Self {
            offset: root_mean(&offsets),
            in_sides: root_mean(&in_sides),
            size_over_side: quantile(&ratios, 0.5).unwrap_or(f64::NAN),
        }
    }
}

/// NEES over 6 of all poses but the first, which is the world's frame; not a number where one has no covariance.
fn mean_nees(answers: &[(Estimate, f64)], episodes: &[Episode]) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for ((answer, _), episode) in answers.iter().zip(episodes) {
        let truth = &episode.truth.world_from_robot;
        let Some(covariances) = &answer.pose_covariances else { return f64::NAN };
        for ((pose, covariance), true_pose) in
            answer.world_from_robot.iter().zip(covariances).zip(truth).skip(1)
        {
            let true_pose: Pose = truth[0].inverse() * true_pose;
            let error = se3::log(&pose.inv_mul(&true_pose));
            let Some(inverse) = covariance.try_inverse() else { return f64::NAN };
            sum += (error.transpose() * inverse * error)[0] / 6.0;
            count += 1;
        }
    }
    sum / f64::from(count)
}

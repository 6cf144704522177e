//! `bench calibrate SCENE [N]`: the estimator's settings, fitted on validation objects.
//!
//! First what boxes say, over those that the border does not cut: for `estimator.bearing_noise`, the root mean square of
//! the offset of the box centre from the object's centre, whole and in box sides; for `estimator.size_over_box_side`,
//! the median of the object's size over the box side at the object's distance.
//!
//! Then how much a crop is worth once its neighbours have been counted, by `estimator.semantic_information_scale`: mean
//! ATE, its paired difference to `geometric`, and the mean normalised estimation error squared of all poses (NEES over 6:
//! 1 where consistent). Likewise of the rows beside a model's that the scene names: `gaussian_process`, whose hyper-parameters of
//! most marginal likelihood are told, `azimuth_head` and `discrete_class`.

use super::{Trial, columns, estimated, open, print, trials};
use crate::command::cli::CalibrateArgs;
use crate::command::error::BenchError;
use crate::exit::Exit;
use crate::pipeline::{chosen_model, model};
use crate::result::statistics::quantile;
use crate::scene_file::row::Row;
use nalgebra::Point3;
use std::io::Write;
use vantage_dataset::{ObjectTruth, Pose, Viewpoint, se3};
use vantage_learn::gaussian_process::Hyperparameters;
use vantage_slam::{Estimate, Estimator, Geometric, Semantic};

const SCALES: [f64; 5] = [1.0, 0.5, 0.25, 0.1, 0.05];

/// Prints what boxes say, and the ATE by the scale of a crop's information.
pub fn calibrate(args: &CalibrateArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let CalibrateArgs { validation: args, model: named } = args;
    let pipeline = open(args)?;
    let loaded = model(&pipeline, chosen_model(&pipeline, false, named.as_deref())?.as_deref())?;
    let trials = trials(&pipeline, args)?;
    let instances =
        |trial: &Trial| trial.truth.objects.iter().map(|object| object.instance).collect::<Vec<_>>();
    loaded.check_unseen(trials.iter().flat_map(instances))?;

    let boxes = Boxes::of(&trials);
    writeln!(
        stdout,
        "box centre off by {:.5} of the focal length, {:.4} box sides",
        boxes.offset, boxes.in_sides
    )?;
    writeln!(stdout, "size over box side: {:.3}\n", boxes.size_over_side)?;

    let (fitted, likelihood) = of_gaussian_process(&trials);
    writeln!(stdout, "gaussian process, log marginal likelihood {likelihood:.0}: {fitted:#.4?}\n")?;

    let mut settings = pipeline.file.estimator.settings();
    settings.solver.covariances = true;
    let of = |estimator: &dyn Estimator| {
        estimated(&pipeline, &trials, |trial| estimator.estimate(&trial.observations))
    };
    let errors = |answers: &[(Estimate, f64)]| answers.iter().map(|(_, error)| *error).collect::<Vec<_>>();
    let geometric = of(&Geometric::new(&settings))?;
    let reference = errors(&geometric);
    let line = |name: String, answers: &[(Estimate, f64)]| -> Vec<String> {
        let nees = format!("{:.2}", mean_nees(answers, &trials));
        std::iter::once(name).chain(columns(&errors(answers), &reference)).chain([nees]).collect()
    };
    let mut rows = vec![line("geometric".to_owned(), &geometric)];
    for scale in SCALES {
        settings.semantics.information_scale = scale;
        rows.push(line(scale.to_string(), &of(&Semantic::new(&settings, loaded.viewing()))?));
    }
    let rivals = pipeline.file.estimator.rows.iter().filter(|row| !Row::DEFAULT.contains(row));
    for &row in rivals {
        for scale in SCALES {
            settings.semantics.information_scale = scale;
            let answers = of(&*row.estimator(&settings, loaded.reader()))?;
            rows.push(line(format!("{row} {scale}"), &answers));
        }
    }
    print(stdout, &["Scale", "ATE [m]", "Difference [m]", "+- 95% [m]", "NEES / 6"], rows)?;
    Ok(Exit::Success)
}

/// What boxes say of objects.
struct Boxes {
    offset: f64,
    in_sides: f64,
    size_over_side: f64,
}

impl Boxes {
    fn of(trials: &[Trial]) -> Self {
        let (mut offsets, mut in_sides, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
        for Trial { observations, truth } in trials {
            let camera = &observations.camera;
            for detection in &observations.detections {
                let seen = &detection.bounding_box;
                if seen.is_truncated(camera) {
                    continue;
                }
                let Some(object) = truth.objects.get(detection.track) else { continue };
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

/// The hyper-parameters that objects ask for.
fn of_gaussian_process(trials: &[Trial]) -> (Hyperparameters, f64) {
    let of_trial = |Trial { observations, truth }: &'_ Trial| {
        let object = |(track, object): (usize, &ObjectTruth)| {
            let detections = observations.detections.iter().filter(|detection| detection.track == track);
            let views = detections.filter_map(|detection| {
                let world_from_camera =
                    truth.world_from_robot[detection.step] * observations.robot_from_camera;
                let object_from_camera = object.world_from_object.inv_mul(&world_from_camera);
                let viewpoint = Viewpoint::new(&object_from_camera, object.size)?;
                Some((detection.masked_crop.clone(), viewpoint.azimuth()))
            });
            views.collect::<Vec<_>>()
        };
        truth.objects.iter().enumerate().map(object).collect::<Vec<_>>()
    };
    let objects: Vec<_> = trials.iter().flat_map(of_trial).collect();
    let lent: Vec<Vec<_>> =
        objects.iter().map(|views| views.iter().map(|(crop, azimuth)| (crop, *azimuth)).collect()).collect();
    Hyperparameters::fit(&lent)
}

/// NEES over 6 of all poses but the first, which is the world's frame; not a number where one has no covariance.
fn mean_nees(answers: &[(Estimate, f64)], trials: &[Trial]) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for ((answer, _), trial) in answers.iter().zip(trials) {
        let truth = &trial.truth.world_from_robot;
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

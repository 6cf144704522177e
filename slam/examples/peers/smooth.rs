//! The graph of [`crate::ring`], taken in step by step.

use crate::Failure;
use crate::clock::{cpu_seconds, peak_bytes};
use crate::numbers::{Numbers, Source};
use crate::view::ViewFactor;
use nalgebra::{DVector, Matrix6, Vector6};
use std::collections::BTreeSet;
use std::path::Path;
use std::time::Instant;
use vantage_dataset::Pose;
use vantage_slam::Key;
use vantage_slam::factor::{BetweenFactor, PosePrior, StandardNormalPrior};
use vantage_slam::graph::Graph;
use vantage_slam::incremental::{Smoother, Thresholds};
use vantage_slam::variable::{Value, Values};

/// What is left of a change, as a share of the relinearization threshold; and most iterations, as when a robot is followed step by step.
const PROPAGATION: f64 = 0.01;
const ITERATIONS: usize = 2;
const REJECTIONS: usize = 8;
/// Square roots of information, of the first pose and of each object.
const GAUGE: f64 = 1e3;
const WEAK: f64 = 0.1;

/// Prints peak memory; writes two times of each step, of the processor and on the wall, and at the end the values of poses, objects and
/// latents, as they are and settled.
pub fn run(graph: &Path, relinearization: f64, times: &Path, maximum: &Path) -> Result<(), Failure> {
    let mut source = Source::open(graph)?;
    let mut count = || source.take_count();
    let (poses, detections, objects, latent, measurement) =
        (count()?, count()?, count()?, count()?, count()?);
    let [rotation, translation] = source.take(2)?[..] else { return Err("no deviations".into()) };
    let deviations = Vector6::from_fn(|i, _| if i < 3 { rotation } else { translation });
    let odometry = Matrix6::from_diagonal(&deviations.map(|deviation| 1.0 / deviation));
    let propagation = PROPAGATION * relinearization;
    let mut smoother = Smoother::new(Thresholds {
        relinearization,
        propagation,
        iterations: ITERATIONS,
        rejections: REJECTIONS,
    });
    let mut seen = BTreeSet::new();
    let mut seconds = Numbers::create(times)?;
    let held = peak_bytes()?;
    for step in 0..poses {
        let (mut graph, mut first) = (Graph::default(), Values::default());
        let (motion, base) = (source.take_pose()?, source.take_pose()?);
        let robot = match step.checked_sub(1).map(Key::Robot) {
            Some(before) => {
                graph.push(BetweenFactor::new(before, Key::Robot(step), motion, odometry));
                smoother.values().pose(before).ok_or("no pose before")? * motion
            }
            None => {
                graph.push(PosePrior::new(Key::Robot(0), base, Matrix6::identity() * GAUGE));
                base
            }
        };
        first.insert(Key::Robot(step), Value::Pose(robot));
        for _ in 0..detections {
            let object = source.take_count()?;
            let (robot_from_object, object_base) = (source.take_pose()?, source.take_pose()?);
            let keys = [Key::Robot(step), Key::Object(object), Key::Latent(object)];
            if seen.insert(object) {
                first.insert(keys[1], Value::Pose(robot * robot_from_object));
                first.insert(keys[2], Value::Vector(DVector::zeros(latent)));
                graph.push(PosePrior::new(keys[1], object_base, Matrix6::identity() * WEAK));
                graph.push(StandardNormalPrior::new(keys[2]));
            }
            let mut matrix = |columns| source.take_matrix(measurement, columns);
            let jacobians = [matrix(6)?, matrix(6)?, matrix(latent)?];
            let constant = DVector::from_vec(source.take(measurement)?);
            graph.push(ViewFactor { keys, bases: [base, object_base], jacobians, constant });
        }
        let (cpu, wall) = (cpu_seconds(), Instant::now());
        smoother.add(graph, &first);
        smoother.update().map_err(|error| format!("{error:?}"))?;
        seconds.put(&[cpu_seconds() - cpu, wall.elapsed().as_secs_f64()])?;
    }
    seconds.finish()?;
    println!("memory {}", peak_bytes()? - held);
    let mut values = Numbers::create(maximum)?;
    put(&mut values, &smoother, poses, objects)?;
    smoother.settle(1e-14, 30).map_err(|error| format!("{error:?}"))?;
    put(&mut values, &smoother, poses, objects)?;
    values.finish()
}

fn put(numbers: &mut Numbers, smoother: &Smoother<'_>, poses: usize, objects: usize) -> Result<(), Failure> {
    let keys = (0..poses).map(Key::Robot).chain((0..objects).map(Key::Object));
    for key in keys.chain((0..objects).map(Key::Latent)) {
        match smoother.values().get(key) {
            Some(Value::Pose(pose)) => numbers.put_pose(pose)?,
            Some(Value::Vector(vector)) => numbers.put(vector.as_slice())?,
            _ => numbers.put_pose(&Pose::identity())?,
        }
    }
    Ok(())
}

//! A graph of the size that ours have: a robot drives twice round a ring of objects, and sees the nearest ones.

use crate::Failure;
use crate::numbers::Numbers;
use nalgebra::{DMatrix, DVector, Vector3};
use std::f64::consts::TAU;
use std::path::Path;
use vantage_dataset::{Pose, Seed, Tangent, se3};

const POSES: usize = 1000;
const LAPS: f64 = 2.0;
const OBJECTS: usize = 100;
const DETECTIONS: usize = 5;
const MEASUREMENT: usize = 32;
/// Metres.
const RADIUS: f64 = 24.0;
/// Standard deviations of odometry, radians and metres a step.
const ODOMETRY: [f64; 2] = [0.002, 0.01];
/// Of what an object's first value is off, seen from the robot, radians and metres.
const FIRST: [f64; 2] = [0.05, 0.1];
/// Of the entries of whitened derivatives by a pose and by a latent.
const DERIVATIVES: [f64; 2] = [1.5, 0.35];

fn on_ring(turn: f64, radius: f64) -> Pose {
    let place = Pose::translation(radius * libm::cos(turn), radius * libm::sin(turn), 0.0);
    place * Pose::rotation(Vector3::new(0.0, 0.0, turn + TAU / 4.0))
}

/// Writes counts (poses, detections a pose, objects, latent, measurement) and deviations of odometry; then for each pose motion from the
/// one before, `x_0`, and for each detection the object's number, its pose as first seen from the robot, `o_0`, `A_x`, `A_o`, `A_e`, `c`.
pub fn write(latent: usize, path: &Path) -> Result<(), Failure> {
    let mut stream = Seed(7).stream("ring", 0);
    let mut random = |[rotation, translation]: [f64; 2]| {
        Tangent::from_fn(|i, _| stream.normal() * if i < 3 { rotation } else { translation })
    };
    let objects: Vec<Pose> = (0..OBJECTS)
        .map(|object| {
            let side = if object % 2 == 0 { 3.0 } else { -3.0 };
            on_ring(TAU * object as f64 / OBJECTS as f64, RADIUS + side) * se3::exp(&random([0.5, 0.5]))
        })
        .collect();
    let mut stream = Seed(7).stream("ring", 1);
    let latents: Vec<DVector<f64>> =
        objects.iter().map(|_| DVector::from_fn(latent, |_, _| stream.normal())).collect();
    let mut numbers = Numbers::create(path)?;
    numbers.put(&[POSES, DETECTIONS, OBJECTS, latent, MEASUREMENT].map(|count| count as f64))?;
    numbers.put(&ODOMETRY)?;
    let mut before = on_ring(0.0, RADIUS);
    for step in 0..POSES {
        let robot = on_ring(LAPS * TAU * step as f64 / POSES as f64, RADIUS);
        numbers.put_pose(&(before.inv_mul(&robot) * se3::exp(&random(ODOMETRY))))?;
        numbers.put_pose(&robot)?;
        before = robot;
        let away = |object: &usize| (objects[*object].translation.vector - robot.translation.vector).norm();
        let mut nearest: Vec<usize> = (0..OBJECTS).collect();
        nearest.sort_by(|a, b| away(a).total_cmp(&away(b)));
        for object in nearest.into_iter().take(DETECTIONS) {
            let robot_from_object = robot.inv_mul(&objects[object]);
            let mut matrix =
                |columns, scale| DMatrix::from_fn(MEASUREMENT, columns, |_, _| scale * stream.normal());
            let by_robot = matrix(6, DERIVATIVES[0]);
            // What moves both leaves the view as it is.
            let by_object = -&by_robot * se3::adjoint(&robot_from_object);
            let by_latent = matrix(latent, DERIVATIVES[1]);
            let constant = matrix(1, 1.0) - &by_latent * &latents[object];
            numbers.put(&[object as f64])?;
            numbers.put_pose(&(robot_from_object * se3::exp(&random(FIRST))))?;
            numbers.put_pose(&objects[object])?;
            numbers.put(by_robot.as_slice())?;
            numbers.put(by_object.as_slice())?;
            numbers.put(by_latent.as_slice())?;
            numbers.put(constant.as_slice())?;
        }
    }
    numbers.finish()
}

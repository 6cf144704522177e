//! Pose graphs as g2o text, which g2o, GTSAM, Ceres' examples and SE-Sync read.
//!
//! `VERTEX_SE3:QUAT id x y z qx qy qz qw` and `EDGE_SE3:QUAT i j x y z qx qy qz qw`, then the upper triangle of the
//! information, row by row, translation before rotation. The information is that of a right perturbation in radians, as GTSAM
//! takes it; g2o itself perturbs by the quaternion's vector, half as long.

use nalgebra::Matrix6;
use std::fmt::Write;
use vantage_dataset::store::pose_fields;
use vantage_dataset::{Odometry, Pose};

/// The text of odometry as edges between `initial` poses (`world_from_robot` by step), the first of them fixed.
///
/// An edge whose covariance has no inverse is left out.
pub fn encode(initial: &[Pose], odometry: &[Odometry]) -> String {
    let mut text = String::new();
    let mut line = |line: std::fmt::Arguments<'_>| {
        let _ = writeln!(text, "{line}");
    };
    for (step, pose) in initial.iter().enumerate() {
        line(format_args!("VERTEX_SE3:QUAT {step} {}", numbers(&pose_fields(pose))));
    }
    if !initial.is_empty() {
        line(format_args!("FIX 0"));
    }
    for edge in odometry {
        let Some(information) = edge.covariance.try_inverse() else { continue };
        let measured = numbers(&pose_fields(&edge.robot_from_robot));
        let upper = numbers(&upper_triangle(&translation_first(&information)));
        line(format_args!("EDGE_SE3:QUAT {} {} {measured} {upper}", edge.from, edge.to));
    }
    text
}

/// From rotation before translation.
fn translation_first(information: &Matrix6<f64>) -> Matrix6<f64> {
    Matrix6::from_fn(|row, column| information[((row + 3) % 6, (column + 3) % 6)])
}

fn upper_triangle(matrix: &Matrix6<f64>) -> Vec<f64> {
    (0..6).flat_map(|row| (row..6).map(move |column| matrix[(row, column)])).collect()
}

fn numbers(values: &[f64]) -> String {
    values.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector3, Vector6};

    #[test]
    fn an_edge_has_its_information_translation_first() {
        let motion = Pose::translation(1.0, 0.0, 0.5);
        let variances = Vector6::new(0.25, 0.5, 1.0, 2.0, 4.0, 8.0);
        let edge = Odometry {
            from: 0,
            to: 1,
            robot_from_robot: motion,
            covariance: Matrix6::from_diagonal(&variances),
        };
        let text = encode(&[Pose::new(Vector3::zeros(), Vector3::zeros()), motion], &[edge]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1");
        assert_eq!(lines[2], "FIX 0");
        let information = "0.5 0 0 0 0 0 0.25 0 0 0 0 0.125 0 0 0 4 0 0 2 0 1";
        assert_eq!(lines[3], format!("EDGE_SE3:QUAT 0 1 1 0 0.5 0 0 0 1 {information}"));
    }
}

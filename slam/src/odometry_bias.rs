//! Odometry's bias: an error that grows with the distance and is the same all through an episode.

use garde::Validate;
use nalgebra::{Matrix6, Matrix6x2};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::Odometry;
use vantage_dataset::rule::not_nan;

/// Where a tangent has the yaw, and the way along.
const YAW: usize = 2;
const ALONG: usize = 3;

/// What a robot's data sheet says of the bias: the deviations from which each episode draws it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct OdometryBias {
    /// Standard deviation of the scale error of the distance along, metres per metre.
    #[garde(range(min = 0.0, max = 1.0), custom(not_nan))]
    pub translation_per_metre: f64,
    /// Standard deviation of the drift of the yaw, degrees per metre.
    #[garde(range(min = 0.0, max = 360.0), custom(not_nan))]
    pub rotation_deg_per_metre: f64,
}

impl OdometryBias {
    /// Numbers of the bias.
    pub const DIM: usize = 2;

    /// `B` with `measured = true motion * Exp(B b + white noise)` for a bias `b`, along and yaw, that is standard normal.
    ///
    /// The distance is that of the measured motion.
    pub fn response(&self, odometry: &Odometry) -> Matrix6x2<f64> {
        let distance = odometry.robot_from_robot.translation.vector.norm();
        let mut response = Matrix6x2::zeros();
        response[(ALONG, 0)] = self.translation_per_metre * distance;
        response[(YAW, 1)] = self.rotation_deg_per_metre.to_radians() * distance;
        response
    }

    /// The covariance of the white noise: that of the whole error, as it is told, less the bias's.
    pub fn white(&self, odometry: &Odometry) -> Matrix6<f64> {
        let response = self.response(odometry);
        odometry.covariance - response * response.transpose()
    }
}

//! A camera carried by hand.

use super::Drive;
use crate::scene::HandheldSpec;
use std::f64::consts::PI;
use vantage_dataset::{Pose, Seed, Stream, Tangent, se3};

/// Sinusoids that add up in each degree of freedom.
const WAVES: usize = 3;

/// Sways the camera about where a robot would have held it; the robot's frame goes with it.
///
/// Stream: `hand`, once. The offset is `Exp` of a tangent
/// within `tilt_deg` degrees about and `sway` metres along each axis.
pub fn sway(spec: &HandheldSpec, robot_from_camera: &Pose, drive: &mut Drive, seed: Seed) {
    let mut stream = seed.stream("hand", 0);
    let amplitudes = [spec.tilt_deg.to_radians(), spec.sway];
    let waves: Vec<Wave> = (0..6).map(|i| Wave::draw(amplitudes[i / 3], spec.period, &mut stream)).collect();
    for (time, pose) in drive.timestamps.iter().zip(&mut drive.world_from_robot) {
        let offset = se3::exp(&Tangent::from_fn(|i, _| waves[i].at(*time)));
        *pose = *pose * robot_from_camera * offset * robot_from_camera.inverse();
    }
}

/// A sum of sinusoids of equal share.
struct Wave {
    amplitude: f64,
    /// Radians a second, and radians.
    terms: [[f64; 2]; WAVES],
}

impl Wave {
    fn draw(amplitude: f64, period: f64, stream: &mut Stream) -> Self {
        let terms = std::array::from_fn(|i| {
            let longer = 1.0 + i as f64 + stream.unit();
            [2.0 * PI / (period * longer), stream.uniform(-PI, PI)]
        });
        Self { amplitude, terms }
    }

    fn at(&self, time: f64) -> f64 {
        let sum: f64 = self.terms.iter().map(|[rate, phase]| libm::sin(rate * time + phase)).sum();
        self.amplitude * sum / WAVES as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn the_camera_sways_within_bounds_in_every_degree_of_freedom() {
        let mount = Pose::new(Vector3::new(0.0, 0.0, 1.2), Vector3::new(-1.5, 0.3, 0.0));
        let spec = HandheldSpec { sway: 0.05, tilt_deg: 4.0, period: 2.0 };
        let timestamps: Vec<f64> = (0..400).map(|i| f64::from(i) * 0.1).collect();
        let mut drive =
            Drive { world_from_robot: vec![Pose::identity(); 400], timestamps, middle: 0.5, carried: None };
        sway(&spec, &mount, &mut drive, Seed(5));
        let offsets: Vec<Tangent> =
            drive.world_from_robot.iter().map(|pose| se3::log(&(mount.inverse() * pose * mount))).collect();
        for axis in 0..6 {
            let bound = if axis < 3 { 4f64.to_radians() } else { 0.05 };
            let reach = offsets.iter().map(|offset| offset[axis].abs()).fold(0.0, f64::max);
            assert!((0.3 * bound..=bound + 1e-12).contains(&reach), "axis {axis}: {reach} of {bound}");
        }
    }
}

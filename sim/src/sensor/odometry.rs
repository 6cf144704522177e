//! Odometry: the motion between two steps, measured with errors that grow with it, `u_k` of Eq. 1.

use crate::scene::{OdometrySpec, SlipSpec};
use nalgebra::Matrix6;
use vantage_dataset::{Odometry, Pose, Seed, Tangent, se3};

/// Standard deviations that even a standing robot's odometry has: radians and metres.
const FLOOR: [f64; 2] = [1e-4, 1e-4];

/// Standard deviations of where a robot is carried: radians of its heading and metres along the floor, as wide as those of any heading and any place
/// in a room; out of the plane it stays on the floor.
const CARRIED: [f64; 6] = [0.01, 0.01, 2.5, 4.0, 4.0, 0.01];

/// Standard deviations of one measurement, rotation first; and of its part that is the same all through an episode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Drawn anew at each step.
    pub independent: Tangent,
    /// The episode's bias times the distance travelled.
    pub bias: Tangent,
}

impl Noise {
    /// The noise of a motion `from_robot_from_to_robot`.
    pub fn of_motion(spec: &OdometrySpec, motion: &Pose) -> Self {
        let distance = motion.translation.vector.norm();
        let angle = se3::so3_log(&motion.rotation).norm();
        let rotation =
            [FLOOR[0], spec.rotation_deg_per_metre.to_radians() * distance, spec.rotation_per_radian * angle]
                .iter()
                .map(|sigma| sigma * sigma)
                .sum::<f64>()
                .sqrt();
        let translation = (FLOOR[1] * FLOOR[1]
            + spec.translation_per_metre * spec.translation_per_metre * distance * distance)
            .sqrt();
        let out = spec.out_of_plane;
        let least = |sigma: f64, floor: f64| (sigma * out).max(floor);
        let yaw_bias = spec.bias_rotation_deg_per_metre.to_radians() * distance;
        let along_bias = spec.bias_translation_per_metre * distance;
        Self {
            independent: Tangent::new(
                least(rotation, FLOOR[0]),
                least(rotation, FLOOR[0]),
                rotation,
                translation,
                translation,
                least(translation, FLOOR[1]),
            ),
            bias: Tangent::new(0.0, 0.0, yaw_bias, along_bias, 0.0, 0.0),
        }
    }

    /// Covariance of one measurement by itself. Measurements of one episode share the bias, so that their errors are
    /// correlated, which this does not say.
    pub fn covariance(&self) -> Matrix6<f64> {
        let variances =
            self.independent.component_mul(&self.independent) + self.bias.component_mul(&self.bias);
        Matrix6::from_diagonal(&variances)
    }
}

/// Measures every motion between consecutive true poses: `true motion * Exp(noise)`.
///
/// Streams: `odometry` by step, `odometry bias` once. Both draw standard normals that the noise model scales, so
/// that a change of the model changes the size of the errors, not their shape. Of the motion to the step before which the robot is `carried`
/// nothing is measured: it is told as none, of a covariance as wide as any.
pub fn measure(
    spec: &OdometrySpec,
    world_from_robot: &[Pose],
    carried: Option<usize>,
    seed: Seed,
) -> Vec<Odometry> {
    let mut bias_stream = seed.stream("odometry bias", 0);
    let bias = Tangent::from_fn(|_, _| bias_stream.normal());
    world_from_robot
        .windows(2)
        .enumerate()
        .map(|(from, pair)| {
            if carried == Some(from + 1) {
                let covariance = Matrix6::from_diagonal(&Tangent::from(CARRIED.map(|sigma| sigma * sigma)));
                return Odometry { from, to: from + 1, robot_from_robot: Pose::identity(), covariance };
            }
            let motion = pair[0].inv_mul(&pair[1]);
            let noise = Noise::of_motion(spec, &motion);
            let mut stream = seed.stream("odometry", from as u64);
            let independent = Tangent::from_fn(|_, _| stream.normal());
            let error = noise.independent.component_mul(&independent) + noise.bias.component_mul(&bias);
            let mut measured = motion * se3::exp(&error);
            if let Some(slip) = &spec.slip {
                measured.translation.vector *= slipped(slip, from, seed);
            }
            Odometry { from, to: from + 1, robot_from_robot: measured, covariance: noise.covariance() }
        })
        .collect()
}

/// By which the distance of a step is overstated: 1 where no wheel slips. Stream: `slip`, by step.
fn slipped(spec: &SlipSpec, step: usize, seed: Seed) -> f64 {
    let mut stream = seed.stream("slip", step as u64);
    let slips = stream.chance(spec.probability);
    let excess = stream.uniform(0.0, spec.excess);
    if slips { 1.0 + excess } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn wheels_slip_as_often_as_they_are_told_and_disturb_no_other_noise() {
        let track: Vec<Pose> = (0..2001).map(|i| Pose::translation(0.4 * f64::from(i), 0.0, 0.0)).collect();
        let slipping = OdometrySpec { slip: Some(SlipSpec { probability: 0.1, excess: 0.5 }), ..spec() };
        let (plain, slipped) =
            (measure(&spec(), &track, None, Seed(3)), measure(&slipping, &track, None, Seed(3)));
        let ratios: Vec<f64> = plain
            .iter()
            .zip(&slipped)
            .map(|(a, b)| b.robot_from_robot.translation.x / a.robot_from_robot.translation.x)
            .collect();
        let slips: Vec<f64> = ratios.iter().copied().filter(|ratio| *ratio > 1.0 + 1e-9).collect();
        assert!((150..250).contains(&slips.len()), "{} of 2000", slips.len());
        assert!(slips.iter().all(|ratio| *ratio <= 1.5));
        assert_eq!(ratios.iter().filter(|ratio| (**ratio - 1.0).abs() < 1e-12).count(), 2000 - slips.len());
        assert_eq!(plain[7].covariance, slipped[7].covariance);
    }

    fn spec() -> OdometrySpec {
        OdometrySpec {
            translation_per_metre: 0.05,
            rotation_deg_per_metre: 2.0,
            rotation_per_radian: 0.05,
            out_of_plane: 0.2,
            bias_translation_per_metre: 0.03,
            bias_rotation_deg_per_metre: 1.5,
            slip: None,
        }
    }

    fn motion() -> Pose {
        Pose::new(Vector3::new(0.4, 0.02, 0.0), Vector3::new(0.0, 0.0, 0.1))
    }

    /// Squared Mahalanobis distances of one measurement in each of `n` episodes, summed: chi-square with 6n degrees.
    fn chi_square(n: u64, steps: usize) -> f64 {
        let mut pose = Pose::identity();
        let track: Vec<Pose> = (0..=steps)
            .map(|_| {
                let here = pose;
                pose *= motion();
                here
            })
            .collect();
        (0..n)
            .map(|seed| {
                let measured = &measure(&spec(), &track, None, Seed(seed))[steps - 1];
                let error = se3::log(&(motion().inverse() * measured.robot_from_robot));
                let inverse = measured.covariance.try_inverse().unwrap();
                (error.transpose() * inverse * error).x
            })
            .sum()
    }

    #[test]
    fn errors_have_the_covariance_they_claim() {
        let (n, steps) = (2_000, 3);
        let degrees = 6.0 * n as f64;
        let deviation = (chi_square(n, steps) - degrees) / (2.0 * degrees).sqrt();
        assert!(deviation.abs() < 3.5, "{deviation:.2} standard deviations from chi-square");
    }

    #[test]
    fn noise_grows_with_the_motion_and_never_vanishes() {
        let still = Noise::of_motion(&spec(), &Pose::identity());
        assert!(still.covariance().cholesky().is_some());
        let (once, thrice) = (motion(), motion() * motion() * motion());
        let (a, b) = (Noise::of_motion(&spec(), &once), Noise::of_motion(&spec(), &thrice));
        assert!((b.independent - a.independent).min() > 0.0);
        let silent = OdometrySpec { bias_translation_per_metre: 0.0, ..spec() };
        assert_eq!(Noise::of_motion(&silent, &once).bias.fixed_rows::<3>(3).norm(), 0.0);
    }

    #[test]
    fn the_bias_is_the_same_in_all_of_an_episode() {
        let only_bias = OdometrySpec {
            translation_per_metre: 0.0,
            rotation_deg_per_metre: 0.0,
            rotation_per_radian: 0.0,
            ..spec()
        };
        let track = [Pose::identity(), motion(), motion() * motion()];
        let measured = measure(&only_bias, &track, None, Seed(4));
        let yaw_error = |i: usize| se3::log(&(motion().inverse() * measured[i].robot_from_robot))[2];
        assert!(yaw_error(0).abs() > 1e-3, "{}", yaw_error(0));
        assert!((yaw_error(0) - yaw_error(1)).abs() < 1e-3);
    }
}

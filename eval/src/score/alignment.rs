//! Ways to lay an estimate on the truth before poses are compared: those of evo, and one that turns about z alone.

use super::align::{Similarity, similarity};
use super::pairs::{Pairs, PairsError};
use clap::ValueEnum;
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use serde::Serialize;
use thiserror::Error;
use vantage_dataset::Pose;

/// Positions that spread less across their line than this share of what they do along it lie nearly on it: an error of a thousandth of the path,
/// which the best odometry has, then turns the estimate by any angle.
const NEARLY_STRAIGHT: f64 = 1e-3;

/// What of the estimate's frame is free.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Alignment {
    /// Nothing: both frames are one.
    None,
    /// The first estimated pose is laid on the first true one: the closed rule of our tables (`evo --align_origin`).
    #[default]
    Origin,
    /// Rotation and translation, by least squares of all positions (Umeyama 1991; `evo -a`).
    Se3,
    /// Rotation, translation and scale (`evo -as`).
    Sim3,
    /// The scale alone (`evo -s`).
    Scale,
    /// Translation and heading about z, by least squares: what a robot that knows gravity is free in.
    Yaw,
}

/// How an estimate lies on the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Laid {
    /// Factor of the estimate's positions.
    pub scale: f64,
    /// The estimate's world frame in the true one, after that.
    pub truth_from_estimate: Pose,
}

/// Why an estimate cannot be laid on the truth.
#[derive(Debug, Error, PartialEq)]
pub enum AlignmentError {
    /// The positions leave a part of the alignment free.
    #[error(
        "the positions lie {place}: they spread across it below a thousandth of what they do along it, and no alignment of this kind is \
         determined by them; take {remedy}"
    )]
    Straight {
        /// On what.
        place: &'static str,
        /// What is determined.
        remedy: &'static str,
    },
    /// Likewise, as there is one position.
    #[error(
        "the positions lie in one place: no alignment of this kind is determined by them; take --align origin"
    )]
    OnePlace,
    /// Poses that are not finite once they are scaled.
    #[error(transparent)]
    Pairs(#[from] PairsError),
}

impl Alignment {
    /// What lays the estimate on the truth: its positions are scaled, then moved.
    pub fn of(self, pairs: &Pairs) -> Result<Laid, AlignmentError> {
        let positions = |poses: &[Pose]| poses.iter().map(|p| p.translation.vector).collect::<Vec<_>>();
        let spread = || {
            let found = similarity(&positions(pairs.truth()), &positions(pairs.estimate()));
            found.filter(|found| found.along > f64::EPSILON).ok_or(AlignmentError::OnePlace)
        };
        let best = |remedy| {
            let found = spread()?;
            let straight = AlignmentError::Straight { place: "on a line, or nearly so", remedy };
            // Both are squares.
            if found.across < NEARLY_STRAIGHT.powi(2) * found.along { Err(straight) } else { Ok(found) }
        };
        let (scale, truth_from_estimate) = match self {
            Self::None => (1.0, Pose::identity()),
            Self::Origin => (1.0, pairs.true_world_from_estimate_world()),
            Self::Se3 => (1.0, best("--align yaw or --align origin")?.rigid),
            Self::Sim3 => {
                let Similarity { scale, scaled, .. } = best("--align scale, --align yaw or --align origin")?;
                (scale, scaled)
            }
            Self::Scale => (spread()?.scale, Pose::identity()),
            Self::Yaw => (1.0, by_yaw(&positions(pairs.truth()), &positions(pairs.estimate()))?),
        };
        Ok(Laid { scale, truth_from_estimate })
    }

    /// The pairs with the estimate laid on the truth.
    pub fn apply(self, pairs: &Pairs) -> Result<Pairs, AlignmentError> {
        let Laid { scale, truth_from_estimate } = self.of(pairs)?;
        let lay = |pose: &Pose| {
            let scaled = Pose::from_parts((pose.translation.vector * scale).into(), pose.rotation);
            if truth_from_estimate == Pose::identity() { scaled } else { truth_from_estimate * scaled }
        };
        let estimate: Vec<Pose> = pairs.estimate().iter().map(lay).collect();
        Ok(Pairs::by_step(pairs.truth(), &estimate)?)
    }
}

/// The turn about z and the translation of least squares.
fn by_yaw(truth: &[Vector3<f64>], estimate: &[Vector3<f64>]) -> Result<Pose, AlignmentError> {
    let mean = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let (of_truth, of_estimate) = (mean(truth), mean(estimate));
    let (mut sine, mut cosine, mut spread) = (0.0, 0.0, [0.0; 2]);
    for (t, e) in truth.iter().zip(estimate) {
        let (t, e) = (t - of_truth, e - of_estimate);
        sine += e.x * t.y - e.y * t.x;
        cosine += e.x * t.x + e.y * t.y;
        spread[0] += t.norm_squared();
        spread[1] += e.norm_squared();
    }
    let whole = (spread[0] * spread[1]).sqrt();
    if whole <= f64::EPSILON * truth.len() as f64 {
        return Err(AlignmentError::OnePlace);
    }
    if libm::hypot(sine, cosine) < NEARLY_STRAIGHT.powi(2) * whole {
        let (place, remedy) = ("one above the other, or nearly so", "--align origin");
        return Err(AlignmentError::Straight { place, remedy });
    }
    let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), libm::atan2(sine, cosine));
    Ok(Pose::from_parts(Translation3::from(of_truth - rotation * of_estimate), rotation))
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_dataset::{Tangent, se3};

    fn track() -> Vec<Pose> {
        (0..9)
            .map(|i| {
                let t = f64::from(i);
                se3::exp(&Tangent::from([0.1 * t, 0.02 * t * t, -0.3, t, (0.7 * t).sin(), 0.1 * t * t]))
            })
            .collect()
    }

    fn left(alignment: Alignment, moved: impl Fn(&Pose) -> Pose) -> f64 {
        let truth = track();
        let estimate: Vec<Pose> = truth.iter().map(moved).collect();
        let aligned = alignment.apply(&Pairs::by_step(&truth, &estimate).unwrap()).unwrap();
        let off = |(t, e): (&Pose, &Pose)| (t.to_homogeneous() - e.to_homogeneous()).norm();
        aligned.truth().iter().zip(aligned.estimate()).map(off).fold(0.0, f64::max)
    }

    #[test]
    fn each_undoes_what_it_leaves_free_and_nothing_else() {
        let frame = se3::exp(&Tangent::from([0.3, -1.0, 2.0, 4.0, -5.0, 6.0]));
        let turn = Pose::new(Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.0, 0.0, 2.2));
        let scaled = |pose: &Pose| Pose::from_parts((pose.translation.vector * 2.5).into(), pose.rotation);
        for alignment in [Alignment::Origin, Alignment::Se3, Alignment::Sim3] {
            assert!(left(alignment, |pose| frame * pose) < 1e-9, "{alignment:?}");
        }
        assert!(left(Alignment::Yaw, |pose| turn * pose) < 1e-9);
        assert!(left(Alignment::Yaw, |pose| frame * pose) > 0.1);
        assert!(left(Alignment::Sim3, |pose| frame * scaled(pose)) < 1e-9);
        assert!(left(Alignment::Scale, scaled) < 1e-9);
        assert!(left(Alignment::Se3, scaled) > 0.1);
        assert_eq!(left(Alignment::None, |pose| *pose), 0.0);
        assert!(left(Alignment::None, |pose| turn * pose) > 0.1);
    }

    #[test]
    fn positions_that_leave_it_free_are_an_error() {
        // Nine metres along an axis, and so much across it.
        let path = |along: Vector3<f64>, across: f64| -> Vec<Pose> {
            let off = |i: i32| (along.zxy() * f64::from(i % 2) + along.yzx() * f64::from(i % 3)) * across;
            (0..10)
                .map(|i| Pose::from_parts((along * f64::from(i) + off(i)).into(), UnitQuaternion::identity()))
                .collect()
        };
        let told = |alignment: Alignment, poses: &[Pose]| {
            alignment.apply(&Pairs::by_step(poses, poses).unwrap()).err().map(|error| error.to_string())
        };
        for across in [0.0, 1e-9, 1e-4, 1e-3] {
            let line = path(Vector3::x(), across);
            for alignment in [Alignment::Se3, Alignment::Sim3] {
                let told = told(alignment, &line).unwrap();
                assert!(
                    told.contains("on a line") && told.contains("--align yaw or --align origin"),
                    "{told}"
                );
            }
            let determined = [Alignment::Scale, Alignment::Yaw, Alignment::Origin];
            assert!(determined.into_iter().all(|alignment| told(alignment, &line).is_none()), "{across}");
            let post = path(Vector3::z(), across);
            assert!(told(Alignment::Yaw, &post).unwrap().contains("one above the other"), "{across}");
        }
        for axis in [Vector3::x(), Vector3::z()] {
            let bent = path(axis, 0.03);
            for alignment in [Alignment::Se3, Alignment::Sim3, Alignment::Scale, Alignment::Yaw] {
                assert_eq!(told(alignment, &bent), None, "{alignment:?}");
            }
        }
        for alignment in [Alignment::Se3, Alignment::Sim3, Alignment::Scale, Alignment::Yaw] {
            assert!(told(alignment, &path(Vector3::zeros(), 0.0)).unwrap().contains("in one place"));
        }
    }
}

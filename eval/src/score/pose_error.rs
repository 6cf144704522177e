//! Errors of single poses and of motions between two of them, as evo defines them, with their statistics.
//!
//! ```text
//! APE:  E_i  = Q_i^-1 P_i                              Q true, P estimated
//! RPE:  E_ij = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j)            i, j some distance apart
//! ```

use super::angle_between;
use super::pairs::Pairs;
use crate::result::statistics::quantile;
use clap::ValueEnum;
use serde::Serialize;
use vantage_dataset::Pose;

/// How far from the wanted distance two poses may be where all pairs count, as a share of it: evo's default.
const TOLERANCE: f64 = 0.1;

/// Errors, translations in metres and rotations in degrees.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseErrors {
    /// The pair of poses that each is of: of a motion, the later one.
    pub at: Vec<usize>,
    /// Metres.
    pub translation: Vec<f64>,
    /// Degrees.
    pub rotation: Vec<f64>,
}

/// What a distance along a trajectory is counted in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Unit {
    /// Poses; a part of one counts as none.
    #[default]
    Frames,
    /// Length of the estimated path.
    Metres,
    /// Angle that the estimate has turned by.
    Degrees,
}

/// Which two poses a motion is between.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spacing {
    /// How far they are apart.
    pub delta: f64,
    /// In what.
    pub unit: Unit,
    /// Of every pose to the one that is this far on, within a tenth; else each motion begins where the one before ended.
    pub all_pairs: bool,
}

/// Of errors; at least one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorStatistics {
    /// Root mean square.
    pub rmse: f64,
    /// Mean.
    pub mean: f64,
    /// Median.
    pub median: f64,
    /// Standard deviation of all that there are.
    pub std: f64,
    /// Least.
    pub min: f64,
    /// Largest.
    pub max: f64,
    /// Sum of squares.
    pub sse: f64,
}

impl PoseErrors {
    fn of(pairs: impl Iterator<Item = (usize, Pose, Pose)>) -> Self {
        let mut errors = Self::default();
        for (at, truth, estimate) in pairs {
            errors.at.push(at);
            errors.translation.push((truth.translation.vector - estimate.translation.vector).norm());
            errors.rotation.push(angle_between(&truth.rotation, &estimate.rotation).to_degrees());
        }
        errors
    }

    /// Of each pose.
    pub fn absolute(pairs: &Pairs) -> Self {
        let poses = pairs.truth().iter().zip(pairs.estimate()).enumerate();
        Self::of(poses.map(|(i, (truth, estimate))| (i, *truth, *estimate)))
    }

    /// Of motions.
    pub fn relative(pairs: &Pairs, spacing: Spacing) -> Self {
        let motion = |poses: &[Pose], (i, j): (usize, usize)| poses[i].inverse() * poses[j];
        let ends = spacing.ends(pairs.estimate());
        Self::of(ends.into_iter().map(|at| (at.1, motion(pairs.truth(), at), motion(pairs.estimate(), at))))
    }
}

impl Spacing {
    /// Where motions begin and end.
    fn ends(&self, poses: &[Pose]) -> Vec<(usize, usize)> {
        match self.unit {
            Unit::Frames => {
                let delta = (self.delta as usize).max(1);
                let step = if self.all_pairs { 1 } else { delta };
                (0..poses.len().saturating_sub(delta)).step_by(step).map(|i| (i, i + delta)).collect()
            }
            Unit::Metres if self.all_pairs => self.as_far_by_path(poses),
            Unit::Metres => self.in_turn_by_path(poses),
            Unit::Degrees if self.all_pairs => self.turned_as_far(poses),
            Unit::Degrees => self.in_turn_by_angle(poses),
        }
    }

    /// Of every pose to that whose distance along the path is nearest to what is wanted.
    fn as_far_by_path(&self, poses: &[Pose]) -> Vec<(usize, usize)> {
        let mut travelled = vec![0.0; poses.len()];
        for (i, step) in poses.windows(2).enumerate() {
            travelled[i + 1] = travelled[i] + length(step);
        }
        let end = |i: usize| {
            let off = |j: &usize| (travelled[*j] - travelled[i] - self.delta).abs();
            let nearest = (i + 1..poses.len()).min_by(|a, b| off(a).total_cmp(&off(b)))?;
            (off(&nearest) <= TOLERANCE * self.delta).then_some((i, nearest))
        };
        (0..poses.len()).filter_map(end).collect()
    }

    /// From one pose, the first to begin with, to the next after at least so long a path.
    fn in_turn_by_path(&self, poses: &[Pose]) -> Vec<(usize, usize)> {
        let (mut ends, mut path) = (vec![0], 0.0);
        for (i, step) in poses.windows(2).enumerate() {
            path += length(step);
            if path >= self.delta {
                ends.push(i + 1);
                path = 0.0;
            }
        }
        ends.windows(2).map(|pair| (pair[0], pair[1])).collect()
    }

    fn turned_as_far(&self, poses: &[Pose]) -> Vec<(usize, usize)> {
        let is_as_far =
            |i: usize, j: usize| (angle(&[poses[i], poses[j]]) - self.delta).abs() <= TOLERANCE * self.delta;
        let ends = |i: usize| (i + 1..poses.len()).filter(move |&j| is_as_far(i, j)).map(move |j| (i, j));
        (0..poses.len()).flat_map(ends).collect()
    }

    fn in_turn_by_angle(&self, poses: &[Pose]) -> Vec<(usize, usize)> {
        let (mut ends, mut turned, mut start) = (Vec::new(), 0.0, 0);
        for (i, step) in poses.windows(2).enumerate() {
            turned += angle(step);
            if turned >= self.delta {
                ends.push((start, i + 1));
                (turned, start) = (0.0, i + 1);
            }
        }
        ends
    }
}

fn length(step: &[Pose]) -> f64 {
    (step[1].translation.vector - step[0].translation.vector).norm()
}

/// Degrees.
fn angle(step: &[Pose]) -> f64 {
    angle_between(&step[0].rotation, &step[1].rotation).to_degrees()
}

impl ErrorStatistics {
    /// `None` for no errors.
    pub fn of(errors: &[f64]) -> Option<Self> {
        let n = errors.len() as f64;
        let mut sorted = errors.to_vec();
        sorted.sort_by(f64::total_cmp);
        let sse: f64 = errors.iter().map(|error| error * error).sum();
        let mean = errors.iter().sum::<f64>() / n;
        let variance = errors.iter().map(|error| (error - mean) * (error - mean)).sum::<f64>() / n;
        Some(Self {
            rmse: (sse / n).sqrt(),
            mean,
            median: quantile(&sorted, 0.5)?,
            std: variance.sqrt(),
            min: *sorted.first()?,
            max: *sorted.last()?,
            sse,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn spacing(delta: f64, unit: Unit, all_pairs: bool) -> Spacing {
        Spacing { delta, unit, all_pairs }
    }

    #[test]
    fn motions_are_as_far_apart_as_is_asked() {
        let straight: Vec<Pose> = (0..7).map(|i| Pose::translation(0.5 * f64::from(i), 0.0, 0.0)).collect();
        let ends = |delta, unit, all| spacing(delta, unit, all).ends(&straight);
        assert_eq!(ends(2.0, Unit::Frames, false), [(0, 2), (2, 4), (4, 6)]);
        assert_eq!(ends(2.0, Unit::Frames, true), [(0, 2), (1, 3), (2, 4), (3, 5), (4, 6)]);
        assert_eq!(ends(1.0, Unit::Metres, true), [(0, 2), (1, 3), (2, 4), (3, 5), (4, 6)]);
        assert_eq!(ends(1.0, Unit::Metres, false), [(0, 2), (2, 4), (4, 6)]);
        assert!(ends(1.0, Unit::Degrees, true).is_empty() && ends(9.0, Unit::Metres, true).is_empty());
        let turning: Vec<Pose> =
            (0..5).map(|i| Pose::new(Vector3::zeros(), Vector3::z() * (0.1 * f64::from(i)))).collect();
        let degrees = 0.2f64.to_degrees();
        assert_eq!(spacing(0.99 * degrees, Unit::Degrees, false).ends(&turning), [(0, 2), (2, 4)]);
        assert_eq!(spacing(degrees, Unit::Degrees, true).ends(&turning), [(0, 2), (1, 3), (2, 4)]);
        assert!(spacing(1.0, Unit::Frames, false).ends(&[]).is_empty());
    }

    #[test]
    fn statistics_are_those_of_the_errors() {
        let found = ErrorStatistics::of(&[3.0, 4.0, 0.0, 1.0]).unwrap();
        assert_eq!((found.mean, found.median, found.min, found.max), (2.0, 2.0, 0.0, 4.0));
        assert_eq!((found.sse, found.rmse, found.std), (26.0, 6.5f64.sqrt(), 2.5f64.sqrt()));
        assert_eq!(ErrorStatistics::of(&[]), None);
    }
}

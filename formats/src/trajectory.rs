//! A trajectory with timestamps, and the TUM text form, in which evo and others hand over theirs.
//!
//! One pose a line: `timestamp tx ty tz qx qy qz qw`, seconds and metres, exactly eight numbers with one space
//! between and none at the end; lines that start with `#` are comments. Written by [`vantage_dataset::store::write_tum`].

use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use thiserror::Error;
use vantage_dataset::Pose;
use vantage_dataset::se3::is_finite;

/// Poses with timestamps that never go back, all finite. (TUM's own ground truth repeats some.)
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    timestamps: Vec<f64>,
    world_from_robot: Vec<Pose>,
}

/// Why poses and timestamps make no trajectory.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum TrajectoryError {
    /// Not one timestamp a pose.
    #[error("{timestamps} timestamps for {poses} poses: each pose needs one")]
    Length {
        /// Number of timestamps.
        timestamps: usize,
        /// Number of poses.
        poses: usize,
    },
    /// A pose or timestamp is NaN or infinite.
    #[error("pose {index} or its timestamp is not finite")]
    NotFinite {
        /// Index of the pose.
        index: usize,
    },
    /// A timestamp goes back.
    #[error("timestamp {timestamp} of pose {index} is before {before}: timestamps must not go back")]
    GoesBack {
        /// Index of the pose.
        index: usize,
        /// Its timestamp, seconds.
        timestamp: f64,
        /// The timestamp before it, seconds.
        before: f64,
    },
}

/// Why a text is no TUM trajectory.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum TumError {
    /// A line with another number of columns; also a double or trailing space, or a blank line.
    #[error(
        "line {line}: {found} columns, expected 8 (timestamp tx ty tz qx qy qz qw) with one space between"
    )]
    Columns {
        /// Line number, from 1.
        line: usize,
        /// Columns found.
        found: usize,
    },
    /// A column that is no number.
    #[error("line {line}, column {column}: {text:?} is not a number")]
    Number {
        /// Line number, from 1.
        line: usize,
        /// Column number, from 1.
        column: usize,
        /// What stands there.
        text: String,
    },
    /// A quaternion that is no rotation.
    #[error("line {line}: the quaternion has norm {norm}, expected 1")]
    Quaternion {
        /// Line number, from 1.
        line: usize,
        /// Its norm.
        norm: f64,
    },
    /// A pose or timestamp that is infinite or NaN.
    #[error("line {line}: the pose or its timestamp is not finite")]
    NotFinite {
        /// Line number, from 1.
        line: usize,
    },
    /// A timestamp that goes back.
    #[error(
        "line {line}: timestamp {timestamp} is before {before}, that of the pose above: timestamps must not go back"
    )]
    GoesBack {
        /// Line number, from 1.
        line: usize,
        /// Its timestamp, seconds.
        timestamp: f64,
        /// The timestamp of the pose above, seconds.
        before: f64,
    },
    /// Another pose at the time of the pose above.
    #[error(
        "line {line}: another pose than the one above, at the same time {timestamp}: expected one pose a time"
    )]
    TwoPoses {
        /// Line number, from 1.
        line: usize,
        /// The time, seconds.
        timestamp: f64,
    },
    /// No pose at all.
    #[error("no pose in the file")]
    Empty,
}

/// How far from 1 the norm of a written quaternion may be; TUM's own files round to four decimals.
const QUATERNION_NORM_TOLERANCE: f64 = 0.01;

impl Trajectory {
    /// Poses at `timestamps`, seconds.
    pub fn new(timestamps: Vec<f64>, world_from_robot: Vec<Pose>) -> Result<Self, TrajectoryError> {
        if timestamps.len() != world_from_robot.len() {
            return Err(TrajectoryError::Length {
                timestamps: timestamps.len(),
                poses: world_from_robot.len(),
            });
        }
        for (index, (t, pose)) in timestamps.iter().zip(&world_from_robot).enumerate() {
            if !(t.is_finite() && is_finite(pose)) {
                return Err(TrajectoryError::NotFinite { index });
            }
        }
        for (index, pair) in timestamps.windows(2).enumerate() {
            if pair[1] < pair[0] {
                return Err(TrajectoryError::GoesBack {
                    index: index + 1,
                    timestamp: pair[1],
                    before: pair[0],
                });
            }
        }
        Ok(Self { timestamps, world_from_robot })
    }

    /// Seconds.
    pub fn timestamps(&self) -> &[f64] {
        &self.timestamps
    }

    /// The poses.
    pub fn world_from_robot(&self) -> &[Pose] {
        &self.world_from_robot
    }

    /// Number of poses.
    pub fn len(&self) -> usize {
        self.timestamps.len()
    }

    /// Whether there is no pose.
    pub fn is_empty(&self) -> bool {
        self.timestamps.is_empty()
    }

    /// Reads an estimate, a TUM text with one pose a time (that may be repeated as it is); a UTF-8 byte order mark is skipped.
    pub fn from_tum(text: &str) -> Result<Self, TumError> {
        Self::read(text, false)
    }

    /// Reads a recorded ground truth, as [`Trajectory::from_tum`] does an estimate. A motion capture may note two measurements at one
    /// time, as in TUM's `fr2_desk`.
    pub fn recorded_from_tum(text: &str) -> Result<Self, TumError> {
        Self::read(text, true)
    }

    fn read(text: &str, measured_twice: bool) -> Result<Self, TumError> {
        let (mut timestamps, mut poses): (Vec<f64>, Vec<Pose>) = (Vec::new(), Vec::new());
        for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
            if line.starts_with('#') {
                continue;
            }
            let line_number = index + 1;
            let (t, pose) = parse_line(line, line_number)?;
            if !(t.is_finite() && is_finite(&pose)) {
                return Err(TumError::NotFinite { line: line_number });
            }
            if let Some((&before, above)) = timestamps.last().zip(poses.last()) {
                if t < before {
                    return Err(TumError::GoesBack { line: line_number, timestamp: t, before });
                }
                if t == before && pose != *above && !measured_twice {
                    return Err(TumError::TwoPoses { line: line_number, timestamp: t });
                }
            }
            timestamps.push(t);
            poses.push(pose);
        }
        if poses.is_empty() {
            return Err(TumError::Empty);
        }
        Ok(Self { timestamps, world_from_robot: poses })
    }
}

fn parse_line(text: &str, line: usize) -> Result<(f64, Pose), TumError> {
    let columns: Vec<&str> = text.split(' ').collect();
    if columns.len() != 8 || columns.iter().any(|c| c.is_empty()) {
        let found = columns.iter().filter(|c| !c.is_empty()).count();
        return Err(TumError::Columns { line, found: if found == 8 { columns.len() } else { found } });
    }
    let mut n = [0.0f64; 8];
    for (column, (value, text)) in n.iter_mut().zip(&columns).enumerate() {
        *value = text.parse().map_err(|_| TumError::Number {
            line,
            column: column + 1,
            text: (*text).to_owned(),
        })?;
    }
    let quaternion = Quaternion::new(n[7], n[4], n[5], n[6]);
    let norm: f64 = quaternion.norm();
    let is_rotation = (norm - 1.0).abs() <= QUATERNION_NORM_TOLERANCE;
    if !is_rotation {
        return Err(TumError::Quaternion { line, norm });
    }
    // A quaternion we wrote is kept to the bit; one that was rounded is normalized.
    let rotation = if (norm - 1.0).abs() <= 4.0 * f64::EPSILON {
        UnitQuaternion::new_unchecked(quaternion)
    } else {
        UnitQuaternion::new_normalize(quaternion)
    };
    Ok((n[0], Pose::from_parts(Translation3::new(n[1], n[2], n[3]), rotation)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use vantage_dataset::store::write_tum;
    use vantage_dataset::{Tangent, se3};

    fn poses() -> impl Strategy<Value = Vec<Pose>> {
        let tangent = proptest::array::uniform6(-3.0..3.0f64);
        proptest::collection::vec(tangent.prop_map(|t| se3::exp(&Tangent::from(t))), 1..20)
    }

    fn written(timestamps: &[f64], poses: &[Pose]) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.tum");
        write_tum(&path, timestamps, poses).unwrap();
        std::fs::read_to_string(path).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn reading_inverts_writing_to_the_bit(poses in poses(), start in 0.0..2e9f64) {
            let timestamps: Vec<f64> = (0..poses.len()).map(|i| start + i as f64 / 10.0).collect();
            let read = Trajectory::from_tum(&written(&timestamps, &poses)).unwrap();
            prop_assert_eq!(read, Trajectory::new(timestamps, poses).unwrap());
        }
    }

    #[test]
    fn written_lines_are_as_evo_wants_them() {
        let text = written(&[0.0, 1e-7], &[Pose::identity(); 2]);
        for line in text.lines().skip(1) {
            assert_eq!(line.split(' ').filter(|c| !c.is_empty()).count(), 8, "{line:?}");
            assert_eq!(line.trim(), line);
        }
        assert!(text.ends_with('\n'));
    }

    #[test]
    fn malformed_lines_are_refused_with_their_number() {
        let good = "0 0 0 0 0 0 0 1\n";
        let error = |bad: &str| Trajectory::from_tum(&format!("# c\n{good}{bad}")).unwrap_err();
        assert_eq!(error("1 0 0 0 0 0 1"), TumError::Columns { line: 3, found: 7 });
        assert_eq!(error("1 0 0 0 0 0 0 1 "), TumError::Columns { line: 3, found: 9 });
        assert_eq!(error("1  0 0 0 0 0 0 1"), TumError::Columns { line: 3, found: 9 });
        assert_eq!(error("1 0 x 0 0 0 0 1"), TumError::Number { line: 3, column: 3, text: "x".into() });
        assert_eq!(error("1 0 0 0 0 0 0 0"), TumError::Quaternion { line: 3, norm: 0.0 });
        assert!(matches!(error("1 0 0 0 0 0 0 NaN"), TumError::Quaternion { line: 3, .. }));
        assert_eq!(error("1 inf 0 0 0 0 0 1"), TumError::NotFinite { line: 3 });
        let back = error("-1 0 0 0 0 0 0 1");
        assert_eq!(back, TumError::GoesBack { line: 3, timestamp: -1.0, before: 0.0 });
        assert_eq!(error("0 0 0 1 0 0 0 1"), TumError::TwoPoses { line: 3, timestamp: 0.0 });
        assert!(Trajectory::from_tum(&good.repeat(2)).is_ok());
        let twice = format!("{good}0 0 0 1 0 0 0 1\n");
        assert_eq!(Trajectory::recorded_from_tum(&twice).map(|read| read.len()), Ok(2));
        assert_eq!(Trajectory::from_tum("# only\n"), Err(TumError::Empty));
        assert!(Trajectory::from_tum(&format!("\u{feff}{good}")).is_ok());
    }
}

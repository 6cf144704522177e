//! Trajectories as KITTI and EuRoC write them.
//!
//! KITTI: the upper three rows of `world_from_robot`, twelve numbers a line, row-major, without times. EuRoC: `timestamp [ns], p (x y z), q (w x
//! y z)` and more columns, separated by commas, under a line that starts with `#`.

use crate::rigid::nearly_rigid;
use crate::trajectory::{Trajectory, TrajectoryError};
use nalgebra::{Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3};
use thiserror::Error;
use vantage_dataset::Pose;

const NANOSECONDS: f64 = 1e-9;
/// How far from 1 the norm of a written quaternion may be.
const NORM: f64 = 0.01;

/// How poses are written in a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PoseText {
    /// Eight numbers a line, separated by blanks.
    Tum,
    /// Twelve.
    Kitti,
    /// Numbers separated by commas.
    Euroc,
}

/// Why a text is no trajectory of KITTI's or EuRoC's.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PoseTextError {
    /// A line that does not hold a pose.
    #[error("line {line}: {reason}")]
    Line {
        /// Its number, from 1.
        line: usize,
        /// What is wrong.
        reason: String,
    },
    /// No pose at all.
    #[error("no pose in the file")]
    Empty,
    /// Times that go back.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
}

impl PoseText {
    /// By its first line that is no comment; TUM where nothing speaks for the others.
    pub fn of(text: &str) -> Self {
        match lines(text).next() {
            Some((_, line)) if line.contains(',') => Self::Euroc,
            Some((_, line)) if line.split_whitespace().count() == 12 => Self::Kitti,
            _ => Self::Tum,
        }
    }
}

impl Trajectory {
    /// Reads poses of KITTI's. Their times are their numbers, from 0 on.
    ///
    /// # Errors
    ///
    /// A line without twelve numbers, or whose matrix is no rotation.
    pub fn from_kitti(text: &str) -> Result<Self, PoseTextError> {
        let pose = |(line, text): (usize, &str)| {
            let n: [f64; 12] = numbers(line, text.split_whitespace())?;
            let rotation = Matrix3::new(n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10]);
            let pose = nearly_rigid(rotation, Vector3::new(n[3], n[7], n[11]));
            pose.ok_or_else(|| failed(line, "the 3 x 3 matrix is no rotation"))
        };
        let poses = lines(text).map(pose).collect::<Result<Vec<Pose>, _>>()?;
        if poses.is_empty() {
            return Err(PoseTextError::Empty);
        }
        Ok(Self::new((0..poses.len()).map(|index| index as f64).collect(), poses)?)
    }

    /// Reads a table of EuRoC's, as its ground truth; columns after the eighth are left alone.
    ///
    /// # Errors
    ///
    /// A line without eight numbers, a quaternion of another norm than 1, and times that go back.
    pub fn from_euroc(text: &str) -> Result<Self, PoseTextError> {
        let mut times = Vec::new();
        let mut poses = Vec::new();
        for (line, text) in lines(text) {
            let [time, x, y, z, qw, qx, qy, qz] = numbers(line, text.split(',').take(8))?;
            let quaternion = Quaternion::new(qw, qx, qy, qz);
            if (quaternion.norm() - 1.0).abs() > NORM {
                return Err(failed(
                    line,
                    &format!("the quaternion has norm {}, expected 1", quaternion.norm()),
                ));
            }
            times.push(time * NANOSECONDS);
            poses.push(Pose::from_parts(
                Translation3::new(x, y, z),
                UnitQuaternion::from_quaternion(quaternion),
            ));
        }
        if poses.is_empty() {
            return Err(PoseTextError::Empty);
        }
        Ok(Self::new(times, poses)?)
    }
}

/// Lines with their numbers, without blank ones and comments.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = text.lines().enumerate().map(|(index, line)| (index + 1, line.trim()));
    lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
}

fn numbers<'a, const N: usize>(
    line: usize,
    words: impl Iterator<Item = &'a str>,
) -> Result<[f64; N], PoseTextError> {
    let number = |word: &str| {
        let number = word.trim().parse::<f64>().ok().filter(|number| number.is_finite());
        number.ok_or_else(|| failed(line, &format!("{word:?} is no finite number")))
    };
    let numbers = words.map(number).collect::<Result<Vec<f64>, _>>()?;
    let found = numbers.len();
    numbers.try_into().map_err(|_| failed(line, &format!("{found} numbers, expected {N}")))
}

fn failed(line: usize, reason: &str) -> PoseTextError {
    PoseTextError::Line { line, reason: reason.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KITTI: &str = "1 0 0 0.5 0 1 0 -2 0 0 1 3\n0 -1 0 1 1 0 0 0 0 0 1 0\n";
    const EUROC: &str = "#timestamp, p_x, p_y, p_z, q_w, q_x, q_y, q_z, v_x\n\
                         1403636580838555648,4.68,-1.78,0.78,0.707107,0,0,0.707107,-0.02\n\
                         1403636580843555648,4.69,-1.78,0.79,1,0,0,0,-0.02\n";

    #[test]
    fn poses_of_kitti_are_numbered() {
        assert_eq!(PoseText::of(KITTI), PoseText::Kitti);
        let read = Trajectory::from_kitti(KITTI).unwrap();
        assert_eq!(read.timestamps(), [0.0, 1.0]);
        let [first, second] = read.world_from_robot() else { panic!() };
        assert_eq!(first.translation.vector, Vector3::new(0.5, -2.0, 3.0));
        assert!((second.rotation * Vector3::x() - Vector3::y()).norm() < 1e-12);
    }

    #[test]
    fn poses_of_euroc_have_seconds_and_their_scalar_first() {
        assert_eq!(PoseText::of(EUROC), PoseText::Euroc);
        let read = Trajectory::from_euroc(EUROC).unwrap();
        assert!((read.timestamps()[1] - read.timestamps()[0] - 0.005).abs() < 1e-6);
        let turned = read.world_from_robot()[0].rotation * Vector3::x();
        assert!((turned - Vector3::y()).norm() < 1e-5);
    }

    #[test]
    fn what_is_no_pose_is_told_with_its_line() {
        let kitti = |text: &str| Trajectory::from_kitti(text).unwrap_err().to_string();
        assert_eq!(kitti("# none\n\n1 2 3\n"), "line 3: 3 numbers, expected 12");
        assert!(kitti("2 0 0 0 0 2 0 0 0 0 2 0").contains("no rotation"));
        assert!(kitti("nan 0 0 0 0 1 0 0 0 0 1 0").contains("\"nan\" is no finite number"));
        let euroc = |text: &str| Trajectory::from_euroc(text).unwrap_err().to_string();
        assert_eq!(euroc("1,2,3\n"), "line 1: 3 numbers, expected 8");
        assert!(euroc("1,0,0,0,2,0,0,0").contains("norm 2"));
        assert!(euroc("2000000000,0,0,0,1,0,0,0\n1000000000,0,0,0,1,0,0,0").contains("is before"));
        assert_eq!(euroc("# only words"), "no pose in the file");
        assert_eq!(PoseText::of("0 1 2 3 0 0 0 1"), PoseText::Tum);
    }
}

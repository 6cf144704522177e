//! Why two trajectories are not compared.

use crate::exit::Ends;
use crate::result::trajectory::TumError;
use crate::score::alignment::AlignmentError;
use crate::score::object_map_file::ObjectMapError;
use std::io;
use std::path::PathBuf;
use thiserror::Error;
use vantage_formats::PoseTextError;

/// Why two trajectories are not compared.
#[derive(Debug, Error)]
pub enum ScoreError {
    /// A file that cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file that is no trajectory.
    #[error("{}: {source}", path.display())]
    Tum {
        /// The file.
        path: PathBuf,
        /// Why.
        source: TumError,
    },
    /// Likewise, of KITTI's or EuRoC's.
    #[error("{}: {source}", path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// Why.
        source: PoseTextError,
    },
    /// One of the files has no times.
    #[error(
        "one trajectory is KITTI's, which has no times, and the other is not: give both as KITTI, or both with times"
    )]
    Untimed,
    /// Trajectories without times, of other lengths.
    #[error(
        "{truth} true and {estimate} estimated poses of KITTI's, which has no times: expected one for one"
    )]
    Numbers {
        /// True poses.
        truth: usize,
        /// Estimated ones.
        estimate: usize,
    },
    /// No pose of one is near one of the other in time.
    #[error(
        "no two poses are within {max_difference} s of each other: the truth runs from {} to {} s, the estimate from {} to {} s; give both \
         the same clock, or raise --max-difference",
        truth[0], truth[1], estimate[0], estimate[1]
    )]
    Apart {
        /// What is near, seconds.
        max_difference: f64,
        /// First and last time of the truth, seconds.
        truth: [f64; 2],
        /// First and last time of the estimate, seconds.
        estimate: [f64; 2],
    },
    /// An option that says nothing of what is scored.
    #[error("{option} says nothing of {of}; leave it out")]
    Option {
        /// The option.
        option: &'static str,
        /// What is scored.
        of: &'static str,
    },
    /// A part of a frame.
    #[error(
        "--delta {delta}: expected a whole number of frames; other distances take --unit metres or --unit degrees"
    )]
    Frames {
        /// What was asked for.
        delta: f64,
    },
    /// Maps in other words than the task's.
    #[error(
        "none of the maps' {objects} objects with a label is of a class of the task: they are {unknown}, it has {known}; rename the labels, or \
         leave the column out"
    )]
    Labels {
        /// Objects with a label.
        objects: usize,
        /// What they are labelled, the first few.
        unknown: String,
        /// What the task has, the first few.
        known: String,
    },
    /// A map that cannot be read.
    #[error(transparent)]
    Map(#[from] ObjectMapError),
    /// The estimate cannot be laid on the truth.
    #[error(transparent)]
    Alignment(#[from] AlignmentError),
}

impl Ends for ScoreError {}

//! Trajectories in the TUM format: `timestamp tx ty tz qx qy qz qw`, seconds, metres, unit quaternion.

use super::error::{Fault, StoreError};
use super::file_record::FileRecord;
use super::hashed_file::{Sink, Source, write_hashed};
use super::pose_fields::{from_fields, pose_fields};
use super::tables::ROBOT;
use crate::Pose;
use std::io;
use std::path::Path;

/// Writes a trajectory that evo and the TUM RGB-D tools read: `poses[i]` (`world_from_robot`) at `timestamps[i]`.
///
/// Stops at the shorter of the two.
pub fn write_tum(path: &Path, timestamps: &[f64], poses: &[Pose]) -> Result<FileRecord, StoreError> {
    write_hashed(path, |sink| write_rows(sink, timestamps, poses))
}

fn write_rows(sink: &mut Sink, timestamps: &[f64], poses: &[Pose]) -> io::Result<()> {
    ROBOT.write(sink, timestamps.iter().zip(poses), |row, (timestamp, pose)| {
        row.put_floats([timestamp])?;
        row.put_floats(&pose_fields(pose))
    })
}

/// Reads the robot's true trajectory.
pub(super) fn read_robot(folder: &Path, source: &mut Source) -> Result<(Vec<f64>, Vec<Pose>), StoreError> {
    let rows = ROBOT.read(folder, source, |row| -> Result<_, Fault> {
        let [timestamp] = row.take_floats()?;
        Ok((timestamp, from_fields(row.take_floats()?)))
    })?;
    Ok(rows.into_iter().unzip())
}

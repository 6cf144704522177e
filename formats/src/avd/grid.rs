//! Where each movement leads on the grid.

use super::movement::Movement;
use super::{GRID, HEADINGS};
use nalgebra::{Vector2, Vector3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use vantage_dataset::Pose;

/// How far from the grid's step a neighbour may stand, metres.
const SLACK: f64 = 0.05;

/// One image of the grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Station {
    pub(super) cluster: u32,
    pub(super) heading: u32,
    position: Vector2<f64>,
    /// Azimuth of the camera's view, radians.
    azimuth: f64,
}

impl Station {
    pub(super) fn new(cluster: u32, heading: u32, world_from_camera: &Pose) -> Self {
        let view = world_from_camera.rotation * Vector3::z();
        let position = world_from_camera.translation.vector.xy();
        Self { cluster, heading, position, azimuth: libm::atan2(view.y, view.x) }
    }

    /// Which of the stations a movement leads to: the next heading at the same point, or the neighbour on the grid, with
    /// the same heading, that lies nearest to the direction of the movement and less than 45 degrees off it.
    pub(super) fn target(&self, movement: Movement, stations: &[Station]) -> Option<usize> {
        let turned = |by: u32| {
            let heading = (self.heading + by) % HEADINGS;
            stations.iter().position(|other| other.cluster == self.cluster && other.heading == heading)
        };
        let direction = match movement {
            Movement::RotateCcw => return turned(1),
            Movement::RotateCw => return turned(HEADINGS - 1),
            Movement::Forward => 0.0,
            Movement::Backward => PI,
            Movement::Left => FRAC_PI_2,
            Movement::Right => -FRAC_PI_2,
        };
        let neighbours = stations.iter().enumerate().filter_map(|(index, other)| {
            let offset = other.position - self.position;
            let off = libm::atan2(offset.y, offset.x) - self.azimuth - direction;
            let off = (off - 2.0 * PI * (off / (2.0 * PI)).round()).abs();
            let near = (offset.norm() - GRID).abs() < SLACK && off < FRAC_PI_4;
            (other.heading == self.heading && near).then_some((index, off))
        });
        neighbours.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
    }
}

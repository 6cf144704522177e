//! No object is ever seen again: what odometry and bearings are worth without closing a loop.

use super::{Association, Associator};
use crate::input::EstimateError;
use vantage_dataset::Tracklets;

/// Takes each tracklet as an object of its own.
#[derive(Clone, Copy, Debug, Default)]
pub struct Separate;

impl Associator for Separate {
    fn associate(&self, seen: &Tracklets) -> Result<Association, EstimateError> {
        Ok(Association::certain((0..seen.count()).map(Some).collect()))
    }
}

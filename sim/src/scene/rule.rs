//! Rules that more than one part of a scene file needs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[low, high]`, both included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct Interval(pub [f64; 2]);

impl Interval {
    /// The lower end.
    pub fn low(self) -> f64 {
        self.0[0]
    }

    /// The upper end.
    pub fn high(self) -> f64 {
        self.0[1]
    }
}

/// An interval inside `low..=high` whose ends are in order.
pub fn interval_within(low: f64, high: f64) -> impl Fn(&Interval, &()) -> garde::Result {
    move |interval, ()| {
        let [a, b] = interval.0;
        if low <= a && a <= b && b <= high {
            Ok(())
        } else {
            Err(garde::Error::new(format!(
                "got [{a}, {b}], expected two numbers from {low} to {high}, the smaller first"
            )))
        }
    }
}

//! Association: weights against brute force, their calibration, faults, and the cases of others.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

mod calibration;
mod discrete_marginals;
mod exact;
mod faults;
mod jacobians;
mod linear_world;
mod shared;
mod spatial;

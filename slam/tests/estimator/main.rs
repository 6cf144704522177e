//! The estimator on simulated worlds, with a smooth observation model whose truth is known.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

mod association_faults;
mod associator;
mod carried;
mod consistency;
mod depth;
mod extents;
mod hypotheses;
mod incremental;
mod input;
mod jacobians;
mod landmarks;
mod learning;
mod linear;
mod lives;
mod model;
mod online;
mod online_ranges;
mod pairs;
mod process_refitted;
mod ranges;
mod recovery;
mod repeatable;
mod semantic;
mod semantic_jacobians;
mod sensors;
mod shared;
mod stalled;
mod steerable;
mod underconstrained;
mod which;
mod world;

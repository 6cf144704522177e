//! From scenes to episodes and views, with the real engine, objects and reference renderer.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

mod carried;
mod detect;
mod determinism;
mod drive;
mod look;
mod loops;
mod paths;
mod relit;
mod revisit;
mod ring;
mod scene;
mod scene_file;
mod sensors;
mod settle;
mod sides;
mod views;

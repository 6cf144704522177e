//! Scores, tables, the accuracy gate and the `bench` command.
//!
//! Every number answers one question: how far is an estimate `x` of Eq. 1 from the truth, after the closed rule that
//! both start from the same pose? `ATE = sqrt(mean_k |t(x_1^-1 x_k) - t(X_1^-1 X_k)|^2)` for trajectories, and
//! partition agreement (ARI, V-measure) and retrieval for latents `e`. A number is a mean over seeds with its 95%
//! interval and its paired difference to a reference method; an undefined number is `None`, never 0 and never NaN.
//!
//! - [`score`]: estimate x truth -> number
//! - [`statistics`], [`distribution`], [`table`], [`results`], [`manifest`]: numbers -> a result with its origin
//! - [`render`], [`figure`], [`report`], [`result_folder`]: result -> text, pictures, files
//! - [`gate`]: result x committed result -> verdict
//! - [`scene_file`], [`cli`], [`run`], [`exit`]: the `bench` command

pub mod cli;
pub mod command;
pub mod distribution;
pub mod error;
pub mod exit;
pub mod figure;
pub mod gate;
pub mod manifest;
pub mod metric;
pub mod output;
pub mod pipeline;
pub mod progress;
#[cfg(feature = "rerun")]
pub mod recording;
pub mod render;
pub mod report;
pub mod result_folder;
pub mod results;
pub mod run;
pub mod scene_file;
pub mod score;
pub mod seeds;
pub mod statistics;
pub mod study_file;
pub mod table;
pub mod trajectory;

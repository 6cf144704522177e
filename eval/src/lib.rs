//! Scores, tables, the accuracy gate and the `bench` command.
//!
//! Every number answers one question: how far is an estimate `x` of Eq. 1 from the truth, after the closed rule that
//! both start from the same pose? `ATE = sqrt(mean_k |t(x_1^-1 x_k) - t(X_1^-1 X_k)|^2)` for trajectories, and
//! partition agreement (ARI, V-measure) and retrieval for latents `e`. A number is a mean over seeds with its 95%
//! interval and its paired difference to a reference method; an undefined number is `None`, never 0 and never NaN.
//!
//! Rooms, from the ground up; each uses those above it:
//!
//! - [`exit`]: an error -> an exit code
//! - [`progress`]: what is under way -> a bar, or lines
//! - [`code`]: source code -> its hash, in the keys of the cache
//! - [`result`]: numbers -> tables with their origin -> files
//! - [`scene_file`]: YAML -> a checked scene, or a study
//! - [`score`]: estimate x truth -> numbers
//! - [`gate`]: result x committed result -> verdict
//! - [`figure`]: estimates, latents, scores -> pictures
//! - [`left_out`]: what a program is built without
//! - [`supplied`]: what comes with the program
//! - [`pipeline`]: scene -> episodes, model, estimates, tables, each stage an entry of the cache
//! - [`command`]: arguments -> a run of `bench` -> exit code

pub mod code;
pub mod command;
pub mod exit;
pub mod figure;
pub mod gate;
pub mod left_out;
pub mod pipeline;
pub mod progress;
pub mod result;
pub mod scene_file;
pub mod score;
pub mod supplied;

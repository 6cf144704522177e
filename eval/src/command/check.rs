//! `bench check SCENE`: fresh results against the committed ones.

use super::score::score;
use crate::cli::CheckArgs;
use crate::exit::{BenchError, Exit};
use crate::gate::compare;
use crate::render::Style;
use crate::results::Results;
use crate::scene_file::{self, SceneFile};
use std::io::Write;

/// Compares, and prints what moved.
pub fn check(args: &CheckArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let scene: SceneFile = scene_file::read(&args.scene)?;
    let baseline = Results::read(&args.baseline.join(&scene.name))?;
    let fresh = score(&args.scene, &args.stages)?.results;
    let verdict = compare(&baseline, &fresh)?;
    write!(stdout, "{}", verdict.report(Style::Terminal))?;
    Ok(if verdict.passed() { Exit::Success } else { Exit::Regression })
}

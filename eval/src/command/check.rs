//! `bench check SCENE`: fresh results against the committed ones.

use super::score::{score, seeds};
use crate::cli::CheckArgs;
use crate::error::BenchError;
use crate::exit::Exit;
use crate::gate::{Machine, comparable, compare};
use crate::render::Style;
use crate::results::Results;
use crate::scene_file::{self, SceneFile};
use std::io::Write;

/// Compares, and prints what moved.
pub fn check(args: &CheckArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let scene: SceneFile = scene_file::read(&args.scene)?;
    let folder = args.baseline.join(&scene.name);
    let baseline = Results::read(&folder)?;
    comparable(&baseline, &scene.name, &scene_file::hash(&scene)?, &seeds(&scene, &args.stages))?;
    let fresh = score(&args.scene, &args.stages)?;
    let verdict = compare(&baseline, &fresh.results)?;
    write!(stdout, "{}", verdict.report(Style::Terminal))?;
    let there = Machine::read(&folder);
    write!(stdout, "{}", Machine::of(&fresh.manifest).compared_with(there.as_ref()))?;
    Ok(if verdict.passed() { Exit::Success } else { Exit::Regression })
}

//! `bench check SCENE`: fresh results against the committed ones.

use super::scene::error::RunError;
use super::scene::line::{Beside, line, seeds};
use crate::command::cli::CheckArgs;
use crate::command::error::BenchError;
use crate::command::report::place;
use crate::command::sweep::Part;
use crate::exit::Exit;
use crate::gate::{Machine, comparable, compare, junit};
use crate::pipeline::Naming;
use crate::result::grid::Style;
use crate::result::kind::ResultKind;
use crate::result::output_folder::OutputFolder;
use crate::result::results_file::Results;
use crate::scene_file::{self, SceneFile};
use crate::score::association::ASSOCIATION;
use crate::score::online::ONLINE;
use std::io::Write;
use std::path::Path;

/// Compares, and prints what moved.
pub fn check(args: &CheckArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let scene: SceneFile = scene_file::read(&args.scene)?;
    if !scene.vary.is_empty() {
        return Err(RunError::Varies { scene: args.scene.clone(), what: "`bench check`" }.into());
    }
    let folder = ResultKind::Scene.place(&args.baseline, &scene.name);
    let baseline = Results::read(&folder)?;
    comparable(&baseline, &scene.name, &scene_file::hash(&scene)?, &seeds(&scene, &args.stages))?;
    let has = |table| baseline.table(table).is_some();
    let beside =
        Beside { online: has(ONLINE), associate: has(ASSOCIATION), associations: &[], part: Part::default() };
    let files = [&args.junit, &args.markdown, &args.json].into_iter().flatten();
    files
        .clone()
        .try_for_each(|file| Ok::<_, BenchError>(OutputFolder::probe(&place(file)?.0).map(drop)?))?;
    let fresh = line(&args.scene, &args.stages, Naming::Kind, beside)?;
    let verdict = compare(&baseline, &fresh.results)?;
    write!(stdout, "{}", verdict.report(Style::terminal()))?;
    let there = Machine::read(&folder);
    let machine = Machine::of(&fresh.manifest).compared_with(there.as_ref());
    write!(stdout, "{machine}")?;
    if let Some(file) = &args.junit {
        write(file, &junit(&scene.name, &verdict)?)?;
    }
    if let Some(file) = &args.markdown {
        let text = format!("## {}\n\n{}\n{machine}", scene.name, verdict.report(Style::Markdown));
        write(file, text.as_bytes())?;
    }
    if let Some(file) = &args.json {
        write(file, (serde_json::to_string_pretty(&verdict)? + "\n").as_bytes())?;
    }
    Ok(if verdict.passed() { Exit::Success } else { Exit::Regression })
}

fn write(file: &Path, bytes: &[u8]) -> Result<(), BenchError> {
    let (folder, name) = place(file)?;
    Ok(OutputFolder::probe(&folder)?.write(name, bytes)?)
}

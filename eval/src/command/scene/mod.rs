//! `bench SCENE`: the whole line, from a scene file to tables and pictures.

pub mod error;
pub mod line;
mod pictures;
mod record;

use super::cli::RunArgs;
use super::exit::Exit;
use crate::command::error::BenchError;
use crate::pipeline::{Answer, Naming, PANICKED};
use crate::progress::Progress;
use crate::result::folder::ResultFolder;
use crate::result::grid::Style;
use crate::result::kind::ResultKind;
use crate::result::output_folder::OutputFolder;
use crate::result::report;
use crate::result::table::{Outcome, Run, Table};
use crate::result::table_text;
use crate::scene_file::{self, SceneFile};
use crate::score::trajectory_scores::TRAJECTORIES;
use crate::score::unseen::Unseen;
use crate::score::viewpoint::{ViewpointTrial, summarize, summarize_by_family};
use crate::score::viewpoint_table::viewpoint_table;
use error::RunError;
use line::{Scored, line};
use std::io::Write;

/// Runs the line, writes results, trajectories and pictures below `args.out`, and prints the tables.
pub fn bench(args: &RunArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let out = OutputFolder::probe(&args.out)?;
    // Required by the command line whenever there is no other command.
    let scene = args.scene.clone().unwrap_or_default();
    let file: SceneFile = scene_file::read(&scene)?;
    ResultFolder::check(&out, &file.name, ResultKind::Scene)?;
    let scored = line(&scene, &args.stages, Naming::Folder)?;
    let viewpoints = viewpoints(&scored.unseen, Style::Markdown);
    let (name, progress) = (&scored.results.scene, Progress::detect());
    let folder = ResultFolder::open(&out, name, ResultKind::Scene, &progress)?;
    let written = format!("written to {}", folder.path().display());
    pictures::write(&folder, &scored)?;
    folder.write("viewpoint.md", format!("# {name}\n\n{viewpoints}").as_bytes())?;
    report::write(folder, &scored.results, &scored.manifest)?;
    progress.note(&written);
    print(&scored, stdout)?;
    told_of_failures(&scored, &progress);
    let panicked = |answer: &Answer| matches!(&answer.outcome, Outcome::Failed(reason) if reason == PANICKED);
    if scored.answers.is_empty() {
        let any = scored.results.tables.iter().flat_map(Table::runs).any(|run| !run.scores.is_empty());
        return if any { Ok(Exit::Success) } else { Err(RunError::NothingSeen { scene }.into()) };
    }
    if scored.answers.iter().any(|(_, rows)| rows.iter().any(panicked)) {
        return Err(RunError::Panicked { scene }.into());
    }
    if scored.answers.iter().all(|(_, rows)| rows.iter().all(|answer| answer.world_from_robot.is_empty())) {
        return Err(RunError::NothingAnswered { scene }.into());
    }
    if scored.detections == 0 {
        return Err(RunError::NothingSeen { scene }.into());
    }
    Ok(Exit::Success)
}

/// Says how many runs of each other estimator failed, and why the first did.
fn told_of_failures(scored: &Scored, progress: &Progress) {
    let trajectories = scored.results.tables.iter().filter(|table| table.name() == TRAJECTORIES);
    let runs: Vec<&Run> = trajectories.flat_map(Table::runs).collect();
    for entry in &scored.entries {
        let of_entry = || runs.iter().filter(|run| run.method == entry.name);
        let failed = of_entry().filter_map(|run| match &run.outcome {
            Outcome::Failed(reason) => Some((run.seed, reason)),
            _ => None,
        });
        if let Some((seed, reason)) = failed.clone().next() {
            let (failed, all, name) = (failed.count(), of_entry().count(), &entry.name);
            progress.note(&format!(
                "note: {failed} of {all} runs of {name} failed, that of seed {} first: {reason}",
                seed.0
            ));
        }
    }
}

/// Prints every table, and the viewpoint errors by family.
fn print(scored: &Scored, stdout: &mut impl Write) -> Result<(), BenchError> {
    for table in &scored.results.tables {
        writeln!(stdout, "{}", table_text::tables(table, Style::Terminal))?;
    }
    writeln!(stdout, "{}", viewpoints(&scored.unseen, Style::Terminal))?;
    Ok(())
}

/// The viewpoint errors by family, of each model; under its name where there are several.
fn viewpoints(unseen: &[(String, Vec<Unseen>)], style: Style) -> String {
    let models = unseen.len();
    let of_model = |(name, unseen): &(String, Vec<Unseen>)| {
        let trials: Vec<ViewpointTrial> = unseen.iter().flat_map(|on| on.trials.iter().cloned()).collect();
        let table = viewpoint_table(&summarize_by_family(&trials), &summarize(&trials), style);
        if models > 1 { format!("{name}\n\n{table}") } else { table }
    };
    unseen.iter().map(of_model).collect::<Vec<_>>().join("\n")
}

//! What a run says on standard output: tables, where files lie, the answer.

use super::association::{self, ASSOCIATION_TIMES};
use super::line::Scored;
use super::online::times;
use crate::command::cli::{RunArgs, TablesChoice};
use crate::command::error::BenchError;
use crate::command::places::places;
use crate::command::report::REPORT;
use crate::result::grid::Style;
use crate::result::report::TABLES;
use crate::result::results_file::FILE_NAME;
use crate::result::step_errors::STEP_ERRORS;
use crate::result::step_times::{STEP_TIMES, step_times};
use crate::result::{summary_text, table_text};
use crate::score::association::ASSOCIATION;
use crate::score::online::ONLINE;
use crate::score::trajectory_scores::TRAJECTORIES;
use crate::score::unseen_table::{OF_GROUNDING, OF_LATENTS};
use crate::score::viewpoint::{ViewpointTrial, summarize, summarize_by_family};
use crate::score::viewpoint_table::viewpoint_table;
use std::io::Write;
use std::path::Path;

/// Says it; as JSON, the results and nothing else.
pub fn say(
    args: &RunArgs,
    scored: &Scored,
    folder: &Path,
    pictures: &[&str],
    stdout: &mut impl Write,
) -> Result<(), BenchError> {
    if args.json {
        return Ok(stdout.write_all(scored.results.to_json()?.as_bytes())?);
    }
    match args.tables {
        TablesChoice::Short => short(scored, stdout)?,
        TablesChoice::All => all(scored, stdout)?,
    }
    let mut kinds = vec![
        ("report", vec![REPORT]),
        ("tables", vec![TABLES]),
        ("raw scores", vec![FILE_NAME]),
        ("pictures", pictures.to_vec()),
    ];
    if !scored.episodes.is_empty() {
        kinds.push(("trajectories", vec!["<seed>/<method>.tum"]));
    }
    if !scored.online.is_empty() {
        kinds.push(("newest poses", vec!["<seed>/<method>.online.tum"]));
        kinds.push(("by step", vec![STEP_ERRORS, STEP_TIMES]));
    }
    if !scored.associations.is_empty() {
        kinds.push(("associations", vec!["<seed>/<row>.association.csv"]));
        kinds.push(("their times", vec![ASSOCIATION_TIMES]));
    }
    write!(stdout, "{}", places(folder, kinds))?;
    if let Some(table) = scored.results.table(TRAJECTORIES) {
        let answers = summary_text::answers(table);
        if !answers.is_empty() {
            writeln!(stdout, "\n{}", answers.join("\n"))?;
        }
    }
    Ok(())
}

fn short(scored: &Scored, stdout: &mut impl Write) -> Result<(), BenchError> {
    let style = Style::terminal();
    if let Some(table) = scored.results.table(TRAJECTORIES) {
        writeln!(stdout, "{}", summary_text::trajectories(table, style))?;
    }
    if let Some(table) = scored.results.table(ONLINE) {
        writeln!(stdout, "{}", table_text::tables(table, style))?;
        writeln!(stdout, "{}\n", step_times(&times(scored), style))?;
    }
    if let Some(table) = scored.results.table(ASSOCIATION) {
        writeln!(stdout, "{}", table_text::tables(table, style))?;
        writeln!(stdout, "{}\n", step_times(&association::times(scored), style))?;
    }
    if let (Some(latents), Some(classes)) =
        (scored.results.table(OF_LATENTS.name), scored.results.table(OF_GROUNDING.name))
    {
        writeln!(stdout, "{}", summary_text::latents(latents, classes, style))?;
    }
    Ok(())
}

/// Every table, and the viewpoint errors by family.
fn all(scored: &Scored, stdout: &mut impl Write) -> Result<(), BenchError> {
    let style = Style::terminal();
    for table in &scored.results.tables {
        writeln!(stdout, "{}", table_text::tables(table, style))?;
    }
    for (model, unseen) in &scored.unseen {
        let trials: Vec<ViewpointTrial> = unseen.iter().flat_map(|on| on.trials.iter().cloned()).collect();
        let by_family = viewpoint_table(&summarize_by_family(&trials), &summarize(&trials), style);
        writeln!(stdout, "azimuths by {model}, by family, views of all seeds\n\n{by_family}")?;
    }
    Ok(())
}

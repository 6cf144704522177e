//! `bench baseline SCENE --why TEXT`: the results that later runs are checked against, made anew.

use super::cli::{BaselineArgs, RunArgs, TablesChoice};
use crate::command::error::BenchError;
use crate::command::scene::bench;
use crate::exit::{Ends, Exit};
use crate::result::output_folder::OutputFolder;
use crate::scene_file::{self, SceneFile};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use thiserror::Error;

/// Where reasons are kept, beside the results.
const REASONS: &str = "BASELINES.md";
const HEAD: &str = "# Why baselines changed\n\n";

/// Why a baseline is not made anew.
#[derive(Debug, Error)]
pub enum BaselineError {
    /// Files that are not committed could have made it.
    #[error("{} is changed and not committed, so that nobody could make this baseline again: commit it, or stash it", path.display())]
    Dirty {
        /// The first of them.
        path: PathBuf,
    },
    /// No reason is given.
    #[error("--why is empty: say in a line why the baseline changes")]
    NoReason,
}

impl Ends for BaselineError {}

/// Runs the scene into the folder of baselines, in place of what is there, and writes the reason down.
pub fn baseline(args: &BaselineArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let why = args.why.split_whitespace().collect::<Vec<_>>().join(" ");
    if why.is_empty() {
        return Err(BaselineError::NoReason.into());
    }
    let scene: SceneFile = scene_file::read(&args.scene)?;
    if let Some(path) = changed(&args.baseline) {
        return Err(BaselineError::Dirty { path }.into());
    }
    let run = RunArgs {
        scene: Some(args.scene.clone()),
        out: args.baseline.clone(),
        replace: true,
        online: false,
        associate: false,
        associations: Vec::new(),
        tables: TablesChoice::Short,
        json: false,
        stages: args.stages.clone(),
    };
    let exit = bench(&run, stdout)?;
    if exit == Exit::Success {
        let before = std::fs::read_to_string(args.baseline.join(REASONS)).unwrap_or_else(|_| HEAD.to_owned());
        let commit =
            git(&["rev-parse", "--short", "HEAD"]).map(|hash| format!(", commit {hash}")).unwrap_or_default();
        let text = format!("{}\n- {}{commit}: {why}\n", before.trim_end(), scene.name);
        OutputFolder::probe(&args.baseline)?.write(REASONS, text.as_bytes())?;
        writeln!(stdout, "reason        {}", args.baseline.join(REASONS).display())?;
    }
    Ok(exit)
}

/// The first tracked file outside of the baselines that differs from the commit; none where there is no repository.
fn changed(baselines: &Path) -> Option<PathBuf> {
    let but_these = format!(":(exclude){}", baselines.display());
    let status = git(&["status", "--porcelain", "--untracked-files=no", "--", ".", &but_these])?;
    status.lines().next().and_then(|line| line.get(3..)).map(PathBuf::from)
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    // A line of the status may begin with a blank.
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim_end().to_owned())
}

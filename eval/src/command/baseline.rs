//! `bench baseline SCENE --why TEXT`: the results that later runs are checked against, made anew.

use super::cli::{BaselineArgs, RunArgs, TablesChoice};
use crate::command::error::BenchError;
use crate::command::scene::bench;
use crate::exit::{Ends, Exit};
use crate::result::output_folder::OutputFolder;
use crate::scene_file::{self, SceneFile};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use thiserror::Error;
use vantage_dataset::store::read_regular;

/// Where reasons are kept, beside the results.
const REASONS: &str = "BASELINES.md";
const LARGEST: u64 = 1 << 20;
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
    /// The reasons so far cannot be read.
    #[error("{}: {reason}; move it away, or mend it", path.display())]
    Reasons {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// Git does not say what has changed.
    #[error("git does not say which files have changed: run from inside the repository")]
    Git,
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
    if let Some(path) = changed(&args.baseline)? {
        return Err(BaselineError::Dirty { path }.into());
    }
    let before = reasons(&args.baseline.join(REASONS))?;
    let run = RunArgs {
        scene: Some(args.scene.clone()),
        out: args.baseline.clone(),
        replace: true,
        online: false,
        dump: false,
        associate: false,
        associations: Vec::new(),
        tables: TablesChoice::Short,
        json: false,
        stages: args.stages.clone(),
    };
    let exit = bench(&run, stdout)?;
    if exit == Exit::Success {
        let commit =
            git(&["rev-parse", "--short", "HEAD"]).map(|hash| format!(", commit {hash}")).unwrap_or_default();
        let text = format!("{}\n- {}{commit}: {why}\n", before.trim_end(), scene.name);
        OutputFolder::probe(&args.baseline)?.write(REASONS, text.as_bytes())?;
        writeln!(stdout, "reason        {}", args.baseline.join(REASONS).display())?;
    }
    Ok(exit)
}

/// What is written down already.
fn reasons(path: &Path) -> Result<String, BaselineError> {
    let failed = |reason: String| BaselineError::Reasons { path: path.to_owned(), reason };
    match read_regular(path, LARGEST) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(HEAD.to_owned()),
        Err(error) => Err(failed(error.to_string())),
        Ok(bytes) => String::from_utf8(bytes).map_err(|error| failed(error.to_string())),
    }
}

/// The first tracked file of the repository, outside of the baselines, that differs from the commit; none where there is no repository.
fn changed(baselines: &Path) -> Result<Option<PathBuf>, BaselineError> {
    if git(&["rev-parse", "--is-inside-work-tree"]).as_deref() != Some("true") {
        return Ok(None);
    }
    let top = git(&["rev-parse", "--show-toplevel"]).ok_or(BaselineError::Git)?;
    let status = git(&["status", "--porcelain", "--untracked-files=no"]).ok_or(BaselineError::Git)?;
    let absolute = std::path::absolute(baselines).map_err(|_| BaselineError::Git)?;
    let paths =
        status.lines().filter_map(|line| Some(Path::new(&top).join(line.get(3..)?.trim_matches('"'))));
    Ok(paths.into_iter().find(|path| !path.starts_with(&absolute)))
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    // A line of the status may begin with a blank.
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim_end().to_owned())
}

//! `bench train SCENE --out DIR`: the scene's model, trained from scratch.

use crate::cli::TrainArgs;
use crate::exit::{BenchError, Exit};
use crate::output::OutputFolder;
use crate::pipeline::{Pipeline, train as train_into};
use std::io::Write;

/// Trains into `args.out`, from where a killed training left it.
pub fn train(args: &TrainArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let out = OutputFolder::probe(&args.out)?;
    let pipeline = Pipeline::open(&args.scene, &args.cache, args.renderer)?;
    train_into(&pipeline, out.path())?;
    writeln!(stdout, "model written to {}", out.path().display())?;
    Ok(Exit::Success)
}

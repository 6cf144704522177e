//! `bench train SCENE --out DIR`: the scene's model, trained from scratch.

use crate::command::cli::TrainArgs;
use crate::command::error::BenchError;
use crate::exit::Exit;
use crate::pipeline::{Pipeline, train as train_into, train_on};
use crate::result::output_folder::OutputFolder;
use std::io::Write;
use vantage_learn::TrainingDevice;

/// Trains into `args.out`, from where a killed training left it.
pub fn train(args: &TrainArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let device = if args.gpu { gpu()? } else { TrainingDevice::default() };
    let out = OutputFolder::probe(&args.out)?;
    let pipeline = Pipeline::open(&args.scene, &args.making.cache, args.making.renderer.into())?;
    let _lock = out.lock(&pipeline.progress)?;
    match (&args.views, &args.validation_views) {
        (Some(training), Some(validation)) => train_on(&pipeline, training, validation, &device, out.path())?,
        _ => train_into(&pipeline, &device, out.path())?,
    }
    writeln!(stdout, "model written to {}", out.path().display())?;
    Ok(Exit::Success)
}

#[cfg(feature = "gpu")]
fn gpu() -> Result<TrainingDevice, BenchError> {
    Ok(TrainingDevice::gpu().map_err(crate::pipeline::StageError::from)?)
}

#[cfg(not(feature = "gpu"))]
fn gpu() -> Result<TrainingDevice, BenchError> {
    Err(crate::left_out::LeftOut::Gpu.into())
}

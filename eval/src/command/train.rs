//! `bench train SCENE --out DIR`: the scene's model, trained from scratch.

use crate::command::cli::TrainArgs;
use crate::command::error::BenchError;
use crate::command::folder::FolderError;
use crate::exit::Exit;
use crate::pipeline::{Pipeline, train as train_into, train_on};
use crate::result::output_folder::OutputFolder;
use std::fs;
use std::io::Write;
use std::path::Path;
use vantage_learn::{CHECKPOINT, MANIFEST, TrainingDevice};

/// Trains into `args.out`, from where a killed training left it.
pub fn train(args: &TrainArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let device = if args.gpu { gpu()? } else { TrainingDevice::default() };
    let out = OutputFolder::probe(&args.out)?;
    let pipeline = Pipeline::open(&args.scene, &args.making.cache, args.making.renderer.into())?;
    let _lock = out.lock(&pipeline.progress)?;
    if !out.is_empty()? && !is_begun(out.path()) {
        return Err(FolderError::NotOurs { folder: args.out.clone() }.into());
    }
    match (&args.views, &args.validation_views) {
        (Some(training), Some(validation)) => train_on(&pipeline, training, validation, &device, out.path())?,
        _ => train_into(&pipeline, &device, out.path())?,
    }
    writeln!(stdout, "model written to {}", out.path().display())?;
    Ok(Exit::Success)
}

/// Whether a training has begun there, or come to its end.
fn is_begun(folder: &Path) -> bool {
    let is_of_training = |name: &str| name.starts_with(CHECKPOINT) || name == MANIFEST;
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.file_name()).any(|name| name.to_str().is_some_and(is_of_training))
}

#[cfg(feature = "gpu")]
fn gpu() -> Result<TrainingDevice, BenchError> {
    Ok(TrainingDevice::gpu().map_err(crate::pipeline::StageError::from)?)
}

#[cfg(not(feature = "gpu"))]
fn gpu() -> Result<TrainingDevice, BenchError> {
    Err(crate::left_out::LeftOut::Gpu.into())
}

//! `bench train SCENE --out DIR`: the scene's model, trained from scratch.

use crate::command::cli::TrainArgs;
use crate::command::error::BenchError;
use crate::command::folder::FolderError;
use crate::command::view_split::check_split;
use crate::exit::Exit;
use crate::pipeline::{Pipeline, StageError, train as train_into, train_on};
use crate::result::output_folder::OutputFolder;
use std::fs;
use std::io::Write;
use std::path::Path;
use vantage_dataset::Split;
use vantage_dataset::store::read_regular;
use vantage_learn::{
    CANARY, CHECKPOINT, CURVE_PICTURE, CURVE_TABLE, INSTANCE_LIST, LARGEST_FILE, MANIFEST, SHEET, TrainError,
    TrainingDevice,
};

/// How the table of losses begins.
const CURVE_HEADER: &str = "stage,step,loss,";

/// Trains into `args.out`, from where a killed training left it.
pub fn train(args: &TrainArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let device = if args.gpu { gpu()? } else { TrainingDevice::default() };
    if let (Some(training), Some(validation)) = (&args.views, &args.validation_views) {
        check_split(training, "--views", Split::Train)?;
        check_split(validation, "--validation-views", Split::Validation)?;
    }
    let out = OutputFolder::probe(&args.out)?;
    let pipeline = Pipeline::open(&args.scene, &args.making.cache, args.making.renderer.into())?;
    let _lock = out.lock(&pipeline.progress)?;
    check(out.path())?;
    match (&args.views, &args.validation_views) {
        (Some(training), Some(validation)) => train_on(&pipeline, training, validation, &device, out.path())?,
        _ => train_into(&pipeline, &device, out.path())?,
    }
    writeln!(stdout, "model written to {}", out.path().display())?;
    Ok(Exit::Success)
}

/// Refuses a folder with a finished model, and one with files that a training would write and that are of none.
fn check(folder: &Path) -> Result<(), BenchError> {
    let manifest = folder.join(MANIFEST);
    if manifest.exists() {
        return Err(StageError::from(TrainError::AlreadyTrained { path: manifest }).into());
    }
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    let is_begun = names.iter().any(|name| name.starts_with(CHECKPOINT)) || has_curve(folder);
    if !is_begun && names.iter().any(|name| is_of_training(name)) {
        return Err(FolderError::NotOurs { folder: folder.to_owned() }.into());
    }
    Ok(())
}

/// Whether a training's losses are there, as of one that diverged.
fn has_curve(folder: &Path) -> bool {
    let table = read_regular(&folder.join(CURVE_TABLE), LARGEST_FILE);
    table.is_ok_and(|table| table.starts_with(CURVE_HEADER.as_bytes()))
}

fn is_of_training(name: &str) -> bool {
    [CURVE_TABLE, CURVE_PICTURE, SHEET, CANARY, INSTANCE_LIST].contains(&name) || name.ends_with(".onnx")
}

#[cfg(feature = "gpu")]
fn gpu() -> Result<TrainingDevice, BenchError> {
    Ok(TrainingDevice::gpu().map_err(StageError::from)?)
}

#[cfg(not(feature = "gpu"))]
fn gpu() -> Result<TrainingDevice, BenchError> {
    Err(crate::left_out::LeftOut::Gpu.into())
}

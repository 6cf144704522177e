//! How fast the default networks train, and how fast tract runs a model's graphs: see `benches/peers.sh`.
//!
//! `speed train` prints a line for each stage: its name, milliseconds a step. `speed run MODEL` prints one for each graph: its
//! name, microseconds a run. `speed run-batches MODEL FOLDER` does so for the graphs of a folder, of any batch, which the library
//! would not run, by the kernels that it chooses as it loads a model. `RAYON_NUM_THREADS` sets the number of threads.

#[path = "../tests/support/synthetic.rs"]
mod synthetic;

use mimalloc::MiMalloc;
use std::cell::Cell;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};
use tract_onnx::prelude::*;
use vantage_dataset::{Seed, Split};
use vantage_learn::{Model, Progress, Stage, Training, TrainingDevice, TrainingSpec, Viewing, train};
use vantage_model::{LatentGaussian, ObservationModel};

/// As in `bench`.
#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

const STEPS: u32 = 30;
const RUNS: usize = 301;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["train"] => trained(),
        ["run", model] => ran(Path::new(model)),
        ["run-batches", model, folder] => ran_batches(Path::new(model), Path::new(folder)),
        _ => Err("usage: speed train | speed run MODEL | speed run-batches MODEL FOLDER".into()),
    }
}

fn trained() -> Result<(), Box<dyn std::error::Error>> {
    let training = synthetic::views(Split::Train, 60, 16, 1);
    let validation = synthetic::views(Split::Validation, 20, 16, 2);
    let spec = TrainingSpec { trunk_steps: STEPS, steps: STEPS, ..TrainingSpec::default() };
    let folder = tempfile::tempdir()?;
    let mut last = Instant::now();
    let mut times: [Vec<Duration>; 2] = Default::default();
    let mut watch = |progress: &Progress| {
        if let Progress::Step { stage, .. } = progress {
            times[usize::from(*stage == Stage::Autoencoder)].push(last.elapsed());
        }
        last = Instant::now();
        ControlFlow::Continue(())
    };
    let asked = Training {
        training: &training,
        validation: &validation,
        spec: &spec,
        seed: Seed(0),
        provenance: &BTreeMap::new(),
        folder: folder.path(),
        trunks: None,
        device: &TrainingDevice::default(),
    };
    train(asked, &mut watch)?;
    for (name, times) in ["trunk", "autoencoder"].into_iter().zip(times) {
        println!("{name} {:.3}", 1e3 * median(times));
    }
    Ok(())
}

fn ran(model: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let Model::ViewpointDependent(model) = Model::load(model)? else {
        return Err("not viewpoint-dependent".into());
    };
    let views = synthetic::views(Split::Validation, 2, 2, 2);
    let view = &views.views[0];
    let x = view.viewpoint.conditioning();
    let latent =
        LatentGaussian::posterior(model.latent().dimension, &[model.encode(&view.crop, &view.viewpoint)?])
            .mean;
    let report = |name: &str, microseconds: f64| println!("{name} {microseconds:.2}");
    report("measurement", microseconds(|| model.measure(&view.crop).map(drop))?);
    // An encoder keeps what it made of the last crops.
    let calls = Cell::new(0u16);
    let another = || {
        let mut crop = view.crop.clone();
        crop.0[..2].copy_from_slice(&calls.replace(calls.get() + 1).to_le_bytes());
        crop
    };
    report("encoder", microseconds(|| model.encode(&another(), &view.viewpoint).map(drop))?);
    let turned = || view.viewpoint.turned(f64::from(calls.replace(calls.get() + 1)));
    report("encoder_from_elsewhere", microseconds(|| model.encode(&view.crop, &turned()).map(drop))?);
    report("decoder", microseconds(|| model.decode(&latent, &x).map(drop))?);
    report("decoder_jacobian", microseconds(|| model.decode_linear(&latent, &x).map(drop))?);
    report("image", microseconds(|| model.decode_image(&latent, &x).map(drop))?);
    Ok(())
}

fn ran_batches(model: &Path, folder: &Path) -> Result<(), Box<dyn std::error::Error>> {
    Model::load(model)?;
    let mut graphs =
        std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<std::io::Result<Vec<_>>>()?;
    graphs.retain(|path| path.extension().is_some_and(|extension| extension == "onnx"));
    graphs.sort();
    for path in graphs {
        let plan = tract_onnx::onnx().model_for_path(&path)?.into_optimized()?.into_runnable()?;
        let inputs = plan.model().input_outlets()?.iter().map(|&outlet| {
            let fact = plan.model().outlet_fact(outlet)?;
            let shape = fact.shape.as_concrete().unwrap_or_default();
            let numbers: Vec<f32> =
                (0..shape.iter().product()).map(|i: usize| (i * 7 % 101) as f32 / 101.0).collect();
            Ok(Tensor::from_shape(shape, &numbers)?.into_tvalue())
        });
        let inputs: TVec<TValue> = inputs.collect::<TractResult<_>>()?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        println!("{name} {:.2}", microseconds(|| plan.run(inputs.clone()).map(drop))?);
    }
    Ok(())
}

fn microseconds<E>(run: impl Fn() -> Result<(), E>) -> Result<f64, E> {
    let mut times = Vec::new();
    for _ in 0..RUNS {
        let started = Instant::now();
        run()?;
        times.push(started.elapsed());
    }
    Ok(1e6 * median(times))
}

/// Seconds.
fn median(mut times: Vec<Duration>) -> f64 {
    times.sort();
    times[times.len() / 2].as_secs_f64()
}

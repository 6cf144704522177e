//! How fast the default networks train, and how fast tract runs them: `cargo run --release --example speed`.
//!
//! Set `RAYON_NUM_THREADS` to see what threads give.

#[path = "../tests/support/synthetic.rs"]
mod synthetic;

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};
use vantage_dataset::{Seed, Split};
use vantage_learn::{LatentGaussian, Progress, Stage, Training, TrainingSpec, ViewpointModel, train};

const STEPS: u32 = 30;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let training = synthetic::views(Split::Train, 60, 16, 1);
    let validation = synthetic::views(Split::Validation, 20, 16, 2);
    let spec = TrainingSpec { trunk_steps: STEPS, steps: STEPS, ..TrainingSpec::default() };
    let folder = tempfile::tempdir()?;
    let mut last = Instant::now();
    let mut times: [Vec<Duration>; 2] = Default::default();
    let mut watch = |progress: &Progress| {
        if let Progress::Step { stage, .. } = progress {
            times[usize::from(*stage == Stage::Autoencoder)].push(last.elapsed());
        } else {
            println!("{:.2} s until {progress:?}", last.elapsed().as_secs_f64());
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
    };
    train(asked, &mut watch)?;
    println!("{:.2} s for the export", last.elapsed().as_secs_f64());
    let crops = [spec.trunk_batch, spec.batch * spec.views];
    for ((name, times), crops) in ["trunk", "autoencoder"].into_iter().zip(&mut times).zip(crops) {
        times.sort();
        let median = times[times.len() / 2].as_secs_f64();
        println!("{name}: {:.1} ms a step, {:.0} views a second", 1e3 * median, f64::from(crops) / median);
    }

    let started = Instant::now();
    let model = ViewpointModel::load(folder.path())?;
    println!("load: {:.0} ms", 1e3 * started.elapsed().as_secs_f64());
    let view = &validation.views[0];
    let x = view.viewpoint.conditioning();
    let latent = LatentGaussian::posterior(128, &[model.encode(&view.crop, &view.viewpoint)?]).mean;
    let report = |name: &str, microseconds: f64| println!("{name}: {microseconds:.0} us");
    report("measure", microseconds(|| model.measure(&view.crop).map(drop))?);
    report("encode", microseconds(|| model.encode(&view.crop, &view.viewpoint).map(drop))?);
    report("predict", microseconds(|| model.predict(&latent, &x).map(drop))?);
    report("linearize", microseconds(|| model.linearize(&latent, &x).map(drop))?);
    report("reconstruct", microseconds(|| model.reconstruct(&latent, &x).map(drop))?);
    Ok(())
}

/// Median over some hundred runs.
fn microseconds<E>(run: impl Fn() -> Result<(), E>) -> Result<f64, E> {
    let mut times = Vec::new();
    for _ in 0..301 {
        let started = Instant::now();
        run()?;
        times.push(started.elapsed());
    }
    times.sort();
    Ok(1e6 * times[times.len() / 2].as_secs_f64())
}

//! What the reduced measurement of IV-C leaves of the azimuth, and what it saves: all pixels of the predicted crop beside it.
//!
//! `cargo run --release -p vantage-eval --example full_pixels -- scenes/tabletop.yaml`
//!
//! Of the scene's reference model and its test instances: known from the views of even sessions, asked for the azimuth of each view
//! of an odd one. A pixel's noise is Gaussian and its own, its variance fitted on validation instances. Columns: numbers;
//! milliseconds of a prediction, and of one with its derivative by the azimuth (by pixels a central difference); the deviation
//! that the Fisher information promises of an azimuth, and the error, medians in degrees; the share of errors within 1.96 of
//! the promised deviation.

use nalgebra::DVector;
use std::error::Error;
use std::path::Path;
use std::time::Instant;
use vantage_dataset::{Crop, Seed, Split, View, ViewSet, Viewpoint};
use vantage_eval::cli::RendererChoice;
use vantage_eval::pipeline::{Likelihood, Pipeline, any_model, views};
use vantage_eval::score::azimuth_information::promised_deviation;
use vantage_eval::score::viewpoint::{ViewpointTrial, most_likely_azimuth};
use vantage_eval::statistics::quantile;
use vantage_learn::{LatentGaussian, Viewing};

/// Half the central difference, radians: predicted crops have bytes, whose rounding a smaller one would show.
const HALF_STEP: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// Deviations of a Gaussian that hold 95% of it.
const WITHIN: f64 = 1.96;
const TIMED: usize = 101;

fn main() -> Result<(), Box<dyn Error>> {
    let scene = std::env::args().nth(1).ok_or("usage: SCENE")?;
    let pipeline = Pipeline::open(Path::new(&scene), Path::new("cache"), RendererChoice::Auto)?;
    let folder = pipeline.file.training.reference.as_ref().map(|path| pipeline.folder.join(path));
    let (loaded, _) = any_model(&pipeline, folder.as_deref())?;
    let viewing = loaded.viewing().ok_or("a model that knows no viewpoints")?;
    let model = &*viewing;

    let (validation, _) = views(&pipeline, Split::Validation, pipeline.file.training.seed, &mut |_| ())?;
    let variance = pixel_variance(&asked(&validation, model)?, model)?;
    let seed = pipeline.file.evaluation.seeds.as_slice().first().copied().unwrap_or(Seed(0));
    let (test, _) = views(&pipeline, Split::Test, seed, &mut |_| ())?;
    let queries = asked(&test, model)?;

    println!("measurement  numbers  predict  with derivative  promised  error  inside");
    let first = queries.first().ok_or("no view of an odd session")?;
    let mut reduced = Found::default();
    let mut pixels = Found::default();
    for query in &queries {
        reduced.add(query, by_measurement(query, model)?);
        pixels.add(query, by_pixels(query, &variance, model)?);
    }
    let (latent, viewpoint) = (&first.latent, &first.view.viewpoint);
    reduced.print(
        "reduced",
        model.noise().sqrt_information().nrows(),
        milliseconds(|| model.predict_view(latent, viewpoint).map(drop))?,
        milliseconds(|| model.by_azimuth(latent, viewpoint).map(drop))?,
    );
    let look = |turn: f64| seen(model, latent, &viewpoint.turned(turn)).map(drop);
    let twice = || look(HALF_STEP).and_then(|()| look(-HALF_STEP));
    pixels.print("pixels", variance.len(), milliseconds(|| look(0.0))?, milliseconds(twice)?);
    Ok(())
}

/// A view of an odd session, and the latent by those of the even ones.
struct Query<'a> {
    view: &'a View,
    latent: DVector<f64>,
    trial: ViewpointTrial,
}

fn asked<'a>(set: &'a ViewSet, model: &dyn Viewing) -> Result<Vec<Query<'a>>, Box<dyn Error>> {
    let mut queries = Vec::new();
    for (index, instance) in set.instances.iter().enumerate() {
        let (known, held_out): (Vec<_>, Vec<_>) =
            set.views.iter().filter(|view| view.instance == index).partition(|view| view.session % 2 == 0);
        let factors: Result<Vec<LatentGaussian>, _> =
            known.iter().map(|view| model.encode_view(&view.crop, &view.viewpoint)).collect();
        let latent = LatentGaussian::posterior(model.latent().dimension, &factors?).mean;
        queries.extend(held_out.into_iter().map(|view| Query {
            view,
            latent: latent.clone(),
            trial: ViewpointTrial {
                family: instance.family.clone(),
                symmetry: instance.symmetry,
                azimuth: view.viewpoint.azimuth(),
                found: None,
            },
        }));
    }
    Ok(queries)
}

fn numbers(crop: &Crop) -> DVector<f64> {
    DVector::from_iterator(crop.0.len(), crop.0.iter().map(|&value| f64::from(value)))
}

fn seen(
    model: &dyn Viewing,
    latent: &DVector<f64>,
    viewpoint: &Viewpoint,
) -> Result<DVector<f64>, Box<dyn Error>> {
    let crop = model.reconstruct_view(latent, viewpoint).ok_or("a model that predicts no crops")??;
    Ok(numbers(&crop))
}

/// Mean square of what is wrong with each predicted number of a crop; one step of a byte at least.
fn pixel_variance(queries: &[Query<'_>], model: &dyn Viewing) -> Result<DVector<f64>, Box<dyn Error>> {
    let mut sum: Option<DVector<f64>> = None;
    for Query { view, latent, .. } in queries {
        let residual = numbers(&view.crop) - seen(model, latent, &view.viewpoint)?;
        let square = residual.component_mul(&residual);
        sum = Some(sum.map_or_else(|| square.clone(), |sum| sum + &square));
    }
    let sum = sum.ok_or("no validation view of an odd session")?;
    Ok((sum / queries.len() as f64).map(|variance| variance.max(1.0)))
}

/// Promised deviation and most likely azimuth.
type Answer = (Option<f64>, Option<f64>);

fn by_measurement(query: &Query<'_>, model: &dyn Viewing) -> Result<Answer, Box<dyn Error>> {
    let Query { view, latent, trial } = query;
    let noise = model.noise();
    let derivative = model.by_azimuth(latent, &view.viewpoint)?;
    let promised = promised_deviation(&derivative, &noise.sqrt_information(), noise.degrees_of_freedom);
    let likelihood = Likelihood::new(model, latent, &view.crop)?;
    let at = |azimuth: f64| likelihood.at(&view.viewpoint.turned(azimuth - trial.azimuth));
    Ok((promised, most_likely_azimuth(|azimuth| at(azimuth).unwrap_or(f64::NAN))))
}

fn by_pixels(
    query: &Query<'_>,
    variance: &DVector<f64>,
    model: &dyn Viewing,
) -> Result<Answer, Box<dyn Error>> {
    let Query { view, latent, trial } = query;
    let look = |turn: f64| seen(model, latent, &view.viewpoint.turned(turn));
    let squared = |residual: DVector<f64>| residual.component_mul(&residual).component_div(variance).sum();
    let information = squared((look(HALF_STEP)? - look(-HALF_STEP)?) / (2.0 * HALF_STEP));
    let crop = numbers(&view.crop);
    let at = |azimuth: f64| look(azimuth - trial.azimuth).map(|seen| -0.5 * squared(&crop - seen));
    let found = most_likely_azimuth(|azimuth| at(azimuth).unwrap_or(f64::NAN));
    Ok(((information > 0.0).then(|| 1.0 / information.sqrt()), found))
}

#[derive(Default)]
struct Found {
    promised: Vec<f64>,
    errors: Vec<f64>,
    inside: usize,
}

impl Found {
    /// Surfaces of revolution have no azimuth to find.
    fn add(&mut self, query: &Query<'_>, (promised, found): Answer) {
        let Some(error) = (ViewpointTrial { found, ..query.trial.clone() }).error() else { return };
        let Some(promised) = promised else { return };
        self.inside += usize::from(error <= WITHIN * promised);
        self.promised.push(promised);
        self.errors.push(error);
    }

    fn print(mut self, name: &str, numbers: usize, predict: f64, with_derivative: f64) {
        let median = |values: &mut Vec<f64>| {
            values.sort_by(f64::total_cmp);
            quantile(values, 0.5).unwrap_or(f64::NAN).to_degrees()
        };
        let (promised, error) = (median(&mut self.promised), median(&mut self.errors));
        let inside = 100.0 * self.inside as f64 / self.errors.len() as f64;
        println!(
            "{name:11}  {numbers:7}  {predict:7.3}  {with_derivative:15.3}  {promised:8.2}  {error:5.1}  {inside:5.0}%"
        );
    }
}

/// Median of the calls.
fn milliseconds<E>(call: impl Fn() -> Result<(), E>) -> Result<f64, E> {
    let mut times = Vec::with_capacity(TIMED);
    for _ in 0..TIMED {
        let start = Instant::now();
        call()?;
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    times.sort_by(f64::total_cmp);
    Ok(times[TIMED / 2])
}

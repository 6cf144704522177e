//! What the reduced measurement of IV-C leaves of the azimuth, and what it saves, beside the pixels of the predicted crop.
//!
//! `cargo run --release -p vantage-eval --example full_pixels -- scenes/tabletop.yaml`
//!
//! Of the scene's reference model and its test instances: known from the views of even sessions, asked for the azimuth of each view
//! of an odd one. `reduced` has the model's noise, a Student t with a full covariance. `independent` and `pixels` have Gaussian
//! noise, each number its own, its variance fitted on validation instances. Columns: numbers; milliseconds of a prediction, and of
//! one with all derivatives (of pixels by central differences, as of any model without a Jacobian); then means over the scene's
//! seeds with 95% intervals: the median error that the Fisher information promises of an azimuth and the one that was found, degrees;
//! and the share of errors within 1.96 deviations of the promise; last the azimuths, those of surfaces of revolution aside.

use nalgebra::DVector;
use rayon::prelude::*;
use std::error::Error;
use std::path::Path;
use std::time::Instant;
use vantage_dataset::{Crop, Split, View, ViewSet, Viewpoint};
use vantage_eval::pipeline::{Pipeline, RendererChoice, any_model, views};
use vantage_eval::result::statistics::{Mean, quantile};
use vantage_eval::score::azimuth_information::promised_deviation;
use vantage_eval::score::likelihood::Likelihood;
use vantage_eval::score::viewpoint::{ViewpointTrial, most_likely_azimuth};
use vantage_learn::Viewing;
use vantage_model::LatentGaussian;

/// Half the central difference, radians: a predicted crop has bytes, whose rounding a smaller one would show.
const HALF_STEP: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// Deviations of a Gaussian that hold 95% of it, and half of it.
const WITHIN: f64 = 1.96;
const HALF: f64 = 0.6745;
const TIMED: usize = 101;

fn main() -> Result<(), Box<dyn Error>> {
    let scene = std::env::args().nth(1).ok_or("usage: SCENE")?;
    let pipeline = Pipeline::open(Path::new(&scene), Path::new("cache"), RendererChoice::Auto)?;
    let folder = pipeline.file.training.reference.as_ref().map(|path| pipeline.folder.join(path));
    let (loaded, _) = any_model(&pipeline, folder.as_deref())?;
    let model = loaded.viewing().ok_or("a model that knows no viewpoints")?;

    let (validation, _) = views(&pipeline, Split::Validation, pipeline.file.training.seed, &mut |_| ())?;
    let fitted = asked(&validation, model)?;
    let measured = |query: &Query<'_>| -> Numbers {
        Ok(model.measure(&query.view.crop)? - model.predict(&query.latent, &query.view.viewpoint)?)
    };
    let wrong = |query: &Query<'_>| -> Numbers {
        Ok(numbers(&query.view.crop) - seen(model, &query.latent, &query.view.viewpoint)?)
    };
    let (of_numbers, of_pixels) = (variance(&fitted, measured, 0.0)?, variance(&fitted, wrong, 1.0)?);

    let mut found: [Vec<Found>; 3] = Default::default();
    for &seed in pipeline.file.evaluation.seeds.as_slice() {
        let (test, _) = views(&pipeline, Split::Test, seed, &mut |_| ())?;
        let queries = asked(&test, model)?;
        let answers: Vec<[Answer; 3]> = queries
            .par_iter()
            .map(|query| {
                let answers = || -> Result<[Answer; 3], Box<dyn Error>> {
                    Ok([
                        by_measurement(query, model)?,
                        independent(query, &of_numbers, &model.measure(&query.view.crop)?, |viewpoint| {
                            Ok(model.predict(&query.latent, viewpoint)?)
                        })?,
                        independent(query, &of_pixels, &numbers(&query.view.crop), |viewpoint| {
                            seen(model, &query.latent, viewpoint)
                        })?,
                    ])
                };
                answers().map_err(|error| error.to_string())
            })
            .collect::<Result<_, String>>()?;
        for (way, found) in found.iter_mut().enumerate() {
            found.push(Found::of(queries.iter().zip(answers.iter().map(|answer| answer[way]))));
        }
    }

    let first = fitted.first().ok_or("no view of an odd session")?;
    let (latent, viewpoint) = (&first.latent, &first.view.viewpoint);
    let inputs = 2 * (latent.len() + viewpoint.conditioning().len());
    let predict = milliseconds(|| model.predict(latent, viewpoint).map(drop))?;
    let linearize = milliseconds(|| model.linearize(latent, viewpoint).map(drop))?;
    let look = milliseconds(|| seen(model, latent, viewpoint).map(drop))?;
    let differences =
        milliseconds(|| (0..inputs).try_for_each(|_| seen(model, latent, viewpoint).map(drop)))?;
    println!(
        "measurement  numbers  predict  derivatives  promised          found             inside            azimuths"
    );
    let [reduced, independent, pixels] = found;
    print("reduced", of_numbers.len(), [predict, linearize], &reduced);
    print("independent", of_numbers.len(), [predict, linearize], &independent);
    print("pixels", of_pixels.len(), [look, differences], &pixels);
    Ok(())
}

/// Of a measurement or a crop.
type Numbers = Result<DVector<f64>, Box<dyn Error>>;

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
            known.iter().map(|view| model.encode(&view.crop, &view.viewpoint)).collect();
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

fn seen(model: &dyn Viewing, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Numbers {
    let crop = model.reconstruct(latent, viewpoint).ok_or("a model that predicts no crops")??;
    Ok(numbers(&crop))
}

/// Mean square of what is wrong with each predicted number, or `least`: of a byte a step, since corners of masked crops are always
/// black.
fn variance(queries: &[Query<'_>], residual: impl Fn(&Query<'_>) -> Numbers, least: f64) -> Numbers {
    let mut sum: Option<DVector<f64>> = None;
    for query in queries {
        let residual = residual(query)?;
        let square = residual.component_mul(&residual);
        sum = Some(sum.map_or_else(|| square.clone(), |sum| sum + &square));
    }
    let mean = sum.ok_or("no validation view of an odd session")? / queries.len() as f64;
    Ok(mean.map(|variance| variance.max(least)))
}

/// Promised deviation and most likely azimuth.
type Answer = (Option<f64>, Option<f64>);

fn by_measurement(query: &Query<'_>, model: &dyn Viewing) -> Result<Answer, Box<dyn Error>> {
    let Query { view, latent, trial } = query;
    let noise = model.noise();
    let derivative = model.linearize(latent, &view.viewpoint)?.d_viewpoint.by_azimuth(&view.viewpoint);
    let promised = promised_deviation(&derivative, noise.sqrt_information(), noise.degrees_of_freedom());
    let likelihood = Likelihood::new(model, latent, &view.crop)?;
    let at = |azimuth: f64| likelihood.at(&view.viewpoint.turned(azimuth - trial.azimuth));
    Ok((promised, most_likely_azimuth(|azimuth| at(azimuth).unwrap_or(f64::NAN))))
}

/// By numbers whose noise is Gaussian and independent.
fn independent(
    query: &Query<'_>,
    variance: &DVector<f64>,
    measured: &DVector<f64>,
    predicted: impl Fn(&Viewpoint) -> Numbers,
) -> Result<Answer, Box<dyn Error>> {
    let Query { view, trial, .. } = query;
    let look = |turn: f64| predicted(&view.viewpoint.turned(turn));
    let squared = |residual: DVector<f64>| residual.component_mul(&residual).component_div(variance).sum();
    let information = squared((look(HALF_STEP)? - look(-HALF_STEP)?) / (2.0 * HALF_STEP));
    let at = |azimuth: f64| look(azimuth - trial.azimuth).map(|seen| -0.5 * squared(measured - seen));
    let found = most_likely_azimuth(|azimuth| at(azimuth).unwrap_or(f64::NAN));
    let promised = information > 0.0 && information.is_finite();
    Ok((promised.then(|| 1.0 / information.sqrt()), found))
}

/// Of a seed: medians in degrees, a share, and how many.
struct Found {
    promised: f64,
    error: f64,
    inside: f64,
    azimuths: usize,
}

impl Found {
    /// Surfaces of revolution have no azimuth to find; no promise is one of nothing.
    fn of<'a>(answers: impl Iterator<Item = (&'a Query<'a>, Answer)>) -> Self {
        let (mut promised, mut errors, mut inside) = (Vec::new(), Vec::new(), 0);
        for (query, (promise, found)) in answers {
            let Some(error) = (ViewpointTrial { found, ..query.trial.clone() }).error() else { continue };
            let promise = promise.unwrap_or(f64::INFINITY);
            inside += usize::from(error <= WITHIN * promise);
            promised.push(HALF * promise);
            errors.push(error);
        }
        let median = |values: &mut Vec<f64>| {
            values.sort_by(f64::total_cmp);
            quantile(values, 0.5).unwrap_or(f64::NAN).to_degrees()
        };
        Self {
            promised: median(&mut promised),
            error: median(&mut errors),
            inside: inside as f64 / errors.len() as f64,
            azimuths: errors.len(),
        }
    }
}

fn print(name: &str, numbers: usize, [predict, derivatives]: [f64; 2], found: &[Found]) {
    let mean = |of: fn(&Found) -> f64| {
        let values: Vec<f64> = found.iter().map(of).collect();
        Mean::of(&values).map_or_else(String::new, |mean| {
            format!("{:6.3} +- {:6.3}", mean.mean, mean.half_width.unwrap_or(f64::NAN))
        })
    };
    let (promised, error, inside) =
        (mean(|found| found.promised), mean(|found| found.error), mean(|found| found.inside));
    let azimuths: usize = found.iter().map(|found| found.azimuths).sum();
    println!(
        "{name:11}  {numbers:7}  {predict:7.3}  {derivatives:11.3}  {promised}  {error}  {inside}  {azimuths:8}"
    );
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

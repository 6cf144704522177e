//! What a model expects to see of objects, and from where it thinks a view was taken.

use super::latents::names;
use crate::command::error::BenchError;
use crate::figure::calibration::calibration_svg;
use crate::figure::crop_table::{Block, crop_table_png};
use crate::figure::viewpoint_map::{ViewpointPanel, viewpoint_map_png};
use crate::score::calibration::calibration;
use crate::score::likelihood::Likelihood;
use nalgebra::{DVector, Vector3};
use std::f64::consts::PI;
use vantage_dataset::{Crop, View, ViewSet, Viewpoint};
use vantage_learn::Viewing;
use vantage_model::LatentGaussian;

/// Objects of the sheet and of the viewpoint maps, each of another family.
const OBJECTS: usize = 6;
/// Held-out views of each on the sheet, at most.
const HELD_OUT: usize = 8;
/// Cells of a viewpoint map.
const AZIMUTHS: usize = 120;
const ELEVATIONS: usize = 20;
/// Elevations of a viewpoint map, degrees.
const ELEVATION_RANGE: (f64, f64) = (0.0, 80.0);

/// The views that are shown, and the encoder's word on each.
pub(in crate::command) struct Looks<'a> {
    set: &'a ViewSet,
    model: &'a dyn Viewing,
    factors: Vec<LatentGaussian>,
}

/// Views of one instance.
struct Parts<'a> {
    /// Family and number, as titles have it.
    name: String,
    family: &'a str,
    /// Of the even sessions: known.
    known: Vec<(&'a View, &'a LatentGaussian)>,
    /// Of the odd sessions, under other light: held out.
    held_out: Vec<&'a View>,
}

impl<'a> Looks<'a> {
    pub(in crate::command) fn new(set: &'a ViewSet, model: &'a dyn Viewing) -> Result<Self, BenchError> {
        let encode = |view: &View| model.encode(&view.crop, &view.viewpoint);
        Ok(Self { set, model, factors: set.views.iter().map(encode).collect::<Result<_, _>>()? })
    }

    /// Whether any object has views of both kinds.
    pub(in crate::command) fn any(&self) -> bool {
        !self.objects().is_empty()
    }

    /// The instances that have views of both kinds.
    fn complete(&self) -> impl Iterator<Item = Parts<'_>> {
        let instances = self.set.instances.iter().enumerate().zip(names(self.set));
        let parts = instances.map(|((index, instance), name)| {
            let own =
                || self.set.views.iter().zip(&self.factors).filter(move |(view, _)| view.instance == index);
            Parts {
                name,
                family: &instance.family,
                known: own().filter(|(view, _)| view.session % 2 == 0).collect(),
                held_out: own().filter(|(view, _)| view.session % 2 == 1).map(|(view, _)| view).collect(),
            }
        });
        parts.filter(|parts| !parts.known.is_empty() && !parts.held_out.is_empty())
    }

    /// The first of each of some families, spread over all of them.
    fn objects(&self) -> Vec<Parts<'_>> {
        let mut families: Vec<&str> = Vec::new();
        let mut all: Vec<Parts<'_>> = self.complete().collect();
        all.retain(|parts| {
            let first = !families.contains(&parts.family);
            families.push(parts.family);
            first
        });
        let (count, chosen) = (all.len(), OBJECTS.min(all.len()));
        let mut place = 0..count;
        all.retain(|_| {
            let place = place.next().unwrap_or(count);
            (0..chosen).any(|index| index * count / chosen == place)
        });
        all
    }

    /// Whether held-out views lie as far from what the known ones predict as the noise says; `None` where the model has no answer
    /// to any.
    pub(in crate::command) fn calibration(&self) -> Result<Option<Vec<u8>>, BenchError> {
        let mut residuals = Vec::new();
        for parts in self.complete() {
            let latent = self.fused(&parts);
            for view in &parts.held_out {
                let likelihood = Likelihood::new(self.model, &latent, &view.crop)?;
                residuals.extend(likelihood.whitened_residual(&view.viewpoint));
            }
        }
        let found = calibration(&residuals, self.model.noise().degrees_of_freedom());
        Ok(found.map(|found| calibration_svg(&found)).transpose()?.map(String::into_bytes))
    }

    fn posterior(&self, factors: &[LatentGaussian]) -> DVector<f64> {
        LatentGaussian::posterior(self.model.latent().dimension, factors).mean
    }

    fn fused(&self, parts: &Parts<'_>) -> DVector<f64> {
        let factors: Vec<LatentGaussian> = parts.known.iter().map(|(_, factor)| (*factor).clone()).collect();
        self.posterior(&factors)
    }

    /// An input and held-out views by rising azimuth from it, above what is expected from the input alone, and from all
    /// known views; `None` of a model that predicts no crops.
    pub(in crate::command) fn predictions(&self) -> Result<Option<Vec<u8>>, BenchError> {
        let mut blocks = Vec::new();
        for parts in self.objects() {
            let (input, factor) = parts.known[0];
            let from_input = |view: &View| {
                let degrees = (view.viewpoint.azimuth() - input.viewpoint.azimuth()).to_degrees();
                (degrees + 180.0).rem_euclid(360.0) - 180.0
            };
            let mut held_out = parts.held_out.clone();
            held_out.sort_by(|a, b| from_input(a).abs().total_cmp(&from_input(b).abs()));
            held_out.truncate(HELD_OUT);
            let shown: Vec<&View> = [input].into_iter().chain(held_out).collect();
            let line = |latent: &DVector<f64>| -> Result<Option<Vec<Crop>>, BenchError> {
                let crop = |view: &&View| self.model.reconstruct(latent, &view.viewpoint);
                Ok(shown.iter().map(crop).collect::<Option<Result<_, _>>>().transpose()?)
            };
            let (Some(alone), Some(together)) =
                (line(&self.posterior(std::slice::from_ref(factor)))?, line(&self.fused(&parts))?)
            else {
                return Ok(None);
            };
            let truth = shown.iter().map(|view| view.crop.clone()).collect();
            let captions = shown.iter().enumerate().map(|(column, view)| match column {
                0 => "input".to_owned(),
                _ => format!("azimuth\n{:+.0} deg", from_input(view)),
            });
            blocks.push(Block {
                captions: captions.collect(),
                rows: vec![
                    ("seen".to_owned(), truth),
                    ("from the input".to_owned(), alone),
                    (format!("from {} views", parts.known.len()), together),
                ],
                name: parts.name,
            });
        }
        Ok(Some(crop_table_png(&blocks)?))
    }

    /// The likelihood of one held-out view of each object, given the known ones; roll and distance as they are. `None` where the model
    /// has no answer to any.
    pub(in crate::command) fn viewpoints(&self) -> Result<Option<Vec<u8>>, BenchError> {
        let mut panels = Vec::new();
        for parts in self.objects() {
            let view = parts.held_out[0];
            let latent = self.fused(&parts);
            let likelihood = Likelihood::new(self.model, &latent, &view.crop)?;
            let (low, high) = ELEVATION_RANGE;
            let elevation =
                |row: usize| (low + (high - low) * (row as f64 + 0.5) / ELEVATIONS as f64).to_radians();
            let azimuth = |column: usize| -PI + 2.0 * PI * (column as f64 + 0.5) / AZIMUTHS as f64;
            let at = |row: usize, column: usize| {
                likelihood
                    .at(&seen_from(&view.viewpoint, azimuth(column), elevation(row)))
                    .unwrap_or(f64::NAN)
            };
            let row = |row: usize| (0..AZIMUTHS).map(|column| at(row, column)).collect();
            let log_likelihood: Vec<Vec<f64>> = (0..ELEVATIONS).map(row).collect();
            if !log_likelihood.iter().flatten().all(|value| value.is_finite()) {
                continue;
            }
            let (truth, known) = (&view.viewpoint, parts.known.len());
            panels.push(ViewpointPanel {
                title: format!("{}, known from {known} other views", parts.name),
                crop: view.crop.clone(),
                log_likelihood,
                elevations: ELEVATION_RANGE,
                truth: (truth.azimuth().to_degrees(), truth.elevation().to_degrees()),
            });
        }
        Ok(if panels.is_empty() { None } else { Some(viewpoint_map_png(&panels)?) })
    }
}

/// A viewpoint of the same roll and distance, radians.
fn seen_from(viewpoint: &Viewpoint, azimuth: f64, elevation: f64) -> Viewpoint {
    let (s, c) = libm::sincos(azimuth);
    let horizontal = libm::cos(elevation);
    Viewpoint { direction: Vector3::new(c * horizontal, s * horizontal, libm::sin(elevation)), ..*viewpoint }
}

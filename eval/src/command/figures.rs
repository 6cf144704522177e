//! `bench figures SCENE --out DIR`: what a model makes of objects it has not seen, as pictures.

use super::score::chosen_model;
use crate::cli::FiguresArgs;
use crate::exit::{BenchError, Exit};
use crate::figure::FigureError;
use crate::figure::crop_table::{Block, crop_table_png};
use crate::figure::embedding_map::EmbeddingMap;
use crate::figure::tsne::tsne;
use crate::figure::viewpoint_map::{ViewpointPanel, viewpoint_map_png};
use crate::output::OutputFolder;
use crate::pipeline::{Likelihood, Pipeline, model, steady_latents, views};
use nalgebra::Vector3;
use std::f64::consts::PI;
use std::io::Write;
use vantage_dataset::viewpoint::CONDITIONING;
use vantage_dataset::{Crop, Seed, Split, View, ViewSet, Viewpoint};
use vantage_learn::{LatentGaussian, ViewpointModel};

/// Objects of the sheet and of the viewpoint maps, each of another family.
const OBJECTS: usize = 6;
/// Held-out views of each on the sheet, at most.
const HELD_OUT: usize = 8;
/// Cells of a viewpoint map.
const AZIMUTHS: usize = 120;
const ELEVATIONS: usize = 20;
/// Elevations of a viewpoint map, degrees.
const ELEVATION_RANGE: (f64, f64) = (0.0, 80.0);

/// Draws the test instances of the scene's first seed: their latents as t-SNE, reconstructions and predictions, and
/// likelihoods over viewpoints.
pub fn figures(args: &FiguresArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let out = OutputFolder::probe(&args.out)?;
    let pipeline = Pipeline::open(&args.scene, &args.cache, args.renderer)?;
    let loaded = model(&pipeline, chosen_model(&pipeline, false, args.model.as_deref()).as_deref())?;
    let seed = pipeline.file.evaluation.seeds.as_slice().first().copied().unwrap_or(Seed(0));
    let (set, _) = views(&pipeline, Split::Test, seed, &mut |_| ())?;
    loaded.check_unseen(set.instances.iter().map(|instance| instance.id))?;

    let shown = Shown::new(&set, loaded.model.inner())?;
    let (svg, png) = shown.latents()?;
    for (name, bytes) in [
        ("latents.svg", svg.into_bytes()),
        ("latents.png", png),
        ("predictions.png", shown.predictions()?),
        ("viewpoints.png", shown.viewpoints()?),
    ] {
        out.write(name, &bytes)?;
        writeln!(stdout, "{}", out.path().join(name).display())?;
    }
    Ok(Exit::Success)
}

/// The views that are shown, and the encoder's word on each.
struct Shown<'a> {
    set: &'a ViewSet,
    model: &'a ViewpointModel,
    factors: Vec<LatentGaussian>,
}

/// Views of one instance.
struct Parts<'a> {
    /// Family and number, as titles have it.
    name: String,
    /// Of the even sessions: known.
    known: Vec<(&'a View, &'a LatentGaussian)>,
    /// Of the odd sessions, under other light: held out.
    held_out: Vec<&'a View>,
}

impl<'a> Shown<'a> {
    fn new(set: &'a ViewSet, model: &'a ViewpointModel) -> Result<Self, BenchError> {
        let encode = |view: &View| model.encode(&view.crop, &view.viewpoint);
        Ok(Self { set, model, factors: set.views.iter().map(encode).collect::<Result<_, _>>()? })
    }

    /// The map of all views as SVG, and with images as PNG.
    fn latents(&self) -> Result<(String, Vec<u8>), BenchError> {
        let latents = steady_latents(&self.factors, self.model.latent());
        let points = tsne(&latents).ok_or(FigureError::Empty { figure: "t-SNE" })?;
        let groups: Vec<usize> = self.set.views.iter().map(|view| view.instance).collect();
        let names: Vec<String> = (0..self.set.instances.len()).map(|index| self.name(index)).collect();
        let crops: Vec<&Crop> = self.set.views.iter().map(|view| &view.crop).collect();
        let title =
            format!("t-SNE of latents, one of each view; a colour for each of {} instances", names.len());
        let map =
            EmbeddingMap { title: &title, points: &points, groups: &groups, names: &names, crops: &crops };
        Ok((map.svg()?, map.png()?))
    }

    fn name(&self, instance: usize) -> String {
        let family = &self.set.instances[instance].family;
        let before = self.set.instances[..instance].iter().filter(|other| other.family == *family).count();
        format!("{family} {}", before + 1)
    }

    /// The first instance of each of some families, spread over all of them, that has views of both kinds.
    fn objects(&self) -> Vec<Parts<'_>> {
        let mut families: Vec<&str> = Vec::new();
        let mut all = Vec::new();
        for (index, instance) in self.set.instances.iter().enumerate() {
            let own = || self.set.views.iter().zip(&self.factors).filter(|(view, _)| view.instance == index);
            let parts = Parts {
                name: self.name(index),
                known: own().filter(|(view, _)| view.session % 2 == 0).collect(),
                held_out: own().filter(|(view, _)| view.session % 2 == 1).map(|(view, _)| view).collect(),
            };
            let complete = !parts.known.is_empty() && !parts.held_out.is_empty();
            if complete && !families.contains(&instance.family.as_str()) {
                families.push(&instance.family);
                all.push(parts);
            }
        }
        let (count, chosen) = (all.len(), OBJECTS.min(all.len()));
        let mut place = 0..count;
        all.retain(|_| {
            let place = place.next().unwrap_or(count);
            (0..chosen).any(|index| index * count / chosen == place)
        });
        all
    }

    fn posterior(&self, factors: &[LatentGaussian]) -> nalgebra::DVector<f64> {
        LatentGaussian::posterior(self.model.latent().dimension, factors).mean
    }

    fn fused(&self, parts: &Parts<'_>) -> nalgebra::DVector<f64> {
        let factors: Vec<LatentGaussian> = parts.known.iter().map(|(_, factor)| (*factor).clone()).collect();
        self.posterior(&factors)
    }

    /// An input and held-out views by rising azimuth from it, above what is expected from the input alone, and from all
    /// known views.
    fn predictions(&self) -> Result<Vec<u8>, BenchError> {
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
            let line = |latent: &nalgebra::DVector<f64>| -> Result<Vec<Crop>, BenchError> {
                let crop = |view: &&View| {
                    let x: [f64; CONDITIONING] = view.viewpoint.conditioning();
                    Ok(self.model.reconstruct(latent, &x)?)
                };
                shown.iter().map(crop).collect()
            };
            let truth = shown.iter().map(|view| view.crop.clone()).collect();
            let captions = shown.iter().enumerate().map(|(column, view)| match column {
                0 => "input".to_owned(),
                _ => format!("{:+.0}", from_input(view)),
            });
            blocks.push(Block {
                captions: captions.collect(),
                rows: vec![
                    ("seen".to_owned(), truth),
                    ("from the input".to_owned(), line(&self.posterior(std::slice::from_ref(factor)))?),
                    (format!("from {} views", parts.known.len()), line(&self.fused(&parts))?),
                ],
                name: parts.name,
            });
        }
        Ok(crop_table_png(&blocks)?)
    }

    /// The likelihood of one held-out view of each object, given the known ones; roll and distance as they are.
    fn viewpoints(&self) -> Result<Vec<u8>, BenchError> {
        let mut panels = Vec::new();
        for parts in self.objects() {
            let view = parts.held_out[0];
            let latent = self.fused(&parts);
            let likelihood = Likelihood::new(&self.model, &latent, &view.crop)?;
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
            let (truth, known) = (&view.viewpoint, parts.known.len());
            panels.push(ViewpointPanel {
                title: format!("{}, known from {known} other views", parts.name),
                crop: view.crop.clone(),
                log_likelihood: (0..ELEVATIONS).map(row).collect(),
                elevations: ELEVATION_RANGE,
                truth: (truth.azimuth().to_degrees(), truth.elevation().to_degrees()),
            });
        }
        Ok(viewpoint_map_png(&panels)?)
    }
}

/// A viewpoint of the same roll and distance, radians.
fn seen_from(viewpoint: &Viewpoint, azimuth: f64, elevation: f64) -> Viewpoint {
    let (s, c) = libm::sincos(azimuth);
    let horizontal = libm::cos(elevation);
    Viewpoint { direction: Vector3::new(c * horizontal, s * horizontal, libm::sin(elevation)), ..*viewpoint }
}

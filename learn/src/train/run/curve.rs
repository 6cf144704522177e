//! The loss curve: as rows while training, as CSV and SVG for people.

use super::files;
use super::progress::Stage;
use crate::train::error::TrainError;
use plotters::coord::Shift;
use plotters::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The curve as a table.
pub const CURVE_TABLE: &str = "loss.csv";
/// The curve as a picture.
pub const CURVE_PICTURE: &str = "loss.svg";

/// The loss of a step, and the terms it is the sum of.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Loss {
    pub stage: Stage,
    /// Counted from 1.
    pub step: usize,
    pub total: f64,
    /// Unweighted terms: see [`terms`].
    pub terms: [f64; 4],
}

/// What the terms of a stage's loss are.
fn terms(stage: Stage) -> &'static [&'static str] {
    match stage {
        Stage::Trunk => &["azimuth", "upright", "instance"],
        Stage::Autoencoder => &["measurement", "image", "divergence", "association"],
    }
}

/// Losses in the order of the steps.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub(crate) struct Curve(pub Vec<Loss>);

impl Curve {
    /// The last loss of each stage.
    pub(crate) fn last(&self, stage: Stage) -> Option<f64> {
        self.0.iter().rev().find(|loss| loss.stage == stage).map(|loss| loss.total)
    }

    /// Writes `loss.csv`: `stage,step,loss,term,...`.
    pub(crate) fn write_table(&self, folder: &Path) -> Result<PathBuf, TrainError> {
        let all: Vec<&str> =
            [Stage::Trunk, Stage::Autoencoder].into_iter().flat_map(terms).copied().collect();
        let mut table = format!("stage,step,loss,{}\n", all.join(","));
        for loss in &self.0 {
            table += &format!("{},{},{}", loss.stage, loss.step, loss.total);
            for name in &all {
                let place = terms(loss.stage).iter().position(|term| term == name);
                table += &place.map_or(",".into(), |place| format!(",{}", loss.terms[place]));
            }
            table.push('\n');
        }
        let path = folder.join(CURVE_TABLE);
        files::write(&path, table.as_bytes())?;
        Ok(path)
    }

    /// Writes `loss.svg`: one panel a stage.
    pub(crate) fn write_picture(&self, folder: &Path) -> Result<(), TrainError> {
        let path = folder.join(CURVE_PICTURE);
        let mut svg = String::new();
        self.draw(&mut svg).map_err(|error| files::unwritable(&path, &error))?;
        files::write(&path, svg.as_bytes())
    }

    fn draw(&self, svg: &mut String) -> Result<(), Box<dyn std::error::Error>> {
        let root = SVGBackend::with_string(svg, (960, 400)).into_drawing_area();
        root.fill(&WHITE)?;
        let panels = root.split_evenly((1, 2));
        for (panel, stage) in panels.iter().zip([Stage::Trunk, Stage::Autoencoder]) {
            let losses: Vec<_> = self.0.iter().filter(|loss| loss.stage == stage).copied().collect();
            draw_stage(panel, stage, &losses)?;
        }
        root.present()?;
        Ok(())
    }
}

fn draw_stage(
    panel: &DrawingArea<SVGBackend, Shift>,
    stage: Stage,
    losses: &[Loss],
) -> Result<(), Box<dyn std::error::Error>> {
    let (low, high) = losses.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), loss| {
        (low.min(loss.total), high.max(loss.total))
    });
    if losses.is_empty() {
        return Ok(());
    }
    let margin = 0.05 * (high - low).max(1e-9);
    let mut chart = ChartBuilder::on(panel)
        .caption(format!("loss of the {stage}"), ("sans-serif", 16))
        .margin(12)
        .x_label_area_size(32)
        .y_label_area_size(56)
        .build_cartesian_2d(0.0..losses.len() as f64, low - margin..high + margin)?;
    chart.configure_mesh().x_desc("step").x_labels(5).y_labels(6).light_line_style(WHITE).draw()?;
    let point = |loss: &Loss| (loss.step as f64, loss.total);
    chart.draw_series(LineSeries::new(losses.iter().map(point), RGBColor(190, 205, 225).stroke_width(1)))?;
    chart.draw_series(LineSeries::new(smoothed(losses), RGBColor(30, 80, 160).stroke_width(2)))?;
    Ok(())
}

/// Means over windows of a fortieth of the curve.
fn smoothed(losses: &[Loss]) -> Vec<(f64, f64)> {
    let window = (losses.len() / 40).max(1);
    let mean = |window: &[Loss]| {
        let count = window.len() as f64;
        let step = window.iter().map(|loss| loss.step as f64).sum::<f64>() / count;
        (step, window.iter().map(|loss| loss.total).sum::<f64>() / count)
    };
    losses.chunks(window).map(mean).collect()
}

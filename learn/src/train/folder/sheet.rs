//! The reconstruction sheet: what the model makes of instances it has not seen, to be looked at.

use super::predictions::Predictions;
use crate::train::data::components::Components;
use crate::train::data::views::Views;
use crate::train::error::TrainError;
use crate::train::run::files;
use image::{ImageFormat, RgbImage, imageops};
use nalgebra::DVector;
use std::io::Cursor;
use std::path::Path;
use vantage_dataset::Crop;
use vantage_dataset::crop::{CROP_BYTES, CROP_SIDE};

/// The sheet's file.
pub const SHEET: &str = "reconstructions.png";

const ROWS: usize = 12;
/// Views predicted in each row, beside the one encoded.
const OTHERS: usize = 4;
const GAP: u32 = 2;
const SCALE: u32 = 2;

/// Draws, for each of some instances: a view and its reconstruction, then other views, each above what is
/// expected from the first view alone and from several.
pub(crate) fn write(
    folder: &Path,
    predictions: &Predictions,
    views: &Views,
    components: &Components,
    context: usize,
) -> Result<(), TrainError> {
    let chosen: Vec<_> = views
        .groups
        .iter()
        .map(|group| &group.views)
        .filter(|views| views.len() > OTHERS)
        .take(ROWS)
        .collect();
    let tile = CROP_SIDE as u32 + GAP;
    let size = (tile * (1 + OTHERS as u32), (3 * tile + GAP) * chosen.len() as u32);
    let mut sheet = RgbImage::from_pixel(size.0.max(1), size.1.max(1), image::Rgb([255; 3]));
    for (row, of_instance) in chosen.iter().enumerate() {
        let shown = &of_instance[..=OTHERS];
        let several = &of_instance[OTHERS + 1..];
        let several = &several[..several.len().min(context)];
        let from = shown[0];
        let one = predictions.posterior(from, &shown[..1]).mean;
        let fused = if several.is_empty() { one.clone() } else { predictions.posterior(from, several).mean };
        let seen = |latent: &DVector<f64>| rebuilt(&predictions.decode(latent, from, shown).1, components);
        let originals: Vec<_> = shown.iter().map(|&view| views.set.views[view].crop.clone()).collect();
        for (line, crops) in [originals, seen(&one), seen(&fused)].iter().enumerate() {
            for (column, crop) in crops.iter().enumerate() {
                let y = row as u32 * (3 * tile + GAP) + line as u32 * tile;
                imageops::replace(&mut sheet, &picture(crop), i64::from(column as u32 * tile), i64::from(y));
            }
        }
    }
    let (width, height) = (sheet.width() * SCALE, sheet.height() * SCALE);
    let sheet = imageops::resize(&sheet, width, height, imageops::FilterType::Nearest);
    let path = folder.join(SHEET);
    let mut png = Cursor::new(Vec::new());
    sheet.write_to(&mut png, ImageFormat::Png).map_err(|error| files::unwritable(&path, &error))?;
    files::write(&path, png.get_ref())
}

/// Crops of coefficients `[crops, components]`.
fn rebuilt(coefficients: &[f32], components: &Components) -> Vec<Crop> {
    let layer = &components.layer;
    let crop = |row: &[f32]| {
        let mut planes = layer.bias.clone();
        for (weights, &coefficient) in layer.weight.chunks_exact(CROP_BYTES).zip(row) {
            planes.iter_mut().zip(weights).for_each(|(plane, weight)| *plane += coefficient * weight);
        }
        Crop::from_chw(&planes)
    };
    coefficients.chunks_exact(layer.inputs()).map(crop).collect()
}

fn picture(crop: &Crop) -> RgbImage {
    let side = CROP_SIDE as u32;
    RgbImage::from_fn(side, side, |x, y| {
        let start = (y as usize * CROP_SIDE + x as usize) * 3;
        image::Rgb([crop.0[start], crop.0[start + 1], crop.0[start + 2]])
    })
}

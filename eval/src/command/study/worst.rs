//! The azimuths that were told worst, beside what they were taken for.

use crate::figure::FigureError;
use crate::figure::crop_table::{Block, crop_table_png};
use crate::score::known_views::{KnownViewTrial, asked};
use vantage_dataset::{Crop, ViewSet};

/// The sheet's file.
pub const WORST: &str = "worst_azimuths.png";
/// Objects on it.
const OBJECTS: usize = 12;

/// The worst query of each of the worst objects: the crop that was asked, the known view nearest to the azimuth that was told, and that nearest
/// to the true one. `trials` are those of `set`, of `known` known views; `None` where no azimuth was told.
pub fn worst_png(
    set: &ViewSet,
    known: usize,
    trials: &[KnownViewTrial],
) -> Result<Option<Vec<u8>>, FigureError> {
    let mut worst: Vec<Option<(f64, String, Vec<Crop>)>> = vec![None; set.instances.len()];
    for (query, trial) in asked(set, known).iter().zip(trials) {
        let (Some(error), Some(told)) = (trial.viewpoint.error(), trial.viewpoint.found) else { continue };
        let crops = [Some(query.view), query.nearest(told), query.nearest(trial.viewpoint.azimuth)];
        let crops: Vec<Crop> = crops.into_iter().flatten().map(|view| view.crop.clone()).collect();
        let of_object = &mut worst[query.view.instance];
        if of_object.as_ref().is_none_or(|(before, ..)| error > *before) {
            *of_object = Some((error, trial.viewpoint.family.clone(), crops));
        }
    }
    let mut worst: Vec<_> = worst.into_iter().flatten().collect();
    worst.sort_by(|a, b| b.0.total_cmp(&a.0));
    worst.truncate(OBJECTS);
    if worst.is_empty() {
        return Ok(None);
    }
    let row = |(error, family, crops): (f64, String, Vec<Crop>)| {
        let family: String = family.chars().take(14).collect();
        (format!("{family} {:.0}", error.to_degrees()), crops)
    };
    let block = Block {
        name: "errors, degrees".to_owned(),
        captions: ["asked", "taken\nfor", "nearest\nknown"].map(str::to_owned).to_vec(),
        rows: worst.into_iter().map(row).collect(),
    };
    crop_table_png(&[block]).map(Some)
}

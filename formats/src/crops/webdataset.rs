//! Crops as WebDataset: `<key>.masked.png`, `<key>.boxed.png` and `<key>.json` of each, one after another.

use super::row::Row;
use crate::shard::TarShard;
use serde::Serialize;
use std::io;
use vantage_dataset::store::pose_fields;
use vantage_dataset::{Camera, Sample, Split, Viewpoint};

/// `<key>.json`.
#[derive(Serialize)]
struct Labels<'a> {
    /// As text: many readers keep integers in 63 bits.
    episode: String,
    step: usize,
    /// Seconds.
    timestamp: f64,
    track: usize,
    instance: String,
    family: &'a str,
    split: Split,
    /// Left, top, right, bottom, pixels.
    bounding_box: [f64; 4],
    visible_fraction: f64,
    /// `width`, `height`, `fx`, `fy`, `cx`, `cy`, pixels; pixel centres at +0.5.
    camera: Camera,
    /// `tx, ty, tz, qx, qy, qz, qw`.
    world_from_camera: [f64; 7],
    object_from_camera: [f64; 7],
    viewpoint: Option<ViewpointLabels>,
}

#[derive(Serialize)]
struct ViewpointLabels {
    direction: [f64; 3],
    roll: f64,
    log_distance: f64,
}

/// Adds a sample.
pub(super) fn add(tar: &mut TarShard, row: &Row) -> io::Result<()> {
    let Row { key, masked, boxed, sample } = row;
    tar.add(&format!("{key}.masked.png"), masked)?;
    tar.add(&format!("{key}.boxed.png"), boxed)?;
    tar.add(&format!("{key}.json"), &serde_json::to_vec(&labels(sample))?)
}

fn labels(sample: &Sample) -> Labels<'_> {
    let (min, max) = (sample.bounding_box.min, sample.bounding_box.max);
    let viewpoint = sample.viewpoint.map(|Viewpoint { direction, roll, log_distance }| ViewpointLabels {
        direction: direction.into(),
        roll,
        log_distance,
    });
    Labels {
        episode: sample.episode.to_string(),
        step: sample.step,
        timestamp: sample.timestamp,
        track: sample.track,
        instance: sample.instance.to_string(),
        family: &sample.family,
        split: sample.split,
        bounding_box: [min.x, min.y, max.x, max.y],
        visible_fraction: sample.visible_fraction,
        camera: sample.camera,
        world_from_camera: pose_fields(&sample.world_from_camera),
        object_from_camera: pose_fields(&sample.object_from_camera),
        viewpoint,
    }
}

//! An archive of images in BOP's WebDataset: every image with annotations of its own, masks as run lengths.

use super::annotation::Annotation;
use crate::image_file::{CompressionType, Pixels, jpeg, png};
use crate::rle::Rle;
use crate::shard::TarShard;
use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use vantage_dataset::Capture;

/// The archive under way.
#[derive(Debug)]
pub(super) struct ImageShard(TarShard);

impl ImageShard {
    pub(super) fn create(path: &Path) -> io::Result<Self> {
        TarShard::create(path).map(Self)
    }

    pub(super) fn add(
        &mut self,
        scene: u32,
        image: u32,
        capture: &Capture,
        annotation: &Annotation<'_>,
    ) -> io::Result<()> {
        let (width, height) = (capture.camera.width, capture.camera.height);
        let ((rgb, depth), (masks, visible)) = rayon::join(
            || {
                (
                    jpeg(&capture.rgb, width, height),
                    png(&Pixels::Deep(&annotation.depth), width, height, CompressionType::Default),
                )
            },
            || {
                let visible = annotation.visible_masks.iter().map(Vec::as_slice);
                (runs(annotation.masks.iter().copied(), width), runs(visible, width))
            },
        );
        let members = [
            ("rgb.jpg", rgb?),
            ("depth.png", depth?),
            ("camera.json", serde_json::to_vec(&annotation.camera)?),
            ("gt.json", serde_json::to_vec(&annotation.poses)?),
            ("gt_info.json", serde_json::to_vec(&annotation.infos)?),
            ("mask.json", serde_json::to_vec(&masks)?),
            ("mask_visib.json", serde_json::to_vec(&visible)?),
        ];
        members
            .iter()
            .try_for_each(|(part, bytes)| self.0.add(&format!("{scene:06}_{image:06}.{part}"), bytes))
    }

    pub(super) fn close(self) -> io::Result<()> {
        self.0.close()
    }
}

/// By the index of the object in `gt.json`.
fn runs<'a>(masks: impl Iterator<Item = &'a [bool]>, width: u32) -> BTreeMap<usize, Rle> {
    masks.map(|mask| Rle::encode(mask, width as usize)).enumerate().collect()
}

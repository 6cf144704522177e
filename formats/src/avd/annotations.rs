//! `annotations.json`: the boxes in each image, and where each movement leads.

use super::movement::Movement;
use crate::import::{FETCH_AGAIN, ImportError, read_file};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use vantage_dataset::store::StoreError;

const FILE: &str = "annotations.json";
const LARGEST: u64 = 256 << 20;

/// Width of the dataset's images, pixels.
const PUBLISHED_WIDTH: f64 = 1920.0;
/// Sides of a box, pixels of these images, that both must exceed for a difficulty of 1, 2, 3, 4: the longer and the shorter.
const DIFFICULTIES: [(f64, f64); 4] = [(300.0, 100.0), (200.0, 75.0), (100.0, 50.0), (50.0, 30.0)];

/// What is known of one image, by its file name.
pub(super) type Annotations = BTreeMap<String, Annotation>;

/// What is known of one image.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Annotation {
    pub(super) bounding_boxes: Vec<LabelledBox>,
    rotate_ccw: String,
    rotate_cw: String,
    forward: String,
    backward: String,
    left: String,
    right: String,
}

/// `xmin, ymin, xmax, ymax` in pixels, instance, difficulty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LabelledBox(
    pub(super) f64,
    pub(super) f64,
    pub(super) f64,
    pub(super) f64,
    pub(super) u32,
    pub(super) u8,
);

impl Annotation {
    /// The image that a movement leads to.
    pub(super) fn target(&self, movement: Movement) -> Option<&str> {
        let name = match movement {
            Movement::Forward => &self.forward,
            Movement::Backward => &self.backward,
            Movement::Left => &self.left,
            Movement::Right => &self.right,
            Movement::RotateCcw => &self.rotate_ccw,
            Movement::RotateCw => &self.rotate_cw,
        };
        (!name.is_empty()).then_some(name)
    }
}

pub(super) fn read(scan: &Path) -> Result<Annotations, ImportError> {
    let path = scan.join(FILE);
    let bytes = read_file(&path, LARGEST).map_err(|error| match error {
        error if error.is_absence() => {
            let expected = "the folder of one scan, such as Home_001_1";
            ImportError::invalid(
                scan,
                "folder",
                format!("no {FILE} in it"),
                expected,
                "name a folder of a scan",
            )
        }
        error => error,
    })?;
    serde_json::from_slice(&bytes).map_err(|error| {
        let field = format!("line {}", error.line());
        let expected = "images by name, with boxes of 6 numbers and 6 movements";
        ImportError::invalid(&path, field, error, expected, FETCH_AGAIN)
    })
}

/// What is written of one image; boxes have whole pixels.
#[derive(Debug, Serialize)]
pub(super) struct Written {
    pub(super) bounding_boxes: Vec<[u32; 6]>,
    pub(super) rotate_ccw: String,
    pub(super) rotate_cw: String,
    pub(super) forward: String,
    pub(super) backward: String,
    pub(super) left: String,
    pub(super) right: String,
}

pub(super) fn write(scan: &Path, annotations: &BTreeMap<String, Written>) -> Result<(), StoreError> {
    let path = scan.join(FILE);
    serde_json::to_vec(annotations)
        .map_err(std::io::Error::from)
        .and_then(|bytes| std::fs::write(&path, bytes))
        .map_err(StoreError::write(&path))
}

/// The difficulty of a box, in an image of some width, by the dataset's rule: 1 is easy, 5 hard. What counts is the share of the image.
pub(super) fn difficulty(width: f64, height: f64, image_width: u32) -> u8 {
    let [width, height] = [width, height].map(|side| side * PUBLISHED_WIDTH / f64::from(image_width));
    let (longer, shorter) = (width.max(height), width.min(height));
    let rank = DIFFICULTIES.iter().position(|(long, short)| longer > *long && shorter > *short);
    rank.map_or(5, |rank| rank as u8 + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn difficulties_are_those_of_the_published_examples() {
        assert_eq!(difficulty(301.0, 101.0, 1920), 1);
        assert_eq!(difficulty(300.0, 100.0, 1920), 2);
        assert_eq!(difficulty(80.0, 250.0, 1920), 2);
        assert_eq!(difficulty(250.0, 60.0, 1920), 3);
        assert_eq!(difficulty(51.0, 31.0, 1920), 4);
        assert_eq!(difficulty(50.0, 30.0, 1920), 5);
        assert_eq!(difficulty(101.0, 34.0, 640), 1, "a third of the width, a third of the sides");
    }
}

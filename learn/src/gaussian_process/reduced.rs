//! The reduced measurement `m(z)` of pixels alone: low frequencies of grey, of red against blue, and of the silhouette.

use nalgebra::DVector;
use std::f64::consts::PI;
use vantage_dataset::Crop;
use vantage_dataset::crop::CROP_SIDE;

/// M.
pub const COMPONENTS: usize = 16;

const PIXELS: usize = CROP_SIDE * CROP_SIDE;
const GREY: [(usize, usize); 8] = [(1, 0), (2, 0), (3, 0), (0, 1), (1, 1), (2, 1), (0, 2), (1, 2)];
const RED_AGAINST_BLUE: [(usize, usize); 4] = [(1, 0), (2, 0), (0, 1), (1, 1)];
const SILHOUETTE: [(usize, usize); 4] = [(1, 0), (2, 0), (3, 0), (1, 1)];

/// Discrete cosine transform, horizontal and vertical frequency first, of the object's pixels, each channel normalised to mean 0
/// and deviation 1 over them, so that the light's strength and tint do not matter; `None` where all is black or of one colour.
pub fn measurement(crop: &Crop) -> Option<DVector<f64>> {
    let pixels = crop.0.as_chunks::<3>().0;
    let inside = |rgb: &[u8; 3]| rgb.iter().any(|&value| value > 0);
    let count = pixels.iter().filter(|rgb| inside(rgb)).count() as f64;
    if count == 0.0 {
        return None;
    }
    let channel = |c: usize| -> Vec<f64> {
        let of_object = || pixels.iter().filter(|rgb| inside(rgb)).map(|rgb| f64::from(rgb[c]));
        let mean = of_object().sum::<f64>() / count;
        let deviation = (of_object().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt();
        let normal = |rgb: &[u8; 3]| if inside(rgb) { (f64::from(rgb[c]) - mean) / deviation } else { 0.0 };
        pixels.iter().map(normal).collect()
    };
    let [red, green, blue] = [0, 1, 2].map(channel);
    let grey = |i: usize| (red[i] + green[i] + blue[i]) / 3.0;
    let against = |i: usize| red[i] - blue[i];
    let silhouette = |i: usize| f64::from(u8::from(inside(&pixels[i])));
    let numbers = GREY
        .iter()
        .map(|&at| coefficient(grey, at))
        .chain(RED_AGAINST_BLUE.iter().map(|&at| coefficient(against, at)))
        .chain(SILHOUETTE.iter().map(|&at| coefficient(silhouette, at)));
    let measured = DVector::from_iterator(COMPONENTS, numbers);
    measured.iter().all(|x| x.is_finite()).then_some(measured)
}

/// Mean over the pixels of the plane times the cosines of these frequencies.
fn coefficient(plane: impl Fn(usize) -> f64, (across, down): (usize, usize)) -> f64 {
    let table = |frequency: usize| -> [f64; CROP_SIDE] {
        std::array::from_fn(|i| libm::cos(PI * frequency as f64 * (i as f64 + 0.5) / CROP_SIDE as f64))
    };
    let (columns, rows) = (table(across), table(down));
    let sum: f64 = (0..PIXELS).map(|i| plane(i) * columns[i % CROP_SIDE] * rows[i / CROP_SIDE]).sum();
    sum / PIXELS as f64
}

//! How crops are cut: the square around a detection, area-filtered to 32x32.

use crate::crop::{CROP_BYTES, CROP_SIDE, Crop};
use crate::episode::BoundingBox;

/// Side of a crop's window over the longer side of the visible box.
pub const MARGIN: f64 = 1.1;

/// A rendered image with its ids; row-major, `width * height` pixels.
#[derive(Clone, Copy, Debug)]
pub struct Labelled<'a> {
    /// Width, pixels.
    pub width: usize,
    /// sRGB, 3 bytes a pixel.
    pub rgb: &'a [u8],
    /// Id of each pixel.
    pub ids: &'a [u32],
}

/// The square window of a crop, pixels: its upper left corner and its side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Upper left corner; may lie outside the image.
    pub corner: [f64; 2],
    /// Side.
    pub side: f64,
}

impl Window {
    /// The window centred on a visible box.
    pub fn around(visible: &BoundingBox) -> Self {
        let side = MARGIN * visible.side();
        let center = visible.center();
        Self { corner: [center.x - side / 2.0, center.y - side / 2.0], side }
    }
}

/// Cuts a crop: each of its pixels is the mean over its share of the window, with fractional coverage at the
/// edges. Pixels that are not `only` (where given) or lie outside the image are black.
pub fn cut(image: &Labelled<'_>, window: &Window, only: Option<u32>) -> Crop {
    let height = image.ids.len() / image.width;
    let columns = coverage(window.corner[0], window.side, image.width);
    let rows = coverage(window.corner[1], window.side, height);

    let first_row = rows.iter().map(|span| span.first).min().unwrap_or(0);
    let last_row = rows.iter().map(|span| span.first + span.weights.len()).max().unwrap_or(0);
    let narrowed: Vec<[[f32; 3]; CROP_SIDE]> = (first_row..last_row)
        .map(|row| std::array::from_fn(|column| narrow(image, row, &columns[column], only)))
        .collect();

    let mut bytes = Box::new([0; CROP_BYTES]);
    for (row, span) in rows.iter().enumerate() {
        for column in 0..CROP_SIDE {
            let mut sum = [0.0_f32; 3];
            for (offset, weight) in span.weights.iter().enumerate() {
                let pixel = narrowed[span.first - first_row + offset][column];
                for channel in 0..3 {
                    sum[channel] += weight * pixel[channel];
                }
            }
            for channel in 0..3 {
                bytes[(row * CROP_SIDE + column) * 3 + channel] = (sum[channel] + 0.5) as u8;
            }
        }
    }
    Crop(bytes)
}

/// Input pixels that one output pixel covers along one axis, and each one's share of it.
struct Span {
    first: usize,
    weights: Vec<f32>,
}

fn coverage(corner: f64, side: f64, pixels: usize) -> Vec<Span> {
    let step = side / CROP_SIDE as f64;
    (0..CROP_SIDE)
        .map(|i| {
            let low = (corner + i as f64 * step).clamp(0.0, pixels as f64);
            let high = (corner + (i + 1) as f64 * step).clamp(0.0, pixels as f64);
            let (first, end) = (low.floor() as usize, high.ceil() as usize);
            let weights = (first..end)
                .map(|pixel| ((high.min((pixel + 1) as f64) - low.max(pixel as f64)) / step) as f32)
                .collect();
            Span { first, weights }
        })
        .collect()
}

fn narrow(image: &Labelled<'_>, row: usize, span: &Span, only: Option<u32>) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for (offset, weight) in span.weights.iter().enumerate() {
        let pixel = row * image.width + span.first + offset;
        if only.is_none_or(|id| image.ids[pixel] == id) {
            for (channel, value) in sum.iter_mut().enumerate() {
                *value += weight * f32::from(image.rgb[pixel * 3 + channel]);
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    fn window(x: f64, y: f64, side: f64) -> Window {
        Window { corner: [x, y], side }
    }

    /// 64x64; red grows with the column, green with the row, ids are 7 in the left half.
    fn gradient() -> (Vec<u8>, Vec<u32>) {
        let pixels = (0..64 * 64).map(|i| (i % 64, i / 64));
        let rgb = pixels.clone().flat_map(|(x, y)| [4 * x as u8, 4 * y as u8, 50]).collect();
        (rgb, pixels.map(|(x, _)| if x < 32 { 7 } else { 8 }).collect())
    }

    fn at(crop: &Crop, row: usize, column: usize) -> [u8; 3] {
        std::array::from_fn(|channel| crop.0[(row * CROP_SIDE + column) * 3 + channel])
    }

    #[test]
    fn a_window_is_the_visible_box_and_a_margin() {
        let visible = BoundingBox { min: Vector2::new(10.0, 20.0), max: Vector2::new(20.0, 60.0) };
        let window = Window::around(&visible);
        assert!((window.side - 44.0).abs() < 1e-12);
        assert!((window.corner[0] + 7.0).abs() < 1e-12 && (window.corner[1] - 18.0).abs() < 1e-12);
    }

    #[test]
    fn halving_averages_four_pixels() {
        let (rgb, ids) = gradient();
        let image = Labelled { width: 64, rgb: &rgb, ids: &ids };
        let crop = cut(&image, &window(0.0, 0.0, 64.0), None);
        assert_eq!(at(&crop, 5, 3), [26, 42, 50]);
    }

    #[test]
    fn shifting_by_a_fraction_of_a_pixel_blends_by_coverage() {
        let (rgb, ids) = gradient();
        let image = Labelled { width: 64, rgb: &rgb, ids: &ids };
        let crop = cut(&image, &window(10.25, 8.0, 32.0), None);
        assert_eq!(at(&crop, 0, 0), [41, 32, 50]);
    }

    #[test]
    fn other_ids_and_the_outside_are_black() {
        let (rgb, ids) = gradient();
        let image = Labelled { width: 64, rgb: &rgb, ids: &ids };
        let crop = cut(&image, &window(16.0, 40.0, 32.0), Some(7));
        assert_eq!(at(&crop, 3, 15), [124, 172, 50]);
        assert_eq!(at(&crop, 3, 16), [0, 0, 0]);
        assert_eq!(at(&crop, 24, 3), [0, 0, 0]);
        let outside = cut(&image, &window(200.0, -90.0, 32.0), None);
        assert_eq!(outside, Crop::black());
    }

    #[test]
    fn a_tiny_window_enlarges() {
        let (rgb, ids) = gradient();
        let image = Labelled { width: 64, rgb: &rgb, ids: &ids };
        let crop = cut(&image, &window(20.0, 30.0, 2.0), None);
        assert_eq!(at(&crop, 0, 0), [80, 120, 50]);
        assert_eq!(at(&crop, 31, 31), [84, 124, 50]);
    }
}

//! What a camera does to an image: exposure, blur, noise.

use crate::scene::ImageSpec;
use vantage_dataset::{Seed, Stream};

/// Kernels reach so many standard deviations to each side.
const REACH: f64 = 3.0;

/// Degrades an sRGB image of `width` pixels a row, in place; `scale` is how many pixels of the camera one pixel of the
/// image covers along each side.
///
/// Streams: `exposure` and `image noise`, by `index`.
pub fn degrade(spec: &ImageSpec, rgb: &mut [u8], width: usize, scale: f64, seed: Seed, index: u64) {
    if spec.exposure_stops > 0.0 {
        let stops = spec.exposure_stops * seed.stream("exposure", index).normal();
        let table = exposed(libm::exp2(stops));
        rgb.iter_mut().for_each(|value| *value = table[usize::from(*value)]);
    }
    let sigma = spec.blur_pixels / scale;
    if sigma > 0.05 {
        blur(rgb, width, sigma);
    }
    if spec.noise_levels > 0.0 {
        let mut stream = seed.stream("image noise", index);
        let sigma = spec.noise_levels / scale;
        for value in rgb {
            *value = noisy(*value, sigma, &mut stream);
        }
    }
}

fn noisy(value: u8, sigma: f64, stream: &mut Stream) -> u8 {
    (f64::from(value) + sigma * stream.normal()).round().clamp(0.0, 255.0) as u8
}

/// What each sRGB value becomes under `gain` times the light (IEC 61966-2-1).
fn exposed(gain: f64) -> [u8; 256] {
    std::array::from_fn(|value| {
        let encoded = value as f64 / 255.0;
        let linear =
            if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) };
        let light = (gain * linear).min(1.0);
        let encoded =
            if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * libm::pow(light, 1.0 / 2.4) - 0.055 };
        (255.0 * encoded).round() as u8
    })
}

/// Gaussian blur along rows, then along columns; the border is repeated.
fn blur(rgb: &mut [u8], width: usize, sigma: f64) {
    let reach = (REACH * sigma).ceil() as i64;
    let weights: Vec<f64> =
        (-reach..=reach).map(|i| libm::exp(-0.5 * (i as f64 / sigma) * (i as f64 / sigma))).collect();
    let total: f64 = weights.iter().sum();
    let weights: Vec<f32> = weights.iter().map(|w| (w / total) as f32).collect();
    let height = rgb.len() / (3 * width);
    let across: Vec<f32> = rgb.iter().map(|&value| f32::from(value)).collect();
    let along = filtered(&across, &weights, [width, 3], [height, 3 * width]);
    let both = filtered(&along, &weights, [height, 3 * width], [width, 3]);
    for (value, blurred) in rgb.iter_mut().zip(both) {
        *value = (blurred + 0.5) as u8;
    }
}

/// Filters along an axis of `[count, stride]`, for every place of the other.
fn filtered(values: &[f32], weights: &[f32], axis: [usize; 2], other: [usize; 2]) -> Vec<f32> {
    let mut out = vec![0.0; values.len()];
    let reach = weights.len() / 2;
    for line in 0..other[0] {
        for at in 0..axis[0] {
            for channel in 0..3 {
                let place = |i: usize| line * other[1] + i * axis[1] + channel;
                out[place(at)] = weights
                    .iter()
                    .enumerate()
                    .map(|(k, w)| w * values[place((at + k).saturating_sub(reach).min(axis[0] - 1))])
                    .sum();
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 40;

    fn step() -> Vec<u8> {
        (0..WIDTH * 30).flat_map(|i| if i % WIDTH < WIDTH / 2 { [40; 3] } else { [200; 3] }).collect()
    }

    fn degraded(spec: &ImageSpec, index: u64) -> Vec<u8> {
        let mut rgb = step();
        degrade(spec, &mut rgb, WIDTH, 1.0, Seed(2), index);
        rgb
    }

    #[test]
    fn a_perfect_camera_changes_nothing() {
        let perfect = ImageSpec { exposure_stops: 0.0, blur_pixels: 0.0, noise_levels: 0.0 };
        assert_eq!(degraded(&perfect, 0), step());
    }

    #[test]
    fn noise_has_the_spread_that_was_asked_for_and_differs_between_images() {
        let spec = ImageSpec { exposure_stops: 0.0, blur_pixels: 0.0, noise_levels: 4.0 };
        let errors: Vec<f64> =
            degraded(&spec, 1).iter().zip(step()).map(|(a, b)| f64::from(*a) - f64::from(b)).collect();
        let variance = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
        assert!((variance.sqrt() - 4.0).abs() < 0.2, "{}", variance.sqrt());
        assert_ne!(degraded(&spec, 1), degraded(&spec, 2));
        assert_eq!(degraded(&spec, 1), degraded(&spec, 1));
    }

    #[test]
    fn blur_spreads_an_edge_over_its_width_and_keeps_the_rest() {
        let spec = ImageSpec { exposure_stops: 0.0, blur_pixels: 1.5, noise_levels: 0.0 };
        let blurred = degraded(&spec, 0);
        let at = |column: usize| blurred[(10 * WIDTH + column) * 3];
        assert_eq!((at(5), at(35)), (40, 200));
        // The Gaussian's cumulative share one and a half standard deviations beyond the edge is 0.933.
        assert!((f64::from(at(21)) - (40.0 + 160.0 * 0.84)).abs() < 6.0, "{}", at(21));
        assert!((i32::from(at(19)) + i32::from(at(20)) - 240).abs() <= 1);
    }

    #[test]
    fn exposure_scales_light_and_saturates() {
        assert_eq!(exposed(1.0), std::array::from_fn(|i| i as u8));
        assert_eq!(exposed(0.5)[188], 137);
        assert_eq!(exposed(8.0)[200], 255);
    }
}

//! Peak signal-to-noise ratio of predicted crops, decibels.

use vantage_dataset::Crop;
use vantage_dataset::crop::CROP_BYTES;

/// Mean squared error of an image that is right but for being rounded to 8 bits, grey levels squared: no prediction can be
/// told to be better. A perfect one so has 58.9 dB.
const ROUNDING: f64 = 1.0 / 12.0;

/// `10 log10(255^2 / mean squared error)` over all pixels and channels of a crop.
pub fn psnr(truth: &Crop, predicted: &Crop) -> f64 {
    let squares: u64 =
        truth.0.iter().zip(predicted.0.iter()).map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2)).sum();
    let mean = squares as f64 / CROP_BYTES as f64;
    10.0 * libm::log10(255.0 * 255.0 / mean.max(ROUNDING))
}

/// The crop whose every number is the mean over the given ones; `None` for none.
pub fn mean_crop<'a>(crops: impl IntoIterator<Item = &'a Crop>) -> Option<Crop> {
    let mut sums = vec![0u64; CROP_BYTES];
    let mut n = 0u64;
    for crop in crops {
        n += 1;
        sums.iter_mut().zip(crop.0.iter()).for_each(|(sum, &value)| *sum += u64::from(value));
    }
    let mut mean = Crop::black();
    for (value, sum) in mean.0.iter_mut().zip(&sums) {
        *value = u8::try_from((2 * sum).checked_add(n)?.checked_div(2 * n)?).ok()?;
    }
    Some(mean)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use vantage_dataset::Seed;

    fn grey(value: u8) -> Crop {
        Crop(Box::new([value; CROP_BYTES]))
    }

    #[test]
    fn known_errors_have_known_ratios() {
        assert_relative_eq!(psnr(&grey(10), &grey(35)), 20.172_003_4, epsilon = 1e-6);
        assert_eq!(psnr(&grey(0), &grey(255)), 0.0);
        let mut noise = Crop::black();
        let mut stream = Seed(1).stream("noise", 0);
        noise.0.iter_mut().for_each(|value| *value = stream.below(256) as u8);
        // Uniform noise against mid-grey: 255^2 / 12 per number.
        assert_relative_eq!(psnr(&grey(128), &noise), 10.0 * 12f64.log10(), epsilon = 0.1);
    }

    #[test]
    fn truth_is_best_and_as_good_as_8_bits_can_tell() {
        assert_relative_eq!(psnr(&grey(7), &grey(7)), 58.922_6, epsilon = 1e-4);
        assert!(psnr(&grey(7), &grey(7)) > psnr(&grey(7), &grey(8)));
    }

    #[test]
    fn a_mean_is_rounded_to_the_nearest() {
        assert_eq!(mean_crop(&[grey(1), grey(2), grey(2)]), Some(grey(2)));
        assert_eq!(mean_crop(&[grey(255), grey(255)]), Some(grey(255)));
        assert_eq!(mean_crop(&[]), None);
    }
}

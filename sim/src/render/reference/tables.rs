//! Light on sRGB-encoded colours.

use std::sync::LazyLock;

/// The offset of the sRGB curve, levels.
pub(super) const TOE: f32 = 0.055 * 255.0;

/// Irradiances of one binary order that are told apart, as a power of two.
const FRACTION_BITS: u32 = 8;
/// Least irradiance that is not taken for darkness, 2^-12, and the binary orders from there on.
const DARKEST: u32 = 127 - 12;
const ORDERS: usize = 16;
const GAINS: usize = ORDERS << FRACTION_BITS;

/// Curves that a platform's mathematics would round differently elsewhere.
#[derive(Debug)]
pub(super) struct Tables {
    gains: [f32; GAINS],
}

/// The tables.
pub(super) static TABLES: LazyLock<Tables> = LazyLock::new(|| {
    let middle = |i: usize| f32::from_bits((bits(i) + bits(i + 1)) / 2);
    let gain = |i: usize| libm::pow(f64::from(middle(i)), 1.0 / 2.4) as f32;
    Tables { gains: std::array::from_fn(|i| if i == 0 { 0.0 } else { gain(i) }) }
});

/// Of the least irradiance of an entry.
fn bits(entry: usize) -> u32 {
    (DARKEST << 23) + ((entry as u32) << (23 - FRACTION_BITS))
}

impl Tables {
    /// `irradiance^(1 / 2.4)`, by which light scales what lies on the curve of sRGB: IEC 61966-2-1 decodes the level `a` to
    /// `((a + TOE) / (255 + TOE))^2.4` and encodes likewise, so that under an irradiance `e` it becomes
    /// `(a + TOE) e^(1 / 2.4) - TOE`. Near black, where sRGB is a line, it becomes `a e`. Of the two the greater is right in dim
    /// light, below 1, and the lesser in bright light, but for where one of the two colours is on the line and the other is not: a level
    /// off at most under irradiances of 0.2 to 3, and three under others.
    #[inline(always)]
    pub fn gain(&self, irradiance: f32) -> f32 {
        let entry = (irradiance.to_bits() as i32).wrapping_sub(bits(0) as i32) >> (23 - FRACTION_BITS);
        self.gains[entry.clamp(0, GAINS as i32 - 1) as usize % GAINS]
    }
}

/// The nearest integer of a number below 2^21 in size, and any integer for others: faster than a cast, which saturates.
#[inline(always)]
pub(super) fn round_small(x: f32) -> i32 {
    // A sum of this size keeps no fraction: its low bits are the integer.
    const SHIFT: f32 = 12_582_912.0;
    ((x + SHIFT).to_bits() as i32).wrapping_sub(SHIFT.to_bits() as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decode(encoded: f64) -> f64 {
        if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
    }

    fn encode(linear: f64) -> f64 {
        if linear <= 0.0031308 { linear * 12.92 } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 }
    }

    #[test]
    fn light_is_within_a_level_of_srgb_and_within_three_near_darkness_and_glare() {
        for step in 0..=400_u16 {
            let irradiance = f32::from(step) / 100.0;
            for level in 0..=255_u8 {
                let level = f32::from(level);
                let (curve, line) = ((level + TOE) * TABLES.gain(irradiance) - TOE, level * irradiance);
                let got = if irradiance > 1.0 { curve.min(line) } else { curve.max(line) };
                let expected = 255.0 * encode(decode(f64::from(level) / 255.0) * f64::from(irradiance));
                let off = (f64::from(got).min(255.0) - expected.min(255.0)).abs();
                let most = if (20..=300).contains(&step) { 1.0 } else { 3.0 };
                assert!(off < most, "level {level} under {irradiance}: {got}, expected {expected}");
            }
        }
    }

    #[test]
    fn small_numbers_round_to_the_nearest_integer() {
        for (x, rounded) in [(0.0, 0), (0.6, 1), (-0.6, -1), (4094.7, 4095), (-2_000_000.0, -2_000_000)] {
            assert_eq!(round_small(x), rounded);
        }
    }
}

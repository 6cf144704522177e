//! Transfer curves as tables.

use std::sync::LazyLock;

/// Steps of an 8-bit level that are decoded apart.
pub(super) const LEVEL_STEPS: usize = 4;

const ENCODED: usize = 4096;

/// Curves that a platform's mathematics would round differently elsewhere.
#[derive(Debug)]
pub(super) struct Tables {
    /// Linear light of sRGB, in [`LEVEL_STEPS`] of a level; the end is never read.
    linear: [f32; 256 * LEVEL_STEPS],
    /// sRGB level of linear light.
    encoded: [u8; ENCODED],
    /// `256 log2(1 + (i + 1/2) / 256)`.
    log2: [u16; 256],
}

/// The tables.
pub(super) static TABLES: LazyLock<Tables> = LazyLock::new(|| Tables {
    linear: std::array::from_fn(|i| decode(i as f64 / (255 * LEVEL_STEPS) as f64) as f32),
    encoded: std::array::from_fn(|i| (encode(i as f64 / (ENCODED - 1) as f64) * 255.0 + 0.5) as u8),
    log2: std::array::from_fn(|i| (libm::log2(1.0 + (i as f64 + 0.5) / 256.0) * 256.0 + 0.5) as u16),
});

impl Tables {
    /// Linear light of an sRGB-encoded value in [`LEVEL_STEPS`] of a level.
    #[inline(always)]
    pub fn linear(&self, encoded: u32) -> f32 {
        self.linear[encoded as usize % (256 * LEVEL_STEPS)]
    }

    /// The index, for [`encoded`](Self::encoded), of linear light, clamped to `[0, 1]`.
    #[inline(always)]
    pub fn encoding(linear: f32) -> u32 {
        round_small((linear * (ENCODED - 1) as f32).clamp(0.0, (ENCODED - 1) as f32)) as u32
    }

    /// An sRGB level.
    #[inline(always)]
    pub fn encoded(&self, encoding: u32) -> u8 {
        self.encoded[encoding as usize % ENCODED]
    }

    /// `128 log2(x)` of a positive number.
    #[inline(always)]
    pub fn half_log2(&self, x: f32) -> i32 {
        let bits = x.to_bits();
        let exponent = ((bits >> 23) & 0xff) as i32 - 127;
        ((exponent << 8) + i32::from(self.log2[((bits >> 15) & 0xff) as usize])) >> 1
    }
}

/// The nearest integer of a number below 2^21 in size, and any integer for others: faster than a cast, which saturates.
#[inline(always)]
pub(super) fn round_small(x: f32) -> i32 {
    // A sum of this size keeps no fraction: its low bits are the integer.
    const SHIFT: f32 = 12_582_912.0;
    ((x + SHIFT).to_bits() as i32).wrapping_sub(SHIFT.to_bits() as i32)
}

/// IEC 61966-2-1.
fn decode(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

fn encode(linear: f64) -> f64 {
    if linear <= 0.0031308 { linear * 12.92 } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_survives_decoding_and_encoding() {
        for level in 0..=255_u8 {
            let linear = TABLES.linear(u32::from(level) * LEVEL_STEPS as u32);
            let back = TABLES.encoded(Tables::encoding(linear));
            assert!(back.abs_diff(level) <= 1, "{level} -> {linear} -> {back}");
        }
        assert_eq!(TABLES.encoded(Tables::encoding(7.0)), 255);
    }

    #[test]
    fn small_numbers_round_to_the_nearest_integer() {
        for (x, rounded) in [(0.0, 0), (0.6, 1), (-0.6, -1), (4094.7, 4095), (-2_000_000.0, -2_000_000)] {
            assert_eq!(round_small(x), rounded);
        }
    }

    #[test]
    fn logarithm_is_within_a_step() {
        for i in 0..1000 {
            let x = 0.001 + 0.37 * f64::from(i);
            let error = f64::from(TABLES.half_log2(x as f32)) - 128.0 * libm::log2(x);
            assert!(error.abs() < 1.5, "{x}: {error}");
        }
    }
}

//! The semantic measurement: the 32x32 RGB crop of a detection.

use crate::widest::widest;

/// Side of a crop in pixels.
pub const CROP_SIDE: usize = 32;
/// Bytes of a crop: 32 x 32 x 3.
pub const CROP_BYTES: usize = CROP_SIDE * CROP_SIDE * 3;

/// An sRGB crop, row-major, interleaved `[row][column][channel]`.
#[derive(Clone, PartialEq, Eq)]
pub struct Crop(pub Box<[u8; CROP_BYTES]>);

impl Crop {
    /// An all-black crop.
    pub fn black() -> Self {
        Self(Box::new([0; CROP_BYTES]))
    }

    /// The crop as `f32` in `[0, 1]`, `[3, 32, 32]` (channel, row, column).
    pub fn to_chw(&self) -> Vec<f32> {
        let mut planes = vec![0.0; CROP_BYTES];
        let (red, rest) = planes.split_at_mut(CROP_SIDE * CROP_SIDE);
        let (green, blue) = rest.split_at_mut(CROP_SIDE * CROP_SIDE);
        let pixels = self.0.as_chunks::<3>().0;
        widest(
            #[inline(always)]
            || {
                let outputs = red.iter_mut().zip(green.iter_mut()).zip(blue.iter_mut());
                for (((red, green), blue), rgb) in outputs.zip(pixels) {
                    [*red, *green, *blue] = rgb.map(
                        #[inline(always)]
                        |value| f32::from(value) / 255.0,
                    );
                }
            },
        );
        planes
    }

    /// The crop nearest to planes `[3, 32, 32]` (channel, row, column); what is beyond `[0, 1]` is cut off.
    ///
    /// # Panics
    ///
    /// Where there are not 3072 numbers.
    pub fn from_chw(planes: &[f32]) -> Self {
        assert_eq!(planes.len(), CROP_BYTES, "not the planes of a crop");
        let mut crop = Self::black();
        let (red, rest) = planes.split_at(CROP_SIDE * CROP_SIDE);
        let (green, blue) = rest.split_at(CROP_SIDE * CROP_SIDE);
        let pixels = crop.0.as_chunks_mut::<3>().0;
        widest(
            #[inline(always)]
            || {
                for (((pixel, red), green), blue) in pixels.iter_mut().zip(red).zip(green).zip(blue) {
                    *pixel = [*red, *green, *blue].map(
                        #[inline(always)]
                        |value| rounded(value.clamp(0.0, 1.0) * 255.0),
                    );
                }
            },
        );
        crop
    }
}

/// `number.round()` of a number from 0 to 255, without the call that this is on CPUs before SSE 4.1.
#[inline(always)]
fn rounded(number: f32) -> u8 {
    let whole = number as i32;
    (whole + i32::from(number - whole as f32 >= 0.5)) as u8
}

impl std::fmt::Debug for Crop {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Crop({})", blake3::hash(&*self.0).to_hex())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_that_of_the_standard_library() {
        for step in 0..=255 * 64 {
            let number = step as f32 / 64.0;
            for near in [number.next_down().max(0.0), number, number.next_up().min(255.0)] {
                assert_eq!(rounded(near), near.round() as u8, "{near}");
            }
        }
    }

    #[test]
    fn there_and_back_is_the_same_crop_and_what_is_out_of_range_is_cut_off() {
        let mut crop = Crop::black();
        crop.0.iter_mut().enumerate().for_each(|(index, byte)| *byte = (index * 7) as u8);
        let mut planes = crop.to_chw();
        assert_eq!(Crop::from_chw(&planes), crop);
        (planes[0], planes[CROP_SIDE * CROP_SIDE]) = (-0.5, 1.5);
        assert_eq!(Crop::from_chw(&planes).0[..3], [0, 255, crop.0[2]]);
    }
}

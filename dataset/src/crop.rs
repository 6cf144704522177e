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
}

impl std::fmt::Debug for Crop {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Crop({})", blake3::hash(&*self.0).to_hex())
    }
}

//! The semantic measurement: the 32x32 RGB crop of a detection.

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
        let pixels = CROP_SIDE * CROP_SIDE;
        let mut planes = vec![0.0; CROP_BYTES];
        for (pixel, rgb) in self.0.chunks_exact(3).enumerate() {
            for (channel, &value) in rgb.iter().enumerate() {
                planes[channel * pixels + pixel] = f32::from(value) / 255.0;
            }
        }
        planes
    }
}

impl std::fmt::Debug for Crop {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Crop({})", blake3::hash(&*self.0).to_hex())
    }
}

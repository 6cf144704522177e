//! Square, mipmapped textures.

use std::ops::RangeInclusive;

/// Side of the finest level of procedural textures, texels.
pub const TEXTURE_SIDE: usize = 128;

/// Sides that a finest level may have, texels; of these the powers of two.
pub const TEXTURE_SIDES: RangeInclusive<usize> = TEXTURE_SIDE..=512;

/// Albedo, sRGB-encoded 8-bit RGBA (alpha unused), with its full chain of mip levels, finest first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texture {
    /// Level `l` holds `(side >> l)^2` texels, row-major; the coarsest one texel.
    pub levels: Vec<Vec<[u8; 4]>>,
}

impl Texture {
    /// Builds the chain by 2x2 box filtering of the finest level, whose side is inferred.
    ///
    /// # Panics
    /// If the finest level is not a square whose side is a power of two in [`TEXTURE_SIDES`].
    pub fn new(finest: Vec<[u8; 4]>) -> Self {
        let mut side = finest.len().isqrt();
        assert!(
            side * side == finest.len() && side.is_power_of_two() && TEXTURE_SIDES.contains(&side),
            "{} texels of the finest level: expected a square of 128, 256 or 512 on a side",
            finest.len()
        );
        let mut levels = vec![finest];
        while side > 1 {
            let fine = &levels[levels.len() - 1];
            let half = side / 2;
            let coarse = (0..half * half)
                .map(|i| {
                    let (row, column) = (2 * (i / half), 2 * (i % half));
                    let corner = row * side + column;
                    let four = [fine[corner], fine[corner + 1], fine[corner + side], fine[corner + side + 1]];
                    std::array::from_fn(|channel| {
                        let sum: u16 = four.iter().map(|texel| u16::from(texel[channel])).sum();
                        ((sum + 2) / 4) as u8
                    })
                })
                .collect();
            levels.push(coarse);
            side = half;
        }
        Self { levels }
    }

    /// One colour everywhere.
    pub fn plain(rgb: [u8; 3]) -> Self {
        Self::new(vec![[rgb[0], rgb[1], rgb[2], 255]; TEXTURE_SIDE * TEXTURE_SIDE])
    }

    /// Side of the finest level, texels.
    pub fn side(&self) -> usize {
        1 << (self.levels.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::catch_unwind;

    #[test]
    fn the_side_is_inferred() {
        for side in [128, 256, 512] {
            let texture = Texture::new(vec![[9, 8, 7, 255]; side * side]);
            assert_eq!(texture.side(), side);
            assert_eq!(texture.levels[texture.levels.len() - 1], [[9, 8, 7, 255]]);
        }
        for texels in [0, 64 * 64, 192 * 192, 128 * 256, 1024 * 1024] {
            assert!(catch_unwind(|| Texture::new(vec![[0; 4]; texels])).is_err(), "{texels} texels");
        }
    }
}

//! Square, mipmapped textures.

use std::ops::RangeInclusive;

/// Side of the finest level of procedural textures, texels.
pub const TEXTURE_SIDE: usize = 128;

/// Sides that a finest level may have, texels; of these the powers of two.
pub const TEXTURE_SIDES: RangeInclusive<usize> = TEXTURE_SIDE..=512;

/// Albedo, sRGB-encoded 8-bit RGBA (alpha unused), with its full chain of mip levels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texture {
    /// All levels, each row-major, the coarsest (one texel) first.
    texels: Vec<[u8; 4]>,
    levels: usize,
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
        Self { levels: levels.len(), texels: levels.into_iter().rev().flatten().collect() }
    }

    /// One colour everywhere.
    pub fn plain(rgb: [u8; 3]) -> Self {
        Self::new(vec![[rgb[0], rgb[1], rgb[2], 255]; TEXTURE_SIDE * TEXTURE_SIDE])
    }

    /// Side of the finest level, texels.
    pub fn side(&self) -> usize {
        1 << self.coarsest()
    }

    /// The level of one texel; 0 is the finest.
    pub fn coarsest(&self) -> usize {
        self.levels - 1
    }

    /// The `(side >> level)^2` texels of a level, row-major.
    ///
    /// # Panics
    /// If there is no such level.
    pub fn level(&self, level: usize) -> &[[u8; 4]] {
        let steps = self.coarsest() - level;
        &self.texels[first_texel(steps as u32) as usize..][..1 << (2 * steps)]
    }

    /// The levels, finest first.
    pub fn levels(&self) -> impl Iterator<Item = &[[u8; 4]]> {
        (0..self.levels).map(|level| self.level(level))
    }

    /// All levels, each row-major, the coarsest first; see [`first_texel`].
    pub(crate) fn texels(&self) -> &[[u8; 4]] {
        &self.texels
    }
}

/// Index of the first texel of the level so many steps finer than the coarsest, at most 15: `(4^steps - 1) / 3`.
#[inline(always)]
pub(crate) fn first_texel(steps: u32) -> u32 {
    0x5555_5555 & ((1 << (2 * steps)) - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::catch_unwind;

    #[test]
    fn levels_halve_in_side_and_average() {
        let stripes: Vec<[u8; 4]> =
            (0..128 * 128).map(|i| [if i % 2 == 0 { 40 } else { 80 }, 3, 2, 1]).collect();
        let texture = Texture::new(stripes.clone());
        assert_eq!(texture.level(0), stripes);
        let sides: Vec<usize> = texture.levels().map(|texels| texels.len().isqrt()).collect();
        assert_eq!(sides, [128, 64, 32, 16, 8, 4, 2, 1]);
        assert!(texture.levels().skip(1).flatten().all(|&texel| texel == [60, 3, 2, 1]));
    }

    #[test]
    fn the_side_is_inferred() {
        for side in [128, 256, 512] {
            let texture = Texture::new(vec![[9, 8, 7, 255]; side * side]);
            assert_eq!(texture.side(), side);
            assert_eq!(texture.level(texture.coarsest()), [[9, 8, 7, 255]]);
        }
        for texels in [0, 64 * 64, 192 * 192, 128 * 256, 1024 * 1024] {
            assert!(catch_unwind(|| Texture::new(vec![[0; 4]; texels])).is_err(), "{texels} texels");
        }
    }
}

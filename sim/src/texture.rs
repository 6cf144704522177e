//! Square, mipmapped textures.

/// Side of the finest level, texels; every texture has this size so that a GPU array can hold them all.
pub const TEXTURE_SIDE: usize = 128;

/// Albedo, sRGB-encoded 8-bit RGBA (alpha unused), with its full chain of mip levels, finest first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texture {
    /// Level `l` holds `(TEXTURE_SIDE >> l)^2` texels, row-major.
    pub levels: Vec<Vec<[u8; 4]>>,
}

impl Texture {
    /// Builds the chain by 2x2 box filtering of the `TEXTURE_SIDE^2` texels of the finest level.
    ///
    /// # Panics
    /// If `finest` does not hold `TEXTURE_SIDE^2` texels.
    pub fn new(finest: Vec<[u8; 4]>) -> Self {
        assert_eq!(finest.len(), TEXTURE_SIDE * TEXTURE_SIDE, "texels of the finest level");
        let mut levels = vec![finest];
        let mut side = TEXTURE_SIDE;
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
}

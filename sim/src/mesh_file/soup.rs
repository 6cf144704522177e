//! What a mesh file says, in its own frame and unit.

use super::MeshFault;
use image::RgbImage;

/// Most pixels of all images of a mesh together.
const MAX_PIXELS: usize = 1 << 26;

/// Everything a file says about shape and look.
#[derive(Debug, Default)]
pub(crate) struct Soup {
    pub parts: Vec<Part>,
    pub materials: Vec<Material>,
    pub images: Vec<RgbImage>,
}

impl Soup {
    /// Adds an image and returns its index.
    pub fn add_image(&mut self, image: RgbImage) -> Result<usize, MeshFault> {
        self.images.push(image);
        let pixels = self.images.iter().map(|image| image.len() / 3).sum();
        if pixels > MAX_PIXELS {
            return Err(MeshFault::TooMany { what: "pixels of images", got: pixels, limit: MAX_PIXELS });
        }
        Ok(self.images.len() - 1)
    }
}

/// Triangles of one material; indices are in range, lists as long as `positions`.
#[derive(Debug)]
pub(crate) struct Part {
    pub positions: Vec<[f32; 3]>,
    pub normals: Option<Vec<[f32; 3]>>,
    /// v down.
    pub uvs: Option<Vec<[f32; 2]>>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Index among the materials.
    pub material: usize,
}

/// A look.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Material {
    pub name: String,
    /// Linear; multiplies the image where there is one.
    pub color: [f32; 3],
    /// Index among the images.
    pub image: Option<usize>,
    /// How the image goes on along u and v.
    pub wrap: [Wrap; 2],
}

/// How an image goes on outside of `[0, 1]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wrap {
    Repeat,
    Mirror,
    Clamp,
}

impl Wrap {
    /// The pixel, of `len`, for a pixel of the endless image.
    pub fn pixel(self, at: i64, len: u32) -> u32 {
        let len = i64::from(len);
        let inside = match self {
            Wrap::Repeat => at.rem_euclid(len),
            Wrap::Mirror => {
                let at = at.rem_euclid(2 * len);
                if at < len { at } else { 2 * len - 1 - at }
            }
            Wrap::Clamp => at.clamp(0, len - 1),
        };
        inside as u32
    }

    /// Length after which the endless image repeats, in images.
    pub fn period(self) -> Option<f64> {
        match self {
            Wrap::Repeat => Some(1.0),
            Wrap::Mirror => Some(2.0),
            Wrap::Clamp => None,
        }
    }
}

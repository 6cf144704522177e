//! Visible masks.

use crate::episode::BoundingBox;
use nalgebra::Vector2;

/// Extent of the pixels of one id.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mask {
    /// Box of the pixels.
    pub bounding_box: BoundingBox,
    /// How many there are.
    pub pixels: u32,
}

impl Mask {
    /// The mask of `id` in an image `width` pixels wide, or `None` where it does not occur.
    pub fn of(ids: &[u32], width: usize, id: u32) -> Option<Self> {
        let mut extent = Extent::default();
        for (row, line) in ids.chunks_exact(width).enumerate() {
            for (column, _) in line.iter().enumerate().filter(|(_, found)| **found == id) {
                extent.add(column, row);
            }
        }
        extent.mask()
    }

    /// The masks of the ids `1..=count`, in that order.
    pub fn of_all(ids: &[u32], width: usize, count: usize) -> Vec<Option<Self>> {
        let mut extents = vec![Extent::default(); count];
        for (row, line) in ids.chunks_exact(width).enumerate() {
            for (column, &id) in line.iter().enumerate().filter(|(_, found)| **found > 0) {
                extents[id as usize - 1].add(column, row);
            }
        }
        extents.iter().map(Extent::mask).collect()
    }
}

#[derive(Clone, Copy, Default)]
struct Extent {
    min: [usize; 2],
    end: [usize; 2],
    pixels: u32,
}

impl Extent {
    fn add(&mut self, column: usize, row: usize) {
        let pixel = [column, row];
        for (axis, at) in pixel.into_iter().enumerate() {
            self.min[axis] = if self.pixels == 0 { at } else { self.min[axis].min(at) };
            self.end[axis] = self.end[axis].max(at + 1);
        }
        self.pixels += 1;
    }

    fn mask(&self) -> Option<Mask> {
        let corner = |at: [usize; 2]| Vector2::new(at[0] as f64, at[1] as f64);
        (self.pixels > 0).then(|| Mask {
            bounding_box: BoundingBox { min: corner(self.min), max: corner(self.end) },
            pixels: self.pixels,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_are_the_extents_of_their_pixels() {
        #[rustfmt::skip]
        let ids = [
            0, 0, 2, 2,
            0, 0, 0, 2,
            1, 0, 0, 0,
        ];
        let two = Mask {
            bounding_box: BoundingBox { min: Vector2::new(2.0, 0.0), max: Vector2::new(4.0, 2.0) },
            pixels: 3,
        };
        let one = Mask {
            bounding_box: BoundingBox { min: Vector2::new(0.0, 2.0), max: Vector2::new(1.0, 3.0) },
            pixels: 1,
        };
        assert_eq!(Mask::of(&ids, 4, 2), Some(two));
        assert_eq!(Mask::of(&ids, 4, 3), None);
        assert_eq!(Mask::of_all(&ids, 4, 3), [Some(one), Some(two), None]);
    }
}

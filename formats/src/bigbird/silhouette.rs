//! The object's pixels in one image.

use image::GrayImage;
use nalgebra::Vector2;
use vantage_dataset::Mask;

/// Smaller parts of a mask, as a share of its largest, are noise.
const SMALLEST_PART: f64 = 0.05;
/// A mask that covers more than this share of the image is that of the background.
const LARGEST_SHARE: f64 = 0.5;

/// Id of the object's pixels.
pub(super) const OBJECT: u32 = 1;

/// The object in one image.
pub(super) struct Silhouette {
    /// Box and number of the object's pixels.
    pub(super) mask: Mask,
    /// [`OBJECT`] or 0, row-major.
    pub(super) ids: Vec<u32>,
    /// First and last pixel of the object in each row that has some, at their outer edges.
    pub(super) outline: Vec<Vector2<f64>>,
}

/// Why a mask shows no object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unfit {
    Empty,
    Inverted,
    CutOff,
}

impl Silhouette {
    /// The object is 0 in `mask`.
    pub(super) fn of(mask: &GrayImage) -> Result<Self, Unfit> {
        let (width, height) = (mask.width() as usize, mask.height() as usize);
        let mut ids: Vec<u32> = mask.iter().map(|pixel| u32::from(*pixel == 0)).collect();
        let whole = Mask::of(&ids, width.max(1), OBJECT).ok_or(Unfit::Empty)?;
        if f64::from(whole.pixels) > LARGEST_SHARE * ids.len() as f64 || borders(&whole, width, height) == 4 {
            return Err(Unfit::Inverted);
        }
        keep_large_parts(&mut ids, width);
        let mask = Mask::of(&ids, width, OBJECT).ok_or(Unfit::Empty)?;
        if borders(&mask, width, height) > 0 {
            return Err(Unfit::CutOff);
        }
        let mut outline = Vec::new();
        for (row, line) in ids.chunks_exact(width).enumerate() {
            let first = line.iter().position(|id| *id == OBJECT);
            let last = line.iter().rposition(|id| *id == OBJECT);
            for column in first.into_iter().chain(last.map(|last| last + 1)) {
                outline.push(Vector2::new(column as f64, row as f64 + 0.5));
            }
        }
        Ok(Self { mask, ids, outline })
    }
}

/// How many borders of the image the mask touches.
fn borders(mask: &Mask, width: usize, height: usize) -> usize {
    let (min, max) = (mask.bounding_box.min, mask.bounding_box.max);
    [min.x <= 0.0, min.y <= 0.0, max.x >= width as f64, max.y >= height as f64]
        .iter()
        .filter(|touched| **touched)
        .count()
}

/// Clears the 4-connected parts that are noise.
fn keep_large_parts(ids: &mut [u32], width: usize) {
    let mut part_of = vec![0; ids.len()];
    let mut sizes = vec![0_usize];
    let mut open = Vec::new();
    for start in 0..ids.len() {
        if ids[start] != OBJECT || part_of[start] != 0 {
            continue;
        }
        let part = sizes.len();
        sizes.push(0);
        part_of[start] = part;
        open.push(start);
        while let Some(pixel) = open.pop() {
            sizes[part] += 1;
            let column = pixel % width;
            let left = (column > 0).then(|| pixel - 1);
            let right = (column + 1 < width).then_some(pixel + 1);
            let below = (pixel + width < ids.len()).then_some(pixel + width);
            for next in [left, right, pixel.checked_sub(width), below].into_iter().flatten() {
                if ids[next] == OBJECT && part_of[next] == 0 {
                    part_of[next] = part;
                    open.push(next);
                }
            }
        }
    }
    let largest = sizes.iter().max().copied().unwrap_or(0) as f64;
    for (id, part) in ids.iter_mut().zip(part_of) {
        if (sizes[part] as f64) < SMALLEST_PART * largest {
            *id = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(width: u32, height: u32, object: impl Fn(u32, u32) -> bool) -> GrayImage {
        GrayImage::from_fn(width, height, |x, y| image::Luma([if object(x, y) { 0 } else { 255 }]))
    }

    #[test]
    fn specks_do_not_widen_the_box() {
        let image = mask(40, 30, |x, y| (10..20).contains(&x) && (5..15).contains(&y) || (x, y) == (38, 28));
        let silhouette = Silhouette::of(&image).ok().unwrap();
        assert_eq!(silhouette.mask.pixels, 100);
        assert_eq!(silhouette.mask.bounding_box.max, Vector2::new(20.0, 15.0));
        assert_eq!(silhouette.outline.len(), 20);
    }

    #[test]
    fn unfit_masks_are_told_apart() {
        let fault = |image: &GrayImage| Silhouette::of(image).err();
        assert_eq!(fault(&mask(8, 8, |_, _| false)), Some(Unfit::Empty));
        assert_eq!(fault(&mask(8, 8, |_, _| true)), Some(Unfit::Inverted));
        assert_eq!(
            fault(&mask(8, 8, |x, y| !(1..7).contains(&x) || !(1..7).contains(&y))),
            Some(Unfit::Inverted)
        );
        assert_eq!(fault(&mask(8, 8, |x, y| x < 2 && y == 4)), Some(Unfit::CutOff));
    }
}

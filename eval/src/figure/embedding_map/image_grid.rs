//! The images nearest to the points of an axis-aligned grid over a square of the plane.

use super::super::canvas::Canvas;
use super::{EmbeddingMap, Square};
use plotters::prelude::*;
use vantage_dataset::crop::CROP_SIDE;

/// Pixels of the picture a pixel of a crop.
const SCALE: u32 = 2;
/// Side of a cell, pixels: a crop, its frame and a gap.
const CELL: u32 = CROP_SIDE as u32 * SCALE + 2 * FRAME + 1;
/// Width of the frame in the colour of the image's group, pixels.
const FRAME: u32 = 3;

/// A square picture of `side` pixels. Each image is in the cell that its point is in, or in one beside it, at most once; cells
/// with no point near stay empty.
pub(super) fn image_grid(map: &EmbeddingMap<'_>, square: Square, colors: &[RGBColor], side: u32) -> Canvas {
    let mut canvas = Canvas::new(side, side);
    let cells = side / CELL;
    let margin = (side - cells * CELL) / 2;
    for (column, row, index) in nearest(map.points, square, cells) {
        let (left, top) = (margin + column * CELL, margin + row * CELL);
        let color = colors[map.groups[index]];
        let corner = (left as i32, top as i32);
        let opposite = ((left + CELL - 2) as i32, (top + CELL - 2) as i32);
        let area = (&mut canvas).into_drawing_area();
        // The canvas refuses nothing.
        let _: Result<(), _> = area.draw(&Rectangle::new([corner, opposite], color.filled()));
        drop(area);
        canvas.crop(map.crops[index], left + FRAME, top + FRAME, SCALE);
    }
    canvas
}

/// Column and row (downwards) of each cell that has an image, and which. Pairs of cells and points are taken by rising
/// distance, as long as it is under a cell's side, and each but once; ties go to the lowest index.
fn nearest(points: &[[f64; 2]], square: Square, cells: u32) -> Vec<(u32, u32, usize)> {
    let pitch = square.side / f64::from(cells);
    let mut pairs = Vec::new();
    for (column, row) in (0..cells).flat_map(|column| (0..cells).map(move |row| (column, row))) {
        let center = [
            square.low[0] + (f64::from(column) + 0.5) * pitch,
            square.low[1] + (f64::from(cells - 1 - row) + 0.5) * pitch,
        ];
        for (index, point) in points.iter().enumerate() {
            let distance = libm::hypot(point[0] - center[0], point[1] - center[1]);
            if distance < pitch {
                pairs.push((distance, column, row, index));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2, a.3).cmp(&(b.1, b.2, b.3))));
    let mut filled: Vec<(u32, u32, usize)> = Vec::new();
    let mut used = vec![false; points.len()];
    let mut full = vec![false; (cells * cells) as usize];
    for (_, column, row, index) in pairs {
        let cell = (column * cells + row) as usize;
        if !used[index] && !full[cell] {
            (used[index], full[cell]) = (true, true);
            filled.push((column, row, index));
        }
    }
    filled
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_stand_where_their_points_are_and_once() {
        let square = Square { low: [0.0, 0.0], side: 4.0 };
        let points = [[0.5, 0.5], [3.4, 3.6], [3.6, 3.4], [2.0, 9.0]];
        let mut filled = nearest(&points, square, 4);
        filled.sort_by_key(|&(_, _, index)| index);
        assert_eq!(filled[0], (0, 3, 0));
        assert_eq!(filled[1], (3, 0, 1));
        assert_eq!((filled.len(), filled[2].2), (3, 2));
        assert_ne!((filled[2].0, filled[2].1), (3, 0));
    }
}

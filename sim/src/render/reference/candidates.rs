//! Which triangles of a mesh may cover a pixel's centre.
//!
//! Most do not, and which do the CPU cannot predict: all are looked at without branches.

use super::raster::pixels;
use super::view::{Vertex, outside};

/// Triangles that are looked at together.
const BATCH: usize = 16;

/// Room for numbers of triangles.
#[derive(Debug, Default)]
pub(super) struct Candidates {
    numbers: Vec<u32>,
}

/// Corners of a batch of triangles, the first of all, the second of all, the third of all.
#[derive(Default)]
struct Corners {
    x: [[i32; BATCH]; 3],
    y: [[i32; BATCH]; 3],
    outside: [[u32; BATCH]; 3],
}

impl Candidates {
    /// The numbers of the triangles that face the camera and have a pixel's centre in the box around them, or need clipping.
    #[inline(always)]
    pub fn find(&mut self, triangles: &[[u32; 3]], vertices: &[Vertex], size: [i32; 2]) -> &[u32] {
        if self.numbers.len() < triangles.len() {
            self.numbers.resize(triangles.len(), 0);
        }
        let numbers = self.numbers.as_mut_slice();
        let mut met = 0;
        for (number, triangle) in (0..).zip(triangles) {
            let [a, b, c] = triangle.map(
                #[inline(always)]
                |index| vertices[index as usize].outside,
            );
            numbers[met] = number;
            met += usize::from(a & b & c & !outside::GUARD == 0);
        }
        let mut count = 0;
        let mut corners = Corners::default();
        for first in (0..met).step_by(BATCH) {
            let last = (first + BATCH).min(met);
            for (i, &number) in numbers[first..last].iter().enumerate() {
                for (corner, &index) in triangles[number as usize].iter().enumerate() {
                    let vertex = &vertices[index as usize];
                    corners.x[corner][i] = vertex.x;
                    corners.y[corner][i] = vertex.y;
                    corners.outside[corner][i] = vertex.outside;
                }
            }
            let kept = corners.kept(size);
            for i in first..last {
                numbers[count] = numbers[i];
                count += (kept[i - first] & 1) as usize;
            }
        }
        &self.numbers[..count]
    }
}

impl Corners {
    /// All bits of a triangle that is a candidate, else none.
    #[inline(always)]
    fn kept(&self, [width, height]: [i32; 2]) -> [i32; BATCH] {
        let Self { x, y, outside } = self;
        let mut away = [0; BATCH];
        for i in 0..BATCH {
            let across = |axis: &[[i32; BATCH]; 3], corner: usize| i64::from(axis[corner][i] - axis[0][i]);
            let area = across(y, 1) * across(x, 2) - across(x, 1) * across(y, 2);
            away[i] = ((area - 1) >> 63) as i32;
        }
        let mut kept = [0; BATCH];
        for i in 0..BATCH {
            let (left, right) = pixels([x[0][i], x[1][i], x[2][i]], width);
            let (top, bottom) = pixels([y[0][i], y[1][i], y[2][i]], height);
            let covers = (left - right) & (top - bottom) & !away[i];
            let clipped = -(((outside[0][i] | outside[1][i] | outside[2][i]) & outside::UNPROJECTED) as i32);
            kept[i] = (covers | clipped) >> 31;
        }
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::super::raster::Outline;
    use super::*;
    use vantage_dataset::Seed;

    const SIZE: [i32; 2] = [48, 32];

    fn vertex(x: i32, y: i32, outside: u32) -> Vertex {
        Vertex { x, y, inverse_depth: 1.0, outside }
    }

    #[test]
    fn candidates_are_the_triangles_that_have_an_outline() {
        let mut random = Seed(5).stream("triangles", 0);
        // About the image, and of all sizes: some face away, lie beyond or fall between the pixels' centres.
        let vertices: Vec<Vertex> = (0..3 * 1000)
            .map(|i| {
                let size = [40, 400, 20_000][i / 3 % 3];
                let mut at = |side: i32| 128 * side - size / 2 + random.below(size as usize) as i32;
                vertex(at(SIZE[0]), at(SIZE[1]), 0)
            })
            .collect();
        let triangles: Vec<[u32; 3]> = (0..1000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let outlined = |triangle: &[u32; 3]| {
            let corners = triangle.map(|index| [vertices[index as usize].x, vertices[index as usize].y]);
            Outline::new(corners, SIZE[0], SIZE[1]).is_some()
        };
        let expected: Vec<u32> = (0..1000).filter(|&i| outlined(&triangles[i as usize])).collect();
        assert!((200..800).contains(&expected.len()), "{} of 1000", expected.len());
        assert_eq!(Candidates::default().find(&triangles, &vertices, SIZE), expected);
    }

    #[test]
    fn triangles_that_need_clipping_are_candidates_unless_all_corners_are_beyond_one_side() {
        let [near, guard, left] =
            [outside::NEAR, outside::GUARD, outside::LEFT].map(|outside| vertex(0, 0, outside));
        let inside = vertex(100, 100, 0);
        let vertices = [near, guard, left, inside];
        let triangles = [[0, 0, 3], [0, 1, 2], [1, 1, 1], [0, 0, 0], [2, 2, 2], [2, 2, 3]];
        assert_eq!(Candidates::default().find(&triangles, &vertices, SIZE), [0, 1, 2]);
    }

    #[test]
    fn room_is_used_again() {
        let vertices = [vertex(0, 0, 0), vertex(0, 4000, 0), vertex(4000, 0, 0)];
        let mut candidates = Candidates::default();
        assert_eq!(candidates.find(&[[0, 1, 2]; 40], &vertices, SIZE).len(), 40);
        assert_eq!(candidates.find(&[[0, 2, 1], [0, 1, 2]], &vertices, SIZE), [1]);
    }
}

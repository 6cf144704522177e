//! Which triangles of a mesh may cover a pixel's centre.
//!
//! Most do not, and which do the CPU cannot predict: all are looked at without branches.

use super::view::{SUBPIXELS, Vertex, outside, pixels};

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
    /// The numbers of the triangles that face the camera and have a pixel's centre in the box around them, or need clipping;
    /// with `slack`, less than half a pixel, also of those that would if each corner were moved by so many subpixels.
    #[inline(always)]
    pub fn find(
        &mut self,
        triangles: &[[u32; 3]],
        vertices: &[Vertex],
        size: [i32; 2],
        slack: i32,
    ) -> &[u32] {
        // What lies beyond a side of the window is half a pixel from any centre, and stays beyond them.
        debug_assert!(slack < SUBPIXELS / 2);
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
            let kept = corners.kept(size, slack);
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
    fn kept(&self, [width, height]: [i32; 2], slack: i32) -> [i32; BATCH] {
        let Self { x, y, outside } = self;
        let mut away = [0; BATCH];
        for i in 0..BATCH {
            let across = |axis: &[[i32; BATCH]; 3], corner: usize| i64::from(axis[corner][i] - axis[0][i]);
            let [x1, x2, y1, y2] = [across(x, 1), across(x, 2), across(y, 1), across(y, 2)];
            // By how much twice the area changes at most where the corners move.
            let change = i64::from(2 * slack) * (x1.abs() + x2.abs() + y1.abs() + y2.abs())
                + i64::from(8 * slack * slack);
            away[i] = ((y1 * x2 - x1 * y2 + change - 1) >> 63) as i32;
        }
        let mut kept = [0; BATCH];
        for i in 0..BATCH {
            let (left, right) = pixels([x[0][i], x[1][i], x[2][i]], width, slack);
            let (top, bottom) = pixels([y[0][i], y[1][i], y[2][i]], height, slack);
            let covers = (left - right) & (top - bottom) & !away[i];
            let clipped = -(((outside[0][i] | outside[1][i] | outside[2][i]) & outside::UNPROJECTED) as i32);
            kept[i] = (covers | clipped) >> 31;
        }
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_dataset::Seed;

    const SIZE: [i32; 2] = [48, 32];

    fn vertex(x: i32, y: i32, outside: u32) -> Vertex {
        Vertex { x, y, inverse_depth: 1.0, outside }
    }

    /// Triangles about the image, and of all sizes: some face away, lie beyond or fall between the pixels' centres.
    fn random_triangles(count: usize) -> Vec<Vertex> {
        let mut random = Seed(5).stream("triangles", 0);
        (0..3 * count)
            .map(|i| {
                let size = [40, 400, 20_000][i / 3 % 3];
                let mut at = |side: i32| 128 * side - size / 2 + random.below(size as usize) as i32;
                vertex(at(SIZE[0]), at(SIZE[1]), 0)
            })
            .collect()
    }

    fn found(vertices: &[Vertex], slack: i32) -> Vec<u32> {
        let triangles: Vec<[u32; 3]> =
            (0..vertices.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Candidates::default().find(&triangles, vertices, SIZE, slack).to_vec()
    }

    #[test]
    fn slack_keeps_what_moved_corners_make_a_candidate_and_not_all() {
        const SLACK: i32 = 16;
        let vertices = random_triangles(3000);
        let (exact, kept) = (found(&vertices, 0), found(&vertices, SLACK));
        let mut random = Seed(6).stream("moves", 0);
        let mut moved_in = 0;
        for _ in 0..20 {
            let mut moved = vertices.clone();
            for vertex in &mut moved {
                let mut shift = || random.below(2 * SLACK as usize + 1) as i32 - SLACK;
                (vertex.x, vertex.y) = (vertex.x + shift(), vertex.y + shift());
            }
            let candidates = found(&moved, 0);
            assert!(candidates.iter().all(|number| kept.binary_search(number).is_ok()));
            moved_in += candidates.iter().filter(|number| exact.binary_search(number).is_err()).count();
        }
        assert!(moved_in > 100, "{moved_in}");
        assert!(kept.len() < 2 * exact.len(), "{} for {}", kept.len(), exact.len());
    }

    #[test]
    fn triangles_that_need_clipping_are_candidates_unless_all_corners_are_beyond_one_side() {
        let [near, guard, left] =
            [outside::NEAR, outside::GUARD, outside::LEFT].map(|outside| vertex(0, 0, outside));
        let inside = vertex(100, 100, 0);
        let vertices = [near, guard, left, inside];
        let triangles = [[0, 0, 3], [0, 1, 2], [1, 1, 1], [0, 0, 0], [2, 2, 2], [2, 2, 3]];
        assert_eq!(Candidates::default().find(&triangles, &vertices, SIZE, 0), [0, 1, 2]);
    }

    #[test]
    fn room_is_used_again() {
        let vertices = [vertex(0, 0, 0), vertex(0, 4000, 0), vertex(4000, 0, 0)];
        let mut candidates = Candidates::default();
        assert_eq!(candidates.find(&[[0, 1, 2]; 40], &vertices, SIZE, 0).len(), 40);
        assert_eq!(candidates.find(&[[0, 2, 1], [0, 1, 2]], &vertices, SIZE, 0), [1]);
    }
}

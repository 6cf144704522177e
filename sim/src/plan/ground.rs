//! The floor plan: where a robot may be.

use super::stand::Outline;
use crate::scene::RoomSpec;
use nalgebra::Vector2;
use vantage_dataset::Stream;

/// Points tried before a plan counts as full.
const TRIES: usize = 10_000;

/// A room with the outlines of what stands in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Ground {
    /// Half the room's extent along x and y, metres.
    half_extents: Vector2<f64>,
    obstacles: Vec<(Vector2<f64>, Outline)>,
}

impl Ground {
    /// The plan of a room with outlines, about their centres.
    pub fn new(room: &RoomSpec, obstacles: Vec<(Vector2<f64>, Outline)>) -> Self {
        Self { half_extents: Vector2::new(room.length / 2.0, room.width / 2.0), obstacles }
    }

    /// Half the room's extent along x and y, metres.
    pub fn half_extents(&self) -> Vector2<f64> {
        self.half_extents
    }

    /// Distance of a point, world frame, from the nearest wall or obstacle, metres; negative where it is inside one.
    pub fn clearance(&self, point: &Vector2<f64>) -> f64 {
        let walls = (self.half_extents - point.abs()).min();
        let obstacles = self.obstacles.iter().map(|(center, outline)| outline.distance(&(point - center)));
        obstacles.fold(walls, f64::min)
    }

    /// The least clearance of some points, metres, and where it is.
    pub fn narrowest(&self, points: impl Iterator<Item = Vector2<f64>>) -> Option<(f64, Vector2<f64>)> {
        points.map(|point| (self.clearance(&point), point)).min_by(|(a, _), (b, _)| a.total_cmp(b))
    }

    /// A point at least so far from everything; `None` where there seems to be none.
    pub fn draw_free(&self, margin: f64, stream: &mut Stream) -> Option<Vector2<f64>> {
        (0..TRIES).find_map(|_| {
            let [x, y]: [f64; 2] = self.half_extents.into();
            let point = Vector2::new(stream.uniform(-x, x), stream.uniform(-y, y));
            (self.clearance(&point) >= margin).then_some(point)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_dataset::Seed;

    fn plan() -> Ground {
        Ground {
            half_extents: Vector2::new(3.0, 2.0),
            obstacles: vec![
                (Vector2::new(1.0, 0.0), Outline::Disc { radius: 0.5 }),
                (Vector2::new(-1.0, 0.0), Outline::Rectangle { half_extents: [0.5, 0.25] }),
            ],
        }
    }

    #[test]
    fn clearances_are_distances_to_the_nearest() {
        let clearance = |x: f64, y: f64| plan().clearance(&Vector2::new(x, y));
        assert!((clearance(2.8, 0.0) - 0.2).abs() < 1e-12);
        assert!((clearance(1.0, 1.0) - 0.5).abs() < 1e-12);
        assert!((clearance(1.0, 0.1) + 0.4).abs() < 1e-12);
        assert!((clearance(-1.8, 0.65) - 0.5).abs() < 1e-12);
        assert!((clearance(-1.0, 0.15) + 0.1).abs() < 1e-12);
    }

    #[test]
    fn drawn_points_are_free_and_a_full_room_has_none() {
        let mut stream = Seed(3).stream("free", 0);
        for _ in 0..200 {
            let point = plan().draw_free(0.4, &mut stream).unwrap();
            assert!(plan().clearance(&point) >= 0.4);
        }
        assert_eq!(plan().draw_free(2.5, &mut stream), None);
    }
}

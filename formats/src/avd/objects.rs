//! Where the objects of a scan are: of that the dataset says nothing, so that boxes and depth must.

use crate::meeting::meeting_point;
use nalgebra::{Point3, Vector2};
use vantage_dataset::median::median;
use vantage_dataset::ray::Ray;
use vantage_dataset::{Camera, Pose};

/// Boxes harder than this place an object only where no easier one has depth.
const HARDEST: u8 = 3;

/// One box of an object.
#[derive(Clone, Debug)]
pub(super) struct Evidence {
    pub(super) world_from_camera: Pose,
    /// Centre and sides of the box as an ideal lens would show it, pixels.
    pub(super) center: Vector2<f64>,
    pub(super) sides: Vector2<f64>,
    /// Depth at the centre, metres.
    pub(super) depth: Option<f64>,
    pub(super) difficulty: u8,
}

/// Position and size of an object, metres.
///
/// The position is the median, coordinate by coordinate, of the box centres at their depths, so that it lies somewhat
/// before the object's middle where it was seen from one side alone; without depth it is where the rays through the
/// box centres meet. The size is the median over the boxes of the longer side at that depth.
pub(super) fn place(camera: &Camera, evidence: &[Evidence]) -> Option<(Point3<f64>, f64)> {
    let all: Vec<&Evidence> = evidence.iter().collect();
    let easy: Vec<&Evidence> = evidence.iter().filter(|e| e.difficulty <= HARDEST).collect();
    let meeting = || meeting_point(&all.iter().map(|e| e.ray(camera)).collect::<Vec<Ray>>());
    let (position, boxes) = [&easy, &all]
        .into_iter()
        .find_map(|boxes| Some((by_depth(camera, boxes)?, boxes)))
        .or_else(|| Some((meeting()?, &all)))?;
    let size = median(boxes.iter().filter_map(|e| e.size(camera, &position)).collect())?;
    (size > 0.0 && size.is_finite()).then_some((position, size))
}

fn by_depth(camera: &Camera, boxes: &[&Evidence]) -> Option<Point3<f64>> {
    let points: Vec<Point3<f64>> = boxes
        .iter()
        .filter_map(|e| Some(e.world_from_camera * Point3::from(camera.ray_in_camera(&e.center) * e.depth?)))
        .collect();
    let axis = |axis: usize| median(points.iter().map(|point| point[axis]).collect());
    Some(Point3::new(axis(0)?, axis(1)?, axis(2)?))
}

impl Evidence {
    fn ray(&self, camera: &Camera) -> Ray {
        let direction = self.world_from_camera.rotation * camera.ray_in_camera(&self.center).normalize();
        Ray { origin: self.world_from_camera.translation.vector.into(), direction }
    }

    fn size(&self, camera: &Camera, position: &Point3<f64>) -> Option<f64> {
        let depth = self.depth.unwrap_or((self.world_from_camera.inverse() * position).z);
        (depth > 0.0).then(|| depth * (self.sides.x / camera.fx).max(self.sides.y / camera.fy))
    }
}

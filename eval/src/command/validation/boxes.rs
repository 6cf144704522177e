//! What boxes say of objects, over those that the border of the image does not cut.

use super::Trial;
use crate::result::statistics::quantile;
use nalgebra::{Point3, Vector2};
use std::collections::BTreeMap;
use vantage_slam::bearing_offset::BearingOffset;

/// Of a length at which the offset does not change with the azimuth: its harmonics beyond the constant are left out.
const ALIKE: BearingOffset = BearingOffset { horizontal: 0.0, vertical: 0.0, length: 10.0, smoothness: 1.5 };

/// One box.
pub struct SeenBox {
    /// Cosine and sine of the azimuth, in the world, of the direction from object to camera.
    pub direction: [f64; 2],
    /// Longer side over the focal length.
    pub angular_size: f64,
    /// Its centre less the object's, image x and y over the focal length.
    pub offset: Vector2<f64>,
}

/// The boxes of some trials.
pub struct Boxes {
    /// Of each object that was seen.
    pub by_object: Vec<Vec<SeenBox>>,
    /// Median of an object's size over the side of its box at its distance.
    pub size_over_side: f64,
}

impl Boxes {
    /// All boxes of objects.
    pub fn of(trials: &[Trial]) -> Self {
        let mut by_object: BTreeMap<(usize, usize), Vec<SeenBox>> = BTreeMap::new();
        let mut ratios = Vec::new();
        for (trial, Trial { observations, truth }) in trials.iter().enumerate() {
            let camera = &observations.camera;
            for (number, detection) in observations.detections.iter().enumerate() {
                let seen = &detection.bounding_box;
                if seen.is_truncated(camera) {
                    continue;
                }
                let Some(object) = truth.shown(number, detection) else { continue };
                let world_from_camera =
                    truth.world_from_robot[detection.step] * observations.robot_from_camera;
                let in_world = Point3::from(object.world_from_object.translation.vector);
                let center = world_from_camera.inverse() * in_world;
                let Some(pixel) = camera.project(&center) else { continue };
                let from_object = world_from_camera.translation.vector - in_world.coords;
                let distance = libm::hypot(from_object.x, from_object.y);
                by_object.entry((trial, detection.track)).or_default().push(SeenBox {
                    direction: [from_object.x / distance, from_object.y / distance],
                    angular_size: seen.side() / camera.focal_length(),
                    offset: (seen.center() - pixel).component_div(&Vector2::new(camera.fx, camera.fy)),
                });
                ratios.push(object.size / (seen.side() / camera.fx * center.coords.norm()));
            }
        }
        ratios.sort_by(f64::total_cmp);
        let size_over_side = quantile(&ratios, 0.5).unwrap_or(f64::NAN);
        Self { by_object: by_object.into_values().collect(), size_over_side }
    }

    /// Root mean square of the offset's coordinates over the focal length.
    pub fn offset(&self) -> f64 {
        self.root_mean_square(|_| 1.0)
    }

    /// The same, in box sides.
    pub fn offset_in_sides(&self) -> f64 {
        self.root_mean_square(|seen| seen.angular_size)
    }

    /// The offset that is alike from all sides: deviations are root mean squares over objects of what their boxes are off by in the mean.
    pub fn constant_offset(&self) -> BearingOffset {
        let mean = |seen: &Vec<SeenBox>| {
            seen.iter().map(|one| one.offset / one.angular_size).sum::<Vector2<f64>>() / seen.len() as f64
        };
        let squares: Vector2<f64> =
            self.by_object.iter().map(mean).map(|mean| mean.component_mul(&mean)).sum();
        let deviations = (squares / self.by_object.len() as f64).map(f64::sqrt);
        BearingOffset { horizontal: deviations.x, vertical: deviations.y, ..ALIKE }
    }

    fn root_mean_square(&self, unit: impl Fn(&SeenBox) -> f64) -> f64 {
        let squares = self.by_object.iter().flatten().map(|seen| (seen.offset / unit(seen)).norm_squared());
        let count = self.by_object.iter().map(Vec::len).sum::<usize>();
        (squares.sum::<f64>() / (2 * count) as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_constant_offset_is_of_the_means_of_objects_in_box_sides() {
        let seen = |sides: [f64; 2], angular_size: f64| SeenBox {
            direction: [1.0, 0.0],
            angular_size,
            offset: Vector2::from(sides) * angular_size,
        };
        let one = vec![seen([0.01, 0.05], 0.1), seen([-0.01, 0.03], 0.2)];
        let other = vec![seen([0.02, -0.03], 0.1)];
        let found = Boxes { by_object: vec![one, other], size_over_side: 1.0 }.constant_offset();
        assert_relative_eq!(found.horizontal, 0.02 / 2.0_f64.sqrt(), epsilon = 1e-12);
        assert_relative_eq!(found.vertical, (0.0025_f64 / 2.0).sqrt(), epsilon = 1e-12);
        assert_eq!(found.harmonics().count(), 1);
    }
}

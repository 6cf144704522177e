//! What a sighting makes of an object that it may be of: a bearing, and a first place of one that is new.

use super::hypothesizing::AssociationSettings;
use super::scan::{Estimated, pose};
use crate::association::{Addition, Alternative, LocalEstimator};
use crate::factor::{BearingFactor, DepthFactor, Factor};
use crate::noise::Kernel;
use crate::settings::GeometrySettings;
use crate::sighting::Sighting;
use crate::variable::{Key, Value};
use nalgebra::Point3;
use std::f64::consts::PI;
use std::rc::Rc;
use vantage_dataset::{CenterDepth, Observations};

/// A camera and what is assumed of it.
#[derive(Clone, Copy)]
pub(super) struct Sensing<'a> {
    pub settings: &'a AssociationSettings,
    pub geometry: &'a GeometrySettings,
    pub observations: &'a Observations,
}

impl Sensing<'_> {
    /// A bearing to an object, the offset of its box counted as white noise.
    pub fn bearing(&self, object: usize, sighting: &Sighting) -> BearingFactor {
        self.weighted_bearing(object, sighting, 1.0)
    }

    /// The same, whose cost counts with a weight.
    pub fn weighted_bearing(&self, object: usize, sighting: &Sighting, weight: f64) -> BearingFactor {
        BearingFactor::new(
            Key::Robot(sighting.step),
            Key::Object(object),
            self.observations.robot_from_camera,
            &sighting.ray_in_camera,
            self.sigma(sighting) / weight.sqrt(),
            Kernel::Gaussian,
        )
    }

    /// What makes a bearing's cost a density of the image's coordinates over the focal length.
    pub fn log_normalizer(&self, sighting: &Sighting) -> f64 {
        -libm::log(2.0 * PI) - 2.0 * libm::log(self.sigma(sighting))
    }

    fn sigma(&self, sighting: &Sighting) -> f64 {
        let offset =
            self.geometry.bearing_offset.map_or(0.0, |offset| offset.horizontal.max(offset.vertical));
        let noise = self.geometry.bearing_noise.sigma(sighting.angular_size);
        libm::hypot(noise, offset * sighting.angular_size)
    }

    /// Angle, radians, between a sighting and where a hypothesis has an object; none behind the camera.
    pub fn off(&self, hypothesis: &Estimated, object: usize, sighting: &Sighting) -> Option<f64> {
        let place = hypothesis.estimator().value(Key::Object(object))?.position()?;
        let world_from_camera = pose(hypothesis, sighting.step)? * self.observations.robot_from_camera;
        let there = world_from_camera.inverse_transform_point(&place.into()).coords;
        (there.z > 0.0).then(|| there.angle(&sighting.ray_in_camera))
    }

    /// Squared Mahalanobis distance of a sighting from where a hypothesis has an object.
    pub fn distance(&self, hypothesis: &Estimated, object: usize, sighting: &Sighting) -> Option<f64> {
        let joint = hypothesis.estimator().joint(&[Key::Robot(sighting.step), Key::Object(object)])?;
        let bearing: Rc<dyn Factor> = Rc::new(self.bearing(object, sighting));
        Some(joint.weigh(&[bearing], &[])?.distance)
    }

    /// A sighting as one of the nearest of some objects, or of a new one where none is within the gate.
    pub fn nearest(
        &self,
        hypothesis: &Estimated,
        objects: &[usize],
        gate: f64,
        (number, sighting): (usize, &Sighting),
    ) -> Option<Alternative<'static>> {
        let ahead = objects.iter().filter(|object| self.off(hypothesis, **object, sighting).is_some());
        let distances =
            ahead.filter_map(|&object| Some((self.distance(hypothesis, object, sighting)?, object)));
        match distances.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(distance, _)| *distance <= gate) {
            Some((_, object)) => Some(Alternative {
                label: object,
                addition: Addition::default().with(self.bearing(object, sighting)),
                log_weight: 0.0,
                claims: Some(object),
            }),
            None => self.new_object(hypothesis, number, sighting),
        }
    }

    /// Where an object of the usual size is in the camera's frame.
    pub fn first_place(&self, sighting: &Sighting) -> Point3<f64> {
        let meters = self.settings.size / (sighting.angular_size * self.geometry.size_over_box_side);
        Point3::from(sighting.ray_in_camera * meters)
    }

    /// An object that was never seen, at a depth that its box tells by the size that objects have.
    ///
    /// Its weight is that of a Poisson process: objects a cubic metre, along the ray where the box has its size.
    pub fn new_object(
        &self,
        hypothesis: &Estimated,
        number: usize,
        sighting: &Sighting,
    ) -> Option<Alternative<'static>> {
        let robot_from_camera = self.observations.robot_from_camera;
        let AssociationSettings { density, size_spread, .. } = *self.settings;
        let in_camera = self.first_place(sighting);
        let depth = CenterDepth { meters: in_camera.z, sigma: size_spread * in_camera.z };
        let place = pose(hypothesis, sighting.step)? * robot_from_camera * in_camera;
        let (robot, object) = (Key::Robot(sighting.step), Key::Object(number));
        let addition = Addition::default()
            .with(self.bearing(number, sighting))
            .with(DepthFactor::new(robot, object, robot_from_camera, depth, Kernel::Gaussian))
            .with_variable(object, Value::Point(place.coords));
        let log_weight = self.log_normalizer(sighting) + libm::log(density)
            - 0.5 * libm::log(2.0 * PI)
            - libm::log(depth.sigma);
        Some(Alternative { label: number, addition, log_weight, claims: None })
    }
}

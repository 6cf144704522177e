//! The geometric problem of an episode: the factors that odometry, boxes and landmarks make, and the sizes boxes tell.

use crate::factor::{BearingFactor, BetweenFactor, DepthFactor, PosePrior, ProjectionFactor};
use crate::graph::Graph;
use crate::noise::sqrt_information;
use crate::settings::GeometrySettings;
use crate::sighting::Sighting;
use crate::variable::{Key, Values};
use nalgebra::Matrix6;
use vantage_dataset::median::median;
use vantage_dataset::{LandmarkSighting, Observations, Pose};

/// Information of the first pose's prior, which fixes the world frame: a millionth of a radian and metre.
const GAUGE_SQRT_INFORMATION: f64 = 1e6;

/// The gauge, and P(x_k | x_k-1, u_k-1) of Eq. 3.
pub fn add_odometry(graph: &mut Graph<'_>, observations: &Observations) {
    if observations.steps() > 0 {
        let gauge = Matrix6::identity() * GAUGE_SQRT_INFORMATION;
        graph.push(PosePrior::new(Key::Robot(0), Pose::identity(), gauge));
    }
    let mut odometry: Vec<_> = observations.odometry.iter().collect();
    odometry.sort_by_key(|o| (o.from, o.to));
    for o in odometry {
        if let Some(information) = sqrt_information(&o.covariance) {
            let (from, to) = (Key::Robot(o.from), Key::Robot(o.to));
            graph.push(BetweenFactor::new(from, to, o.robot_from_robot, information));
        }
    }
}

/// One episode's boxes and landmarks under some settings.
#[derive(Clone, Copy)]
pub struct Problem<'a> {
    /// What the robot observed.
    pub observations: &'a Observations,
    /// How it is read.
    pub settings: &'a GeometrySettings,
}

impl Problem<'_> {
    /// `world_from_camera` at a step.
    pub fn world_from_camera(&self, values: &Values, step: usize) -> Option<Pose> {
        Some(values.pose(Key::Robot(step))? * self.observations.robot_from_camera)
    }

    /// P(z^g | x_k, o_i) of Eq. 6 for one object: bearings, and depths where the detector tells them.
    pub fn add_bearings(&self, graph: &mut Graph<'_>, track: usize, sightings: &[Sighting]) {
        for sighting in sightings {
            graph.push(BearingFactor::new(
                Key::Robot(sighting.step),
                Key::Object(track),
                self.observations.robot_from_camera,
                &sighting.ray_in_camera,
                self.settings.bearing_noise.sigma(sighting.angular_size),
                self.settings.bearing_kernel,
            ));
            self.add_depth(graph, track, sighting);
        }
    }

    /// The depth of one object at one sighting, where the detector tells it.
    pub fn add_depth(&self, graph: &mut Graph<'_>, track: usize, sighting: &Sighting) {
        let Some(depth) = sighting.depth else { return };
        let (robot, object) = (Key::Robot(sighting.step), Key::Object(track));
        let Observations { robot_from_camera, .. } = *self.observations;
        let kernel = self.settings.bearing_kernel;
        graph.push(DepthFactor::new(robot, object, robot_from_camera, depth, kernel));
    }

    /// P(z^g | x_k, l_j) of Eq. 6 for some sightings of landmarks.
    pub fn add_projections(&self, graph: &mut Graph<'_>, sightings: &[LandmarkSighting]) {
        let Observations { camera, robot_from_camera, .. } = *self.observations;
        for sighting in sightings {
            let kernel = self.settings.bearing_kernel;
            graph.push(ProjectionFactor::new(sighting, camera, robot_from_camera, kernel));
        }
    }

    /// An object's diameter, metres: the median over its views of box side times depth, by the settings' ratio of
    /// diameter to side. `None` where it is behind all cameras.
    pub fn object_size(&self, values: &Values, track: usize, sightings: &[Sighting]) -> Option<f64> {
        let position = values.get(Key::Object(track))?.position()?;
        let side = |sighting: &Sighting| {
            let world_from_camera = self.world_from_camera(values, sighting.step)?;
            let depth = world_from_camera.inverse_transform_point(&position.into()).z;
            (depth > 0.0).then_some(sighting.angular_size * depth)
        };
        let side = median(sightings.iter().filter_map(side).collect())?;
        Some(side * self.settings.size_over_box_side).filter(|size| size.is_finite() && *size > 0.0)
    }
}

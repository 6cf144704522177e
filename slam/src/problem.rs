//! The geometric problem of an episode: the factors that odometry, boxes and landmarks make, and the sizes boxes tell.

use crate::bearing_offset::BearingOffset;
use crate::factor::{
    BearingFactor, BetweenFactor, BiasedBetweenFactor, DepthFactor, OffsetBearingFactor, PosePrior,
    ProjectionFactor, StandardNormalPrior,
};
use crate::graph::Graph;
use crate::odometry_bias::OdometryBias;
use crate::settings::{GeometrySettings, OdometrySettings};
use crate::sighting::Sighting;
use crate::variable::{Key, Value, Values};
use nalgebra::{DVector, Matrix6};
use vantage_dataset::median::median;
use vantage_dataset::{LandmarkSighting, Observations, Odometry, Pose};

/// Information of the first pose's prior, which fixes the world frame: a millionth of a radian and metre.
const GAUGE_SQRT_INFORMATION: f64 = 1e6;

/// Adds the gauge, and P(x_k | x_k-1, u_k-1) of Eq. 3, with the bias's prior and first value where that is a variable.
pub fn add_odometry(
    graph: &mut Graph<'_>,
    values: &mut Values,
    observations: &Observations,
    settings: &OdometrySettings,
) {
    if observations.steps() > 0 {
        add_gauge(graph);
    }
    let mut odometry: Vec<_> = observations.odometry.iter().collect();
    odometry.sort_by_key(|o| (o.from, o.to));
    add_bias(graph, values, settings);
    for o in odometry {
        add_motion(graph, o, settings);
    }
}

/// What fixes the world frame: that of the first pose.
pub fn add_gauge(graph: &mut Graph<'_>) {
    let gauge = Matrix6::identity() * GAUGE_SQRT_INFORMATION;
    graph.push(PosePrior::new(Key::Robot(0), Pose::identity(), gauge));
}

/// The prior of odometry's bias and its first value, where that is a variable.
pub fn add_bias(graph: &mut Graph<'_>, values: &mut Values, settings: &OdometrySettings) {
    if settings.bias.is_some() {
        graph.push(StandardNormalPrior::new(Key::OdometryBias));
        values.insert(Key::OdometryBias, Value::Vector(DVector::zeros(OdometryBias::DIM)));
    }
}

/// P(x_k | x_k-1, u_k-1) of one step.
pub fn add_motion(graph: &mut Graph<'_>, odometry: &Odometry, settings: &OdometrySettings) {
    let Odometry { from, to, robot_from_robot: measured, .. } = *odometry;
    let (from, to) = (Key::Robot(from), Key::Robot(to));
    let Some(information) = settings.sqrt_information(odometry) else { return };
    match settings.bias {
        Some(bias) => {
            let response = bias.response(odometry);
            graph.push(BiasedBetweenFactor::new(from, to, measured, information, &response));
        }
        None => graph.push(BetweenFactor::new(from, to, measured, information)),
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

    /// The prior of an object's offset, of objects that are centres: an ellipsoid has edges of its own.
    fn offset(&self) -> Option<&BearingOffset> {
        self.settings.bearing_offset.as_ref().filter(|_| self.settings.extents.is_none())
    }

    /// P(z^g | x_k, o_i) of Eq. 6 for one object: bearings, with the prior of their offset where that is a variable, and depths where
    /// the detector tells them.
    pub fn add_bearings(&self, graph: &mut Graph<'_>, track: usize, sightings: &[Sighting]) {
        if self.offset().is_some() {
            graph.push(StandardNormalPrior::new(Key::Offset(track)));
        }
        self.add_views(graph, track, sightings);
    }

    /// The bearings and depths of [`Problem::add_bearings`] without the prior: more of what has it.
    pub fn add_views(&self, graph: &mut Graph<'_>, track: usize, sightings: &[Sighting]) {
        let offset = self.offset();
        for sighting in sightings {
            let sigma = self.settings.bearing_noise.sigma(sighting.angular_size);
            let bearing = BearingFactor::new(
                Key::Robot(sighting.step),
                Key::Object(track),
                self.observations.robot_from_camera,
                &sighting.ray_in_camera,
                sigma,
                self.settings.bearing_kernel,
            );
            match offset {
                Some(offset) => {
                    graph.push(OffsetBearingFactor::new(
                        bearing,
                        track,
                        offset,
                        sighting.angular_size,
                        sigma,
                    ));
                }
                None => graph.push(bearing),
            }
            self.add_depth(graph, track, sighting);
        }
    }

    /// Adds the first value of the offset of an object's boxes, where that is a variable: none.
    pub fn add_offset(&self, values: &mut Values, track: usize) {
        if let Some(offset) = self.offset() {
            let none = DVector::zeros(OffsetBearingFactor::dim(offset));
            values.insert(Key::Offset(track), Value::Vector(none));
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

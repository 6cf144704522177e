//! Which factors the rows are made of.

use crate::factor::semantic::SemanticScaling;
use crate::factor::{
    BearingFactor, BetweenFactor, PosePrior, SemanticFactor, StandardNormalPrior, UprightFactor,
};
use crate::graph::Graph;
use crate::noise::sqrt_information;
use crate::observation_model::ObservationModel;
use crate::semantics::{SemanticObject, SemanticView};
use crate::sighting::Sighting;
use crate::solve::Limits;
use crate::spec::{EstimatorSpec, Row};
use crate::variable::{Key, Values};
use nalgebra::{Matrix6, UnitQuaternion};
use vantage_dataset::{Observations, Pose};

/// Information of the first pose's prior, which fixes the world frame: a millionth of a radian and metre.
const GAUGE_SQRT_INFORMATION: f64 = 1e6;

/// One episode under one row's settings.
#[derive(Clone, Copy)]
pub struct Problem<'a> {
    /// What the robot observed.
    pub observations: &'a Observations,
    /// The settings.
    pub spec: &'a EstimatorSpec,
    /// The row.
    pub row: Row,
}

impl Problem<'_> {
    /// When to stop.
    pub fn limits(&self) -> Limits {
        Limits { iterations: self.spec.max_iterations, tolerance: self.spec.tolerance }
    }

    /// `world_from_camera` at a step.
    pub fn world_from_camera(&self, values: &Values, step: usize) -> Option<Pose> {
        Some(values.pose(Key::Robot(step))? * self.observations.robot_from_camera)
    }

    /// The gauge, and P(x_k | x_k-1, u_k-1) of Eq. 4.
    pub fn add_odometry(&self, graph: &mut Graph<'_>) {
        if self.observations.steps() > 0 {
            let gauge = Matrix6::identity() * GAUGE_SQRT_INFORMATION;
            graph.push(PosePrior::new(Key::Robot(0), Pose::identity(), gauge));
        }
        let mut odometry: Vec<_> = self.observations.odometry.iter().collect();
        odometry.sort_by_key(|o| (o.from, o.to));
        for o in odometry {
            if let Some(information) = sqrt_information(&o.covariance) {
                let (from, to) = (Key::Robot(o.from), Key::Robot(o.to));
                graph.push(BetweenFactor::new(from, to, o.robot_from_robot, information));
            }
        }
    }

    /// P(z^g | x_k, o_i) of Eq. 6 for one object.
    pub fn add_bearings(&self, graph: &mut Graph<'_>, track: usize, sightings: &[Sighting]) {
        for sighting in sightings {
            graph.push(BearingFactor::new(
                Key::Robot(sighting.step),
                Key::Object(track),
                self.observations.robot_from_camera,
                &sighting.ray_in_camera,
                self.spec.bearing_noise.sigma(sighting.angular_size),
                self.spec.bearing_kernel,
            ));
        }
    }

    /// P(o_i), P(e_i) and P(z^s | e_i, x_rel) of Eq. 9-10 for one object.
    pub fn add_semantics<'m>(
        &self,
        graph: &mut Graph<'m>,
        model: &'m dyn ObservationModel,
        object: &SemanticObject,
        views: &[SemanticView],
        reference: UnitQuaternion<f64>,
    ) {
        let track = object.track;
        graph.push(UprightFactor::new(Key::Object(track), self.spec.tilt_sigma, reference));
        graph.push(StandardNormalPrior::new(Key::Latent(track)));
        for view in views {
            graph.push(self.semantic_factor(model, object, view));
        }
    }

    /// The semantic factor of one view.
    pub fn semantic_factor<'m>(
        &self,
        model: &'m dyn ObservationModel,
        object: &SemanticObject,
        view: &SemanticView,
    ) -> SemanticFactor<'m> {
        let information = match self.row {
            Row::Uninformative => 0.0,
            _ => self.spec.semantic_information_scale,
        };
        let track = object.track;
        SemanticFactor::new(
            [Key::Robot(view.sighting.step), Key::Object(track), Key::Latent(track)],
            model,
            view.measurement.clone(),
            self.observations.robot_from_camera,
            object.size,
            SemanticScaling { noise: self.spec.semantic_noise_scale, information },
        )
    }
}

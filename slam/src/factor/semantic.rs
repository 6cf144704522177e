//! The semantic measurement P(z^s | e, x_rel) of Eq. 9-10, in the reduced measurement of IV-C.

use super::{Factor, LinearFactor, finite};
use crate::noise::Kernel;
use crate::variable::{Key, Values};
use nalgebra::DVector;
use vantage_dataset::{Pose, Viewpoint, se3};
use vantage_model::ObservationModel;

/// `W (m(z) - h(e, x_rel)) / noise scale` with `x_rel` the viewpoint of
/// `object_from_camera = world_from_object^-1 world_from_robot robot_from_camera`.
#[derive(Clone)]
pub struct SemanticFactor<'m> {
    keys: [Key; 3],
    model: &'m dyn ObservationModel,
    measurement: DVector<f64>,
    robot_from_camera: Pose,
    object_size: f64,
    scaling: SemanticScaling,
}

/// How far the model's own noise is trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SemanticScaling {
    /// Multiplies the spread of the residual; 1 is the model's own.
    pub noise: f64,
    /// Multiplies the log-likelihood; 1 is the model's own, 0 says nothing.
    pub information: f64,
}

impl<'m> SemanticFactor<'m> {
    /// Joins `[robot, object, latent]` by the reduced measurement `m(z)` (`[M]`) of an object of `object_size`
    /// metres.
    pub fn new(
        keys: [Key; 3],
        model: &'m dyn ObservationModel,
        measurement: DVector<f64>,
        robot_from_camera: Pose,
        object_size: f64,
        scaling: SemanticScaling,
    ) -> Self {
        Self { keys, model, measurement, robot_from_camera, object_size, scaling }
    }

    fn object_from_camera(&self, values: &Values) -> Option<Pose> {
        let world_from_camera = values.pose(self.keys[0])? * self.robot_from_camera;
        Some(values.pose(self.keys[1])?.inv_mul(&world_from_camera))
    }
}

impl Factor for SemanticFactor<'_> {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        let viewpoint = Viewpoint::new(&self.object_from_camera(values)?, self.object_size)?;
        let predicted = self.model.predict(values.vector(self.keys[2])?, &viewpoint).ok()?;
        if predicted.len() != self.measurement.len() {
            return None;
        }
        finite(self.model.noise().sqrt_information() * (&self.measurement - predicted) / self.scaling.noise)
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let object_from_camera = self.object_from_camera(values)?;
        let viewpoint = Viewpoint::new(&object_from_camera, self.object_size)?;
        let latent = values.vector(self.keys[2])?;
        let near = self.model.linearize(latent, &viewpoint).ok()?;
        if !near.is_valid(self.measurement.len(), latent.len()) {
            return None;
        }
        let whiten = self.model.noise().sqrt_information() / self.scaling.noise;
        let d_camera = -near.d_viewpoint.by_camera(&whiten, &object_from_camera, self.object_size)?;
        let d_robot = &d_camera * se3::adjoint(&self.robot_from_camera.inverse());
        let d_object = -(&d_camera * se3::adjoint(&object_from_camera.inverse()));
        let to_dynamic = |m: nalgebra::OMatrix<f64, nalgebra::Dyn, nalgebra::U6>| {
            nalgebra::DMatrix::from_column_slice(m.nrows(), 6, m.as_slice())
        };
        LinearFactor {
            residual: &whiten * (&self.measurement - near.mean),
            jacobians: vec![to_dynamic(d_robot), to_dynamic(d_object), -(&whiten * near.d_latent)],
        }
        .finite()
    }

    /// A Student-t over the whole vector: a crop is an outlier as a whole.
    fn kernel(&self) -> Kernel {
        Kernel::of_degrees_of_freedom(self.model.noise().degrees_of_freedom())
    }

    fn information_scale(&self) -> f64 {
        self.scaling.information
    }
}

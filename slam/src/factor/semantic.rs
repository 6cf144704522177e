//! The semantic measurement P(z^s | e, x_rel) of Eq. 9-10, in the reduced measurement of IV-C.

use super::view::View;
use super::{Factor, LinearFactor, finite};
use crate::noise::Kernel;
use crate::variable::{Key, Values};
use nalgebra::{DMatrix, DVector};
use vantage_dataset::{Pose, Viewpoint};
use vantage_model::{Linearization, ObservationModel};

/// `W (m(z) - h(e, x_rel)) / noise scale` with `x_rel` the viewpoint of
/// `object_from_camera = world_from_object^-1 world_from_robot robot_from_camera`. An object that is a centre has the world's axes.
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

    fn view(&self, values: &Values) -> Option<View> {
        let [robot, object, _] = self.keys;
        View::of([robot, object], values, &self.robot_from_camera)
    }

    /// `[robot, object, latent]`.
    pub(super) fn joined(&self) -> &[Key; 3] {
        &self.keys
    }

    /// `m(z)`.
    pub(super) fn measurement(&self) -> &DVector<f64> {
        &self.measurement
    }

    /// `W / noise scale`.
    pub(super) fn whitening(&self) -> DMatrix<f64> {
        self.model.noise().sqrt_information() / self.scaling.noise
    }

    /// `h(e, x_rel)`, `[M]`.
    pub(super) fn predicted(&self, values: &Values) -> Option<DVector<f64>> {
        let viewpoint = Viewpoint::new(&self.view(values)?.object_from_camera, self.object_size)?;
        let predicted = self.model.predict(values.vector(self.keys[2])?, &viewpoint).ok()?;
        (predicted.len() == self.measurement.len()).then_some(predicted)
    }

    /// The prediction with its derivatives, and the view.
    pub(super) fn near(&self, values: &Values) -> Option<(Linearization, View)> {
        let view = self.view(values)?;
        let viewpoint = Viewpoint::new(&view.object_from_camera, self.object_size)?;
        let latent = values.vector(self.keys[2])?;
        let near = self.model.linearize(latent, &viewpoint).ok()?;
        near.is_valid(self.measurement.len(), latent.len()).then_some((near, view))
    }

    /// The derivatives of `-A h` by robot, object and latent, of a matrix `A`.
    pub(super) fn jacobians(
        &self,
        matrix: &DMatrix<f64>,
        near: &Linearization,
        view: &View,
    ) -> Option<[DMatrix<f64>; 3]> {
        let d_camera = -near.d_viewpoint.by_camera(matrix, &view.object_from_camera, self.object_size)?;
        let [d_robot, d_object] = view.jacobians(&d_camera, &self.robot_from_camera);
        Some([d_robot, d_object, -(matrix * &near.d_latent)])
    }
}

impl Factor for SemanticFactor<'_> {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        let predicted = self.predicted(values)?;
        finite(self.model.noise().sqrt_information() * (&self.measurement - predicted) / self.scaling.noise)
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let (near, view) = self.near(values)?;
        let whiten = self.whitening();
        let jacobians = self.jacobians(&whiten, &near, &view)?.into();
        LinearFactor { residual: &whiten * (&self.measurement - near.mean), jacobians }.finite()
    }

    /// A Student-t over the whole vector: a crop is an outlier as a whole.
    fn kernel(&self) -> Kernel {
        Kernel::of_degrees_of_freedom(self.model.noise().degrees_of_freedom())
    }

    fn information_scale(&self) -> f64 {
        self.scaling.information
    }
}

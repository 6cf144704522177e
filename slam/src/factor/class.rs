//! The semantic measurement P(z^s | c, x_rel) of Eq. 8, of a class that is held.

use super::view::View;
use super::{Factor, LinearFactor, finite};
use crate::factor::semantic::SemanticScaling;
use crate::noise::Kernel;
use crate::variable::{Key, Values};
use nalgebra::DVector;
use vantage_dataset::{Pose, Viewpoint};
use vantage_model::ClassModel;

/// `W_c (m(z) - h(c, x_rel)) / noise scale`, `x_rel` as for [`SemanticFactor`](super::SemanticFactor).
#[derive(Clone)]
pub struct ClassFactor<'m> {
    keys: [Key; 2],
    model: &'m dyn ClassModel,
    class: usize,
    measurement: DVector<f64>,
    robot_from_camera: Pose,
    object_size: f64,
    scaling: SemanticScaling,
}

impl<'m> ClassFactor<'m> {
    /// Joins `[robot, object]` by the reduced measurement `m(z)` (`[M]`) of an object of `object_size` metres that is of
    /// a class.
    pub fn new(
        keys: [Key; 2],
        (model, class): (&'m dyn ClassModel, usize),
        measurement: DVector<f64>,
        robot_from_camera: Pose,
        object_size: f64,
        scaling: SemanticScaling,
    ) -> Self {
        Self { keys, model, class, measurement, robot_from_camera, object_size, scaling }
    }

    fn view(&self, values: &Values) -> Option<View> {
        View::of(self.keys, values, &self.robot_from_camera)
    }
}

impl Factor for ClassFactor<'_> {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        let viewpoint = Viewpoint::new(&self.view(values)?.object_from_camera, self.object_size)?;
        let (expected, _) = self.model.linearize(self.class, &viewpoint);
        let whiten = self.model.noise(self.class).sqrt_information();
        finite(whiten * (&self.measurement - expected) / self.scaling.noise)
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let view = self.view(values)?;
        let object_from_camera = view.object_from_camera;
        let viewpoint = Viewpoint::new(&object_from_camera, self.object_size)?;
        let (expected, d_viewpoint) = self.model.linearize(self.class, &viewpoint);
        let whiten = self.model.noise(self.class).sqrt_information() / self.scaling.noise;
        let d_camera = -d_viewpoint.by_camera(&whiten, &object_from_camera, self.object_size)?;
        LinearFactor {
            residual: &whiten * (&self.measurement - expected),
            jacobians: view.jacobians(&d_camera, &self.robot_from_camera).to_vec(),
        }
        .finite()
    }

    fn kernel(&self) -> Kernel {
        Kernel::of_degrees_of_freedom(self.model.noise(self.class).degrees_of_freedom())
    }

    fn information_scale(&self) -> f64 {
        self.scaling.information
    }
}

//! The semantic measurement P(z' | z, e, Delta X) of Eq. 15: of a second view, given the first one.

use super::semantic::SemanticScaling;
use super::view::View;
use super::{Factor, LinearFactor, finite};
use crate::noise::Kernel;
use crate::variable::{Key, Values};
use nalgebra::DVector;
use vantage_dataset::{Pose, Viewpoint};
use vantage_model::{FirstView, PairModel, ViewpointDerivative};

/// `W (m(z') - h(e, m(z), x_rel, x_rel')) / noise scale` with `x_rel` and `x_rel'` the viewpoints of one object at two steps.
///
/// An object that is a centre has the world's axes, and so has its latent: what of a yaw a prediction could depend on, the latent turns.
#[derive(Clone)]
pub struct PairFactor<'m> {
    keys: [Key; 4],
    model: &'m dyn PairModel,
    measurements: [DVector<f64>; 2],
    robot_from_camera: Pose,
    object_size: f64,
    scaling: SemanticScaling,
}

impl<'m> PairFactor<'m> {
    /// Joins `[first robot, second robot, object, latent]` by the reduced measurements `m(z)` and `m(z')` (`[M]`) of an object of
    /// `object_size` metres.
    pub fn new(
        keys: [Key; 4],
        model: &'m dyn PairModel,
        measurements: [DVector<f64>; 2],
        robot_from_camera: Pose,
        object_size: f64,
        scaling: SemanticScaling,
    ) -> Self {
        Self { keys, model, measurements, robot_from_camera, object_size, scaling }
    }

    /// First and second view.
    fn views(&self, values: &Values) -> Option<[(View, Viewpoint); 2]> {
        let [first, second, object, _] = self.keys;
        let of = |robot: Key| {
            let view = View::of([robot, object], values, &self.robot_from_camera)?;
            let viewpoint = Viewpoint::new(&view.object_from_camera, self.object_size)?;
            Some((view, viewpoint))
        };
        Some([of(first)?, of(second)?])
    }
}

impl Factor for PairFactor<'_> {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        let [(_, viewpoint), (_, second)] = self.views(values)?;
        let [measurement, measured] = &self.measurements;
        let first = FirstView { measurement, viewpoint: &viewpoint };
        let predicted = self.model.predict_pair(values.vector(self.keys[3])?, first, &second).ok()?;
        if predicted.len() != measured.len() {
            return None;
        }
        finite(self.model.pair_noise().sqrt_information() * (measured - predicted) / self.scaling.noise)
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let [(first_view, viewpoint), (second_view, second)] = self.views(values)?;
        let [measurement, measured] = &self.measurements;
        let latent = values.vector(self.keys[3])?;
        let first = FirstView { measurement, viewpoint: &viewpoint };
        let near = self.model.linearize_pair(latent, first, &second).ok()?;
        if !near.is_valid(measured.len(), latent.len()) {
            return None;
        }
        let whiten = self.model.pair_noise().sqrt_information() / self.scaling.noise;
        let by = |view: &View, d_viewpoint: &ViewpointDerivative| {
            let d_camera = -d_viewpoint.by_camera(&whiten, &view.object_from_camera, self.object_size)?;
            Some(view.jacobians(&d_camera, &self.robot_from_camera))
        };
        let [d_first, d_object_of_first] = by(&first_view, &near.d_first_viewpoint)?;
        let [d_second, d_object_of_second] = by(&second_view, &near.d_second_viewpoint)?;
        LinearFactor {
            residual: &whiten * (measured - near.mean),
            jacobians: vec![
                d_first,
                d_second,
                d_object_of_first + d_object_of_second,
                -(&whiten * near.d_latent),
            ],
        }
        .finite()
    }

    /// A Student-t over the whole vector: a crop is an outlier as a whole.
    fn kernel(&self) -> Kernel {
        Kernel::of_degrees_of_freedom(self.model.pair_noise().degrees_of_freedom())
    }

    fn information_scale(&self) -> f64 {
        self.scaling.information
    }
}

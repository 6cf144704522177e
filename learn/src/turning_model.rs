//! A viewpoint-predictive model whose latent turns, as one of pairs of views and as one of looks: seen from a viewpoint is a change of
//! viewpoint from azimuth 0, without a first view.

use crate::change::object_centred_change;
use crate::error::ModelError;
use crate::latent::{Latent, LatentLayout};
use crate::predictive_model::PredictiveModel;
use crate::role::{Convention, OBJECT_CENTRED_CHANGE, Role};
use crate::viewing::Viewing;
use nalgebra::{DMatrix, DVector};
use vantage_dataset::viewpoint::{CONDITIONING, HARMONICS};
use vantage_dataset::{Crop, Viewpoint};
use vantage_model::linearization::harmonics_by_angle;
use vantage_model::{
    AnswerError, FirstView, LatentGaussian, Linearization, MeasurementNoise, ObservationModel,
    PairLinearization, PairModel, ViewpointDerivative,
};

/// `p(m | e, x_rel)` as `p(m' | nothing, e, Delta X)` of Eq. 15-20, latents in the object's frame.
#[derive(Debug)]
pub struct TurningModel {
    pub(crate) model: PredictiveModel,
    layout: LatentLayout,
    noise: MeasurementNoise,
    /// No measurement of a first view, `[d_m]`.
    nothing: DVector<f64>,
}

impl TurningModel {
    /// How the latent turns; `None` where it does not, or where the model is told of the camera's motion.
    pub(crate) fn layout(model: &PredictiveModel) -> Option<LatentLayout> {
        let centred = model.convention() == Convention::ObjectCentredChange;
        model.latent().steerable.filter(|_| centred)
    }

    pub(crate) fn new(model: PredictiveModel, layout: LatentLayout) -> Self {
        let noise = model.noise().law();
        Self { nothing: DVector::zeros(model.measurement_dim()), model, layout, noise }
    }
}

/// The harmonics, nothing of the first view's upright part, and that of the viewpoint.
fn change_from_azimuth_0(viewpoint: &Viewpoint) -> [f64; OBJECT_CENTRED_CHANGE] {
    let x = viewpoint.conditioning();
    let mut change = [0.0; OBJECT_CENTRED_CHANGE];
    change[..2 * HARMONICS].copy_from_slice(&x[..2 * HARMONICS]);
    change[CONDITIONING..].copy_from_slice(&x[2 * HARMONICS..]);
    change
}

impl ObservationModel for TurningModel {
    fn latent_dim(&self) -> usize {
        self.layout.dimension()
    }

    fn noise(&self) -> &MeasurementNoise {
        &self.noise
    }

    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError> {
        Ok(self.model.measure(crop)?)
    }

    fn encode(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, AnswerError> {
        let LatentGaussian { mean, variance } = self.model.encode(crop)?;
        Ok(LatentGaussian { mean: self.layout.turned(&mean, viewpoint.azimuth()), variance })
    }

    fn predict(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError> {
        Ok(self.model.predict(latent, &self.nothing, &change_from_azimuth_0(viewpoint))?)
    }

    fn linearize(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<Linearization, AnswerError> {
        let at = self.model.linearize(latent, &self.nothing, &change_from_azimuth_0(viewpoint))?;
        let mut d_conditioning = DMatrix::zeros(at.measurement.len(), CONDITIONING);
        d_conditioning.columns_mut(0, 2 * HARMONICS).copy_from(&at.d_change.columns(0, 2 * HARMONICS));
        let upright = CONDITIONING - 2 * HARMONICS;
        let of_view = at.d_change.columns(CONDITIONING, upright);
        d_conditioning.columns_mut(2 * HARMONICS, upright).copy_from(&of_view);
        let d_viewpoint = ViewpointDerivative::new(d_conditioning);
        Ok(Linearization { mean: at.measurement, d_latent: at.d_latent, d_viewpoint })
    }
}

impl PairModel for TurningModel {
    fn predict_pair(
        &self,
        latent: &DVector<f64>,
        first: FirstView<'_>,
        second: &Viewpoint,
    ) -> Result<DVector<f64>, AnswerError> {
        let change = object_centred_change(first.viewpoint, second);
        let latent = self.layout.turned(latent, -first.viewpoint.azimuth());
        Ok(self.model.predict(&latent, first.measurement, &change)?)
    }

    /// The network's latent is in the first view's frame, so that it turns with the first azimuth, too.
    fn linearize_pair(
        &self,
        latent: &DVector<f64>,
        first: FirstView<'_>,
        second: &Viewpoint,
    ) -> Result<PairLinearization, AnswerError> {
        let azimuth = first.viewpoint.azimuth();
        let change = object_centred_change(first.viewpoint, second);
        let latent = self.layout.turned(latent, -azimuth);
        let at = self.model.linearize(&latent, first.measurement, &change)?;
        let rows =
            at.d_latent.row_iter().map(|row| self.layout.turned(&row.transpose(), azimuth).transpose());
        let d_latent = DMatrix::from_rows(&rows.collect::<Vec<_>>());
        let (turning, upright) = (2 * HARMONICS, CONDITIONING - 2 * HARMONICS);
        let by_turn = at.d_change.columns(0, turning) * harmonics_by_angle(&change[..turning]);
        let by_latent = &at.d_latent * self.layout.by_angle(&latent);
        let by_first_upright = at.d_change.columns(turning, upright).into_owned();
        let by_second_upright = at.d_change.columns(turning + upright, upright).into_owned();
        Ok(PairLinearization {
            mean: at.measurement,
            d_latent,
            d_first_measurement: at.d_measurement,
            d_first_viewpoint: ViewpointDerivative::by_azimuth_and_upright(
                first.viewpoint,
                &-(&by_turn + by_latent),
                &by_first_upright,
            ),
            d_second_viewpoint: ViewpointDerivative::by_azimuth_and_upright(
                second,
                &by_turn,
                &by_second_upright,
            ),
        })
    }
}

impl Viewing for TurningModel {
    fn latent(&self) -> Latent {
        self.model.latent()
    }

    fn reconstruct(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Option<Result<Crop, AnswerError>> {
        let change = change_from_azimuth_0(viewpoint);
        let predicted = || self.model.reconstruct(latent, &self.nothing, &change).map_err(ModelError::into);
        self.model.has(Role::Image).then(predicted)
    }
}

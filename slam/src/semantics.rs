//! The semantic measurements Z^s of objects whose place is known: which views are used, and their factors.

use crate::domain::Domain;
use crate::estimate::Dropped;
use crate::factor::semantic::SemanticScaling;
use crate::factor::{DomainFactor, SemanticFactor, StandardNormalPrior, UprightFactor};
use crate::graph::Graph;
use crate::problem::Problem;
use crate::settings::SemanticSettings;
use crate::sighting::Sighting;
use crate::variable::{Key, Values};
use nalgebra::{DVector, UnitQuaternion, Vector3};
use vantage_dataset::{Crop, Pose, Viewpoint};
use vantage_model::{AnswerError, ObservationModel};

/// An object with semantic views.
#[derive(Clone, Debug)]
pub struct SemanticObject {
    /// Its track.
    pub track: usize,
    /// Its diameter, metres: an estimate that is held.
    pub size: f64,
    /// Its usable views, by step.
    pub views: Vec<SemanticView>,
}

/// One usable crop.
#[derive(Clone, Debug)]
pub struct SemanticView {
    /// Where and when.
    pub sighting: Sighting,
    /// `m(z)`, `[M]`.
    pub measurement: DVector<f64>,
    /// `x_rel` if the object stood upright at yaw 0.
    pub viewpoint: Viewpoint,
}

/// One episode's crops as an observation model reads them.
#[derive(Clone, Copy)]
pub struct Semantics<'a, 'm> {
    /// The geometric problem.
    pub problem: Problem<'a>,
    /// The model.
    pub model: &'m dyn ObservationModel,
    /// How far it is trusted.
    pub settings: SemanticSettings,
    /// What its predictions are changed by, where that is a variable.
    pub domain: Option<&'m Domain>,
}

impl<'m> Semantics<'_, 'm> {
    /// P(o_i), P(e_i) and P(z^s | e_i, x_rel) of Eq. 9-10 for one object.
    pub fn add_factors(
        &self,
        graph: &mut Graph<'m>,
        object: &SemanticObject,
        views: &[SemanticView],
        reference: UnitQuaternion<f64>,
    ) {
        let track = object.track;
        let SemanticSettings { tilt_sigma, yaw_sigma, .. } = self.settings;
        graph.push(UprightFactor::new(Key::Object(track), [tilt_sigma, yaw_sigma], reference));
        graph.push(StandardNormalPrior::new(Key::Latent(track)));
        for view in views {
            let factor = self.factor(object, view);
            match self.domain {
                Some(domain) => graph.push(DomainFactor::new(factor, domain)),
                None => graph.push(factor),
            }
        }
    }

    /// The semantic factor of one view.
    pub fn factor(&self, object: &SemanticObject, view: &SemanticView) -> SemanticFactor<'m> {
        let track = object.track;
        SemanticFactor::new(
            [Key::Robot(view.sighting.step), Key::Object(track), Key::Latent(track)],
            self.model,
            view.measurement.clone(),
            self.problem.observations.robot_from_camera,
            object.size,
            SemanticScaling {
                noise: self.settings.noise_scale,
                information: self.settings.information_scale,
            },
        )
    }

    /// Measures the crops of one object that can be used, and counts the others.
    pub fn object(
        &self,
        values: &Values,
        track: usize,
        sightings: &[Sighting],
        dropped: &mut Dropped,
    ) -> Result<Option<SemanticObject>, AnswerError> {
        let measure =
            |sighting: &Sighting, viewpoint: &Viewpoint| self.measure(self.crop(sighting), viewpoint);
        usable(&self.problem, &self.settings, values, (track, sightings), dropped, measure)
    }

    /// One more crop of an object whose size is known, or `None` where it is not to be used, which is counted.
    pub fn view(
        &self,
        values: &Values,
        object: &SemanticObject,
        sighting: &Sighting,
        dropped: &mut Dropped,
    ) -> Result<Option<SemanticView>, AnswerError> {
        let position = values.get(Key::Object(object.track)).and_then(|value| value.position());
        let last = object.views.last();
        let measure =
            |sighting: &Sighting, viewpoint: &Viewpoint| self.measure(self.crop(sighting), viewpoint);
        let Some(position) = position else { return Ok(None) };
        let upright = Pose::translation(position.x, position.y, position.z);
        view(
            &self.problem,
            &self.settings,
            values,
            (upright, object.size),
            (sighting, last),
            dropped,
            measure,
        )
    }

    /// The crop of a sighting.
    pub fn crop(&self, sighting: &Sighting) -> &Crop {
        &self.problem.observations.detections[sighting.detection].masked_crop
    }

    /// `m(z)` if the model answers this crop with finite numbers throughout.
    fn measure(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<Option<DVector<f64>>, AnswerError> {
        let model = self.model;
        let (m, d) = (model.measurement_dim(), model.latent_dim());
        let Some(measurement) = unless_non_finite(model.measure(crop))? else { return Ok(None) };
        expect_length("measurement", measurement.len(), m)?;
        let Some(posterior) = unless_non_finite(model.encode(crop, viewpoint))? else { return Ok(None) };
        expect_length("encoder's mean", posterior.mean.len(), d)?;
        expect_length("encoder's variance", posterior.variance.len(), d)?;
        if !posterior.is_valid(d) || !measurement.iter().all(|x| x.is_finite()) {
            return Ok(None);
        }
        let near = unless_non_finite(model.linearize(&posterior.mean, viewpoint))?;
        let Some(near) = near else { return Ok(None) };
        expect_length("prediction", near.mean.len(), m)?;
        expect_length("derivative to the latent (columns)", near.d_latent.ncols(), d)?;
        Ok(near.is_valid(m, d).then_some(measurement))
    }
}

/// The crops of an object, by its track and sightings, that can be used, as `measure` reads them; counts the others.
pub(crate) fn usable(
    problem: &Problem<'_>,
    settings: &SemanticSettings,
    values: &Values,
    (track, sightings): (usize, &[Sighting]),
    dropped: &mut Dropped,
    measure: impl Fn(&Sighting, &Viewpoint) -> Result<Option<DVector<f64>>, AnswerError>,
) -> Result<Option<SemanticObject>, AnswerError> {
    let position = values.get(Key::Object(track)).and_then(|value| value.position());
    let size = problem.object_size(values, track, sightings);
    let (Some(position), Some(size)) = (position, size) else {
        dropped.undefined_viewpoint += sightings.len();
        return Ok(None);
    };
    let upright = Pose::translation(position.x, position.y, position.z);
    let mut views: Vec<SemanticView> = Vec::new();
    for sighting in sightings {
        let seen = (sighting, views.last());
        if let Some(view) = view(problem, settings, values, (upright, size), seen, dropped, &measure)? {
            views.push(view);
        }
    }
    Ok((!views.is_empty()).then_some(SemanticObject { track, size, views }))
}

/// A crop of an object that stands upright with a size, after the `last` one used.
fn view(
    problem: &Problem<'_>,
    settings: &SemanticSettings,
    values: &Values,
    (upright, size): (Pose, f64),
    (sighting, last): (&Sighting, Option<&SemanticView>),
    dropped: &mut Dropped,
    measure: impl Fn(&Sighting, &Viewpoint) -> Result<Option<DVector<f64>>, AnswerError>,
) -> Result<Option<SemanticView>, AnswerError> {
    let viewpoint = problem
        .world_from_camera(values, sighting.step)
        .and_then(|world_from_camera| Viewpoint::new(&upright.inv_mul(&world_from_camera), size));
    let Some(viewpoint) = viewpoint else {
        dropped.undefined_viewpoint += 1;
        return Ok(None);
    };
    let separation = settings.minimum_view_separation;
    // Only of the view before: the same direction again, a lap later, is what closes the loop.
    let repeats = |used: &SemanticView| angle(&used.viewpoint.direction, &viewpoint.direction) < separation;
    if last.is_some_and(repeats) {
        dropped.redundant_viewpoint += 1;
        return Ok(None);
    }
    let measurement = measure(sighting, &viewpoint)?;
    dropped.non_finite += usize::from(measurement.is_none());
    Ok(measurement.map(|measurement| SemanticView { sighting: *sighting, measurement, viewpoint }))
}

/// A model's answer, or `None` where it says that it is not finite.
pub(crate) fn unless_non_finite<T>(answer: Result<T, AnswerError>) -> Result<Option<T>, AnswerError> {
    match answer {
        Ok(answer) => Ok(Some(answer)),
        Err(AnswerError::NonFinite { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

fn expect_length(what: &'static str, got: usize, expected: usize) -> Result<(), AnswerError> {
    if got == expected { Ok(()) } else { Err(AnswerError::Shape { what, got, expected }) }
}

fn angle(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    libm::atan2(a.cross(b).norm(), a.dot(b))
}

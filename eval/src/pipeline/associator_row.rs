//! The rows of the table of associations, and the associators that make them.

use std::fmt;
use vantage_dataset::{Camera, Observations, Tracklets};
use vantage_model::ObservationModel;
use vantage_sim::scene::DetectorSpec;
use vantage_slam::Settings;
use vantage_slam::association::Limits;
use vantage_slam::associator::{
    AssociationSettings, Associator, Blind, Encoded, EncodedSettings, Hypothesizing, Separate,
};

/// Steps without a detection after which an object has left the view.
const GAP: usize = 3;
/// Detections of nothing, a steradian and a step, where a scene's detector has none.
const LEAST_CLUTTER: f64 = 1e-3;

/// What an associator is told of who is who.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Told {
    /// Which detections are of one object while that stays in view.
    Tracklets,
    /// Nothing.
    None,
}

/// An associator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AssociatorRow {
    /// No object is ever seen again.
    Separate,
    /// The likeliest objects of a step's detections by geometry, for good.
    Greedy,
    /// The same, with the model's latents beside geometry.
    GreedyLatents,
    /// Hypotheses by geometry.
    Hypotheses,
    /// Hypotheses by geometry and latents: from which side an object is seen says nothing.
    HypothesesLatents,
    /// Hypotheses by geometry, latents and sides.
    HypothesesViews,
}

impl Told {
    /// All levels, the more telling first.
    pub const ALL: [Self; 2] = [Self::Tracklets, Self::None];

    /// Hypotheses that are kept at most: where each detection is a choice, time has to be bounded.
    fn hypotheses(self) -> usize {
        match self {
            Self::Tracklets => 32,
            Self::None => 8,
        }
    }

    /// Observations that tell no more, and of each detection its number among those of `given`.
    pub fn of(self, given: &Observations) -> (Tracklets, Vec<usize>) {
        match self {
            Self::Tracklets => Tracklets::joined(given, GAP),
            Self::None => Tracklets::alone(given),
        }
    }
}

impl AssociatorRow {
    /// All, in the order of the table.
    pub const ALL: [Self; 6] = [
        Self::Separate,
        Self::Greedy,
        Self::GreedyLatents,
        Self::Hypotheses,
        Self::HypothesesLatents,
        Self::HypothesesViews,
    ];

    /// The associator, with an estimator's settings, a detector and a model.
    pub fn associator<'m>(
        self,
        told: Told,
        settings: &Settings,
        (camera, detector): (&Camera, &DetectorSpec),
        model: &'m dyn ObservationModel,
    ) -> Box<dyn Associator + 'm> {
        let default = AssociationSettings::default();
        let limits = Limits { hypotheses: told.hypotheses(), ..default.limits };
        let own = AssociationSettings { limits, clutter: clutter(camera, detector), ..default };
        let greedy = AssociationSettings { limits: Limits { hypotheses: 1, ..own.limits }, ..own };
        let views = EncodedSettings::default();
        let latents = EncodedSettings { side_exponent: 0.0, ..views };
        match self {
            Self::Separate => Box::new(Separate),
            Self::Greedy => Box::new(Hypothesizing::new(settings, greedy, Blind)),
            Self::GreedyLatents => {
                Box::new(Hypothesizing::new(settings, greedy, Encoded::new(model, latents)))
            }
            Self::Hypotheses => Box::new(Hypothesizing::new(settings, own, Blind)),
            Self::HypothesesLatents => {
                Box::new(Hypothesizing::new(settings, own, Encoded::new(model, latents)))
            }
            Self::HypothesesViews => Box::new(Hypothesizing::new(settings, own, Encoded::new(model, views))),
        }
    }
}

/// Detections of nothing, a steradian and a step: as the detector is known to err.
fn clutter(camera: &Camera, detector: &DetectorSpec) -> f64 {
    let area = f64::from(camera.width) / camera.fx * f64::from(camera.height) / camera.fy;
    let each = detector.faults.as_ref().map_or(0.0, |faults| faults.false_per_image);
    (each / area).max(LEAST_CLUTTER)
}

impl fmt::Display for Told {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Tracklets => "tracklets",
            Self::None => "none",
        })
    }
}

impl fmt::Display for AssociatorRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Separate => "separate",
            Self::Greedy => "greedy",
            Self::GreedyLatents => "greedy_latents",
            Self::Hypotheses => "hypotheses",
            Self::HypothesesLatents => "hypotheses_latents",
            Self::HypothesesViews => "hypotheses_views",
        })
    }
}

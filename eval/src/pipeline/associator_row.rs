//! The associators behind the rows of the table of associations.

use crate::scene_file::associator::{AssociatorRow, Told};
use vantage_dataset::{Camera, Observations, Tracklets};
use vantage_learn::readout::{ClassReadout, EmbeddingReadout, Readouts};
use vantage_model::ObservationModel;
use vantage_sim::scene::DetectorSpec;
use vantage_slam::Settings;
use vantage_slam::association::Limits;
use vantage_slam::associator::{
    Alternating, AssociationSettings, Associator, Blind, Classed, ClassedSettings, Embedded,
    EmbeddedSettings, Encoded, EncodedSettings, Hypothesizing, Separate, Weights,
};

/// Steps without a detection after which an object has left the view.
const GAP: usize = 3;
/// Detections of nothing, a steradian and a step, where a scene's detector has none.
const LEAST_CLUTTER: f64 = 1e-3;

/// Squared distance of two numbers that 99% of the right ones are within.
const GATE: f64 = 9.21;
/// Hypotheses that are kept at most where the robot may be anywhere.
const HYPOTHESES_OF_PLACES: usize = 256;

/// What rows read crops by.
#[derive(Clone, Copy)]
pub struct Looks<'m> {
    /// Of views of objects.
    pub model: &'m dyn ObservationModel,
    /// Classes read off its measurement.
    pub readouts: &'m Readouts,
    /// Numbers by which crops are compared; `None` where too few validation views say how.
    pub embedding: Option<EmbeddingReadout<'m>>,
}

impl Told {
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
    /// The associator of what is seen, with an estimator's settings, a detector and what reads crops; `None` without what it reads them by.
    pub fn associator<'m>(
        self,
        (told, seen): (Told, &Observations),
        settings: &Settings,
        detector: &DetectorSpec,
        looks: Looks<'m>,
    ) -> Option<Box<dyn Associator + 'm>> {
        let default = AssociationSettings::default();
        let is_carried = seen.set_down().next().is_some();
        let hypotheses = if is_carried { HYPOTHESES_OF_PLACES } else { told.hypotheses() };
        let limits = Limits { hypotheses, ..default.limits };
        let own = AssociationSettings { limits, clutter: clutter(&seen.camera, detector), ..default };
        let greedy = AssociationSettings { limits: Limits { hypotheses: 1, ..own.limits }, ..own };
        let nearest = AssociationSettings { gate: Some(GATE), ..greedy };
        let views = Encoded::new(looks.model, EncodedSettings::default());
        let latents =
            Encoded::new(looks.model, EncodedSettings { side_exponent: 0.0, ..EncodedSettings::default() });
        let classes = ClassReadout::new(looks.model, &looks.readouts.classes);
        Some(match self {
            Self::Separate => Box::new(Separate),
            Self::Nearest => Box::new(Hypothesizing::new(settings, nearest, Blind)),
            Self::Greedy => Box::new(Hypothesizing::new(settings, greedy, Blind)),
            Self::GreedyLatents => Box::new(Hypothesizing::new(settings, greedy, latents)),
            Self::GreedyEmbedding => {
                let embedded = Embedded::new(looks.embedding?, EmbeddedSettings::default());
                Box::new(Hypothesizing::new(settings, greedy, embedded))
            }
            Self::Em => Box::new(Alternating::new(settings, nearest, latents, Weights::Expected)),
            Self::MaxMixture => Box::new(Alternating::new(settings, nearest, latents, Weights::Largest)),
            Self::Hypotheses => Box::new(Hypothesizing::new(settings, own, Blind)),
            Self::HypothesesClass => {
                let classed = Classed::new(classes, ClassedSettings::default());
                Box::new(Hypothesizing::new(settings, own, classed))
            }
            Self::HypothesesLatents => Box::new(Hypothesizing::new(settings, own, latents)),
            Self::HypothesesViews => Box::new(Hypothesizing::new(settings, own, views)),
        })
    }
}

/// Detections of nothing, a steradian and a step: as the detector is known to err.
fn clutter(camera: &Camera, detector: &DetectorSpec) -> f64 {
    let area = f64::from(camera.width) / camera.fx * f64::from(camera.height) / camera.fy;
    let each = detector.faults.as_ref().map_or(0.0, |faults| faults.false_per_image);
    (each / area).max(LEAST_CLUTTER)
}

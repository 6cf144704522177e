//! The tables of scores on unseen instances: which metrics of which methods stand together.

use super::embedding::Scores;
use crate::result::metric::Metric;
use crate::scene_file::row_name::{MEAN_VIEW, PIXELS};

/// One table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnseenTable {
    /// Its name.
    pub name: &'static str,
    floor: Option<&'static str>,
    metrics: &'static [Metric],
}

/// Clusters of single views with their number given, neighbours, viewpoints.
pub const OF_LATENTS: UnseenTable = UnseenTable {
    name: "latents",
    floor: Some(PIXELS),
    metrics: &[
        Metric::Ari,
        Metric::Nmi,
        Metric::VMeasure,
        Metric::RecallAt1,
        Metric::RecallAt1AcrossLight,
        Metric::ViewpointMedian,
        Metric::ViewpointRight,
    ],
};
/// More of the same.
pub const OF_INSTANCES: UnseenTable = UnseenTable {
    name: "instances",
    floor: Some(PIXELS),
    metrics: &[
        Metric::Homogeneity,
        Metric::Completeness,
        Metric::Purity,
        Metric::Silhouette,
        Metric::RecallAt5,
        Metric::RecallAt5AcrossLight,
        Metric::InstanceRight,
        Metric::InstanceProbability,
    ],
};
/// Clusters whose number is found.
pub const OF_DENSITY: UnseenTable = UnseenTable {
    name: "density",
    floor: Some(PIXELS),
    metrics: &[
        Metric::Ari,
        Metric::VMeasure,
        Metric::Homogeneity,
        Metric::Completeness,
        Metric::Purity,
        Metric::Noise,
        Metric::ClusterCount,
    ],
};
/// Classes from a few tags.
pub const OF_GROUNDING: UnseenTable = UnseenTable {
    name: "grounding",
    floor: Some(PIXELS),
    metrics: &[
        Metric::NearestOf1,
        Metric::NearestOf2,
        Metric::NearestOf5,
        Metric::NearestOf10,
        Metric::GaussianOf2,
        Metric::GaussianOf5,
        Metric::GaussianOf10,
    ],
};
/// Images and azimuths from the decoder.
pub const OF_DECODER: UnseenTable = UnseenTable {
    name: "decoder",
    floor: Some(MEAN_VIEW),
    metrics: &[
        Metric::Psnr,
        Metric::PsnrHeldOut,
        Metric::ViewpointMedian,
        Metric::ViewpointPromised,
        Metric::ViewpointInside,
        Metric::ViewpointByImage,
        Metric::LogLikelihood,
        Metric::Divergence,
    ],
};
/// Residuals against the law that the model claims for them.
pub const OF_CALIBRATION: UnseenTable = UnseenTable {
    name: "calibration",
    floor: None,
    metrics: &[
        Metric::Inside50,
        Metric::Inside80,
        Metric::Inside95,
        Metric::GaussianInside50,
        Metric::GaussianInside95,
        Metric::NumberInside95,
        Metric::WorstNumberInside95,
        Metric::SquaredNormVariance,
    ],
};

/// All of them, as they are printed.
pub const TABLES: [UnseenTable; 6] =
    [OF_LATENTS, OF_INSTANCES, OF_DENSITY, OF_GROUNDING, OF_DECODER, OF_CALIBRATION];

impl UnseenTable {
    /// Its columns.
    pub fn metrics(&self) -> &'static [Metric] {
        self.metrics
    }

    /// The row beside those of models, which they are compared with, if any.
    pub fn floor(&self) -> Option<&'static str> {
        self.floor
    }

    /// Those of some scores that the table shows.
    pub fn shown(&self, scores: &Scores) -> Scores {
        scores.iter().filter(|(metric, _)| self.metrics.contains(metric)).map(|(&m, &v)| (m, v)).collect()
    }
}

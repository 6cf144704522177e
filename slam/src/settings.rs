//! What estimators are told beside observations, grouped by what uses it.

use crate::bearing_offset::BearingOffset;
use crate::domain::DomainPrior;
use crate::factor::UprightFactor;
use crate::noise::{BearingNoise, Kernel, sqrt_information};
use crate::odometry_bias::OdometryBias;
use crate::solve::Limits;
use garde::Validate;
use nalgebra::Matrix6;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::Odometry;
use vantage_dataset::rule::{not_nan, not_negative, positive};
use vantage_dataset::sighting::DIAMETER_PER_BOX;

/// All settings; each estimator takes the groups it has a use for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settings {
    /// Of every estimator.
    pub solver: SolverSettings,
    /// Of every estimator.
    pub odometry: OdometrySettings,
    /// Of those that read boxes.
    pub geometry: GeometrySettings,
    /// Of those that read crops.
    pub semantics: SemanticSettings,
    /// Of those that look for an object's orientation.
    pub orientation: OrientationSettings,
    /// Of those that learn a domain.
    pub domain: DomainPrior,
    /// Of those that learn the last layer of a decoder.
    pub layer: LayerSettings,
}

/// Expectation maximization of a decoder's last layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerSettings {
    /// Rounds on a drive, each from what the drives before taught.
    pub rounds: usize,
}

/// When a problem is solved, and what is told of the solution.
#[derive(Clone, Copy, Debug, PartialEq, Validate)]
pub struct SolverSettings {
    /// Most iterations of Levenberg-Marquardt a problem gets.
    #[garde(skip)]
    pub max_iterations: usize,
    /// Predicted decrease of the cost, relative to it (or to 1 nat where it is less), that counts as none.
    #[garde(custom(positive))]
    pub tolerance: f64,
    /// Whether to compute covariances of poses and objects.
    #[garde(skip)]
    pub covariances: bool,
}

/// Odometry, beside the covariances it comes with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Validate)]
pub struct OdometrySettings {
    /// Prior of the bias, as a variable; none where each covariance's share of it counts as white noise.
    #[garde(dive)]
    pub bias: Option<OdometryBias>,
}

/// Boxes and landmarks' pixels, and what is placed by them.
#[derive(Clone, Copy, Debug, PartialEq, Validate)]
pub struct GeometrySettings {
    /// Noise of the bearings.
    #[garde(dive)]
    pub bearing_noise: BearingNoise,
    /// Prior of the offset of an object's boxes from its centre, as a variable; none where it is left to the noise.
    #[garde(dive)]
    pub bearing_offset: Option<BearingOffset>,
    /// Kernel of the bearings, of depths and of landmarks' pixels.
    #[garde(dive)]
    pub bearing_kernel: Kernel,
    /// Smallest angle, radians, between two rays to an object or landmark that is to be placed.
    #[garde(custom(positive))]
    pub minimum_parallax: f64,
    /// Diameter of an object's bounding sphere over the longer side of its box at the object's distance.
    #[garde(custom(positive))]
    pub size_over_box_side: f64,
    /// Objects as ellipsoids, by the edges of their boxes; centres by bearings alone where left out.
    #[garde(dive)]
    pub extents: Option<ExtentsSettings>,
}

/// The prior of an object's semi-axes: log-normal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct ExtentsSettings {
    /// Median of a semi-axis, metres.
    #[garde(range(min = 1e-3, max = 100.0), custom(not_nan))]
    pub half_axis: f64,
    /// Standard deviation of its logarithm.
    #[garde(range(min = 1e-2, max = 10.0), custom(not_nan))]
    pub log_sigma: f64,
}

/// Semantic factors, and the prior of an object's orientation.
#[derive(Clone, Copy, Debug, PartialEq, Validate)]
pub struct SemanticSettings {
    /// Standard deviation, radians, of an object's tilt about either horizontal axis.
    #[garde(custom(positive))]
    pub tilt_sigma: f64,
    /// Standard deviation, radians, of its yaw about the first one found: wide, but where a model knows no frame of an object.
    #[garde(custom(positive))]
    pub yaw_sigma: f64,
    /// Multiplies the spread of the semantic residual; 1 is the model's own calibration.
    #[garde(custom(positive))]
    pub noise_scale: f64,
    /// Multiplies the log-likelihood of every semantic measurement; 1 is the model's own, 0 says nothing.
    #[garde(custom(not_negative))]
    pub information_scale: f64,
    /// Smallest angle, radians, between the directions from which an object's crop and the one used before it
    /// were taken; 0 uses all.
    #[garde(custom(not_negative))]
    pub minimum_view_separation: f64,
    /// The model's discrepancy; none where it is taken at its word.
    #[garde(dive)]
    pub azimuth_discrepancy: Option<AzimuthDiscrepancy>,
    /// Nats by which an object's views must be less probable under the model than under the null hypothesis for its crops to be left
    /// out; none where no object is asked. See [`crate::unknown_object`].
    #[garde(inner(custom(not_negative)))]
    pub unknown_margin: Option<f64>,
}

/// By how much a model's sense of azimuth is off: a smooth random function of the azimuth, of each object its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct AzimuthDiscrepancy {
    /// Its standard deviation, radians.
    #[garde(range(min = 1e-4, max = 3.2), custom(not_nan))]
    pub sigma: f64,
    /// Concentration `kappa` of its kernel over the azimuth: about one over its squared length in radians.
    #[garde(range(min = 0.0, max = 10.0), custom(not_nan))]
    pub concentration: f64,
}

/// The search for the first orientation of an object.
#[derive(Clone, Copy, Debug, PartialEq, Validate)]
pub struct OrientationSettings {
    /// Yaws tried.
    #[garde(range(min = 1))]
    pub yaw_candidates: usize,
    /// Most views of an object, evenly spread over the track, that score a yaw.
    #[garde(range(min = 1))]
    pub views: usize,
    /// Best modes of the yaw that are refined, the robot held, before one is chosen.
    #[garde(range(min = 1))]
    pub refined_modes: usize,
    /// Margin, nats, below which the second mode of an object is also tried in the full problem.
    #[garde(custom(not_negative))]
    pub ambiguous_margin: f64,
    /// Most objects, the most ambiguous first, whose second mode is tried in the full problem.
    #[garde(skip)]
    pub alternatives: usize,
}

impl OdometrySettings {
    /// The square root of the information of a measurement's white noise; `None` where that has no covariance.
    pub fn sqrt_information(&self, odometry: &Odometry) -> Option<Matrix6<f64>> {
        sqrt_information(&self.bias.map_or(odometry.covariance, |bias| bias.white(odometry)))
    }
}

impl SolverSettings {
    /// When to stop.
    pub fn limits(&self) -> Limits {
        Limits { iterations: self.max_iterations, tolerance: self.tolerance }
    }
}

impl Default for LayerSettings {
    fn default() -> Self {
        Self { rounds: 2 }
    }
}

impl Default for SolverSettings {
    fn default() -> Self {
        Self { max_iterations: 100, tolerance: 1e-6, covariances: true }
    }
}

impl Default for GeometrySettings {
    fn default() -> Self {
        Self {
            bearing_noise: BearingNoise { fixed: 0.003, proportional: 0.05 },
            bearing_offset: None,
            bearing_kernel: Kernel::Huber { threshold: 2.0 },
            minimum_parallax: 0.03,
            size_over_box_side: DIAMETER_PER_BOX,
            extents: None,
        }
    }
}

impl Default for SemanticSettings {
    fn default() -> Self {
        Self {
            tilt_sigma: 0.05,
            yaw_sigma: UprightFactor::FREE_YAW,
            noise_scale: 1.0,
            information_scale: 1.0,
            minimum_view_separation: 0.0,
            azimuth_discrepancy: None,
            unknown_margin: None,
        }
    }
}

impl Default for OrientationSettings {
    fn default() -> Self {
        Self { yaw_candidates: 48, views: 16, refined_modes: 4, ambiguous_margin: 5.0, alternatives: 3 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_valid_and_numbers_that_are_none_are_refused_by_name() {
        let Settings { solver, odometry, geometry, semantics, orientation, domain: _, layer: _ } =
            Settings::default();
        assert!(solver.validate().is_ok() && odometry.validate().is_ok() && geometry.validate().is_ok());
        assert!(semantics.validate().is_ok() && orientation.validate().is_ok());
        let told = |settings: &dyn Fn() -> Result<(), garde::Report>| settings().unwrap_err().to_string();
        for bad in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
            let report = told(&|| SemanticSettings { tilt_sigma: bad, ..semantics }.validate());
            assert!(report.contains("tilt_sigma"), "{report}");
            let report = told(&|| SolverSettings { tolerance: bad, ..solver }.validate());
            assert!(report.contains("tolerance"), "{report}");
        }
        assert!(SemanticSettings { information_scale: 0.0, ..semantics }.validate().is_ok());
        assert!(SemanticSettings { information_scale: f64::NAN, ..semantics }.validate().is_err());
        assert!(OrientationSettings { yaw_candidates: 0, ..orientation }.validate().is_err());
        let bearing_noise = BearingNoise { fixed: 0.0, proportional: 0.0 };
        assert!(GeometrySettings { bearing_noise, ..geometry }.validate().is_err());
        for length in [0.0, f64::NAN, f64::INFINITY] {
            let bearing_offset =
                Some(BearingOffset { horizontal: 0.02, vertical: 0.02, length, smoothness: 2.0 });
            assert!(GeometrySettings { bearing_offset, ..geometry }.validate().is_err(), "{length}");
        }
        let bias = Some(OdometryBias { translation_per_metre: f64::NAN, rotation_deg_per_metre: 0.1 });
        assert!(OdometrySettings { bias }.validate().is_err());
    }
}

//! `estimator`: the rows of a scene, and their settings.

use super::row::Row;
use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::rule::not_nan;
use vantage_slam::bearing_offset::BearingOffset;
use vantage_slam::noise::{BearingNoise, Kernel};
use vantage_slam::odometry_bias::OdometryBias;
use vantage_slam::{
    AzimuthDiscrepancy, DomainPrior, ExtentsSettings, GeometrySettings, LayerSettings, OdometrySettings,
    OrientationSettings, SemanticSettings, Settings, SolverSettings,
};

/// Settings of the estimator; every field has a default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields, default)]
pub struct EstimatorSpec {
    /// The rows to estimate. Default: all but `gaussian_process`, `azimuth_head`, `discrete_class`, `viewpoint_pairs`, `noise_refitted`, `object_process`, `process_refitted`, `domain_adapted`, `decoder_adapted`, `decoder_checked`,
    /// `decoder_taught`, `learning_checked` and `ideal_azimuth`.
    #[garde(length(min = 1), custom(each_once))]
    #[schemars(extend("uniqueItems" = true))]
    pub rows: Vec<Row>,
    /// Most iterations of Levenberg-Marquardt a problem gets. Default: 100.
    #[garde(range(min = 1, max = 100_000))]
    pub max_iterations: usize,
    /// Predicted decrease of the cost, relative to it (or to 1 nat where it is less), at which the estimator
    /// has converged. Default: 1e-6, well above what the rounding of networks in `f32` does to the cost.
    #[garde(range(min = 1e-14, max = 1e-2), custom(not_nan))]
    pub tolerance: f64,
    /// Whether to compute covariances of poses and objects. Default: true.
    #[garde(skip)]
    pub covariances: bool,

    /// Prior of odometry's bias as a variable: what the robot's data sheet says. The covariance of each step is then less by the
    /// bias's share. Default: none, so that the bias counts as white noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[garde(dive)]
    pub odometry_bias: Option<OdometryBias>,

    /// Noise of the bearings. Default: 0.003 fixed, 0.05 per angular size of the box.
    #[garde(dive)]
    pub bearing_noise: BearingNoise,
    /// Prior of the offset of an object's boxes from its centre as a variable, a smooth function of the azimuth. `bearing_noise` is
    /// then what is left. Default: none, so that `bearing_noise` holds the offset too.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[garde(dive, custom(without_edges(&self.extents)))]
    pub bearing_offset: Option<BearingOffset>,
    /// Kernel of the bearings, of depths and of landmarks' pixels. Default: Huber with threshold 2.
    #[garde(dive)]
    pub bearing_kernel: Kernel,
    /// Smallest angle, radians, between two rays to an object or landmark that is to be placed. Default: 0.03.
    #[garde(range(min = 1e-4, max = 3.0), custom(not_nan))]
    pub minimum_parallax: f64,
    /// The prior of the semi-axes of objects that are ellipsoids, estimated from all edges of their boxes. Default: left out, and
    /// objects are centres by bearings.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[garde(dive)]
    pub extents: Option<ExtentsSettings>,

    /// Standard deviation, radians, of an object's tilt about either horizontal axis. Default: 0.05.
    #[garde(range(min = 1e-4, max = 10.0), custom(not_nan))]
    pub tilt_sigma: f64,
    /// Diameter of an object's bounding sphere over the longer side of its box at the object's distance:
    /// how the robot learns the size that the viewpoint's distance is measured in. Default: 1.1.
    #[garde(range(min = 0.1, max = 10.0), custom(not_nan))]
    pub size_over_box_side: f64,
    /// Multiplies the spread of the semantic residual; 1 is the model's own calibration. Default: 1.
    #[garde(range(min = 1e-3, max = 1e3), custom(not_nan))]
    pub semantic_noise_scale: f64,
    /// Multiplies the log-likelihood of every semantic measurement; less than 1 where neighbouring views
    /// repeat each other's error. Default: 1.
    #[garde(range(min = 0.0, max = 1e3), custom(not_nan))]
    pub semantic_information_scale: f64,
    /// Smallest angle, radians, between the directions from which an object's crop and the one used before it were taken;
    /// 0 uses all. Default: 0.
    #[garde(range(min = 0.0, max = 3.2), custom(not_nan))]
    pub minimum_view_separation: f64,
    /// By how much the model's sense of azimuth is off, alike in neighbouring views of an object. Default: not at all.
    #[garde(dive)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub azimuth_discrepancy: Option<AzimuthDiscrepancy>,
    /// Leaves out the crops of an object that the model does not know: whose views are less probable under it, by at least so many nats
    /// (0 to 1e6), than under a null hypothesis that knows no kinds. Default: none are left out.
    #[garde(inner(range(min = 0.0, max = 1e6), custom(not_nan)))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unknown_margin: Option<f64>,

    /// How far an episode may differ from what the model was trained on, for `domain_adapted` and `learning_checked`. Default: an offset of the model's noise, a
    /// gain of a tenth.
    #[garde(dive)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub domain: Option<DomainPrior>,
    /// Rounds of expectation maximization on a drive, for `decoder_adapted` and `decoder_checked`. Default: 2.
    #[garde(inner(range(min = 1, max = 100)))]
    #[schemars(range(min = 1, max = 100))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decoder_rounds: Option<usize>,

    /// Yaws tried for an object's first orientation. Default: 48.
    #[garde(range(min = 8, max = 3600))]
    pub yaw_candidates: usize,
    /// Most views of an object, evenly spread over the track, that score its first orientation. Default: 16.
    #[garde(range(min = 1, max = 100_000))]
    pub orientation_views: usize,
    /// Best modes of the yaw that are refined, the robot held, before one is chosen. Default: 4.
    #[garde(range(min = 1, max = 100))]
    pub refined_modes: usize,
    /// Margin, nats, below which the second mode of an object is also tried in the full problem. Default: 5.
    #[garde(range(min = 0.0, max = 1e6), custom(not_nan))]
    pub ambiguous_margin: f64,
    /// Most objects, the most ambiguous first, whose second mode is tried in the full problem. Default: 3.
    #[garde(range(max = 1000))]
    pub alternatives: usize,
}

impl EstimatorSpec {
    /// The same of one row, without a setting that it has no use for.
    pub fn of_row(&self, row: Row) -> Self {
        let decoder_rounds = self.decoder_rounds.filter(|_| row.learns_in_rounds());
        Self { rows: vec![row], decoder_rounds, ..self.clone() }
    }

    /// The settings as estimators take them.
    pub fn settings(&self) -> Settings {
        Settings {
            solver: SolverSettings {
                max_iterations: self.max_iterations,
                tolerance: self.tolerance,
                covariances: self.covariances,
            },
            odometry: OdometrySettings { bias: self.odometry_bias },
            geometry: GeometrySettings {
                bearing_noise: self.bearing_noise,
                bearing_offset: self.bearing_offset,
                bearing_kernel: self.bearing_kernel,
                minimum_parallax: self.minimum_parallax,
                size_over_box_side: self.size_over_box_side,
                extents: self.extents,
            },
            semantics: SemanticSettings {
                tilt_sigma: self.tilt_sigma,
                yaw_sigma: SemanticSettings::default().yaw_sigma,
                noise_scale: self.semantic_noise_scale,
                information_scale: self.semantic_information_scale,
                minimum_view_separation: self.minimum_view_separation,
                azimuth_discrepancy: self.azimuth_discrepancy,
                unknown_margin: self.unknown_margin,
            },
            orientation: OrientationSettings {
                yaw_candidates: self.yaw_candidates,
                views: self.orientation_views,
                refined_modes: self.refined_modes,
                ambiguous_margin: self.ambiguous_margin,
                alternatives: self.alternatives,
            },
            domain: self.domain.unwrap_or_default(),
            layer: self.decoder_rounds.map_or_else(LayerSettings::default, |rounds| LayerSettings { rounds }),
        }
    }
}

fn each_once(rows: &[Row], (): &()) -> garde::Result {
    let twice = rows.iter().enumerate().find(|(i, row)| rows[..*i].contains(row));
    twice.map_or(Ok(()), |(_, row)| {
        Err(garde::Error::new(format!("{row} stands there twice: name each row once")))
    })
}

fn without_edges(
    extents: &Option<ExtentsSettings>,
) -> impl FnOnce(&Option<BearingOffset>, &()) -> garde::Result + '_ {
    move |offset, ()| match (offset, extents) {
        (Some(_), Some(_)) => Err(garde::Error::new(
            "is there beside `extents`, whose objects have the edges of their boxes in place of bearings: leave one out",
        )),
        _ => Ok(()),
    }
}

impl Default for EstimatorSpec {
    fn default() -> Self {
        let Settings { solver, odometry, geometry, semantics, orientation, domain: _, layer: _ } =
            Settings::default();
        Self {
            rows: Row::DEFAULT.to_vec(),
            max_iterations: solver.max_iterations,
            tolerance: solver.tolerance,
            covariances: solver.covariances,
            odometry_bias: odometry.bias,
            bearing_noise: geometry.bearing_noise,
            bearing_offset: geometry.bearing_offset,
            bearing_kernel: geometry.bearing_kernel,
            minimum_parallax: geometry.minimum_parallax,
            extents: geometry.extents,
            tilt_sigma: semantics.tilt_sigma,
            size_over_box_side: geometry.size_over_box_side,
            semantic_noise_scale: semantics.noise_scale,
            semantic_information_scale: semantics.information_scale,
            minimum_view_separation: semantics.minimum_view_separation,
            azimuth_discrepancy: semantics.azimuth_discrepancy,
            unknown_margin: semantics.unknown_margin,
            domain: None,
            decoder_rounds: None,
            yaw_candidates: orientation.yaw_candidates,
            orientation_views: orientation.views,
            refined_modes: orientation.refined_modes,
            ambiguous_margin: orientation.ambiguous_margin,
            alternatives: orientation.alternatives,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_parts_and_refuses_what_it_does_not_know() {
        let spec: EstimatorSpec = serde_json::from_str(
            r#"{"rows": ["geometric"], "bearing_kernel": {"student_t": {"degrees_of_freedom": 4.0}}}"#,
        )
        .unwrap();
        assert_eq!(spec.rows, [Row::Geometric]);
        assert_eq!(spec.bearing_kernel, Kernel::StudentT { degrees_of_freedom: 4.0 });
        assert_eq!(spec.max_iterations, EstimatorSpec::default().max_iterations);
        assert!(spec.validate().is_ok());
        assert_eq!(spec.settings().geometry.bearing_kernel, spec.bearing_kernel);
        let rounds = EstimatorSpec { decoder_rounds: Some(5), ..spec.clone() };
        assert_eq!((rounds.settings().layer.rounds, spec.settings().layer.rounds), (5, 2));
        assert_eq!(rounds.of_row(Row::Geometric), spec.of_row(Row::Geometric), "it has no rounds");
        assert_ne!(rounds.of_row(Row::DecoderChecked), spec.of_row(Row::DecoderChecked));
        assert_eq!(EstimatorSpec::default().settings(), Settings::default());
        for unknown in
            [r#"{"iterations": 3}"#, r#"{"bearing_noise": {"fixed": 0.1, "proportional": 0, "x": 1}}"#]
        {
            assert!(serde_json::from_str::<EstimatorSpec>(unknown).is_err(), "{unknown}");
        }
        let text = serde_json::to_string(&spec).unwrap();
        assert_eq!(serde_json::from_str::<EstimatorSpec>(&text).unwrap(), spec);
    }

    #[test]
    fn refuses_numbers_out_of_range() {
        let ok = EstimatorSpec::default();
        assert!(ok.validate().is_ok());
        let offset = Some(BearingOffset { horizontal: 0.1, vertical: 0.1, length: 1.0, smoothness: 1.5 });
        let extents = Some(ExtentsSettings { half_axis: 0.1, log_sigma: 0.5 });
        assert!(EstimatorSpec { bearing_offset: offset, ..ok.clone() }.validate().is_ok());
        assert!(EstimatorSpec { extents, ..ok.clone() }.validate().is_ok());
        let bad = [
            EstimatorSpec { tilt_sigma: f64::NAN, ..ok.clone() },
            EstimatorSpec { tolerance: 0.0, ..ok.clone() },
            EstimatorSpec { rows: vec![], ..ok.clone() },
            EstimatorSpec { rows: vec![Row::Geometric, Row::Odometry, Row::Geometric], ..ok.clone() },
            EstimatorSpec { bearing_offset: offset, extents, ..ok.clone() },
            EstimatorSpec { semantic_information_scale: -1.0, ..ok.clone() },
            EstimatorSpec { unknown_margin: Some(f64::NAN), ..ok.clone() },
            EstimatorSpec { unknown_margin: Some(-1.0), ..ok.clone() },
            EstimatorSpec { decoder_rounds: Some(0), ..ok.clone() },
            EstimatorSpec { decoder_rounds: Some(101), ..ok.clone() },
            EstimatorSpec { bearing_noise: BearingNoise { fixed: 0.0, proportional: 0.0 }, ..ok.clone() },
            EstimatorSpec { bearing_kernel: Kernel::Huber { threshold: f64::NAN }, ..ok.clone() },
            EstimatorSpec { extents: Some(ExtentsSettings { half_axis: 0.0, log_sigma: 0.5 }), ..ok },
        ];
        for spec in bad {
            assert!(spec.validate().is_err(), "{spec:?}");
        }
    }
}

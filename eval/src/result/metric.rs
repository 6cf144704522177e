//! The metrics of the tables: name, unit, direction and how they are printed.

use serde::{Deserialize, Serialize};

/// A column of a result table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Metric {
    /// Absolute trajectory error, first pose aligned: [`crate::score::ate::ate`].
    Ate,
    /// Absolute trajectory error, all positions aligned: [`crate::score::ate::ate_umeyama`].
    AteUmeyama,
    /// Translation part of the relative pose error over one step: [`crate::score::rpe::rpe`].
    RpeTranslation,
    /// Rotation part of the relative pose error over one step.
    RpeRotation,
    /// Yaw error: [`crate::score::heading::heading_error`].
    Heading,
    /// Distance of object centres: [`crate::score::object::object_errors`].
    ObjectCenter,
    /// Orientation error of objects modulo symmetry.
    ObjectOrientation,
    /// Adjusted Rand index: [`crate::score::clustering::cluster_scores`].
    Ari,
    /// Normalized mutual information.
    Nmi,
    /// V-measure.
    VMeasure,
    /// Homogeneity.
    Homogeneity,
    /// Completeness.
    Completeness,
    /// Purity.
    Purity,
    /// Recall@1: [`crate::score::retrieval::recall_at`].
    RecallAt1,
    /// Recall@1 where the match has to come from another lighting session.
    RecallAt1AcrossLight,
    /// Recall@5.
    RecallAt5,
    /// Median azimuth error: [`crate::score::viewpoint::summarize`].
    ViewpointMedian,
    /// Share of azimuth errors under 15 degrees.
    ViewpointRight,
    /// Recall@5 where the matches have to come from another lighting session.
    RecallAt5AcrossLight,
    /// Silhouette of the true instances: [`crate::score::silhouette::silhouette`].
    Silhouette,
    /// Share of views under other light whose most likely known instance is the right one:
    /// [`crate::score::instance_posterior::instance_posterior`].
    InstanceRight,
    /// Mean probability of the right known instance.
    InstanceProbability,
    /// Share of embeddings that HDBSCAN puts in no cluster: [`crate::score::density::density_clusters`].
    Noise,
    /// By how much the number of clusters that HDBSCAN finds is off, over the number of instances.
    ClusterCount,
    /// Class accuracy by the nearest of one tagged image a class: [`crate::score::grounding::ground`].
    NearestOf1,
    /// By the nearest of two.
    NearestOf2,
    /// By the nearest of five.
    NearestOf5,
    /// By the nearest of ten.
    NearestOf10,
    /// Class accuracy by Gaussians about the mean of two tagged images a class.
    GaussianOf2,
    /// Of five.
    GaussianOf5,
    /// Of ten.
    GaussianOf10,
    /// PSNR of a view by the latent of that view alone: [`crate::score::psnr::psnr`].
    Psnr,
    /// PSNR of a view by the latent of views of other sessions.
    PsnrHeldOut,
    /// Median of the deviation that the likelihood promises of the azimuth:
    /// [`crate::score::azimuth_information::promised_deviation`].
    ViewpointPromised,
    /// Share of azimuth errors within 1.96 promised deviations.
    ViewpointInside,
    /// Median azimuth error where all pixels of the predicted image are compared, not the reduced measurement; one view an instance.
    ViewpointByImage,
    /// Mean log-likelihood of a reduced measurement by the latent of views of other sessions: [`crate::score::bound`].
    LogLikelihood,
    /// Mean divergence of what a single view says of the latent from the prior.
    Divergence,
    /// Share of residuals inside the region of 50% of the Student t: [`crate::score::calibration::calibration`].
    Inside50,
    /// Inside that of 80%.
    Inside80,
    /// Inside that of 95%.
    Inside95,
    /// Share of residuals inside the region of 50% of the Gaussian of the same covariance.
    GaussianInside50,
    /// Inside that of 95%.
    GaussianInside95,
    /// Share of single whitened numbers inside their interval of 95%.
    NumberInside95,
    /// Of the whitened number for which that share is farthest from 95%.
    WorstNumberInside95,
    /// Variance of the squared whitened norm over that of the law.
    SquaredNormVariance,
}

/// What a metric is measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Metres.
    Meter,
    /// Radians in files, degrees in tables.
    Radian,
    /// Decibels.
    Decibel,
    /// Natural units of information.
    Nat,
    /// A share or index without unit.
    Ratio,
}

/// Which way a metric is better.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Better {
    /// Errors.
    Lower,
    /// Shares of right answers.
    Higher,
    /// Shares that a law says: the nearer, the better.
    Near(f64),
}

impl Metric {
    /// All metrics, in the order of their declaration.
    pub const ALL: [Metric; 46] = [
        Metric::Ate,
        Metric::AteUmeyama,
        Metric::RpeTranslation,
        Metric::RpeRotation,
        Metric::Heading,
        Metric::ObjectCenter,
        Metric::ObjectOrientation,
        Metric::Ari,
        Metric::Nmi,
        Metric::VMeasure,
        Metric::Homogeneity,
        Metric::Completeness,
        Metric::Purity,
        Metric::RecallAt1,
        Metric::RecallAt1AcrossLight,
        Metric::RecallAt5,
        Metric::ViewpointMedian,
        Metric::ViewpointRight,
        Metric::RecallAt5AcrossLight,
        Metric::Silhouette,
        Metric::InstanceRight,
        Metric::InstanceProbability,
        Metric::Noise,
        Metric::ClusterCount,
        Metric::NearestOf1,
        Metric::NearestOf2,
        Metric::NearestOf5,
        Metric::NearestOf10,
        Metric::GaussianOf2,
        Metric::GaussianOf5,
        Metric::GaussianOf10,
        Metric::Psnr,
        Metric::PsnrHeldOut,
        Metric::ViewpointPromised,
        Metric::ViewpointInside,
        Metric::ViewpointByImage,
        Metric::LogLikelihood,
        Metric::Divergence,
        Metric::Inside50,
        Metric::Inside80,
        Metric::Inside95,
        Metric::GaussianInside50,
        Metric::GaussianInside95,
        Metric::NumberInside95,
        Metric::WorstNumberInside95,
        Metric::SquaredNormVariance,
    ];

    /// Its name in tables, that in files, its unit, and which way it is better.
    fn facts(self) -> (&'static str, &'static str, Unit, Better) {
        use Better::{Higher, Lower, Near};
        use Unit::{Decibel, Meter, Nat, Radian, Ratio};
        match self {
            Metric::Ate => ("ATE", "ate_m", Meter, Lower),
            Metric::AteUmeyama => ("ATE (Umeyama)", "ate_umeyama_m", Meter, Lower),
            Metric::RpeTranslation => ("RPE transl.", "rpe_translation_m", Meter, Lower),
            Metric::RpeRotation => ("RPE rot.", "rpe_rotation_rad", Radian, Lower),
            Metric::Heading => ("Heading", "heading_rad", Radian, Lower),
            Metric::ObjectCenter => ("Object centre", "object_center_m", Meter, Lower),
            Metric::ObjectOrientation => ("Object orient.", "object_orientation_rad", Radian, Lower),
            Metric::Ari => ("ARI", "ari", Ratio, Higher),
            Metric::Nmi => ("NMI", "nmi", Ratio, Higher),
            Metric::VMeasure => ("V-measure", "v_measure", Ratio, Higher),
            Metric::Homogeneity => ("Homogeneity", "homogeneity", Ratio, Higher),
            Metric::Completeness => ("Completeness", "completeness", Ratio, Higher),
            Metric::Purity => ("Purity", "purity", Ratio, Higher),
            Metric::RecallAt1 => ("Recall@1", "recall_at_1", Ratio, Higher),
            Metric::RecallAt1AcrossLight => {
                ("Recall@1, other light", "recall_at_1_other_light", Ratio, Higher)
            }
            Metric::RecallAt5 => ("Recall@5", "recall_at_5", Ratio, Higher),
            Metric::ViewpointMedian => ("Viewpoint median", "viewpoint_median_rad", Radian, Lower),
            Metric::ViewpointRight => ("Viewpoint < 15 deg", "viewpoint_right", Ratio, Higher),
            Metric::RecallAt5AcrossLight => {
                ("Recall@5, other light", "recall_at_5_other_light", Ratio, Higher)
            }
            Metric::Silhouette => ("Silhouette", "silhouette", Ratio, Higher),
            Metric::InstanceRight => ("Instance right", "instance_right", Ratio, Higher),
            Metric::InstanceProbability => ("P(instance)", "instance_probability", Ratio, Higher),
            Metric::Noise => ("Noise", "noise", Ratio, Lower),
            Metric::ClusterCount => ("Clusters off by", "cluster_count_error", Ratio, Lower),
            Metric::NearestOf1 => ("NN, 1 tag", "class_nearest_of_1", Ratio, Higher),
            Metric::NearestOf2 => ("NN, 2 tags", "class_nearest_of_2", Ratio, Higher),
            Metric::NearestOf5 => ("NN, 5 tags", "class_nearest_of_5", Ratio, Higher),
            Metric::NearestOf10 => ("NN, 10 tags", "class_nearest_of_10", Ratio, Higher),
            Metric::GaussianOf2 => ("Gaussian, 2 tags", "class_gaussian_of_2", Ratio, Higher),
            Metric::GaussianOf5 => ("Gaussian, 5 tags", "class_gaussian_of_5", Ratio, Higher),
            Metric::GaussianOf10 => ("Gaussian, 10 tags", "class_gaussian_of_10", Ratio, Higher),
            Metric::Psnr => ("PSNR, own view", "psnr_db", Decibel, Higher),
            Metric::PsnrHeldOut => ("PSNR, held out", "psnr_held_out_db", Decibel, Higher),
            Metric::ViewpointPromised => ("Promised deviation", "viewpoint_promised_rad", Radian, Lower),
            Metric::ViewpointInside => ("Error < 1.96 promised", "viewpoint_inside", Ratio, Near(0.95)),
            Metric::ViewpointByImage => {
                ("Viewpoint median, image", "viewpoint_median_image_rad", Radian, Lower)
            }
            Metric::LogLikelihood => ("Log-likelihood, held out", "log_likelihood_held_out_nat", Nat, Higher),
            Metric::Divergence => ("Divergence, own view", "divergence_nat", Nat, Lower),
            Metric::Inside50 => ("In 50%", "residual_inside_50", Ratio, Near(0.5)),
            Metric::Inside80 => ("In 80%", "residual_inside_80", Ratio, Near(0.8)),
            Metric::Inside95 => ("In 95%", "residual_inside_95", Ratio, Near(0.95)),
            Metric::GaussianInside50 => ("Gaussian: in 50%", "residual_gaussian_inside_50", Ratio, Near(0.5)),
            Metric::GaussianInside95 => {
                ("Gaussian: in 95%", "residual_gaussian_inside_95", Ratio, Near(0.95))
            }
            Metric::NumberInside95 => ("Number in 95%", "residual_number_inside_95", Ratio, Near(0.95)),
            Metric::WorstNumberInside95 => {
                ("Worst number in 95%", "residual_worst_number_inside_95", Ratio, Near(0.95))
            }
            Metric::SquaredNormVariance => {
                ("Var of norm^2 / law", "residual_squared_norm_variance", Ratio, Near(1.0))
            }
        }
    }

    /// Its name in a table's head, without unit.
    pub fn label(self) -> &'static str {
        self.facts().0
    }

    /// Its name in a CSV head, with the unit of the file.
    pub fn column(self) -> &'static str {
        self.facts().1
    }

    /// Its unit.
    pub fn unit(self) -> Unit {
        self.facts().2
    }

    /// Which way it is better.
    pub fn better(self) -> Better {
        self.facts().3
    }

    /// Whether a run's score is the one farthest from its target, on whichever side: in a mean over runs such scores cancel.
    pub fn is_either_extreme(self) -> bool {
        self == Metric::WorstNumberInside95
    }

    /// Whether it is of one view of each instance, where others are of all views.
    pub fn is_of_one_view(self) -> bool {
        self == Metric::ViewpointByImage
    }

    /// Whether another column beside it always says the same: NMI by the arithmetic mean is V-measure.
    pub fn is_repeated(self) -> bool {
        self == Metric::Nmi
    }

    /// Which way it is better, as an arrow; nothing where it has a target.
    pub fn arrow(self) -> &'static str {
        match self.better() {
            Better::Lower => " ↓",
            Better::Higher => " ↑",
            Better::Near(_) => "",
        }
    }

    /// Its name and the unit that tables print, e.g. `Heading [deg]`.
    pub fn heading(self) -> String {
        match self.unit() {
            Unit::Meter => format!("{} [m]", self.label()),
            Unit::Radian => format!("{} [deg]", self.label()),
            Unit::Decibel => format!("{} [dB]", self.label()),
            Unit::Nat => format!("{} [nat]", self.label()),
            Unit::Ratio => self.label().to_owned(),
        }
    }

    /// A value in the unit that tables have.
    pub fn in_table(self, value: f64) -> f64 {
        if self.unit() == Unit::Radian { value.to_degrees() } else { value }
    }

    /// A value as tables print it: metres to 0.1 mm, degrees to 0.001, decibels and nats to 0.01, shares to 0.001.
    pub fn display(self, value: f64) -> String {
        let digits = match self.unit() {
            Unit::Meter => 4,
            Unit::Radian | Unit::Ratio => 3,
            Unit::Decibel | Unit::Nat => 2,
        };
        let text = format!("{:.digits$}", self.in_table(value));
        let is_negative_zero = text.starts_with('-') && text.bytes().all(|b| b"-0.".contains(&b));
        if is_negative_zero { text[1..].to_owned() } else { text }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_and_tables_name_each_metric_once() {
        let columns: std::collections::BTreeSet<_> = Metric::ALL.iter().map(|m| m.column()).collect();
        let labels: std::collections::BTreeSet<_> = Metric::ALL.iter().map(|m| m.label()).collect();
        assert_eq!((columns.len(), labels.len()), (Metric::ALL.len(), Metric::ALL.len()));
        for metric in Metric::ALL {
            let suffix = match metric.unit() {
                Unit::Meter => "_m",
                Unit::Radian => "_rad",
                Unit::Decibel => "_db",
                Unit::Nat => "_nat",
                Unit::Ratio => "",
            };
            assert!(metric.column().ends_with(suffix), "{metric:?}");
        }
    }

    #[test]
    fn angles_are_printed_in_degrees_and_zero_without_sign() {
        assert_eq!(Metric::Heading.display(std::f64::consts::PI), "180.000");
        assert_eq!(Metric::Ate.display(-0.000_01), "0.0000");
        assert_eq!(Metric::Ate.display(-0.000_1), "-0.0001");
        assert_eq!(Metric::Ari.display(1.0), "1.000");
    }
}

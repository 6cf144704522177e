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
}

/// What a metric is measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Metres.
    Meter,
    /// Radians in files, degrees in tables.
    Radian,
    /// A share or index without unit.
    Ratio,
}

/// Which way a metric is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Better {
    /// Errors.
    Lower,
    /// Shares of right answers.
    Higher,
}

impl Metric {
    /// All metrics, in the order of their columns.
    pub const ALL: [Metric; 18] = [
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
    ];

    /// Its name in a table's head, without unit.
    pub fn label(self) -> &'static str {
        match self {
            Metric::Ate => "ATE",
            Metric::AteUmeyama => "ATE (Umeyama)",
            Metric::RpeTranslation => "RPE transl.",
            Metric::RpeRotation => "RPE rot.",
            Metric::Heading => "Heading",
            Metric::ObjectCenter => "Object centre",
            Metric::ObjectOrientation => "Object orient.",
            Metric::Ari => "ARI",
            Metric::Nmi => "NMI",
            Metric::VMeasure => "V-measure",
            Metric::Homogeneity => "Homogeneity",
            Metric::Completeness => "Completeness",
            Metric::Purity => "Purity",
            Metric::RecallAt1 => "Recall@1",
            Metric::RecallAt1AcrossLight => "Recall@1, other light",
            Metric::RecallAt5 => "Recall@5",
            Metric::ViewpointMedian => "Viewpoint median",
            Metric::ViewpointRight => "Viewpoint < 15 deg",
        }
    }

    /// Its name in a CSV head, with the unit of the file.
    pub fn column(self) -> &'static str {
        match self {
            Metric::Ate => "ate_m",
            Metric::AteUmeyama => "ate_umeyama_m",
            Metric::RpeTranslation => "rpe_translation_m",
            Metric::RpeRotation => "rpe_rotation_rad",
            Metric::Heading => "heading_rad",
            Metric::ObjectCenter => "object_center_m",
            Metric::ObjectOrientation => "object_orientation_rad",
            Metric::Ari => "ari",
            Metric::Nmi => "nmi",
            Metric::VMeasure => "v_measure",
            Metric::Homogeneity => "homogeneity",
            Metric::Completeness => "completeness",
            Metric::Purity => "purity",
            Metric::RecallAt1 => "recall_at_1",
            Metric::RecallAt1AcrossLight => "recall_at_1_other_light",
            Metric::RecallAt5 => "recall_at_5",
            Metric::ViewpointMedian => "viewpoint_median_rad",
            Metric::ViewpointRight => "viewpoint_right",
        }
    }

    /// Its unit.
    pub fn unit(self) -> Unit {
        match self {
            Metric::Ate | Metric::AteUmeyama | Metric::RpeTranslation | Metric::ObjectCenter => Unit::Meter,
            Metric::RpeRotation | Metric::Heading | Metric::ObjectOrientation | Metric::ViewpointMedian => {
                Unit::Radian
            }
            _ => Unit::Ratio,
        }
    }

    /// Which way it is better.
    pub fn better(self) -> Better {
        match self.unit() {
            Unit::Meter | Unit::Radian => Better::Lower,
            Unit::Ratio => Better::Higher,
        }
    }

    /// Its name and the unit that tables print, e.g. `Heading [deg]`.
    pub fn heading(self) -> String {
        match self.unit() {
            Unit::Meter => format!("{} [m]", self.label()),
            Unit::Radian => format!("{} [deg]", self.label()),
            Unit::Ratio => self.label().to_owned(),
        }
    }

    /// A value as tables print it: metres to 0.1 mm, degrees to 0.001, shares to 0.001.
    pub fn display(self, value: f64) -> String {
        let (value, digits) = match self.unit() {
            Unit::Meter => (value, 4),
            Unit::Radian => (value.to_degrees(), 3),
            Unit::Ratio => (value, 3),
        };
        let text = format!("{value:.digits$}");
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

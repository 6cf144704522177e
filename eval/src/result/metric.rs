//! The metrics of the tables: name, unit, direction and how they are printed.

use super::better::Better;
use super::unit::Unit;
use serde::{Deserialize, Serialize};

/// Declares [`Metric`]: what each is, its name in tables, that in files, its unit, and which way it is better.
macro_rules! metrics {
    ($($(#[$what:meta])* $metric:ident => $label:literal, $column:literal, $unit:ident, $better:expr;)*) => {
        /// A column of a result table.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum Metric {
            $(#[doc = concat!($label, ".")] $(#[$what])* $metric,)*
        }

        impl Metric {
            #[cfg(test)]
            const ALL: &[Metric] = &[$(Metric::$metric),*];

            fn facts(self) -> (&'static str, &'static str, Unit, Better) {
                use Better::{Higher, Lower, Near};
                match self {
                    $(Metric::$metric => ($label, $column, Unit::$unit, $better),)*
                }
            }
        }
    };
}

metrics! {
    /// Absolute trajectory error, first pose aligned: [`crate::score::ate::ate`].
    Ate => "ATE", "ate_m", Meter, Lower;
    /// Absolute trajectory error, all positions aligned: [`crate::score::ate::ate_umeyama`].
    AteUmeyama => "ATE (Umeyama)", "ate_umeyama_m", Meter, Lower;
    /// Translation part of the relative pose error over one step: [`crate::score::rpe::rpe`].
    RpeTranslation => "RPE transl.", "rpe_translation_m", Meter, Lower;
    /// Rotation part of the relative pose error over one step.
    RpeRotation => "RPE rot.", "rpe_rotation_rad", Radian, Lower;
    /// Yaw error: [`crate::score::heading::heading_error`].
    Heading => "Heading", "heading_rad", Radian, Lower;
    /// Distance of object centres: [`crate::score::object::object_errors`].
    ObjectCenter => "Object centre", "object_center_m", Meter, Lower;
    /// Orientation error of objects modulo symmetry.
    ObjectOrientation => "Object orient.", "object_orientation_rad", Radian, Lower;
    /// Distance of point landmarks: [`crate::score::landmark::landmark_error`].
    Landmark => "Landmark", "landmark_m", Meter, Lower;
    /// Half the width of objects along their axes: [`crate::score::extents::extents_error`].
    Extents => "Extents", "extents_m", Meter, Lower;
    /// Adjusted Rand index: [`crate::score::clustering::cluster_scores`].
    Ari => "ARI", "ari", Ratio, Higher;
    /// Adjusted mutual information: [`crate::score::adjusted_information::adjusted_information`].
    Ami => "AMI", "ami", Ratio, Higher;
    /// Normalized mutual information.
    Nmi => "NMI", "nmi", Ratio, Higher;
    VMeasure => "V-measure", "v_measure", Ratio, Higher;
    Homogeneity => "Homogeneity", "homogeneity", Ratio, Higher;
    Completeness => "Completeness", "completeness", Ratio, Higher;
    Purity => "Purity", "purity", Ratio, Higher;
    /// Recall@1: [`crate::score::retrieval::recall_at`].
    RecallAt1 => "Recall@1", "recall_at_1", Ratio, Higher;
    /// Recall@1 where the match has to come from another lighting session.
    RecallAt1AcrossLight => "Recall@1, other light", "recall_at_1_other_light", Ratio, Higher;
    RecallAt5 => "Recall@5", "recall_at_5", Ratio, Higher;
    /// Median azimuth error: [`crate::score::viewpoint::summarize`].
    ViewpointMedian => "Viewpoint median", "viewpoint_median_rad", Radian, Lower;
    /// Mean error of the azimuths from which an object was seen, its front free: [`crate::score::azimuth::azimuth_error`].
    Azimuth => "Azimuth", "azimuth_rad", Radian, Lower;
    /// Share of azimuth errors under 15 degrees.
    ViewpointRight => "Viewpoint < 15 deg", "viewpoint_right", Ratio, Higher;
    /// Recall@5 where the matches have to come from another lighting session.
    RecallAt5AcrossLight => "Recall@5, other light", "recall_at_5_other_light", Ratio, Higher;
    /// Silhouette of the true instances: [`crate::score::silhouette::silhouette`].
    Silhouette => "Silhouette", "silhouette", Ratio, Higher;
    /// Share of views under other light whose most likely known instance is the right one:
    /// [`crate::score::instance_posterior::instance_posterior`].
    InstanceRight => "Instance right", "instance_right", Ratio, Higher;
    /// Mean probability of the right known instance.
    InstanceProbability => "P(instance)", "instance_probability", Ratio, Higher;
    /// Share of embeddings that HDBSCAN puts in no cluster: [`crate::score::density::density_clusters`].
    Noise => "Noise", "noise", Ratio, Lower;
    /// By how much the number of clusters that HDBSCAN finds is off, over the number of instances.
    ClusterCount => "Clusters off by", "cluster_count_error", Ratio, Lower;
    /// Class accuracy by the nearest of one tagged image a class: [`crate::score::grounding::ground`].
    NearestOf1 => "NN, 1 tag", "class_nearest_of_1", Ratio, Higher;
    NearestOf2 => "NN, 2 tags", "class_nearest_of_2", Ratio, Higher;
    NearestOf5 => "NN, 5 tags", "class_nearest_of_5", Ratio, Higher;
    NearestOf10 => "NN, 10 tags", "class_nearest_of_10", Ratio, Higher;
    /// Class accuracy by Gaussians about the mean of two tagged images a class.
    GaussianOf2 => "Gaussian, 2 tags", "class_gaussian_of_2", Ratio, Higher;
    GaussianOf5 => "Gaussian, 5 tags", "class_gaussian_of_5", Ratio, Higher;
    GaussianOf10 => "Gaussian, 10 tags", "class_gaussian_of_10", Ratio, Higher;
    /// PSNR of a view by the latent of that view alone: [`crate::score::psnr::psnr`].
    Psnr => "PSNR, own view", "psnr_db", Decibel, Higher;
    /// PSNR of a view by the latent of views of other sessions.
    PsnrHeldOut => "PSNR, held out", "psnr_held_out_db", Decibel, Higher;
    /// Median of the deviation that the likelihood promises of the azimuth:
    /// [`crate::score::azimuth_information::promised_deviation`].
    ViewpointPromised => "Promised deviation", "viewpoint_promised_rad", Radian, Lower;
    /// Share of azimuth errors within 1.96 promised deviations.
    ViewpointInside => "Error < 1.96 promised", "viewpoint_inside", Ratio, Near(0.95);
    /// Median azimuth error where all pixels of the predicted image are compared, not the reduced measurement; one view an instance.
    ViewpointByImage => "Viewpoint median, image", "viewpoint_median_image_rad", Radian, Lower;
    /// Mean log-likelihood of a reduced measurement by the latent of views of other sessions: [`crate::score::bound`].
    LogLikelihood => "Log-likelihood, held out", "log_likelihood_held_out_nat", Nat, Higher;
    /// Mean divergence of what a single view says of the latent from the prior.
    Divergence => "Divergence, own view", "divergence_nat", Nat, Lower;
    /// Share of residuals inside the region of 50% of the Student t: [`crate::score::calibration::calibration`].
    Inside50 => "In 50%", "residual_inside_50", Ratio, Near(0.5);
    Inside80 => "In 80%", "residual_inside_80", Ratio, Near(0.8);
    Inside95 => "In 95%", "residual_inside_95", Ratio, Near(0.95);
    /// Share of residuals inside the region of 50% of the Gaussian of the same covariance.
    GaussianInside50 => "Gaussian: in 50%", "residual_gaussian_inside_50", Ratio, Near(0.5);
    GaussianInside95 => "Gaussian: in 95%", "residual_gaussian_inside_95", Ratio, Near(0.95);
    /// Share of single whitened numbers inside their interval of 95%.
    NumberInside95 => "Number in 95%", "residual_number_inside_95", Ratio, Near(0.95);
    /// Of the whitened number for which that share is farthest from 95%.
    WorstNumberInside95 => "Worst number in 95%", "residual_worst_number_inside_95", Ratio, Near(0.95);
    /// Variance of the squared whitened norm over that of the law.
    SquaredNormVariance => "Var of norm^2 / law", "residual_squared_norm_variance", Ratio, Near(1.0);
    /// NEES over degrees of freedom of the robot's last position: [`crate::score::consistency::pose_consistency`].
    NeesPositionEnd => "Position NEES, end", "nees_position_end", Ratio, Near(1.0);
    /// Of its last heading.
    NeesHeadingEnd => "Heading NEES, end", "nees_heading_end", Ratio, Near(1.0);
    /// Of its last pose.
    NeesPoseEnd => "Pose NEES, end", "nees_pose_end", Ratio, Near(1.0);
    /// Of its position, mean over all steps after the first.
    NeesPosition => "Position NEES", "nees_position", Ratio, Near(1.0);
    /// Of its heading, likewise.
    NeesHeading => "Heading NEES", "nees_heading", Ratio, Near(1.0);
    /// Of its pose, likewise.
    NeesPose => "Pose NEES", "nees_pose", Ratio, Near(1.0);
    /// Of the centres of objects, mean over them: [`crate::score::consistency::object_scores`].
    NeesObjectCenter => "Object centre NEES", "nees_object_center", Ratio, Near(1.0);
    /// Of the yaw of asymmetric objects, mean over them.
    NeesObjectYaw => "Object yaw NEES", "nees_object_yaw", Ratio, Near(1.0);
    /// Share of steps with the robot's pose inside its region of 50%.
    PoseInside50 => "Pose in 50%", "pose_inside_50", Ratio, Near(0.5);
    /// Inside that of 80%.
    PoseInside80 => "Pose in 80%", "pose_inside_80", Ratio, Near(0.8);
    /// Inside that of 95%.
    PoseInside95 => "Pose in 95%", "pose_inside_95", Ratio, Near(0.95);
    /// Share of steps with the robot's position inside its region of 50%.
    PositionInside50 => "Position in 50%", "position_inside_50", Ratio, Near(0.5);
    /// Inside that of 80%.
    PositionInside80 => "Position in 80%", "position_inside_80", Ratio, Near(0.8);
    /// Inside that of 95%.
    PositionInside95 => "Position in 95%", "position_inside_95", Ratio, Near(0.95);
    /// Share of steps with the robot's heading inside its interval of 50%.
    HeadingInside50 => "Heading in 50%", "heading_inside_50", Ratio, Near(0.5);
    /// Inside that of 80%.
    HeadingInside80 => "Heading in 80%", "heading_inside_80", Ratio, Near(0.8);
    /// Inside that of 95%.
    HeadingInside95 => "Heading in 95%", "heading_inside_95", Ratio, Near(0.95);
    /// Share of objects with their centre inside its region of 50%: [`crate::score::consistency::object_scores`].
    ObjectCenterInside50 => "Object centre in 50%", "object_center_inside_50", Ratio, Near(0.5);
    /// Inside that of 80%.
    ObjectCenterInside80 => "Object centre in 80%", "object_center_inside_80", Ratio, Near(0.8);
    /// Inside that of 95%.
    ObjectCenterInside95 => "Object centre in 95%", "object_center_inside_95", Ratio, Near(0.95);
    /// Share of asymmetric objects with their yaw inside its interval of 50%.
    ObjectYawInside50 => "Object yaw in 50%", "object_yaw_inside_50", Ratio, Near(0.5);
    /// Inside that of 80%.
    ObjectYawInside80 => "Object yaw in 80%", "object_yaw_inside_80", Ratio, Near(0.8);
    /// Inside that of 95%.
    ObjectYawInside95 => "Object yaw in 95%", "object_yaw_inside_95", Ratio, Near(0.95);
    /// Negative log-likelihood of the robot's last true position.
    PositionSurpriseEnd => "-log p(position), end", "position_surprise_end_nat", Nat, Lower;
    /// Of its last heading.
    HeadingSurpriseEnd => "-log p(heading), end", "heading_surprise_end_nat", Nat, Lower;
    /// Of its last pose.
    PoseSurpriseEnd => "-log p(pose), end", "pose_surprise_end_nat", Nat, Lower;
    /// Of its position, mean over all steps after the first.
    PositionSurprise => "-log p(position)", "position_surprise_nat", Nat, Lower;
    /// Of its heading, likewise.
    HeadingSurprise => "-log p(heading)", "heading_surprise_nat", Nat, Lower;
    /// Of its pose, likewise.
    PoseSurprise => "-log p(pose)", "pose_surprise_nat", Nat, Lower;
    /// Of the true centres of objects, mean over them.
    ObjectCenterSurprise => "-log p(object centre)", "object_center_surprise_nat", Nat, Lower;
    /// Of the true yaws of asymmetric objects, mean over them.
    ObjectYawSurprise => "-log p(object yaw)", "object_yaw_surprise_nat", Nat, Lower;
    /// How much more probable a drive's crops were before it, by what the drives before taught, than by the model as it was trained, a crop.
    PrequentialGain => "Prequential gain", "prequential_gain_nat", Nat, Higher;
    /// Distance of the robot's newest position after each step, root mean square over the steps, first pose aligned:
    /// [`crate::score::online::online_scores`].
    NewestPosition => "Newest position", "newest_position_m", Meter, Lower;
    /// Yaw error of the newest pose, likewise.
    NewestHeading => "Newest heading", "newest_heading_rad", Radian, Lower;
    /// NEES over degrees of freedom of the newest pose, mean over all steps after the first.
    NeesNewest => "Newest pose NEES", "nees_newest", Ratio, Near(1.0);
    /// ATE, first pose aligned, of all poses after the last step.
    AteAtEnd => "ATE after the last step", "ate_at_end_m", Meter, Lower;
    /// Distance of those from the poses by the whole episode at once, root mean square, first pose aligned.
    ApartAtEnd => "From the whole episode's", "apart_at_end_m", Meter, Lower;
    /// Likewise, once all that waits is done and no residual is off its linearisation.
    ApartSettled => "Settled, from the whole episode's", "apart_settled_m", Meter, Lower;
    /// Recall@1 of an object's class by what was believed of objects in earlier episodes: [`crate::score::semantics::class_recall`].
    ClassRecallAt1 => "Class recall@1, earlier episodes", "class_recall_at_1_earlier", Ratio, Higher;
    /// Class accuracy among objects by one tagged object a class of earlier episodes: [`crate::score::grounding::ground_objects`].
    ClassOf1Tag => "Class, 1 tag, earlier episodes", "class_of_1_tag_earlier", Ratio, Higher;
    /// By the mean of three.
    ClassOf3Tags => "Class, 3 tags, earlier episodes", "class_of_3_tags_earlier", Ratio, Higher;
    /// Adjusted Rand index of clusters of what was believed of objects in this episode and earlier ones, and of their classes.
    ClassAri => "Class ARI, with earlier episodes", "class_ari_earlier", Ratio, Higher;
    /// Share of objects whose most probable class by P(c | H) is theirs.
    ClassRight => "Class right", "class_right", Ratio, Higher;
    /// P(c | H) of the true class, mean over objects.
    ClassProbability => "P(true class)", "class_probability_true", Ratio, Higher;
    /// Of pairs of detections taken to be of one object, the share that is: [`crate::score::association`].
    PairPrecision => "Pair precision", "pair_precision", Ratio, Higher;
    /// Of pairs of detections of one object, the share that is taken so.
    PairRecall => "Pair recall", "pair_recall", Ratio, Higher;
    /// The harmonic mean of both.
    PairF1 => "Pair F1", "pair_f1", Ratio, Higher;
    /// Objects found, over those seen.
    ObjectsFound => "Objects found / seen", "objects_found_over_seen", Ratio, Near(1.0);
    /// Of detections of nothing, the share taken for objects.
    FalseTaken => "False taken", "false_taken", Ratio, Lower;
    /// Identity F1: objects and what is told for them matched one to one, `2 IDTP / (IDTP + IDFN + IDTP + IDFP)`.
    IdentityF1 => "IDF1", "identity_f1", Ratio, Higher;
    /// Of tracklets taken to be of an object seen before, the share that is of it.
    LoopPrecision => "Loop precision", "loop_precision", Ratio, Higher;
    /// Of tracklets of an object seen before, the share taken to be of it.
    LoopRecall => "Loop recall", "loop_recall", Ratio, Higher;
    /// Whether all tracklets that were seen whole are told right.
    AllRight => "All right", "all_right", Ratio, Higher;
    /// Whether a hypothesis that is left tells them all right.
    TruthSurvived => "Truth survived", "truth_survived", Ratio, Higher;
    /// The weight of the likeliest hypothesis.
    BestWeight => "Weight of the best", "best_weight", Ratio, Near(1.0);
    /// Brier score of that weight as the probability that all is right.
    BestBrier => "Brier", "best_brier", Ratio, Lower;
    /// Entropy of the hypotheses' weights.
    HypothesesEntropy => "Entropy", "entropy_nat", Nat, Lower;
    /// Hypotheses that are left.
    Hypotheses => "Hypotheses", "hypotheses", Ratio, Lower;
    /// Object map quality: [`crate::score::object_map`].
    MapQuality => "OMQ", "object_map_quality", Ratio, Higher;
    /// The mean quality of matched objects.
    MapPairQuality => "Pair quality", "map_pair_quality", Ratio, Higher;
    /// The mean overlap of their boxes.
    MapOverlap => "Overlap", "map_overlap", Ratio, Higher;
    /// The mean probability of their true class.
    MapLabel => "P(class)", "map_class_probability", Ratio, Higher;
    /// What false objects' probabilities leave to 1, in the mean.
    MapFalseQuality => "False quality", "map_false_quality", Ratio, Higher;
    /// Of a map's objects, the share whose centre is near one of its own.
    MapPrecision => "Precision", "map_precision", Ratio, Higher;
    /// Of true objects, the share that has one in the map.
    MapRecall => "Recall", "map_recall", Ratio, Higher;
    /// The harmonic mean of both.
    MapF1 => "F1", "map_f1", Ratio, Higher;
    /// Distance of their centres, root mean square.
    MapCenter => "Centre", "map_center_m", Meter, Lower;
    /// Whether a robot that was carried is known to be within a metre of where it is, from some detection on to the end.
    Resolved => "Resolved", "resolved", Ratio, Higher;
    /// Whole detections from where it is set down to the one from which on it is resolved; all of them where it never is.
    DetectionsToResolve => "Detections to resolve", "detections_to_resolve", Ratio, Lower;
    /// How far the robot is from where it was believed to be, root mean square of the steps since it was set down.
    PlaceError => "Place", "place_m", Meter, Lower;
    /// The same at the last step.
    FinalPlace => "Final place", "final_place_m", Meter, Lower;
    /// Whether that is known, and within half a metre.
    WithinHalf => "Within 0.5 m", "within_half_m", Ratio, Higher;
    /// Whether that is known, and within a metre.
    WithinOne => "Within 1 m", "within_one_m", Ratio, Higher;
    /// Whether that is known, and within two metres.
    WithinTwo => "Within 2 m", "within_two_m", Ratio, Higher;
    /// ATE of `geometric` by what was associated.
    AteOfGeometric => "ATE of geometric", "ate_geometric_m", Meter, Lower;
    /// ATE of the first learned row by what was associated.
    AteOfLearned => "ATE of the learned row", "ate_learned_m", Meter, Lower;
    /// 90th percentile of the azimuth error: [`crate::score::known_views`].
    ViewpointP90 => "Viewpoint P90", "viewpoint_p90_rad", Radian, Lower;
    /// Share of azimuth errors under 60 degrees.
    ViewpointWithin60 => "Viewpoint < 60 deg", "viewpoint_within_60", Ratio, Higher;
    /// Share of azimuths inside their region of 95%.
    AzimuthInside95 => "Azimuth in 95%", "azimuth_inside_95", Ratio, Near(0.95);
    /// Median azimuth error of views less than 15 degrees from a known one.
    ViewpointMedianNear15 => "Median, nearest < 15 deg", "viewpoint_median_nearest_15_rad", Radian, Lower;
    /// Of those 15 to 30 degrees from the nearest known one.
    ViewpointMedianNear30 => "15-30 deg", "viewpoint_median_nearest_30_rad", Radian, Lower;
    /// Of those 30 to 60 degrees from it.
    ViewpointMedianNear60 => "30-60 deg", "viewpoint_median_nearest_60_rad", Radian, Lower;
    /// Of those farther from it.
    ViewpointMedianFar => "> 60 deg", "viewpoint_median_farther_rad", Radian, Lower;
}

impl Metric {
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

    /// Whether it is a normalized estimation error squared: skewed over runs, so that a symmetric interval would mislead.
    pub fn is_nees(self) -> bool {
        self.column().starts_with("nees_")
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
    use std::collections::BTreeSet;

    #[test]
    fn files_and_tables_name_each_metric_once() {
        let columns: BTreeSet<_> = Metric::ALL.iter().map(|m| m.column()).collect();
        let labels: BTreeSet<_> = Metric::ALL.iter().map(|m| m.label()).collect();
        assert_eq!((columns.len(), labels.len()), (Metric::ALL.len(), Metric::ALL.len()));
        for metric in Metric::ALL.iter().copied() {
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

//! The names of rows: of estimators, of models, and of floors beside them.

use vantage_learn::{Kind, Manifest, Objective};
use vantage_slam::Row;

/// Name of the latents' row.
pub const LATENTS: &str = "viewpoint_dependent";
/// Name of the floor's row.
pub const PIXELS: &str = "pixels_pca64";
/// Name of the row of predicting always the same: the mean of what is known of the instance.
pub const MEAN_VIEW: &str = "mean_view";
/// The name of the true trajectory among those of a seed.
pub const TRUTH: &str = "truth";
/// The semantic row's name with a model of discrete classes.
const DISCRETE_CLASS: &str = "discrete_class";
/// The semantic row's name with a viewpoint-predictive model.
const VIEWPOINT_PREDICTIVE: &str = "viewpoint_predictive";

/// The name of the semantic row, which is the model's.
pub fn semantic_row(manifest: &Manifest) -> &'static str {
    let trained = manifest.training.details.as_ref().map(|details| details.spec.objective);
    match (manifest.kind, trained) {
        (_, Some(Objective::DiscreteClass)) => DISCRETE_CLASS,
        (Kind::ViewpointPredictive, _) => VIEWPOINT_PREDICTIVE,
        _ => Row::ViewpointDependent.name(),
    }
}

/// Names that no other estimator may have: all that rows of ours can have, and that of the truth's file.
pub fn taken_names() -> Vec<&'static str> {
    Row::ALL.map(Row::name).into_iter().chain([DISCRETE_CLASS, VIEWPOINT_PREDICTIVE, TRUTH]).collect()
}

/// The name of a row, given that of the semantic one.
pub fn row_name(row: Row, semantic: &'static str) -> &'static str {
    if row == Row::ViewpointDependent { semantic } else { row.name() }
}

/// Whether a row of trajectories is of neither odometry nor geometry nor the control: of a model, or of somebody else's estimator.
pub fn is_learned(name: &str) -> bool {
    ![Row::Odometry, Row::Geometric, Row::Uninformative].map(Row::name).contains(&name)
}

//! The names of rows: of models, and of floors beside them.

use crate::scene_file::row::Row;
use std::path::Path;
use vantage_learn::{Kind, Manifest, Objective};

/// Name of the row of raw pixels, the floor of latents.
pub const PIXELS: &str = "pixels_pca64";
/// Name of the row of predicting always the same: the mean of what is known of the instance.
pub const MEAN_VIEW: &str = "mean_view";
/// Name of the row of a Gaussian process per object, the floor of azimuths from known views.
pub const GAUSSIAN_PROCESS: &str = "gaussian_process";
/// The name of the true trajectory among those of a seed.
pub const TRUTH: &str = "truth";

const DISCRETE_CLASS: &str = "discrete_class";

/// The row of a variant with a process beside its model.
pub fn with_process(variant: &str) -> String {
    format!("{variant}+process")
}

/// The name of a scene's own model, which is what it is.
pub fn kind_name(manifest: &Manifest) -> String {
    let trained = manifest.training.details.as_ref().map(|details| details.spec.objective);
    match trained {
        Some(Objective::DiscreteClass) => DISCRETE_CLASS.to_owned(),
        _ => manifest.kind.to_string(),
    }
}

/// The name of a row whose folder that is; `None` where it is not of letters, digits, `-`, `_` and `.` alone.
pub fn folder_name(folder: &Path) -> Option<String> {
    let absolute = || folder.canonicalize().ok()?.file_name().map(ToOwned::to_owned);
    let name = folder.file_name().map(ToOwned::to_owned).or_else(absolute)?.into_string().ok()?;
    name.chars().all(|c| c.is_alphanumeric() || "-_.".contains(c)).then_some(name)
}

/// Names that no folder may give a row: those of estimators without a model, of floors, and of the truth's file.
pub fn reserved_names() -> Vec<String> {
    let rows = Row::ALL.iter().filter(|row| !row.is_of_model()).map(Row::to_string);
    rows.chain([PIXELS, MEAN_VIEW, TRUTH].map(str::to_owned)).collect()
}

/// Names that a scene's own model can have.
pub fn kind_names() -> [String; 3] {
    [Kind::ViewpointDependent.to_string(), Kind::ViewpointPredictive.to_string(), DISCRETE_CLASS.to_owned()]
}

/// Whether a row of trajectories is of neither odometry nor geometry nor the control: of a model, or of somebody else's estimator.
pub fn is_learned(name: &str) -> bool {
    !Row::ALL.iter().any(|row| !row.is_of_model() && row.to_string() == name)
}

//! `--map FILE --true-map FILE`: a map of objects beside a trajectory.

use crate::command::cli::ScoreArgs;
use crate::command::score::error::ScoreError;
use crate::command::score::labels;
use crate::progress::Progress;
use crate::result::grid::{Style, draw};
use crate::result::metric::Metric;
use crate::score::alignment::Laid;
use crate::score::embedding::Scores;
use crate::score::object_map::{COLUMNS, Proposal, TrueObject, object_map_scores};
use crate::score::object_map_file::{ObjectMap, ObjectMapError};
use std::path::Path;

/// The scores of the map once it is laid on the truth as the trajectory is; `None` where there is no map.
pub fn scores(args: &ScoreArgs, laid: &Laid) -> Result<Option<Scores>, ScoreError> {
    let (Some(map), Some(truth)) = (&args.map, &args.true_map) else { return Ok(None) };
    let map = read(map)?;
    let truth = objects(truth, map.proposals.iter().any(|proposal| proposal.classes.is_some()))?;
    let known = truth.iter().map(|object| object.class.clone()).collect();
    labels::tell(map.proposals.iter(), &known, "the true map", &Progress::detect());
    let moved = |proposal: &Proposal| proposal.moved(&laid.truth_from_estimate, laid.scale);
    let proposals: Vec<_> = map.proposals.iter().map(moved).collect();
    Ok(Some(object_map_scores(&truth, &proposals)))
}

fn read(path: &Path) -> Result<ObjectMap, ObjectMapError> {
    let missing = || ObjectMapError { path: path.to_owned(), reason: "there is no such file".to_owned() };
    ObjectMap::read(path)?.ok_or_else(missing)
}

/// Each of one class, where the map has classes.
fn objects(path: &Path, with_classes: bool) -> Result<Vec<TrueObject>, ObjectMapError> {
    let object = |proposal: Proposal| {
        let classes = proposal.classes.unwrap_or_else(|| [(String::new(), 1.0)].into());
        let mut certain = classes.into_iter().filter(|(_, p)| *p == 1.0);
        let (class, _) = certain.next()?;
        Some(TrueObject { center: proposal.center, sides: proposal.sides, class })
    };
    let is_labelled = |proposal: &Proposal| proposal.classes.is_some() || !with_classes;
    let read = read(path)?;
    if !read.proposals.iter().all(is_labelled) {
        let reason = "no column label, and the other map has classes".to_owned();
        return Err(ObjectMapError { path: path.to_owned(), reason });
    }
    let objects = read.proposals.into_iter().map(object).collect::<Option<Vec<_>>>();
    let reason = "a true object has one class, of confidence 1".to_owned();
    objects.ok_or(ObjectMapError { path: path.to_owned(), reason })
}

/// The scores as a table.
pub fn text(scores: &Scores) -> String {
    let head = ["Map", "Value"].map(String::from);
    let row = |metric: &Metric| Some(vec![metric.label().to_owned(), format!("{:.6}", scores.get(metric)?)]);
    draw(Style::terminal(), &head, COLUMNS.iter().filter_map(row).collect())
}

//! Maps of objects: object map quality (OMQ; Hall et al. 2022, the scenes' benchmark of BenchBot), and how far centres are off.
//!
//! ```text
//! q_ij = sqrt(IoU_ij p_i(class_j))                      a proposal i for an object j; boxes along common axes
//! OMQ  = sum of q over matched pairs / (TP + FN + sum over false positives of max_c p_i(c))
//! ```
//!
//! The matching is the one to one for which the sum of `q` is most; pairs of quality 0 are none.

use super::embedding::Scores;
use super::root_mean_square;
use crate::result::metric::Metric;
use nalgebra::{Point3, UnitQuaternion, Vector3};
use pathfinding::kuhn_munkres::kuhn_munkres;
use pathfinding::matrix::Matrix;
use std::collections::BTreeMap;
use vantage_dataset::Pose;

/// The name of the table.
pub const OBJECT_MAP: &str = "object_map";
/// Its columns.
pub const COLUMNS: [Metric; 9] = [
    Metric::MapQuality,
    Metric::MapPairQuality,
    Metric::MapOverlap,
    Metric::MapLabel,
    Metric::MapFalseQuality,
    Metric::MapPrecision,
    Metric::MapRecall,
    Metric::MapF1,
    Metric::MapCenter,
];

/// Centres farther apart than this are of different objects, metres.
pub const NEAR: f64 = 0.5;
/// Steps of a quality in the matching, which counts in whole numbers.
const STEPS: f64 = 1e12;

/// An object of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposal {
    /// The centre of its box.
    pub center: Point3<f64>,
    /// The sides of its box along the map's axes, metres; `None` where the map holds centres alone.
    pub sides: Option<Vector3<f64>>,
    /// The probability of each class, together at most 1; `None` where the map has no classes.
    pub classes: Option<BTreeMap<String, f64>>,
}

/// A true object, in the map's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueObject {
    /// The centre of its box.
    pub center: Point3<f64>,
    /// The sides of its box along the map's axes, metres; `None` where they are not known.
    pub sides: Option<Vector3<f64>>,
    /// Its class.
    pub class: String,
}

impl Proposal {
    /// In another frame, once it is scaled: a box that is turned becomes that along the new axes which holds it.
    pub fn moved(&self, new_from_map: &Pose, scale: f64) -> Self {
        Self {
            center: new_from_map * (self.center * scale),
            sides: self.sides.map(|sides| sides_around(&new_from_map.rotation, &(sides * scale))),
            classes: self.classes.clone(),
        }
    }
}

/// The sides, along the axes of a frame, of what holds a box with these sides that is turned by `frame_from_box`.
pub fn sides_around(frame_from_box: &UnitQuaternion<f64>, sides: &Vector3<f64>) -> Vector3<f64> {
    frame_from_box.to_rotation_matrix().matrix().abs() * sides
}

/// The scores of a map. Those of overlap need boxes of all objects, and OMQ, too; where the map has no classes, `q` is the overlap alone and a false
/// positive counts 1.
pub fn object_map_scores(truth: &[TrueObject], map: &[Proposal]) -> Scores {
    let mut scores = by_distance(truth, map);
    let boxed = truth.iter().all(|o| o.sides.is_some()) && map.iter().all(|p| p.sides.is_some());
    if boxed && !truth.is_empty() {
        scores.extend(by_quality(truth, map));
    }
    scores
}

/// What a pair is worth.
#[derive(Clone, Copy, Debug, Default)]
struct Quality {
    overall: f64,
    overlap: f64,
    label: f64,
}

fn by_quality(truth: &[TrueObject], map: &[Proposal]) -> Scores {
    let quality = |i: usize, j: usize| {
        let (object, proposal) = (&truth[i], &map[j]);
        let overlap = overlap(object, proposal);
        match &proposal.classes {
            None => Quality { overall: overlap, overlap, label: 1.0 },
            Some(classes) => {
                let label = classes.get(&object.class).copied().unwrap_or(0.0);
                Quality { overall: (overlap * label).sqrt(), overlap, label }
            }
        }
    };
    let pairs: Vec<(usize, Quality)> = matched(truth.len(), map.len(), |i, j| quality(i, j).overall)
        .into_iter()
        .map(|(i, j)| (j, quality(i, j)))
        .collect();
    let right = pairs.len() as f64;
    let missed = truth.len() as f64 - right;
    let surest = |proposal: &Proposal| match &proposal.classes {
        Some(classes) => classes.values().copied().fold(0.0, f64::max),
        None => 1.0,
    };
    let is_false = |j: &usize| pairs.iter().all(|(matched, _)| matched != j);
    let costs: Vec<f64> = (0..map.len()).filter(is_false).map(|j| surest(&map[j])).collect();
    let cost: f64 = costs.iter().sum();
    let sum = |of: fn(&Quality) -> f64| pairs.iter().map(|(_, quality)| of(quality)).sum::<f64>();
    let mut scores = Scores::from([(Metric::MapQuality, sum(|q| q.overall) / (right + missed + cost))]);
    if !pairs.is_empty() {
        scores.insert(Metric::MapPairQuality, sum(|q| q.overall) / right);
        scores.insert(Metric::MapOverlap, sum(|q| q.overlap) / right);
        if map.iter().any(|proposal| proposal.classes.is_some()) {
            scores.insert(Metric::MapLabel, sum(|q| q.label) / right);
        }
    }
    if !costs.is_empty() {
        scores.insert(Metric::MapFalseQuality, 1.0 - cost / costs.len() as f64);
    }
    scores
}

/// The matching that leaves least distance, of centres within [`NEAR`].
pub fn nearest_pairs(truth: &[TrueObject], map: &[Proposal]) -> Vec<(usize, usize)> {
    matched(truth.len(), map.len(), |i, j| (1.0 - (truth[i].center - map[j].center).norm() / NEAR).max(0.0))
}

fn by_distance(truth: &[TrueObject], map: &[Proposal]) -> Scores {
    let pairs = nearest_pairs(truth, map);
    let (right, objects, proposals) = (pairs.len() as f64, truth.len() as f64, map.len() as f64);
    let mut scores = Scores::new();
    let share = |of: f64, all: f64| (all > 0.0).then(|| of / all);
    scores.extend(share(right, proposals).map(|share| (Metric::MapPrecision, share)));
    scores.extend(share(right, objects).map(|share| (Metric::MapRecall, share)));
    scores.extend(share(2.0 * right, objects + proposals).map(|share| (Metric::MapF1, share)));
    let squares = pairs.iter().map(|&(i, j)| (truth[i].center - map[j].center).norm_squared());
    scores.extend(root_mean_square(squares).map(|off| (Metric::MapCenter, off)));
    scores
}

/// Rows and columns matched one to one so that the sum of their qualities, in `[0, 1]`, is most; those of quality 0 are left out.
fn matched(rows: usize, columns: usize, quality: impl Fn(usize, usize) -> f64) -> Vec<(usize, usize)> {
    if rows == 0 || columns == 0 {
        return Vec::new();
    }
    let is_known = |i: usize, j: usize| i < rows && j < columns;
    // As many columns as rows at least.
    let weights = Matrix::from_fn(rows, columns.max(rows), |(i, j)| {
        if is_known(i, j) { (quality(i, j) * STEPS) as i64 } else { 0 }
    });
    let (_, assigned) = kuhn_munkres(&weights);
    assigned.into_iter().enumerate().filter(|&(i, j)| is_known(i, j) && quality(i, j) > 0.0).collect()
}

/// Intersection over union of two boxes along common axes.
fn overlap(object: &TrueObject, proposal: &Proposal) -> f64 {
    let (Some(a), Some(b)) = (object.sides, proposal.sides) else { return 0.0 };
    let shared = |k: usize| {
        let low = (object.center[k] - a[k] / 2.0).max(proposal.center[k] - b[k] / 2.0);
        let high = (object.center[k] + a[k] / 2.0).min(proposal.center[k] + b[k] / 2.0);
        (high - low).max(0.0)
    };
    let both = shared(0) * shared(1) * shared(2);
    let union = a.product() + b.product() - both;
    if union > 0.0 { both / union } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn object(x: f64, class: &str) -> TrueObject {
        let center = Point3::new(x, 0.0, 0.0);
        TrueObject { center, sides: Some(Vector3::repeat(1.0)), class: class.to_owned() }
    }

    fn proposal(x: f64, classes: &[(&str, f64)]) -> Proposal {
        let classes = classes.iter().map(|(class, p)| ((*class).to_owned(), *p)).collect();
        let center = Point3::new(x, 0.0, 0.0);
        Proposal { center, sides: Some(Vector3::repeat(1.0)), classes: Some(classes) }
    }

    #[test]
    fn truth_is_perfect_and_nothing_scores_nothing() {
        let truth = [object(0.0, "mug"), object(3.0, "book")];
        let same = [proposal(3.0, &[("book", 1.0)]), proposal(0.0, &[("mug", 1.0)])];
        let found = object_map_scores(&truth, &same);
        for metric in [Metric::MapQuality, Metric::MapLabel, Metric::MapOverlap, Metric::MapF1] {
            assert_eq!(found[&metric], 1.0, "{metric:?}");
        }
        assert_eq!(found[&Metric::MapCenter], 0.0);
        let none = object_map_scores(&truth, &[]);
        assert_eq!((none[&Metric::MapQuality], none[&Metric::MapRecall]), (0.0, 0.0));
        assert!(!none.contains_key(&Metric::MapPrecision) && !none.contains_key(&Metric::MapCenter));
    }

    #[test]
    fn quality_is_the_geometric_mean_and_what_is_false_costs_its_confidence() {
        let truth = [object(0.0, "mug"), object(9.0, "book")];
        // Shifted by two fifths: an overlap of three sevenths.
        let map =
            [proposal(0.4, &[("mug", 0.6), ("book", 0.4)]), proposal(20.0, &[("book", 0.7), ("mug", 0.1)])];
        let found = object_map_scores(&truth, &map);
        let q = (0.6f64 * 3.0 / 7.0).sqrt();
        assert_relative_eq!(found[&Metric::MapQuality], q / (1.0 + 1.0 + 0.7), epsilon = 1e-12);
        assert_relative_eq!(found[&Metric::MapPairQuality], q, epsilon = 1e-12);
        assert_relative_eq!(found[&Metric::MapFalseQuality], 0.3, epsilon = 1e-12);
        assert_eq!((found[&Metric::MapPrecision], found[&Metric::MapRecall]), (0.5, 0.5));
    }

    #[test]
    fn centres_alone_have_no_quality_and_are_scored_by_distance() {
        let truth = [object(0.0, "mug"), object(1.0, "mug")];
        let bare = |x: f64| Proposal { center: Point3::new(x, 0.0, 0.0), sides: None, classes: None };
        let found = object_map_scores(&truth, &[bare(0.4), bare(-0.3), bare(5.0)]);
        assert!(!found.contains_key(&Metric::MapQuality));
        // An object takes one proposal, the nearest; the other object has none that is near.
        assert_relative_eq!(found[&Metric::MapPrecision], 1.0 / 3.0);
        assert_relative_eq!(found[&Metric::MapCenter], 0.3);
    }

    #[test]
    fn a_map_that_is_turned_by_a_quarter_keeps_its_boxes_and_others_grow() {
        let of = Proposal { sides: Some(Vector3::new(2.0, 1.0, 0.5)), ..proposal(1.0, &[]) };
        let quarter = of.moved(&Pose::rotation(Vector3::z() * std::f64::consts::FRAC_PI_2), 2.0);
        assert_relative_eq!(quarter.center, Point3::new(0.0, 2.0, 0.0), epsilon = 1e-12);
        assert_relative_eq!(quarter.sides.unwrap(), Vector3::new(2.0, 4.0, 1.0), epsilon = 1e-12);
        let eighth = of.moved(&Pose::rotation(Vector3::z() * std::f64::consts::FRAC_PI_4), 1.0);
        assert_relative_eq!(eighth.sides.unwrap().x, 3.0 / 2.0f64.sqrt(), epsilon = 1e-12);
    }

    #[test]
    fn the_order_of_objects_changes_nothing() {
        let truth = [object(0.0, "mug"), object(0.4, "book"), object(0.9, "mug")];
        let map = [proposal(0.1, &[("mug", 0.5)]), proposal(0.5, &[("mug", 0.4), ("book", 0.6)])];
        let (mut other_truth, mut other_map) = (truth.clone(), map.clone());
        other_truth.reverse();
        other_map.reverse();
        let (here, there) = (object_map_scores(&truth, &map), object_map_scores(&other_truth, &other_map));
        for (metric, value) in here {
            assert_relative_eq!(value, there[&metric], epsilon = 1e-12);
        }
    }
}

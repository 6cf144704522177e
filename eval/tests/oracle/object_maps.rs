//! Object map quality against BenchBot's rule, computed with SciPy on drawn maps.

use nalgebra::{Point3, Vector3};
use serde::Deserialize;
use std::collections::BTreeMap;
use vantage_eval::result::metric::Metric;
use vantage_eval::score::object_map::{Proposal, TrueObject, object_map_scores};

#[derive(Deserialize)]
struct Expected {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    truth: Vec<Object>,
    map: Vec<Mapped>,
    omq: f64,
    pairwise: f64,
    label: f64,
    spatial: f64,
    false_quality: f64,
    counts: [usize; 3],
}

#[derive(Deserialize)]
struct Object {
    center: [f64; 3],
    sides: [f64; 3],
    label: String,
}

#[derive(Deserialize)]
struct Mapped {
    center: [f64; 3],
    sides: [f64; 3],
    probabilities: BTreeMap<String, f64>,
}

#[test]
fn maps_score_as_benchbot_scores_them() {
    let expected: Expected = serde_json::from_str(include_str!("object_maps.json")).unwrap();
    let mut compared = 0;
    for case in &expected.cases {
        let object = |o: &Object| TrueObject {
            center: Point3::from(o.center),
            sides: Some(Vector3::from(o.sides)),
            class: o.label.clone(),
        };
        let proposal = |o: &Mapped| Proposal {
            center: Point3::from(o.center),
            sides: Some(Vector3::from(o.sides)),
            classes: Some(o.probabilities.clone()),
        };
        let truth: Vec<TrueObject> = case.truth.iter().map(object).collect();
        let map: Vec<Proposal> = case.map.iter().map(proposal).collect();
        let found = object_map_scores(&truth, &map);
        let [right, false_ones, _] = case.counts;
        for (metric, theirs, is_defined) in [
            (Metric::MapQuality, case.omq, !truth.is_empty()),
            (Metric::MapPairQuality, case.pairwise, right > 0),
            (Metric::MapLabel, case.label, right > 0),
            (Metric::MapOverlap, case.spatial, right > 0),
            (Metric::MapFalseQuality, case.false_quality, false_ones > 0 && !truth.is_empty()),
        ] {
            let ours = found.get(&metric).copied();
            assert_eq!(ours.is_some(), is_defined, "{metric:?} of {:?}", case.counts);
            assert!(ours.is_none_or(|ours| (ours - theirs).abs() < 1e-9), "{metric:?}: {ours:?}, {theirs}");
            compared += usize::from(is_defined);
        }
    }
    assert_eq!(compared, 24, "the file holds other cases than it did");
}

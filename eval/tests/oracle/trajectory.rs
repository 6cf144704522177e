use serde::Deserialize;
use std::path::Path;
use vantage_eval::result::trajectory::Trajectory;
use vantage_eval::score::ate::{ate, ate_umeyama};
use vantage_eval::score::pairs::{MAX_TIME_DIFFERENCE, Pairs};
use vantage_eval::score::rpe::rpe;

#[derive(Deserialize)]
struct Expected {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    case: String,
    metric: String,
    align: String,
    pose_relation: String,
    delta: Option<f64>,
    unit: Option<String>,
    n: usize,
    files: [String; 2],
    stats: Stats,
}

#[derive(Deserialize)]
struct Stats {
    rmse: f64,
}

impl Case {
    /// Our number for this case, or `None` where it is none of ours.
    fn measure(&self, folder: &Path) -> Option<f64> {
        let translation = self.pose_relation == "translation part";
        let one_frame = self.delta == Some(1.0) && self.unit.as_deref() == Some("frames");
        let score: fn(&Pairs) -> Option<f64> = match (self.metric.as_str(), self.align.as_str()) {
            ("ape", "origin") if translation => ate,
            ("ape", "se3") if translation => ate_umeyama,
            ("rpe", "none" | "se3") if one_frame && translation => |pairs| rpe(pairs).translation,
            ("rpe", "none" | "se3") if one_frame => |pairs| rpe(pairs).rotation.map(f64::to_degrees),
            _ => return None,
        };
        let [truth, estimate] = &self.files;
        let text = |name: &String| std::fs::read_to_string(folder.join(name)).expect("beside its scores");
        let truth = Trajectory::recorded_from_tum(&text(truth)).expect("a recorded truth");
        let estimate = Trajectory::from_tum(&text(estimate)).expect("an estimate");
        let pairs = Pairs::by_time(&truth, &estimate, MAX_TIME_DIFFERENCE).expect("poses of one time");
        assert_eq!(pairs.truth().len(), self.n, "{}: other associations than evo's", self.case);
        Some(score(&pairs).expect("a defined score"))
    }
}

#[test]
fn trajectories_score_as_evo_scores_them() {
    let Some(path) = super::test_data("evo/expected.json") else { return };
    let expected: Expected = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    let mut compared = 0;
    for case in &expected.cases {
        let Some(measured) = case.measure(path.parent().unwrap()) else { continue };
        let published = case.stats.rmse;
        assert!(
            (measured - published).abs() < 1e-9 * published.max(1e-3),
            "{} {} {} {}: {measured}, evo says {published}",
            case.case,
            case.metric,
            case.align,
            case.pose_relation
        );
        compared += 1;
    }
    assert_eq!(compared, 4 * (2 + 8), "the file holds other cases than it did");
}

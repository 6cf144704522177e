use serde::Deserialize;
use std::path::Path;
use vantage_dataset::Pose;
use vantage_eval::result::trajectory::Trajectory;
use vantage_eval::score::ate::{ate, ate_umeyama};
use vantage_eval::score::pairs::{MAX_TIME_DIFFERENCE, Pairs, nearest};
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
        let pairs = by_time(&truth, &estimate);
        assert_eq!(pairs.truth().len(), self.n, "{}: other associations than evo's", self.case);
        Some(score(&pairs).expect("a defined score"))
    }
}

/// The poses nearest in time, for each pose of the shorter trajectory (the estimate where both are as long), as evo associates: a pose
/// of the longer one may serve twice.
fn by_time(truth: &Trajectory, estimate: &Trajectory) -> Pairs {
    let (mut of_truth, mut of_estimate) = (Vec::new(), Vec::new());
    let estimate_longer = estimate.len() > truth.len();
    let (short, long) = if estimate_longer { (truth, estimate) } else { (estimate, truth) };
    for (i, &time) in short.timestamps().iter().enumerate() {
        let Some(j) = nearest(long.timestamps(), time, MAX_TIME_DIFFERENCE) else { continue };
        let (t, e) = if estimate_longer { (i, j) } else { (j, i) };
        of_truth.push(truth.world_from_robot()[t]);
        of_estimate.push(estimate.world_from_robot()[e]);
    }
    Pairs::by_step(&of_truth, &of_estimate).expect("finite poses")
}

#[test]
fn each_pose_of_the_shorter_trajectory_meets_the_nearest_in_time() {
    let line = |timestamps: &[f64]| {
        let poses = timestamps.iter().map(|&t| Pose::translation(t, 0.0, 0.0)).collect();
        Trajectory::new(timestamps.to_vec(), poses).expect("a trajectory")
    };
    let met = |truth: &Trajectory, estimate: &Trajectory| {
        let pairs = by_time(truth, estimate);
        [pairs.truth(), pairs.estimate()]
            .map(|poses| poses.iter().map(|p| p.translation.x).collect::<Vec<_>>())
    };
    let truth = line(&[0.0, 0.1, 0.2, 0.3, 0.4]);
    assert_eq!(
        met(&truth, &line(&[-1.0, 0.095, 0.104, 0.25, 0.405])),
        [[0.1, 0.1, 0.4], [0.095, 0.104, 0.405]]
    );
    assert_eq!(met(&line(&[0.104]), &truth), [[0.104], [0.1]]);
    assert!(by_time(&truth, &line(&[9.0])).truth().is_empty());
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

use serde::Deserialize;
use std::path::Path;
use vantage_dataset::Pose;
use vantage_eval::result::trajectory::Trajectory;
use vantage_eval::score::alignment::Alignment;
use vantage_eval::score::ate::{ate, ate_umeyama};
use vantage_eval::score::pairs::{MAX_TIME_DIFFERENCE, Pairs};
use vantage_eval::score::pose_error::{ErrorStatistics, PoseErrors, Spacing, Unit};
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
    #[serde(default)]
    all_pairs: bool,
    npairs: Option<usize>,
    n: usize,
    files: [String; 2],
    stats: Stats,
}

#[derive(Deserialize)]
struct Stats {
    rmse: f64,
    mean: f64,
    median: f64,
    std: f64,
    min: f64,
    max: f64,
    sse: f64,
}

impl Case {
    fn alignment(&self) -> Alignment {
        match self.align.as_str() {
            "none" => Alignment::None,
            "origin" => Alignment::Origin,
            "se3" => Alignment::Se3,
            "sim3" => Alignment::Sim3,
            "scale_only" => Alignment::Scale,
            other => panic!("an alignment {other}"),
        }
    }

    fn pairs(&self, folder: &Path) -> Pairs {
        let [truth, estimate] = &self.files;
        let text = |name: &String| std::fs::read_to_string(folder.join(name)).expect("beside its scores");
        let truth = Trajectory::recorded_from_tum(&text(truth)).expect("a recorded truth");
        let estimate = Trajectory::from_tum(&text(estimate)).expect("an estimate");
        let pairs = Pairs::by_time(&truth, &estimate, MAX_TIME_DIFFERENCE);
        assert_eq!(pairs.truth().len(), self.n, "{}: other associations than evo's", self.case);
        pairs
    }

    /// Our errors for this case.
    fn measure(&self, folder: &Path) -> Vec<f64> {
        let pairs = self.pairs(folder);
        let aligned = self.alignment().apply(&pairs).expect("positions that span the space");
        let errors = match (self.metric.as_str(), self.delta) {
            ("ape", None) => PoseErrors::absolute(&aligned),
            ("rpe", Some(delta)) => {
                let unit = match self.unit.as_deref() {
                    Some("frames") => Unit::Frames,
                    Some("m") => Unit::Metres,
                    other => panic!("a unit {other:?}"),
                };
                PoseErrors::relative(&aligned, Spacing { delta, unit, all_pairs: self.all_pairs })
            }
            other => panic!("a metric {other:?}"),
        };
        match self.pose_relation.as_str() {
            "translation part" => errors.translation,
            "rotation angle in degrees" => errors.rotation,
            other => panic!("a relation {other}"),
        }
    }
}

#[test]
fn each_pose_of_the_shorter_trajectory_meets_the_nearest_in_time() {
    let line = |timestamps: &[f64]| {
        let poses = timestamps.iter().map(|&t| Pose::translation(t, 0.0, 0.0)).collect();
        Trajectory::new(timestamps.to_vec(), poses).expect("a trajectory")
    };
    let met = |truth: &Trajectory, estimate: &Trajectory| {
        let pairs = Pairs::by_time(truth, estimate, MAX_TIME_DIFFERENCE);
        [pairs.truth(), pairs.estimate()]
            .map(|poses| poses.iter().map(|p| p.translation.x).collect::<Vec<_>>())
    };
    let truth = line(&[0.0, 0.1, 0.2, 0.3, 0.4]);
    assert_eq!(
        met(&truth, &line(&[-1.0, 0.095, 0.104, 0.25, 0.405])),
        [[0.1, 0.1, 0.4], [0.095, 0.104, 0.405]]
    );
    assert_eq!(met(&line(&[0.104]), &truth), [[0.104], [0.1]]);
    assert!(Pairs::by_time(&truth, &line(&[9.0]), MAX_TIME_DIFFERENCE).truth().is_empty());
}

#[test]
fn trajectories_score_as_evo_scores_them() {
    let Some(path) = super::test_data("evo/expected.json") else { return };
    let expected: Expected = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    for case in &expected.cases {
        let errors = case.measure(path.parent().unwrap());
        let name = format!("{} {} {} {}", case.case, case.metric, case.align, case.pose_relation);
        assert!(case.npairs.is_none_or(|pairs| pairs == errors.len()), "{name}: {} motions", errors.len());
        let ours = ErrorStatistics::of(&errors).expect("errors");
        let theirs = &case.stats;
        for (what, ours, theirs) in [
            ("rmse", ours.rmse, theirs.rmse),
            ("mean", ours.mean, theirs.mean),
            ("median", ours.median, theirs.median),
            ("std", ours.std, theirs.std),
            ("min", ours.min, theirs.min),
            ("max", ours.max, theirs.max),
            ("sse", ours.sse, theirs.sse),
        ] {
            assert!(
                (ours - theirs).abs() < 1e-6 * theirs.max(1.0),
                "{name}, {what}: {ours}, evo says {theirs}"
            );
        }
    }
    assert_eq!(expected.cases.len(), 136, "the file holds other cases than it did");
}

#[test]
fn the_scores_of_our_tables_are_those_of_evo() {
    let Some(path) = super::test_data("evo/expected.json") else { return };
    let expected: Expected = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    let mut compared = 0;
    for case in &expected.cases {
        let translation = case.pose_relation == "translation part";
        let one_frame = case.delta == Some(1.0) && case.unit.as_deref() == Some("frames");
        let score: fn(&Pairs) -> Option<f64> = match (case.metric.as_str(), case.align.as_str()) {
            ("ape", "origin") if translation => ate,
            ("ape", "se3") if translation => ate_umeyama,
            ("rpe", "none" | "se3") if one_frame && translation => |pairs| rpe(pairs).translation,
            ("rpe", "none" | "se3") if one_frame => |pairs| rpe(pairs).rotation.map(f64::to_degrees),
            _ => continue,
        };
        let (measured, published) = (score(&case.pairs(path.parent().unwrap())).unwrap(), case.stats.rmse);
        let name = format!("{} {} {} {}", case.case, case.metric, case.align, case.pose_relation);
        assert!(
            (measured - published).abs() < 1e-9 * published.max(1e-3),
            "{name}: {measured}, evo {published}"
        );
        compared += 1;
    }
    assert_eq!(compared, 4 * (2 + 8), "the file holds other cases than it did");
}

use approx::assert_relative_eq;
use serde::Deserialize;
use vantage_eval::result::metric::Metric;
use vantage_eval::score::adjusted_information::adjusted_information;
use vantage_eval::score::association::TrueTracklets;
use vantage_eval::score::clustering::cluster_scores;

#[derive(Deserialize)]
struct Expected {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    name: String,
    r#true: Vec<usize>,
    pred: Vec<usize>,
    ari: f64,
    nmi_arith: f64,
    ami_arith: f64,
    homogeneity: f64,
    completeness: f64,
    v_measure: f64,
    purity: f64,
    rand: f64,
    fowlkes_mallows: f64,
    hungarian_accuracy: f64,
    pairwise_tp: f64,
    pairwise_pred_pairs: f64,
    pairwise_true_pairs: f64,
}

#[test]
fn clusters_score_as_scikit_learn_scores_them() {
    let Some(path) = super::test_data("clustering/expected.json") else { return };
    let expected: Expected = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    assert!(expected.cases.len() >= 7, "the file holds fewer cases than it did");
    for case in expected.cases {
        let scores = cluster_scores(&case.r#true, &case.pred).unwrap();
        for (measured, published) in [
            (scores.ari, case.ari),
            (scores.nmi, case.nmi_arith),
            (scores.homogeneity, case.homogeneity),
            (scores.completeness, case.completeness),
            (scores.v_measure, case.v_measure),
            (scores.purity, case.purity),
        ] {
            assert!((measured - published).abs() < 1e-12, "{}: {scores:?}", case.name);
        }
        let ami = adjusted_information(&case.r#true, &case.pred).unwrap();
        assert!((ami - case.ami_arith).abs() < 1e-9, "{}: {ami}, {}", case.name, case.ami_arith);
    }
    assert_relative_eq!(
        cluster_scores(&[0, 0, 1, 2], &[0, 0, 1, 1]).unwrap().ari,
        4.0 / 7.0,
        epsilon = 1e-12
    );
}

/// Clusters as associations: each item a tracklet.
#[test]
fn associations_score_as_scikit_learn_and_scipy_score_clusters() {
    let Some(path) = super::test_data("clustering/expected.json") else { return };
    let expected: Expected = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    for case in expected.cases {
        let n = case.pred.len();
        let shown = case.r#true.iter().copied().map(Some).collect();
        let truth = TrueTracklets { tracklets: (0..n).collect(), shown, is_whole: vec![true; n] };
        let told: Vec<Option<usize>> = case.pred.iter().copied().map(Some).collect();
        let found = truth.scores(&told);
        let of = |metric: Metric| found.get(&metric).copied();
        let near = |ours: Option<f64>, theirs: f64, what: &str| {
            assert!(
                ours.is_some_and(|x| (x - theirs).abs() < 1e-12),
                "{}, {what}: {ours:?}, {theirs}",
                case.name
            );
        };
        near(of(Metric::IdentityF1), case.hungarian_accuracy, "matched");
        near(of(Metric::Ari), case.ari, "ARI");
        let (right, told, pairs) = (case.pairwise_tp, case.pairwise_pred_pairs, case.pairwise_true_pairs);
        for (metric, all) in [(Metric::PairPrecision, told), (Metric::PairRecall, pairs)] {
            match of(metric) {
                Some(share) => near(Some(share), right / all, "pairs"),
                None => assert_eq!(all, 0.0, "{}: {metric:?}", case.name),
            }
        }
        if let (Some(precision), Some(recall)) = (of(Metric::PairPrecision), of(Metric::PairRecall)) {
            near(Some((precision * recall).sqrt()), case.fowlkes_mallows, "Fowlkes and Mallows");
            let wrong = told - precision * told + pairs - recall * pairs;
            near(Some(1.0 - wrong / (n * (n - 1) / 2) as f64), case.rand, "Rand");
        }
    }
}

use approx::assert_relative_eq;
use serde::Deserialize;
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
    homogeneity: f64,
    completeness: f64,
    v_measure: f64,
    purity: f64,
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
    }
    assert_relative_eq!(
        cluster_scores(&[0, 0, 1, 2], &[0, 0, 1, 1]).unwrap().ari,
        4.0 / 7.0,
        epsilon = 1e-12
    );
}

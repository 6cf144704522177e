//! `bench SCENE --associate`: who is who where estimators are told less than all, and associations of others.

use std::fs;
use vantage_eval::result::metric::Metric;
use vantage_eval::result::results_file::Results;
use vantage_tests::{Finished, SmallScene};

#[test]
fn associations_are_a_table_and_files_that_score_as_they_did() {
    let scene = SmallScene::new(&[]);
    let told = Finished::of(scene.command().arg("--associate"));
    told.expect(0, &["associations: 2 of 2"]);
    for said in ["Pair F1", "tracklets-hypotheses_views", "<row>.association.csv", "association_times.md"] {
        assert!(told.stdout.contains(said), "{said} is missing: {}", told.stdout);
    }
    let place = scene.path("out/scenes/small");
    let results = Results::read(&place).unwrap();
    let (table, whole) = (results.table("association").unwrap(), results.table("trajectory").unwrap());
    assert_eq!(table.methods().len(), 21);
    for run in table.runs_of("given") {
        let of = |metric: Metric| run.scores[&metric];
        assert_eq!((of(Metric::PairF1), of(Metric::ObjectsFound), of(Metric::AllRight)), (1.0, 1.0, 1.0));
        let batch = whole.runs_of("geometric").iter().find(|batch| batch.seed == run.seed).unwrap();
        assert!((of(Metric::AteOfGeometric) - batch.scores[&Metric::Ate]).abs() < 1e-6);
    }
    for run in table.runs_of("tracklets-separate") {
        assert_eq!(run.scores[&Metric::PairPrecision], 1.0);
    }

    let mine = scene.path("mine");
    fs::create_dir(&mine).unwrap();
    for seed in ["0", "1"] {
        let answer = place.join(format!("{seed}/tracklets-hypotheses.association.csv"));
        fs::copy(answer, mine.join(format!("{seed}.csv"))).unwrap();
    }
    let mut again = scene.command();
    Finished::of(again.arg("--replace").arg("--associations").arg(&mine)).expect(0, &[]);
    let results = Results::read(&place).unwrap();
    let table = results.table("association").unwrap();
    for (ours, theirs) in table.runs_of("tracklets-hypotheses").iter().zip(table.runs_of("mine")) {
        for metric in [Metric::PairF1, Metric::Ari, Metric::ObjectsFound, Metric::AteOfGeometric] {
            assert_eq!(ours.scores.get(&metric), theirs.scores.get(&metric), "{metric:?}");
        }
    }

    fs::write(mine.join("1.csv"), "detection,object\n0,1\n0,2\n").unwrap();
    let mut wrong = scene.command();
    Finished::of(wrong.arg("--replace").arg("--associations").arg(&mine))
        .expect(2, &["--associations", "1.csv", "line 3", "stands there twice"]);
}

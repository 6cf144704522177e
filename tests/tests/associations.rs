//! `bench SCENE --associate`: who is who where estimators are told less than all, and associations of others.

use std::fs;
use vantage_eval::result::kind::ResultKind;
use vantage_eval::result::metric::Metric;
use vantage_eval::result::paired::Paired;
use vantage_eval::result::results_file::Results;
use vantage_eval::result::statistics::quantile;
use vantage_tests::{Finished, SmallScene, root};

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
    assert_eq!(table.methods().len(), 23);
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

    let theirs = || Finished::of(scene.command().arg("--replace").arg("--associations").arg(&mine));
    fs::write(mine.join("1.csv"), "detection,object\n0,1\n0,2\n").unwrap();
    theirs().expect(2, &["--associations", "1.csv", "line 3", "stands there twice"]);
    fs::write(mine.join("1.csv"), "detection,object\n90000,1\n").unwrap();
    let told = theirs();
    told.expect(2, &["mine/1.csv", "detection 90000, but seed 1 has", "bench dataset"]);
    assert!(!told.stderr.contains("associations: 1 of 2"), "{}", told.stderr);
    fs::remove_file(mine.join("1.csv")).unwrap();
    theirs().expect(0, &["1 of 2 runs of mine failed, that of seed 1 first: there is no 1.csv"]);
}

#[test]
fn a_robot_that_was_carried_is_scored_by_where_it_believes_to_be() {
    let carried = ("laps: 0.4\n", "laps: 0.4\n  carried_after: 0.2\n");
    let scene = SmallScene::new(&[carried]);
    let told = Finished::of(scene.command().arg("--associate"));
    told.expect(0, &["associations: 2 of 2"]);
    let results = Results::read(&scene.path("out/scenes/small")).unwrap();
    let table = results.table("association").unwrap();
    for run in table.runs_of("tracklets-hypotheses_views") {
        let of = |metric: Metric| run.scores[&metric];
        assert!(of(Metric::FinalPlace).is_finite() && of(Metric::DetectionsToResolve) > 0.0);
        assert!(
            of(Metric::WithinHalf) <= of(Metric::WithinOne) && of(Metric::WithinOne) <= of(Metric::WithinTwo)
        );
    }
    // Who never sees anything again believes in no place.
    assert!(
        table.runs_of("tracklets-separate").iter().all(|run| !run.scores.contains_key(&Metric::Resolved))
    );
}

/// The mean of the detections that each row of `tracklets` needs, its median, and its difference to a rival with half the 95% interval.
#[test]
fn what_is_said_of_carried_robots_is_of_the_raw_scores() {
    let docs = fs::read_to_string(root().join("docs/association.md")).unwrap();
    let of = |scene: &str| Results::read(&ResultKind::Scene.place(&root().join("results"), scene)).unwrap();
    let (aliased, different) = (of("kidnapped_aliased"), of("kidnapped"));
    let detections = Metric::DetectionsToResolve;
    let rows = |results: &Results, row: &str| {
        results.table("association").unwrap().runs_of(&format!("tracklets-hypotheses{row}")).to_vec()
    };
    for (results, row, mean, median) in [
        (&aliased, "", 16.7, 15.5),
        (&aliased, "_class", 16.8, 13.5),
        (&aliased, "_latents", 16.3, 14.5),
        (&aliased, "_views", 5.5, 4.0),
        (&different, "", 10.0, 9.5),
        (&different, "_class", 6.7, 5.5),
        (&different, "_latents", 5.7, 4.5),
        (&different, "_views", 2.7, 2.0),
    ] {
        let mut needed: Vec<f64> = rows(results, row).iter().map(|run| run.scores[&detections]).collect();
        needed.sort_by(f64::total_cmp);
        let got = needed.iter().sum::<f64>() / needed.len() as f64;
        assert!((got - mean).abs() < 0.051, "{row}: a mean of {got}, not {mean}");
        assert_eq!(quantile(&needed, 0.5), Some(median), "{row}");
    }
    for (results, row, rival, metric, mean, half) in [
        (&aliased, "_views", "_latents", detections, -10.8, 4.9),
        (&aliased, "_views", "", detections, -11.2, 4.7),
        (&aliased, "_latents", "", detections, -0.4, 2.4),
        (&aliased, "_views", "_latents", Metric::PlaceError, -0.57, 0.36),
        (&different, "_latents", "", detections, -4.3, 2.6),
        (&different, "_views", "_latents", detections, -3.1, 1.9),
    ] {
        let paired = Paired::of(metric, &rows(results, row), &rows(results, rival)).unwrap().mean().unwrap();
        let digits = if metric == detections { 1 } else { 2 };
        let said = format!("{:.digits$} ± {half:.digits$}", f64::abs(mean));
        assert!(docs.contains(&said), "{said} is not in the docs");
        let off = [paired.mean - mean, paired.half_width.unwrap() - half];
        let most = 0.51 * 10_f64.powi(-(digits as i32));
        assert!(off.iter().all(|off| off.abs() < most), "{row} to {rival}: {paired:?}, not {said}");
    }
}

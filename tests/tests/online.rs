//! `bench SCENE --online`: the estimate after every step, beside that of the whole episode.

use std::fs;
use vantage_eval::result::metric::Metric;
use vantage_eval::result::results_file::Results;
use vantage_eval::result::trajectory::Trajectory;
use vantage_tests::{Finished, SmallScene};

#[test]
fn estimates_after_every_step_are_a_table_a_plot_times_and_paths() {
    let scene = SmallScene::new(&[]);
    let mut command = scene.command();
    command.arg("--online");
    let told = Finished::of(&mut command);
    told.expect(0, &["online: 2 of 2"]);
    for said in [
        "Newest position",
        "milliseconds a step",
        "online.svg",
        "<method>.online.tum",
        "step_times.md",
        "step_errors.csv",
    ] {
        assert!(told.stdout.contains(said), "{said} is missing: {}", told.stdout);
    }
    let place = scene.path("out/scenes/small");
    let results = Results::read(&place).unwrap();
    let (online, whole) = (results.table("online").unwrap(), results.table("trajectory").unwrap());
    assert_eq!(online.methods(), ["odometry", "geometric", "viewpoint_dependent"]);
    for run in online.runs() {
        let batch = whole.runs_of(&run.method).iter().find(|batch| batch.seed == run.seed).unwrap();
        let score = |metric: Metric| run.scores[&metric];
        let apart = (score(Metric::AteAtEnd) - batch.scores[&Metric::Ate]).abs();
        let told = format!("{} on seed {}: {:?}", run.method, run.seed.0, run.scores);
        assert!(
            score(Metric::ApartAtEnd) < 0.02 && apart < 0.02 && score(Metric::NewestPosition) > 0.0,
            "{told}"
        );
        let path =
            fs::read_to_string(place.join(format!("{}/{}.online.tum", run.seed.0, run.method))).unwrap();
        let (newest, last) =
            (Trajectory::from_tum(&path).unwrap(), format!("{}/{}.tum", run.seed.0, run.method));
        let at_once = Trajectory::from_tum(&fs::read_to_string(place.join(last)).unwrap()).unwrap();
        assert_eq!(newest.timestamps(), at_once.timestamps());
    }
    let times = fs::read_to_string(place.join("step_times.md")).unwrap();
    assert!(times.contains("| geometric ") && times.contains("| geometric, 3 seen "), "{times}");

    let errors = fs::read_to_string(place.join("step_errors.csv")).unwrap();
    assert!(errors.starts_with("step,odometry,geometric,viewpoint_dependent\n0,0.000000,"), "{errors}");
    let newest = fs::read_to_string(place.join("0/geometric.online.tum")).unwrap();
    let steps = Trajectory::from_tum(&newest).unwrap().timestamps().len();
    assert_eq!(errors.lines().count(), steps + 1, "{errors}");

    let scores = |table: &str| Results::read(&place).unwrap().table(table).cloned();
    let before = scores("online");
    let mut again = scene.command();
    again.args(["--online", "--replace"]);
    Finished::of(&mut again).expect(0, &[]);
    assert_eq!(scores("online"), before, "a second run differs");
    scene.run().expect(0, &[]);
    assert_eq!(scores("online"), None);
    assert!(!place.join("online.svg").exists());
}

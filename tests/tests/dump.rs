//! `bench SCENE --dump`, and the script that computes the scores anew.

use std::process::Command;
use vantage_tests::{Finished, SmallScene, files, root};

#[test]
fn what_scores_are_made_of_is_left_and_makes_them_again() {
    let scene = SmallScene::new(&[]);
    let mut command = scene.command();
    command.args(["--dump", "--associate", "--online"]);
    Finished::of(&mut command).expect(0, &[]);
    let place = scene.path("out/scenes/small");
    let left: Vec<String> = files(&place).into_keys().map(|path| path.display().to_string()).collect();
    for seed in [0, 1] {
        for name in ["truth", "odometry", "geometric", "viewpoint_dependent", "pixels_pca64.latents"] {
            let file = format!("{seed}/{name}.npz");
            assert!(left.contains(&file), "{file} is not in {left:?}");
        }
    }

    assert!(left.contains(&"0/geometric.online.npz".to_owned()), "{left:?}");

    let python = std::env::var("VANTAGE_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let has = Command::new(&python).args(["-c", "import numpy, scipy, sklearn"]).output();
    if has.is_ok_and(|has| has.status.success()) {
        let script = root().join("examples/recompute/recompute.py");
        let told = Finished::of(Command::new(&python).arg(script).arg(&place));
        told.expect(0, &[]);
        assert!(told.stdout.contains(" 0 differ by more than"), "{}", told.stdout);
        for score in ["nees_pose", "nees_newest", "silhouette", "recall_at1", "pair_f1", "cluster_count"] {
            assert!(told.stdout.contains(score), "{score} was not computed anew: {}", told.stdout);
        }
    } else {
        eprintln!("SKIPPED: {python} lacks numpy, scipy or scikit-learn; set VANTAGE_PYTHON");
    }

    scene.run().expect(0, &[]);
    assert!(!files(&place).into_keys().any(|path| path.extension().is_some_and(|ending| ending == "npz")));
}

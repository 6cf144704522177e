//! `bench sweep`: tasks that fill the cache, and a merge that writes what one process would have written.

use std::fs;
use vantage_tests::{Finished, SmallScene, bench, files};

/// A plan of a small scene's run in so many tasks, in `plan`.
fn planned(scene: &SmallScene, tasks: &str) -> Finished {
    let path = |name: &str| scene.path(name).to_string_lossy().into_owned();
    let mut command = bench();
    command.args(["sweep", "plan", "--tasks", tasks, "--out", &path("plan"), "--", &path("scene.yaml")]);
    command.args(["--renderer", "reference", "--cache", &path("shared"), "--out", &path("merged")]);
    Finished::of(&mut command)
}

fn sweep(scene: &SmallScene, what: &str, more: &[&str]) -> Finished {
    Finished::of(bench().args(["sweep", what]).arg(scene.path("plan")).args(more))
}

#[test]
fn tasks_together_give_the_bytes_of_one_process() {
    let scene = SmallScene::new(&[]);
    scene.run().expect(0, &[]);
    planned(&scene, "3").expect(0, &[]);
    planned(&scene, "3").expect(0, &[]);
    planned(&scene, "4").expect(2, &["another plan", "--out"]);
    sweep(&scene, "merge", &[]).expect(4, &["not done: 0, 1, 2"]);
    sweep(&scene, "run", &[]).expect(2, &["which task", "SLURM_ARRAY_TASK_ID"]);
    sweep(&scene, "run", &["--index", "3"]).expect(2, &["no task 3"]);
    sweep(&scene, "run", &["--index", "2"]).expect(0, &[]);
    let told = |variable: &str, value: &str| {
        Finished::of(bench().env(variable, value).args(["sweep", "run"]).arg(scene.path("plan")))
    };
    told("SLURM_ARRAY_TASK_ID", "0").expect(0, &[]);
    sweep(&scene, "merge", &[]).expect(4, &["not done: 1"]);
    assert!(!scene.path("merged/scenes").exists());
    told("PARALLEL_SEQ", "2").expect(0, &[]);
    let again = told("JOB_COMPLETION_INDEX", "1");
    again.expect(0, &[]);
    assert!(again.stdout.contains("done already"), "{}", again.stdout);

    let both = Finished::of(
        bench()
            .envs([("SLURM_ARRAY_TASK_ID", "0"), ("PARALLEL_SEQ", "2")])
            .args(["sweep", "run"])
            .arg(scene.path("plan")),
    );
    both.expect(2, &["not the same one", "--index"]);
    told("HQ_TASK_ID", "last").expect(2, &["HQ_TASK_ID is \"last\""]);

    let estimates = || fs::read_dir(scene.path("shared/entries/estimate")).unwrap().count();
    let before = estimates();
    sweep(&scene, "merge", &[]).expect(0, &[]);
    assert_eq!(estimates(), before, "nothing is estimated again");
    let written = |out: &str| {
        let mut written = files(&scene.path(out));
        written.retain(|name, _| !name.ends_with("manifest.json") && !name.ends_with("report.html"));
        written
    };
    assert!(written("merged") == written("out"));

    let plan = fs::read(scene.path("plan/plan.json")).unwrap();
    fs::write(scene.path("plan/plan.json"), "{").unwrap();
    planned(&scene, "3").expect(2, &["plan.json"]);
    fs::remove_file(scene.path("plan/plan.json")).unwrap();
    planned(&scene, "3").expect(2, &["another plan"]);
    fs::write(scene.path("plan/plan.json"), plan).unwrap();
    let text = fs::read_to_string(scene.path("scene.yaml")).unwrap();
    fs::write(scene.path("scene.yaml"), text + "# changed\n").unwrap();
    sweep(&scene, "merge", &[]).expect(2, &["not as it was planned"]);
}

#[test]
fn jobs_are_written_for_slurm_and_kubernetes() {
    let scene = SmallScene::new(&[]);
    planned(&scene, "8").expect(0, &[]);
    let slurm = sweep(&scene, "slurm", &[]).stdout;
    assert!(slurm.contains("#SBATCH --array=0-7\n") && slurm.contains("exec bench sweep run '"), "{slurm}");
    let job = sweep(&scene, "kubernetes", &["--image", "lab/bench: x", "--claim", "work"]).stdout;
    assert!(job.contains("completionMode: Indexed\n  completions: 8\n"), "{job}");
    assert!(job.contains("image: \"lab/bench: x\"\n"), "{job}");
}

#[test]
fn what_has_no_parts_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let plan = |words: &[&str]| {
        Finished::of(
            bench()
                .args(["sweep", "plan", "--tasks", "2", "--out"])
                .arg(folder.path().join("p"))
                .arg("--")
                .args(words),
        )
    };
    plan(&["list"]).expect(2, &["only `SCENE`, `study` and `map`"]);
    plan(&["tabletop", "--sedes", "2"]).expect(2, &["no command of bench", "--sedes"]);
    plan(&["no_such_scene"]).expect(2, &["no_such_scene"]);
    Finished::of(bench().args(["sweep", "run"]).arg(folder.path())).expect(2, &["plan.json"]);
    fs::write(folder.path().join("plan.json"), "{\"version\": 9}").unwrap();
    Finished::of(bench().args(["sweep", "merge"]).arg(folder.path())).expect(2, &["plan.json", "sweep plan"]);
}

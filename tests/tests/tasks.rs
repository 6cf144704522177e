//! `bench task` and `bench score SEALED SUBMISSION`: episodes without their truth, and answers to them.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use vantage_dataset::store::{read_episode, read_observations};
use vantage_dataset::{Episode, Pose};
use vantage_tests::{Finished, SmallScene, bench, files};

const SECRET: &str = "nobody guesses this one";

/// A task of two episodes, in `task` and `sealed`.
fn task(scene: &SmallScene, options: &[&str]) -> Finished {
    let mut command = scene.on(&["task"], "scene.yaml");
    command.args(["--episodes", "2"]).args(options).arg("--secret").arg(secret(scene, SECRET));
    command.arg("--out").arg(scene.path("task")).arg("--truth").arg(scene.path("sealed"));
    Finished::of(&mut command)
}

/// A file that holds one.
fn secret(scene: &SmallScene, text: &str) -> PathBuf {
    let path = scene.path("secret");
    fs::write(&path, text).unwrap();
    path
}

fn hash(scene: &SmallScene) -> String {
    let task: Value = serde_json::from_slice(&fs::read(scene.path("task/task.json")).unwrap()).unwrap();
    task["truth"].as_str().unwrap().to_owned()
}

fn score(scene: &SmallScene, options: &[&str]) -> Finished {
    let mut command = bench();
    command.arg("score").arg(scene.path("sealed")).arg(scene.path("mine")).args(options);
    command.arg("--task").arg(scene.path("task"));
    Finished::of(&mut command)
}

fn sealed(scene: &SmallScene) -> Value {
    serde_json::from_slice(&fs::read(scene.path("sealed/sealed.json")).unwrap()).unwrap()
}

/// The truth as a submission, the map in the frame of the trajectory.
fn submit_truth(scene: &SmallScene) -> PathBuf {
    let mine = scene.path("mine");
    for folder in ["trajectories", "associations", "maps"] {
        fs::create_dir_all(mine.join(folder)).unwrap();
    }
    let about = format!("name: oracle\ndivision: open\ntask: {}\n", hash(scene));
    fs::write(mine.join("submission.yaml"), about).unwrap();
    for number in 0..2 {
        let episode = read_episode(&scene.path(&format!("sealed/{number}"))).unwrap();
        let truth = scene.path(&format!("sealed/{number}/truth/robot.tum"));
        fs::copy(truth, mine.join(format!("trajectories/{number}.tum"))).unwrap();
        fs::write(mine.join(format!("maps/{number}.csv")), map(&episode)).unwrap();
        let order = &sealed(scene)["episodes"][number]["order"];
        let rows = order.as_array().unwrap().iter().enumerate().map(|(row, at)| {
            let track = episode.observations.detections[at.as_u64().unwrap() as usize].track;
            format!("{row},{track}\n")
        });
        let text: String = std::iter::once("detection,object\n".to_owned()).chain(rows).collect();
        fs::write(mine.join(format!("associations/{number}.csv")), text).unwrap();
    }
    mine
}

/// The true objects: centres in the world's frame, the sides of boxes along the axes of the robot's first pose.
fn map(episode: &Episode) -> String {
    let first = episode.truth.world_from_robot[0];
    let mut text = "x,y,z,length,width,height,label,e0\n".to_owned();
    for object in &episode.truth.objects {
        let center = object.world_from_object.translation.vector;
        let first_from_object = first.inverse() * object.world_from_object;
        let sides = first_from_object.rotation.to_rotation_matrix().matrix().abs()
            * object.extents.unwrap().half_sides
            * 2.0;
        let [x, y, z] = center.into();
        let [length, width, height] = sides.into();
        text += &format!("{x},{y},{z},{length},{width},{height},{},1\n", object.family);
    }
    text
}

/// The scores of a row on an episode.
fn scores(told: &Finished, table: &str, row: &str, episode: u64) -> Value {
    let told: Value = serde_json::from_str(&told.stdout).unwrap();
    let tables = told["tables"].as_array().unwrap();
    let table = tables.iter().find(|found| found["name"] == table).unwrap();
    let runs = table["runs"].as_array().unwrap();
    runs.iter().find(|run| run["method"] == row && run["seed"] == episode).unwrap().clone()
}

#[test]
fn a_task_holds_nothing_that_was_true_and_the_truth_is_a_perfect_answer() {
    let scene = SmallScene::new(&[]);
    let told = task(&scene, &[]);
    // The way of this scene is the same for all seeds.
    told.expect(0, &["episodes: 2 of 2", "the same path in all episodes"]);
    let sealed = sealed(&scene);
    let seeds: Vec<String> =
        sealed["episodes"].as_array().unwrap().iter().map(|episode| episode["seed"].to_string()).collect();
    for (path, bytes) in files(&scene.path("task")) {
        assert!(!path.starts_with("truth") && !path.to_string_lossy().contains("truth"), "{path:?}");
        let text = String::from_utf8_lossy(&bytes);
        for secret in seeds.iter().map(String::as_str).chain([SECRET]) {
            assert!(!text.contains(secret), "{path:?} tells {secret}");
        }
    }
    assert!(read_observations(&scene.path("task/1")).is_ok());

    // A killed run's folders are taken up: the same task once more changes no byte.
    let before = [files(&scene.path("task")), files(&scene.path("sealed"))];
    fs::remove_file(scene.path("task/task.json")).unwrap();
    task(&scene, &[]).expect(0, &[]);
    assert_eq!([files(&scene.path("task")), files(&scene.path("sealed"))], before);

    submit_truth(&scene);
    let told = score(&scene, &["--json"]);
    told.expect(0, &[]);
    for episode in [0, 1] {
        let driven = &scores(&told, "trajectory", "oracle", episode)["scores"]["ate"];
        assert!(driven.as_f64().unwrap() < 1e-9, "{driven}");
        assert!(scores(&told, "trajectory", "odometry", episode)["scores"]["ate"].as_f64().unwrap() > 1e-6);
        let associated = &scores(&told, "association", "oracle", episode)["scores"];
        assert_eq!((&associated["pair_f1"], &associated["ami"]), (&1.0.into(), &1.0.into()));
        let mapped = scores(&told, "object_map", "oracle", episode)["scores"].clone();
        assert!(mapped["map_center"].as_f64().unwrap() < 1e-9, "{mapped}");
    }
    let table = score(&scene, &[]);
    table.expect(0, &[]);
    for said in ["oracle, open division, 2 episodes; truth", "object_map", "semantics", "OMQ"] {
        assert!(table.stdout.contains(said), "{said:?} is not in {}", table.stdout);
    }

    fs::remove_file(scene.path("mine/trajectories/1.tum")).unwrap();
    let told = score(&scene, &["--json"]);
    told.expect(0, &[]);
    let failed = |table: &str| scores(&told, table, "oracle", 1)["outcome"].to_string();
    assert!(failed("trajectory").contains("there is no 1.tum"));
    assert!(failed("object_map").contains("whose frame it is in"), "{}", failed("object_map"));
    assert!(failed("semantics").contains("whose frame it is in"));
}

#[test]
fn boxes_are_laid_along_the_first_pose_and_a_perfect_map_has_quality_one() {
    let scene = SmallScene::new(&[]);
    task(&scene, &[]).expect(0, &[]);
    let mine = submit_truth(&scene);
    // Without trajectories, maps are in the frame of the first pose.
    fs::remove_dir_all(mine.join("trajectories")).unwrap();
    for number in 0..2 {
        let episode = read_episode(&scene.path(&format!("sealed/{number}"))).unwrap();
        let first = episode.truth.world_from_robot[0];
        let mut moved = episode.clone();
        moved.truth.world_from_robot[0] = Pose::identity();
        for object in &mut moved.truth.objects {
            object.world_from_object = first.inverse() * object.world_from_object;
        }
        fs::write(mine.join(format!("maps/{number}.csv")), map(&moved)).unwrap();
    }
    let told = score(&scene, &["--json"]);
    told.expect(0, &[]);
    for episode in [0, 1] {
        let mapped = scores(&told, "object_map", "oracle", episode)["scores"].clone();
        let seen = mapped["map_recall"].as_f64().unwrap();
        assert_eq!(seen, 1.0, "{mapped}");
        assert!((mapped["map_overlap"].as_f64().unwrap() - 1.0).abs() < 1e-9, "{mapped}");
    }
}

#[test]
fn what_is_not_told_of_who_is_who_is_not_in_the_task() {
    let scene = SmallScene::new(&[]);
    task(&scene, &["--association", "none"]).expect(0, &[]);
    for number in 0..2 {
        let seen = read_observations(&scene.path(&format!("task/{number}"))).unwrap();
        let tracks: Vec<usize> = seen.detections.iter().map(|detection| detection.track).collect();
        let mut sorted = tracks.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), tracks.len(), "each detection is one of its own");
    }
    submit_truth(&scene);
    let told = score(&scene, &["--json"]);
    told.expect(0, &[]);
    assert_eq!(scores(&told, "association", "oracle", 0)["scores"]["pair_f1"], 1.0);
}

#[test]
fn classes_and_episodes_that_the_task_does_not_have_are_told() {
    let scene = SmallScene::new(&[]);
    task(&scene, &[]).expect(0, &[]);
    let mine = submit_truth(&scene);
    assert!(!score(&scene, &[]).stderr.contains("note:"), "all is known");
    let task: Value = serde_json::from_slice(&fs::read(scene.path("task/task.json")).unwrap()).unwrap();
    let known = task["classes"][0].as_str().unwrap();
    fs::write(mine.join("maps/0.csv"), format!("x,y,z,label\n1,2,3,tome\n1,2,3,cup\n1,2,3,{known}\n"))
        .unwrap();
    fs::write(mine.join("maps/1.csv"), "x,y,z\n1,2,3\n").unwrap();
    fs::copy(mine.join("maps/1.csv"), mine.join("maps/2.csv")).unwrap();
    let words = ["2 of 3 objects with a label", "count as wrong: cup, tome; it has", known];
    score(&scene, &[]).expect(0, &words);
    score(&scene, &[]).expect(0, &["1 files in", "maps are of no episode and not scored, 2.csv first"]);
    fs::write(mine.join("maps/0.csv"), "x,y,z,label\n1,2,3,tome\n").unwrap();
    score(&scene, &[])
        .expect(2, &["none of the maps' 1 objects", "they are tome", known, "rename the labels"]);
    let mut alone = bench();
    alone.arg("score").arg(scene.path("sealed")).arg(&mine);
    Finished::of(&mut alone).expect(0, &["1 of 1 objects with a label", "that the truth lacks"]);
}

fn tamper(path: &Path, old: &str, new: &str) {
    let text = fs::read_to_string(path).unwrap();
    assert!(text.contains(old), "{old:?} is not in {text}");
    fs::write(path, text.replacen(old, new, 1)).unwrap();
}

#[test]
fn a_truth_that_was_changed_is_noticed() {
    let scene = SmallScene::new(&[]);
    task(&scene, &[]).expect(0, &[]);
    submit_truth(&scene);
    let objects = scene.path("sealed/1/truth/objects.csv");
    let before = fs::read_to_string(&objects).unwrap();
    fs::write(&objects, before.replacen("0.", "1.", 1)).unwrap();
    score(&scene, &[]).expect(5, &["truth/objects.csv"]);
    fs::write(&objects, before).unwrap();
    score(&scene, &[]).expect(0, &[]);
    tamper(&scene.path("sealed/sealed.json"), SECRET, "another secret");
    score(&scene, &[]).expect(5, &["is not the truth of the task"]);
    let mut alone = bench();
    alone.arg("score").arg(scene.path("sealed")).arg(scene.path("mine"));
    Finished::of(&mut alone).expect(2, &["submission.yaml: task:"]);
}

#[test]
fn what_cannot_be_published_or_scored_is_told_with_a_remedy() {
    let scene = SmallScene::new(&[]);
    let written = |out: &str, truth: &str, secret: &str| {
        let mut command = scene.on(&["task"], "scene.yaml");
        command.args(["--episodes", "1", "--secret"]).arg(self::secret(&scene, secret));
        command.arg("--out").arg(scene.path(out)).arg("--truth").arg(scene.path(truth));
        Finished::of(&mut command)
    };
    written("task", "task/sealed", SECRET).expect(2, &["which is published", "beside it"]);
    written("sealed/task", "sealed", SECRET).expect(2, &["which is published"]);
    written("task", "sealed", "short").expect(2, &["5 different characters of 5", "at least 8 of 16"]);
    written("task", "sealed", &" ".repeat(20)).expect(2, &["0 different characters"]);
    fs::create_dir_all(scene.path("data/0/truth")).unwrap();
    written("data", "sealed", SECRET).expect(2, &["data/0 is not of this task"]);
    task(&scene, &[]).expect(0, &[]);
    written("task", "sealed", SECRET).expect(2, &["task/1 is not of this task"]);
    written("other", "sealed", SECRET).expect(2, &["sealed/1 is not of this task"]);
    task(&scene, &["--association", "none"]).expect(2, &["sealed.json is not of this task"]);

    let mine = scene.path("mine");
    fs::create_dir(&mine).unwrap();
    score(&scene, &[]).expect(2, &["submission.yaml"]);
    for (text, words) in [
        ("name: mine", "division"),
        ("name: mine\ndivision: half", "division"),
        ("name: <b>mine</b>\ndivision: open", "name: expected letters"),
        ("name: ../mine\ndivision: open", "name: expected letters"),
        ("name: ..\ndivision: open", "name: expected letters"),
        ("name: odometry\ndivision: open", "a row of ours"),
        ("name: mine\ndivision: open", "nothing to score"),
    ] {
        fs::write(mine.join("submission.yaml"), format!("{text}\ntask: {}\n", hash(&scene))).unwrap();
        score(&scene, &[]).expect(2, &["mine", words]);
    }
    for options in [
        &["--evo", "evo"][..],
        &["--align", "origin"],
        &["--delta", "1"],
        &["--unit", "metres"],
        &["--all-pairs"],
        &["--max-difference", "0.01"],
        &["--map", "map.csv", "--true-map", "true.csv"],
    ] {
        let told = format!("{} says nothing of a submission; leave it out", options[0]);
        score(&scene, options).expect(2, &[&told]);
    }
    fs::create_dir(mine.join("maps")).unwrap();
    score(&scene, &[]).expect(2, &["maps", "no map; expected 0.csv"]);
    fs::write(mine.join("maps/0.csv"), "x,y,z\n1,2,nan\n").unwrap();
    score(&scene, &[]).expect(2, &["maps/0.csv", "line 2, z: got \"nan\""]);
    fs::write(mine.join("maps/0.csv"), "x,y,z,e0\n1,2,3,0\n").unwrap();
    fs::create_dir(mine.join("map")).unwrap();
    score(&scene, &[]).expect(0, &["mine/map is not scored"]);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(scene.path("sealed/1/truth/robot.tum"), mine.join("maps/1.csv")).unwrap();
        score(&scene, &[]).expect(2, &["maps/1.csv", "it is a link"]);
    }
}

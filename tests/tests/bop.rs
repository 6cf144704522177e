//! The layout of BOP, out and in: what `bench dataset` writes is what `bench import` reads, with masks and without.

use std::fs;
use vantage_dataset::store::{read_episode, read_views, write_episode};
use vantage_dataset::{Episode, Pose, Seed, Tangent, se3};
use vantage_tests::{Finished, SmallScene, bench};

#[test]
fn what_was_written_as_bop_is_read_as_the_same_episodes() {
    let scene = SmallScene::new(&[]);
    Finished::of(&mut scene.dataset("d", &["--seeds", "2", "--format", "vantage,bop"])).expect(0, &[]);
    let import = |out: &str, more: &[&str]| {
        let mut command = bench();
        command.args(["import", "bop"]).arg(scene.path("d/bop")).arg("--out").arg(scene.path(out)).args(more);
        Finished::of(&mut command)
    };
    let like = scene.path("scene.yaml");
    let like = ["--like", like.to_str().unwrap()];
    import("episodes", &[&like[..], &["--draws", "2"]].concat()).expect(0, &[]);
    for seed in 0..2 {
        let own = read_episode(&scene.path(&format!("d/{seed}"))).unwrap();
        let read = read_episode(&scene.path(&format!("episodes/{}", 2 * seed + 1))).unwrap();
        assert_eq!(read.seed, Seed(2 * seed + 1));
        let (seen, expected) = (&read.observations, &own.observations);
        assert_eq!((seen.steps(), seen.detections.len()), (expected.steps(), expected.detections.len()));
        let cameras = |episode: &Episode| -> Vec<Pose> {
            let on_robot = episode.observations.robot_from_camera;
            episode.truth.world_from_robot.iter().map(|pose| pose * on_robot).collect()
        };
        for (a, b) in cameras(&read).iter().zip(cameras(&own)) {
            assert!((a.translation.vector - b.translation.vector).norm() < 1e-8);
            assert!(a.rotation.angle_to(&b.rotation) < 1e-7);
        }
        let place = |episode: &Episode, track: usize| {
            episode.truth.objects[track].world_from_object.translation.vector
        };
        for detection in &expected.detections {
            let at = place(&own, detection.track);
            let same = seen
                .detections
                .iter()
                .find(|other| other.step == detection.step && (place(&read, other.track) - at).norm() < 1e-4);
            let same = same.unwrap();
            assert_eq!(same.bounding_box, detection.bounding_box);
            assert_eq!(same.mask_pixels, detection.mask_pixels);
            assert!(same.masked_crop == detection.masked_crop);
        }
        assert!(
            seen.odometry[0].robot_from_robot
                != read_episode(&scene.path(&format!("episodes/{}", 2 * seed)))
                    .unwrap()
                    .observations
                    .odometry[0]
                    .robot_from_robot
        );
    }
    import("views", &[&like[..], &["--views", "--split", "test"]].concat()).expect(0, &[]);
    let set = read_views(&scene.path("views")).unwrap();
    assert!(set.views.iter().all(|view| view.sighting.is_some()));
    let masked = read_episode(&scene.path("episodes/1")).unwrap();
    for split in fs::read_dir(scene.path("d/bop/test")).unwrap() {
        for masks in ["mask", "mask_visib"] {
            fs::remove_dir_all(split.as_ref().unwrap().path().join(masks)).unwrap();
        }
    }
    import("drawn", &like).expect(0, &[]);
    let drawn = read_episode(&scene.path("drawn/0")).unwrap();
    let of = |episode: &Episode| episode.observations.detections.clone();
    assert!(of(&drawn).len() > 20 && of(&drawn).len() == of(&masked).len());
    for (a, b) in of(&drawn).iter().zip(&of(&masked)) {
        assert_eq!((a.step, a.track, a.bounding_box), (b.step, b.track, b.bounding_box));
        assert!(a.mask_pixels.abs_diff(b.mask_pixels) <= 2 + b.mask_pixels / 50, "{a:?} {b:?}");
    }
    import("none", &["--objects", "obj_000001"]).expect(2, &["--objects is for a view set"]);
    import("none", &["--views", "--objects", "obj_000099"]).expect(2, &["no object obj_000099"]);

    let broken = scene.path("broken/test/000000");
    fs::create_dir_all(&broken).unwrap();
    let whole = scene.path("d/bop/test/000000");
    for name in ["scene_gt.json", "scene_camera.json"] {
        let text = fs::read_to_string(whole.join(name)).unwrap();
        let all: serde_json::Map<String, serde_json::Value> = serde_json::from_str(&text).unwrap();
        let two: serde_json::Map<_, _> =
            all.into_iter().filter(|(image, _)| image == "0" || image == "1").collect();
        fs::write(broken.join(name), serde_json::to_vec(&two).unwrap()).unwrap();
    }
    let import = || {
        let mut command = bench();
        command.args(["import", "bop"]).arg(scene.path("broken")).arg("--out").arg(scene.path("none"));
        Finished::of(&mut command)
    };
    let without = import();
    without.expect(5, &["broken, models: got no folder of them", "fetch the dataset's models"]);
    assert!(!without.stderr.contains("fewer than 3") && !scene.path("none").exists(), "{without:?}");
    fs::rename(scene.path("d/bop/models"), scene.path("broken/models")).unwrap();
    import().expect(4, &["fewer than 3"]);

    let recorded = |seeds: &str, folder: &str| {
        let changed = format!("evaluation: {{ seeds: {seeds}, episodes: {folder} }}");
        let text = fs::read_to_string(scene.path("scene.yaml")).unwrap();
        let at = text.find("evaluation:").unwrap();
        fs::write(scene.path("recorded.yaml"), format!("{}{changed}\n", &text[..at])).unwrap();
        Finished::of(scene.on(&[], "recorded.yaml").arg("--out").arg(scene.path("out")))
    };
    recorded("5", "episodes").expect(2, &["no folder", "episodes/4"]);
    recorded("2", "nowhere").expect(2, &["evaluation.episodes"]);
    let mut tilted = read_episode(&scene.path("episodes/0")).unwrap();
    let tilt = se3::exp(&(Tangent::y() * 0.35));
    tilted.truth.world_from_robot.iter_mut().for_each(|pose| *pose *= tilt);
    tilted.observations.robot_from_camera = tilt.inverse() * tilted.observations.robot_from_camera;
    write_episode(&scene.path("tilted/0"), &tilted, Default::default()).unwrap();
    recorded("1", "tilted").expect(2, &["tilted/0: truth/robot.tum", "20.1 degrees off", "import it again"]);
    recorded("4", "episodes").expect(0, &["note: The episodes were recorded."]);
    for command in ["look", "headroom", "calibrate"] {
        Finished::of(&mut scene.on(&[command], "recorded.yaml")).expect(2, &["this command simulates"]);
    }
    let map = "version: 1\nname: simulated\npurpose: p\nscene: recorded.yaml\nacross: { field: world.objects, over: [1, 2] }\n\
               estimates: [{ rows: [geometric] }]\npanels: [{ name: a, title: a }]\n";
    fs::write(scene.path("map.yaml"), map).unwrap();
    let mut map = scene.on(&["map"], "map.yaml");
    Finished::of(map.arg("--out").arg(scene.path("out"))).expect(2, &["vary the estimator alone"]);
    let mut dataset = scene.on(&["dataset"], "recorded.yaml");
    Finished::of(dataset.arg("--out").arg(scene.path("simulated"))).expect(2, &["this command simulates"]);
}

//! The layouts of BigBIRD and Active Vision, out and in: what `bench dataset` writes, `bench import` reads, and `bench train`
//! learns from.

use std::fs;
use std::path::{Path, PathBuf};
use vantage_dataset::store::{read_episode, read_views};
use vantage_dataset::{Seed, Split};
use vantage_formats::verify_layout;
use vantage_tests::{Finished, SmallScene, assert_resumes, bench};

const CIRCLE: &str = "circle: { radius: 1.6 }\n  laps: 0.4\n  speed: 0.3\n  steps: 12";

fn turntable() -> SmallScene {
    let path = "turntable: { distance: 0.8, elevations_deg: [5, 20, 35, 50, 65], angles: 8 }";
    SmallScene::new(&[
        ("radius: 0.45", "radius: 0.2"),
        ("objects: 3", "objects: 1"),
        (CIRCLE, path),
        ("height: 1.25, yaw_deg: 90, pitch_deg: -16", "height: 0.8, yaw_deg: 0, pitch_deg: 0"),
        (
            "training:\n  seed: 1",
            "training:\n  seed: 1\n  model: { trunk_steps: 2, steps: 2, batch: 4, trunk_batch: 8, measurement_dim: 8 }",
        ),
    ])
}

fn dataset(scene: &SmallScene, formats: &str, seeds: &str) -> Finished {
    Finished::of(&mut scene.dataset("d", &["--seeds", seeds, "--format", formats]))
}

#[test]
fn a_model_learns_from_turntables_in_the_layout_of_bigbird() {
    let scene = turntable();
    dataset(&scene, "bigbird,webdataset", "5").expect(0, &[]);
    let root = scene.path("d/bigbird");
    let mut names: Vec<PathBuf> = fs::read_dir(&root).unwrap().map(|entry| entry.unwrap().path()).collect();
    names.retain(|path| path.is_dir());
    names.sort();
    let names: Vec<String> =
        names.iter().map(|path| path.file_name().unwrap().to_string_lossy().into_owned()).collect();
    assert_eq!(names.len(), 5, "{names:?}");
    let images = fs::read_dir(root.join(&names[0])).unwrap().count();
    assert_eq!(images, 2 * 40 + 3, "an image and its depth, masks, poses, calibration.h5");
    let manifest = verify_layout(&root).unwrap();
    let mut parts: Vec<_> = manifest.shards.iter().map(|part| part.name.clone()).collect();
    parts.sort();
    assert_eq!((parts, manifest.samples), (names.clone(), 5 * 40));
    let poses = root.join(&names[0]).join("calibration.h5");
    let whole = fs::read(&poses).unwrap();
    fs::write(&poses, [&whole[..whole.len() - 1], b"?"].concat()).unwrap();
    assert!(verify_layout(&root).is_err(), "a changed file is found");
    dataset(&scene, "bigbird", "5").expect(5, &[&names[0], "blake3"]);
    fs::write(&poses, whole).unwrap();

    let import = |split: &str, objects: &str, out: &str| {
        let mut command = bench();
        command.args(["import", "bigbird"]).arg(&root).args(["--split", split, "--objects", objects]);
        Finished::of(command.arg("--out").arg(scene.path(out)))
    };
    import("train", &names[..3].join(","), "train").expect(0, &[]);
    import("validation", &names[3], "validation").expect(0, &[]);
    import("train", "no_such_object", "nothing").expect(2, &["no_such_object"]);
    let set = read_views(&scene.path("train")).unwrap();
    assert_eq!((set.split, set.instances.len()), (Split::Train, 3));
    assert!(set.views.len() >= 110, "{} of 120 views", set.views.len());

    for (views, wrong) in [
        ("validation", "validation, which --views names"),
        ("train", "train, which --validation-views names"),
    ] {
        let mut train = scene.on(&["train"], "scene.yaml");
        train.arg("--views").arg(scene.path(views)).arg("--validation-views").arg(scene.path(views));
        let told = Finished::of(train.arg("--out").arg(scene.path("swapped")));
        let other = if views == "train" { "validation" } else { "train" };
        let remedy =
            format!("holds views of split {views}, expected {other}: import them with `--split {other}`");
        told.expect(2, &[wrong, &remedy]);
        assert!(!scene.path("swapped").exists(), "an empty folder is left");
    }
    Finished::of(&mut scene.train_on_views()).expect(0, &[]);
    assert!(scene.path("model/model.yaml").exists());

    let study = |views: &str, more: &str| {
        let own = "  - { name: own, note: trained on the others, folder: model }";
        scene.study("imported", &format!("seeds: 1\nviews: {views}\n{more}variants:\n{own}\n"))
    };
    import("test", &names[3..].join(","), "both").expect(0, &[]);
    import("test", &names[4], "test").expect(0, &[]);
    study("test", "training_views: train\n").expect(2, &["training_views", "trains no variant"]);
    study("nowhere", "").expect(2, &["no folder", "nowhere, which `views` of", "bench import"]);
    study("test", "validation_views: gone\n").expect(2, &["gone, which `validation_views` of"]);
    study("test", "scored: known\n").expect(2, &["views", "leave out"]);
    study("both", "").expect(2, &["was trained on it"]);
    study("test", "").expect(0, &[]);
    assert!(fs::read_to_string(scene.path("out/studies/imported/tables.md")).unwrap().contains("| own "));
    assert!(
        fs::read_to_string(scene.path("out/studies/imported/variants.md"))
            .unwrap()
            .contains("the views in test")
    );
    let asked = study("test", "known_views: [2, 1000]\n");
    asked.expect(0, &["validation views", "known_views 1000: no scored object"]);
    assert!(!asked.stderr.contains("known_views 2: no scored object"), "{}", asked.stderr);
    assert!(!asked.stderr.contains("train views"), "nothing is trained: {}", asked.stderr);
    assert!(asked.stdout.contains("known_views_2, "), "{}", asked.stdout);
    assert!(scene.path("out/studies/imported/study.json").exists());
    let tables = fs::read_to_string(scene.path("out/studies/imported/tables.md")).unwrap();
    let known = tables.split("known_views_2, ").nth(1).unwrap();
    assert!(
        ["| own ", "| own+process ", "| gaussian_process "].iter().all(|row| known.contains(row)),
        "{known}"
    );
    let own = "variants:\n  - { name: own, note: trained on images, folder: model }\n";
    scene.study("simulated", &format!("seeds: 1\nknown_views: [2]\n{own}")).expect(0, &[]);
    let pictures = |study: &str| {
        let is_there = |name: &str| scene.path(&format!("out/studies/{study}")).join(name).exists();
        ["latents.svg", "latents.png", "worst_azimuths.png"].map(is_there)
    };
    assert_eq!(pictures("imported"), [true, false, false], "no image of others is shown");
    assert_eq!(pictures("simulated"), [false, true, true]);
    let trained =
        "training_views: train\nvalidation_views: validation\nscored: known\nseeds: 1\nknown_views: [2]\n";
    scene.study("known", &format!("{trained}variants:\n  - {{ name: own, note: same }}\n")).expect(0, &[]);
    let tables = fs::read_to_string(scene.path("out/studies/known/tables.md")).unwrap();
    let known = tables.split("known_views_2, ").nth(1).unwrap();
    assert!(known.contains("| own ") && known.contains("| gaussian_process "), "{known}");
    let swapped = trained.replace(": train\n", ": validation\n");
    scene.study("swapped", &format!("{swapped}variants:\n  - {{ name: own, note: same }}\n")).expect(
        2,
        &["validation, which `training_views` of", "holds views of split validation", "`--split train`"],
    );
    let few = "variants:\n  - { name: own, note: same, composites: 0 }\n";
    scene.study("few", &format!("{trained}{few}")).expect(2, &["scored as known"]);
    let variants = "variants:\n  - { name: own, note: same, model: { objective: viewpoint_predictive } }\n";
    scene.study("blind", &format!("{trained}{variants}")).expect(2, &["import views that have it"]);
    study("test", "scored_scene: scene.yaml\n").expect(2, &["scored_scene", "beside `views`"]);
    let mut figures = scene.on(&["figures"], "scene.yaml");
    figures.arg("--model").arg(scene.path("model")).arg("--views").arg(scene.path("test"));
    Finished::of(figures.arg("--out").arg(scene.path("figures"))).expect(0, &["two sessions"]);
    assert!(scene.path("figures/latents.png").exists());
}

#[test]
fn photographs_are_read_by_the_names_of_their_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("photos")).unwrap();
    for (name, value) in [("cup__0.png", 200), ("cup__90.png", 150), ("pen__10.png", 90), ("pen__20.png", 0)]
    {
        let is_object = |place: u32| (2..7).contains(&place);
        let pixel = |x, y| image::Rgb([if is_object(x) && is_object(y) { value } else { 0 }; 3]);
        image::RgbImage::from_fn(9, 9, pixel).save(at("photos").join(name)).unwrap();
    }
    image::RgbImage::from_pixel(9, 9, image::Rgb([200; 3])).save(at("photos/pen_40.png")).unwrap();
    fs::copy(at("photos/pen_40.png"), at("photos/pen__50.png")).unwrap();
    let import = |out: &str, more: &[&str]| {
        let mut command = bench();
        command.args(["import", "folder"]).arg(at("photos")).arg("--out").arg(at(out)).args(more);
        Finished::of(&mut command)
    };
    import("views", &["--split", "test", "--elevation-deg", "-20", "--clockwise"]).expect(
        0,
        &["pen__20.png: no pixel is the object's", "pen_40.png: is not named", "pen__50.png, background"],
    );
    let set = read_views(&at("views")).unwrap();
    assert_eq!((set.split, set.instances.len(), set.views.len()), (Split::Test, 2, 3));
    let turned = &set.views[1].viewpoint;
    assert!((turned.azimuth().to_degrees() + 90.0).abs() < 1e-9);
    assert!((turned.elevation().to_degrees() + 20.0).abs() < 1e-9);
    import("cups", &["--objects", "cup"]).expect(0, &[]);
    assert_eq!(read_views(&at("cups")).unwrap().instances.len(), 1);
    import("none", &["--objects", "fork"]).expect(2, &["no object fork"]);
    import("high", &["--elevation-deg", "90"]).expect(2, &["-85 to 85"]);
    for distance in ["1e30", "inf", "NaN", "0.49", "0", "-5"] {
        import("far", &["--distance", distance])
            .expect(2, &["--distance", "sizes of the object from 0.5 to 1000"]);
    }
    import("near", &["--distance", "0.5"]).expect(0, &[]);
    fs::create_dir(at("empty")).unwrap();
    let mut command = bench();
    command.args(["import", "folder"]).arg(at("empty")).arg("--out").arg(at("nothing"));
    let nothing = Finished::of(&mut command);
    nothing.expect(4, &[]);
    assert!(nothing.stdout.contains("looked for photographs named"), "{nothing:?}");
}

#[test]
fn options_without_effect_on_what_is_imported_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let import = |layout: &str, more: &[&str]| {
        let mut command = bench();
        command.args(["import", layout]).arg(folder.path()).arg("--out").arg(folder.path().join("out"));
        Finished::of(command.args(more))
    };
    for layout in ["bigbird", "avd", "bop"] {
        for option in [&["--clockwise"][..], &["--elevation-deg", "25"], &["--distance", "5"]] {
            import(layout, option).expect(2, &[option[0], "is for `folder`"]);
        }
    }
    for layout in ["bigbird", "folder"] {
        import(layout, &["--views"]).expect(2, &["--views is for `avd` and `bop`"]);
    }
    for layout in ["avd", "bop"] {
        let drawn = ["--views", "--like", "sparse_loop", "--draws", "2"];
        import(layout, &drawn).expect(2, &["--draws", "--views"]);
    }
}

#[test]
fn an_import_tells_what_it_lacks_and_leaves_nothing_where_it_finds_nothing() {
    let scene = turntable();
    dataset(&scene, "bigbird", "2").expect(0, &[]);
    let root = scene.path("d/bigbird");
    let manifest = verify_layout(&root).unwrap();
    let [whole, other] = [0, 1].map(|i| root.join(&manifest.shards[i].name));
    let import = |folder: &Path| {
        Finished::of(bench().args(["import", "bigbird"]).arg(folder).arg("--out").arg(scene.path("views")))
    };
    fs::remove_file(other.join("calibration.h5")).unwrap();
    fs::rename(whole.join("masks"), whole.join("aside")).unwrap();
    import(&root).expect(4, &[&format!("left out: {}: no calibration.h5", other.display())]);
    assert!(!scene.path("views").exists(), "an empty folder is left");
    fs::rename(whole.join("aside"), whole.join("masks")).unwrap();
    import(&root).expect(0, &["no calibration.h5"]);
    assert_eq!(read_views(&scene.path("views")).unwrap().instances.len(), 1);

    let refused = |folder: &Path, words: &str| {
        let _ = fs::remove_dir_all(scene.path("views"));
        let finished = import(folder);
        finished.expect(2, &[words]);
        assert!(!scene.path("views").exists(), "an empty folder is left");
        assert!(!finished.stderr.contains("--objects"), "{finished:#?}");
    };
    refused(&whole, "name the folder above it");
    refused(&scene.path("d"), "holds no object, that is, no folder with a calibration.h5");
}

fn apartment(more: &[(&str, &str)]) -> SmallScene {
    let changes = [
        (CIRCLE, "grid: { spacing: 0.3, headings: 12, clearance: 0.35 }"),
        ("height: 1.25, yaw_deg: 90, pitch_deg: -16", "height: 1.25, yaw_deg: 0, pitch_deg: -16"),
        ("length: 6.5, width: 5.5", "length: 3.4, width: 3.2"),
        ("width: 320, height: 240", "width: 160, height: 120"),
    ];
    SmallScene::new(&[&changes, more].concat())
}

#[test]
fn an_apartment_in_the_layout_of_active_vision_reads_back_as_it_was() {
    let scene = apartment(&[]);
    dataset(&scene, "vantage,avd", "1").expect(0, &[]);
    assert_eq!(verify_layout(&scene.path("d/avd")).unwrap().shards[0].name, "Home_001_1");
    let mut command = bench();
    command.args(["import", "avd"]).arg(scene.path("d/avd/Home_001_1"));
    Finished::of(command.arg("--out").arg(scene.path("scan"))).expect(0, &[]);

    let (ours, read) =
        (read_episode(&scene.path("d/0")).unwrap(), read_episode(&scene.path("scan")).unwrap());
    assert_eq!(ours.seed, Seed(0));
    assert_eq!(ours.observations.steps(), read.observations.steps());
    let camera = |episode: &vantage_dataset::Episode, step: usize| {
        episode.truth.world_from_robot[step] * episode.observations.robot_from_camera
    };
    for step in 1..ours.observations.steps() {
        let motion = |episode| camera(episode, 0).inv_mul(&camera(episode, step));
        let apart = motion(&ours).inv_mul(&motion(&read));
        assert!(
            apart.translation.vector.norm() < 1e-6 && apart.rotation.angle() < 1e-6,
            "step {step}: {apart}"
        );
    }
    assert!(!read.truth.objects.is_empty() && read.truth.objects.len() <= ours.truth.objects.len());
    for object in &read.truth.objects {
        let id = object.family.rsplit('_').next().unwrap();
        let truth =
            ours.truth.objects.iter().find(|truth| format!("{:016x}", truth.instance.0) == id).unwrap();
        let in_first = |episode, object: &vantage_dataset::ObjectTruth| {
            camera(episode, 0).inv_mul(&object.world_from_object).translation.vector
        };
        let off = (in_first(&read, object) - in_first(&ours, truth)).norm();
        assert!(off < truth.size, "{}: {off} m off", truth.family);
    }
}

#[test]
fn a_model_learns_from_a_home_in_the_layout_of_active_vision() {
    let scene = apartment(&[(
        "training:\n  seed: 1",
        "training:\n  seed: 1\n  model: { objective: viewpoint_predictive, trunk_steps: 2, steps: 2, batch: 4, \
         trunk_batch: 8, measurement_dim: 4 }",
    )]);
    dataset(&scene, "avd", "1").expect(0, &[]);
    let home = scene.path("d/avd/Home_001_1");
    let names = fs::read_to_string(home.join("present_instance_names.txt")).unwrap();
    let names: Vec<&str> = names.lines().collect();
    let (first, rest) = names.split_first().unwrap();
    let import = |split: &str, objects: &str| {
        let mut command = bench();
        command.args(["import", "avd"]).arg(&home).args(["--views", "--split", split, "--objects", objects]);
        Finished::of(command.arg("--out").arg(scene.path(split)))
    };
    import("train", &rest.join(",")).expect(0, &[]);
    import("validation", first).expect(0, &[]);
    import("test", "no_such_object").expect(2, &["no_such_object"]);
    let set = read_views(&scene.path("train")).unwrap();
    assert_eq!((set.split, set.instances.len()), (Split::Train, rest.len()));

    Finished::of(&mut scene.train_on_views()).expect(0, &[]);
    assert!(scene.path("model/predictor.onnx").exists());
}

#[test]
fn killed_layouts_are_gone_on_with_to_the_same_bytes_and_those_of_other_scenes_refused() {
    let scene = turntable();
    let entries = |root: &Path| fs::read_dir(root).map_or(0, |entries| entries.flatten().count());
    let args = ["--seeds", "3", "--format", "bigbird"];
    assert_resumes(&scene, &args, |killed| entries(&killed.join("bigbird")) > 2);
    let text = fs::read_to_string(scene.path("scene.yaml")).unwrap();
    fs::write(scene.path("scene.yaml"), text.replace("distance: 0.8,", "distance: 0.9,")).unwrap();
    Finished::of(&mut scene.dataset("whole", &args)).expect(2, &["another scene"]);

    let images = |killed: &Path| entries(&killed.join("avd/Home_001_1/jpg_rgb"));
    assert_resumes(&apartment(&[]), &["--seeds", "1", "--format", "avd"], |killed| images(killed) > 5);
}

#[test]
fn a_run_that_was_killed_as_it_began_is_gone_on_with() {
    for (format, scene) in [("bigbird", turntable()), ("avd", apartment(&[]))] {
        let root = scene.path("d").join(format);
        fs::create_dir_all(&root).unwrap();
        for left in [".probe.tmp", "manifest.partial.json.tmp"] {
            fs::write(root.join(left), "").unwrap();
        }
        dataset(&scene, format, "1").expect(0, &[]);
        assert_eq!(verify_layout(&root).unwrap().shards.len(), 1, "{format}");
    }
}

#[test]
fn a_format_that_a_scene_does_not_have_is_refused() {
    let scene = SmallScene::new(&[]);
    dataset(&scene, "bigbird", "1").expect(2, &["--format bigbird", "turntable"]);
    dataset(&scene, "avd", "1").expect(2, &["--format avd", "grid"]);
    assert!(!scene.path("d").exists(), "an empty folder is left");
}

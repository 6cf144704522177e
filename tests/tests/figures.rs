//! `bench figures`: the pictures of a model, the same bytes every time.

use std::path::Path;
use vantage_tests::{Finished, SmallScene};

const PICTURES: [&str; 5] =
    ["latents.svg", "calibration.svg", "latents.png", "predictions.png", "viewpoints.png"];

fn figures(scene: &SmallScene, out: &Path, threads: &str) -> Finished {
    let mut command = scene.on(&["figures"], "scene.yaml");
    Finished::of(command.arg("--out").arg(out).env("RAYON_NUM_THREADS", threads))
}

#[test]
fn a_model_becomes_pictures_and_the_same_ones_on_any_number_of_threads() {
    let scene = SmallScene::new(&[]);
    let read = |folder: &Path| PICTURES.map(|name| std::fs::read(folder.join(name)).expect(name));
    let (one, two) = (scene.path("one"), scene.path("two"));
    let finished = figures(&scene, &one, "1");
    finished.expect(0, &[]);
    assert_eq!(finished.stdout.lines().count(), PICTURES.len() + 1);
    let csv = std::fs::read_to_string(one.join("posterior.csv")).expect("a table");
    let probability = |line: &str| line.split(',').nth(3).and_then(|number| number.parse::<f64>().ok());
    let probabilities: Vec<f64> = csv.lines().skip(1).map(|line| probability(line).expect(line)).collect();
    assert!((8..=4 * 4).contains(&probabilities.len()), "views of one session of two");
    assert!(probabilities.iter().all(|&share| share > 0.25 && share <= 1.0), "{csv}");
    figures(&scene, &two, "2").expect(0, &[]);
    let pictures = read(&one);
    assert_eq!(pictures, read(&two));

    // One circle a view at least: 4 instances of up to 8, with their names below.
    let svg = String::from_utf8(pictures[0].clone()).expect("text");
    let circles = svg.matches("<circle").count();
    assert!((20..=4 * 8 + 4).contains(&circles), "{circles}");
    assert!(["mug 1", "duck 1", "carton 1", "teapot 1"].iter().all(|name| svg.contains(name)));
    // Of 16 numbers the shares in three intervals, and three in the legend.
    let svg = String::from_utf8(pictures[1].clone()).expect("text");
    assert_eq!(svg.matches("<circle").count(), 3 * 16 + 3);
    for png in &pictures[2..] {
        let picture = image::load_from_memory(png).expect("a PNG").to_rgb8();
        let ink = picture.pixels().filter(|pixel| pixel.0 != [255; 3]).count();
        assert!(ink > picture.pixels().len() / 50, "an empty picture");
    }
}

#[test]
fn a_folder_that_cannot_be_written_and_a_missing_model_are_told_of() {
    let scene = SmallScene::new(&[]);
    figures(&scene, &scene.path("scene.yaml/out"), "1").expect(6, &["scene.yaml"]);
    let mut command = scene.on(&["figures"], "scene.yaml");
    Finished::of(command.args(["--model", "none", "--out"]).arg(scene.path("out")))
        .expect(2, &["model none"]);
}

#[test]
fn of_objects_with_one_view_each_it_is_said_what_cannot_be_drawn() {
    let scene = SmallScene::new(&[]);
    let photos = scene.path("photos");
    std::fs::create_dir(&photos).expect("a folder");
    for object in 1u8..=3 {
        let color = image::Rgb([60 * object, 90, 200]);
        let inside = |x: u32, y: u32| (10..50).contains(&x) && (20..40).contains(&y);
        let image =
            image::RgbImage::from_fn(64, 64, |x, y| if inside(x, y) { color } else { image::Rgb([0; 3]) });
        image.save(photos.join(format!("obj{object}__0.png"))).expect("a photograph");
    }
    let mut import = vantage_tests::bench();
    import.args(["import", "folder"]).arg(&photos).arg("--out").arg(scene.path("views"));
    Finished::of(&mut import).expect(0, &[]);
    let mut command = scene.on(&["figures"], "scene.yaml");
    command.arg("--views").arg(scene.path("views")).arg("--out").arg(scene.path("out"));
    let told = Finished::of(&mut command);
    told.expect(4, &["3 views are too few for t-SNE", "no object has views of two sessions"]);
    assert!(told.stdout.is_empty(), "{}", told.stdout);
}

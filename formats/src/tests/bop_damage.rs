//! Damaged copies of a dataset of BOP: what is read of them can be stored, and what is not is told.

use super::bop::json;
use super::bop_import::{Outlines, change, try_read, written};
use super::*;
use serde_json::json;
use vantage_dataset::store::write_episode;

/// A copy with a byte changed, or its end cut off, or, where it is text, a number replaced by one that nobody measures.
fn damage(bytes: &[u8], stream: &mut Stream) -> Vec<u8> {
    const NUMBERS: [&str; 8] =
        ["0", "-1", "1e308", "1e-308", "4294967296", "18446744073709551615", "null", "[]"];
    let mut damaged = bytes.to_vec();
    let at = stream.below(bytes.len());
    match stream.below(3) {
        0 => damaged[at] = stream.below(256) as u8,
        1 => damaged.truncate(at),
        _ => {
            let is_number = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'-' | b'.');
            let Some(start) = (at..bytes.len()).find(|&i| is_number(&bytes[i])) else { return damaged };
            let length = bytes[start..].iter().take_while(|byte| is_number(byte)).count();
            let other = NUMBERS[stream.below(NUMBERS.len())];
            damaged.splice(start..start + length, other.bytes());
        }
    }
    damaged
}

#[test]
fn of_damaged_files_what_is_read_can_be_stored_or_is_an_error() {
    const COPIES: u64 = 150;
    let (folder, _) = written();
    let stored = tempfile::tempdir().unwrap();
    for file in [
        "models/models_info.json",
        "models/obj_000002.ply",
        "train/000000/scene_camera.json",
        "train/000000/scene_gt.json",
        "train/000000/scene_gt_info.json",
        "train/000000/rgb/000000.png",
        "train/000000/mask_visib/000000_000000.png",
    ] {
        let path = folder.path().join(file);
        let whole = fs::read(&path).unwrap();
        let (mut arranged, mut told) = (0, 0);
        for copy in 0..COPIES {
            fs::write(&path, damage(&whole, &mut Seed(copy).stream(file, 0))).unwrap();
            let Ok((arrangements, report)) = try_read(folder.path(), &mut Outlines) else {
                told += 1;
                continue;
            };
            told += usize::from(!report.skipped.is_empty());
            arranged += arrangements.len();
            for (number, BopArrangement { episode, .. }) in arrangements.iter().enumerate() {
                let place =
                    stored.path().join(format!("{}_{copy}_{number}", path.file_name().unwrap().display()));
                write_episode(&place, episode, Provenance::new())
                    .unwrap_or_else(|error| panic!("{file}, {copy}: {error}"));
                fs::remove_dir_all(&place).unwrap();
            }
        }
        fs::write(&path, whole).unwrap();
        assert!(arranged > 5 && told > 20, "{file}: {arranged} arrangements read, {told} copies told of");
    }
}

fn told(report: &ImportReport) -> Vec<String> {
    report.skipped.iter().map(ToString::to_string).collect()
}

#[test]
fn scenes_without_annotations_are_left_out_and_told() {
    let folder = tempfile::tempdir().unwrap();
    write_scenes(folder.path(), BopLayout::Scenes, &scenes());
    let at = |name: &str| folder.path().join(name);
    for scene in ["train/000001", "val/000002", "val/000003"] {
        fs::remove_file(at(scene).join("scene_gt.json")).unwrap();
    }
    let mut report = ImportReport::default();
    let bop = BopScenes::open(folder.path(), &mut report).unwrap();
    assert_eq!(bop.scenes, [at("train/000000")]);
    let told = told(&report);
    assert_eq!(told.len(), 2, "{told:?}");
    assert!(told[0].ends_with("train: scenes without scene_gt.json: 000001"), "{told:?}");
    assert!(told[1].ends_with("val: scenes without scene_gt.json: 000002, 000003"), "{told:?}");
    for (place, named) in [("train/000001", "000001"), ("val", "000002")] {
        let error = BopScenes::open(&at(place), &mut report).unwrap_err().to_string();
        assert!(error.contains(&format!("{named}, annotations: got no scene_gt.json")), "{error}");
        assert!(error.ends_with("fetch the annotations, or name a split that has them"), "{error}");
    }
}

#[test]
fn images_without_an_entry_are_left_out_and_told() {
    let (folder, scene) = written();
    change(folder.path(), "scene_gt.json", |gt| {
        gt.as_object_mut().unwrap().remove("3");
    });
    let (arrangements, report) = try_read(folder.path(), &mut Outlines).unwrap();
    let told = told(&report);
    assert_eq!(told.len(), 1, "{told:?}");
    let why = "scene_gt.json: 1 of 5 images, image 3 the first, have no entry";
    assert!(told[0].ends_with(why), "{told:?}");
    assert_eq!(arrangements[0].episode.observations.steps(), scene.captures.len() - 1);
}

#[test]
fn without_models_it_is_told_at_once_where_they_were_looked_for() {
    let (folder, _) = written();
    fs::rename(folder.path().join("models"), folder.path().join("meshes")).unwrap();
    // It is no annotation, and yet not what is told.
    fs::write(folder.path().join("train/000000/scene_gt.json"), "{").unwrap();
    for place in ["", "train", "train/000000"] {
        let error = try_read(&folder.path().join(place), &mut Outlines).unwrap_err().to_string();
        let folders =
            "got no folder of them, expected one of models, models_eval, models_cad, models_reconst, in";
        assert!(error.contains(folders) && error.contains("train or in"), "{error}");
        assert!(error.ends_with("fetch the dataset's models"), "{error}");
    }
}

#[test]
fn symmetries_that_are_none_are_refused() {
    let (folder, _) = written();
    let path = folder.path().join("models/models_info.json");
    let whole = json(&path);
    for (object, field, value) in [
        ("1", "symmetries_discrete", json!([[1.0, 0.0, 0.0]])),
        ("1", "symmetries_discrete", json!(vec![vec![1.0; 16]])),
        ("3", "symmetries_continuous", json!([{ "axis": [0, 0, 0], "offset": [0, 0, 0] }])),
    ] {
        let mut infos = whole.clone();
        infos[object][field] = value;
        fs::write(&path, infos.to_string()).unwrap();
        let error = try_read(folder.path(), &mut Outlines).unwrap_err().to_string();
        let place = format!("models_info.json, object {object}, {field}[0]: got [");
        assert!(error.contains(&place), "{error}");
    }
}

#[test]
fn no_turn_is_no_symmetry() {
    let (folder, _) = written();
    let path = folder.path().join("models/models_info.json");
    let mut infos = json(&path);
    let own = infos["1"]["symmetries_discrete"].as_array_mut().unwrap();
    own.push(json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]));
    fs::write(&path, infos.to_string()).unwrap();
    let (arrangements, _) = try_read(folder.path(), &mut Outlines).unwrap();
    assert_eq!(arrangements[0].episode.truth.objects[0].symmetry, Symmetry::Cyclic { order: 2 });
}

#[test]
fn words_of_python_for_no_number_are_named() {
    let (folder, _) = written();
    let path = folder.path().join("models/models_info.json");
    let whole = json(&path).to_string();
    for (word, named) in [("NaN", "got NaN"), ("-Infinity", "got Infinity")] {
        let changed = whole.replacen("\"diameter\":", &format!("\"diameter\":{word},\"other\":"), 1);
        fs::write(&path, changed).unwrap();
        let error = try_read(folder.path(), &mut Outlines).unwrap_err().to_string();
        assert!(error.contains(named) && error.contains("JSON has no NaN"), "{error}");
    }
}

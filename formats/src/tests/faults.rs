use super::*;
use nalgebra::Vector3;
use serde_json::Value;
use vantage_dataset::store::{StoreError, StoreErrorKind, write_views};

/// What spoils a record, and what the refusal tells of it.
type Spoil<T> = (fn(&mut T), &'static str);

fn open(folder: &Path, options: CropOptions) -> Result<Opened<CropWriter>, StoreError> {
    CropWriter::open(folder, options, provenance())
}

fn options() -> CropOptions {
    crop_options(CropLayout::WebDataset, 10)
}

#[test]
fn a_folder_of_somebody_else_is_refused_and_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("thesis.tex"), "years of work").unwrap();
    let before = files(folder.path());
    let error = open(folder.path(), options()).unwrap_err();
    assert!(matches!(error, StoreError::Foreign { .. }) && error.kind() == StoreErrorKind::Choice, "{error}");
    assert!(open(&folder.path().join("thesis.tex"), options()).is_err());
    assert_eq!(files(folder.path()), before);

    let folder = tempfile::tempdir().unwrap();
    let views = ViewSet { split: Split::Train, instances: Vec::new(), views: Vec::new() };
    write_views(folder.path(), &views, Provenance::new()).unwrap();
    let before = files(folder.path());
    let error = open(folder.path(), options()).unwrap_err();
    assert!(matches!(error, StoreError::Foreign { .. }), "{error}");
    assert_eq!(files(folder.path()), before);
}

#[test]
fn other_options_are_refused_with_what_differs() {
    let finished = tempfile::tempdir().unwrap();
    write_crops(finished.path(), options(), samples(5));
    let begun = tempfile::tempdir().unwrap();
    let (mut writer, _) = open_crops(begun.path(), options());
    push_crops(&mut writer, samples(25)[..12].to_vec());
    drop(writer);
    for folder in [finished.path(), begun.path()] {
        let before = files(folder);
        let other = CropOptions { samples_per_shard: 11, ..options() };
        let error = open(folder, other).unwrap_err();
        assert_eq!(error.kind(), StoreErrorKind::Choice);
        let told = error.to_string();
        assert!(told.contains("options.samples_per_shard: got 11, expected 10"), "{told}");
        let error = open(folder, crop_options(CropLayout::Parquet, 10)).unwrap_err().to_string();
        assert!(error.contains("layout: got \"parquet\", expected \"webdataset\""), "{error}");
        let error = CropWriter::open(folder, options(), Provenance::new()).unwrap_err().to_string();
        assert!(error.contains("provenance.scene: got null, expected \"a test\""), "{error}");
        assert_eq!(files(folder), before);
    }
}

#[test]
fn a_newer_or_broken_manifest_is_refused_and_left_alone() {
    for (name, finish) in [("manifest.json", true), ("manifest.partial.json", false)] {
        let folder = tempfile::tempdir().unwrap();
        let (writer, _) = open_crops(folder.path(), options());
        if finish {
            writer.finish().unwrap();
        }
        let path = folder.path().join(name);
        let sound = fs::read_to_string(&path).unwrap();
        let newer = sound.replace("\"format\": 2", "\"format\": 3");
        let broken = [
            (newer, "format 3"),
            (sound.replace("\"format\": 2", "\"format\": 0"), "format: got 0, expected 2"),
            (sound[..sound.len() / 2].to_owned(), "manifest"),
            (sound.replace("a test", "A test"), "seal"),
        ];
        for (text, told) in broken {
            fs::write(&path, &text).unwrap();
            let error = open(folder.path(), options()).unwrap_err();
            assert!(error.kind() == StoreErrorKind::Stored && error.to_string().contains(told), "{error}");
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
    }
}

#[test]
fn crops_of_the_first_format_are_sound_and_are_not_gone_on_with() {
    let folder = tempfile::tempdir().unwrap();
    let first = LayoutManifest { format: 1, ..write_crops(folder.path(), options(), samples(5)) };
    forge(folder.path(), first);
    assert_eq!(verify_layout(folder.path()).unwrap().format, 1);
    let before = files(folder.path());
    let error = open(folder.path(), options()).unwrap_err();
    assert!(
        error.kind() == StoreErrorKind::Choice && error.to_string().contains("format: got 2, expected 1"),
        "{error}"
    );
    assert_eq!(files(folder.path()), before);
}

/// Replaces the manifest of a finished dataset, with a seal that is right.
fn forge(folder: &Path, manifest: LayoutManifest) {
    let mut value = serde_json::to_value(LayoutManifest { seal: String::new(), ..manifest }).unwrap();
    value.sort_all_objects();
    let seal = blake3::hash(value.to_string().as_bytes()).to_hex().to_string();
    value["seal"] = Value::from(seal);
    fs::write(folder.join("manifest.json"), value.to_string()).unwrap();
}

#[test]
fn a_manifest_that_leads_out_of_its_folder_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut forged = write_crops(folder.path(), options(), samples(5));
    forged.shards[0].name = "../../etc/passwd".to_owned();
    forge(folder.path(), forged);
    let error = verify_layout(folder.path()).unwrap_err().to_string();
    assert!(error.contains("a plain path inside the folder"), "{error}");
    assert!(open(folder.path(), options()).is_err());
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_told_with_a_remedy_and_can_be_gone_on_from() {
    for layout in [CropLayout::WebDataset, CropLayout::Parquet] {
        let folder = tempfile::tempdir().unwrap();
        let (mut writer, _) = open_crops(folder.path(), crop_options(layout, 10));
        push_crops(&mut writer, samples(25)[..10].to_vec());
        // The eleventh sample closes the first shard and begins the second.
        writer.push(samples(25)[10].clone()).unwrap();
        push_crops(&mut writer, samples(25)[11..20].to_vec());
        drop(writer);
        let (mut writer, skip) = open_crops(folder.path(), crop_options(layout, 10));
        assert_eq!(skip, 10);
        std::os::unix::fs::symlink("/dev/full", folder.path().join(".partial/shard")).unwrap();
        let error = samples(25)[10..]
            .iter()
            .find_map(|sample| writer.push(sample.clone()).err())
            .expect("the disk is full");
        assert_eq!(error.kind(), StoreErrorKind::Unwritable);
        assert!(error.to_string().contains("free some space and run again"), "{error}");
        fs::remove_file(folder.path().join(".partial/shard")).unwrap();
        samples(25)[21..].iter().for_each(|sample| drop(writer.push(sample.clone())));
        assert_eq!(writer.finish().unwrap_err().kind(), StoreErrorKind::Unwritable, "a sample is missing");

        let (mut writer, skip) = open_crops(folder.path(), crop_options(layout, 10));
        assert_eq!(skip, 10);
        push_crops(&mut writer, samples(25)[10..].to_vec());
        writer.finish().unwrap();
        verify_layout(folder.path()).unwrap();
    }
}

#[test]
fn unfit_samples_are_refused_by_name() {
    let cases: [Spoil<Sample>; 6] = [
        (|s| s.camera.fy = f64::NAN, "finite"),
        (|s| s.timestamp = f64::NEG_INFINITY, "finite"),
        (|s| s.object_from_camera.translation.x = f64::NAN, "finite"),
        (|s| s.visible_fraction = 1.5, "visible_fraction"),
        (|s| s.family = "two\nlines".to_owned(), "family"),
        (|s| s.bounding_box.max.x = f64::INFINITY, "finite"),
    ];
    let folder = tempfile::tempdir().unwrap();
    let (mut writer, _) = open_crops(folder.path(), options());
    for (spoil, told) in cases {
        let mut sample = sample(0, Split::Train);
        spoil(&mut sample);
        let error = writer.push(sample).unwrap_err();
        assert!(error.kind() == StoreErrorKind::Bug && error.to_string().contains(told), "{error}");
    }
    for spoilt in [
        CropOptions { samples_per_shard: 0, ..options() },
        CropOptions { name: String::new(), ..options() },
        CropOptions { licence: "a\nb".to_owned(), ..options() },
    ] {
        assert!(open(&folder.path().join("new"), spoilt).is_err());
    }
}

#[test]
fn unfit_captures_are_refused_by_name() {
    let scene = &scenes()[0];
    let cases: [Spoil<Capture>; 6] = [
        (|c| c.rgb.clear(), "rgb"),
        (|c| c.depth.truncate(1), "depth"),
        (|c| c.ids.clear(), "ids"),
        (|c| c.objects[0].track = 17, "track 17"),
        (|c| c.objects[0].visible_pixels += 1, "pixels"),
        (|c| c.world_from_camera.translation.vector = Vector3::new(0.0, f64::NAN, 0.0), "finite"),
    ];
    let folder = tempfile::tempdir().unwrap();
    let (mut writer, _) = open_bop(folder.path(), bop_options(BopLayout::Scenes));
    let ids: BTreeMap<_, _> = scene.objects.iter().map(|o| o.instance).zip(1..).collect();
    let header = Scene { id: 0, split: Split::Train, objects: &scene.objects, ids: &ids };
    let error = writer.push(&header, 0, &scene.captures[0]).unwrap_err().to_string();
    assert!(error.contains("an object whose model was added"), "{error}");
    push_scenes(&mut writer, &scenes()[..1], 0, 1);
    for (spoil, told) in cases {
        let mut capture = scene.captures[1].clone();
        spoil(&mut capture);
        let error = writer.push(&header, 1, &capture).unwrap_err();
        assert!(error.kind() == StoreErrorKind::Bug && error.to_string().contains(told), "{error}");
    }
    writer.push(&Scene { id: 1, ..header }, 0, &scene.captures[0]).unwrap();
    let error = writer.push(&header, 2, &scene.captures[0]).unwrap_err().to_string();
    assert!(error.contains("scenes one after another"), "{error}");
}

#[test]
fn unfit_models_are_refused_by_name() {
    let cases: [Spoil<ObjectModel>; 6] = [
        (|m| m.triangles.clear(), "triangles"),
        (|m| m.triangles[0][1] = 4, "vertices below 4"),
        (|m| m.uvs.truncate(3), "uvs"),
        (|m| m.normals.clear(), "normals"),
        (|m| m.positions[2][0] = f32::INFINITY, "finite"),
        (|m| m.texture.as_mut().unwrap().width = 3, "texture"),
    ];
    let folder = tempfile::tempdir().unwrap();
    let (mut writer, _) = open_bop(folder.path(), bop_options(BopLayout::Scenes));
    let sound = rectangle(0.1, 0.2, Symmetry::None);
    for (spoil, told) in cases {
        let mut model = sound.clone();
        spoil(&mut model);
        let error = writer.add_model(InstanceId(1), 1, &model).unwrap_err();
        assert!(error.kind() == StoreErrorKind::Bug && error.to_string().contains(told), "{error}");
    }
    assert!(writer.add_model(InstanceId(1), 0, &sound).is_err());
    writer.add_model(InstanceId(1), 1, &sound).unwrap();
    writer.add_model(InstanceId(1), 1, &sound).unwrap();
    assert!(writer.add_model(InstanceId(1), 2, &sound).is_err());
    assert!(writer.add_model(InstanceId(2), 1, &sound).is_err());
}

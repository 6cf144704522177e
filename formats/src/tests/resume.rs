use super::*;
use vantage_dataset::store::{StoreError, StoreErrorKind};

fn write_crops_in_parts(folder: &Path, options: &CropOptions, samples: &[Sample], stops: &[usize]) {
    for &stop in stops {
        let (mut writer, skip) = open_crops(folder, options.clone());
        assert_eq!(verify_layout(folder).unwrap_err().kind(), StoreErrorKind::Stored, "not finished yet");
        push_crops(&mut writer, samples[skip as usize..stop.max(skip as usize)].to_vec());
    }
    let (mut writer, skip) = open_crops(folder, options.clone());
    push_crops(&mut writer, samples[skip as usize..].to_vec());
    writer.finish().unwrap();
}

#[test]
fn interrupted_crops_are_those_of_an_uninterrupted_run() {
    let samples = samples(25);
    for layout in [CropLayout::WebDataset, CropLayout::Parquet] {
        let options = crop_options(layout, 10);
        let whole = tempfile::tempdir().unwrap();
        let manifest = write_crops(whole.path(), options.clone(), samples.clone());
        let expected = files(whole.path());
        for stops in [&[0][..], &[1], &[10], &[11, 11], &[25, 26], &[9, 22, 31, 50]] {
            let folder = tempfile::tempdir().unwrap();
            write_crops_in_parts(folder.path(), &options, &samples, stops);
            assert!(files(folder.path()) == expected, "{layout:?} {stops:?}");
            assert_eq!(verify_layout(folder.path()).unwrap(), manifest);
        }
        let reopened = CropWriter::open(whole.path(), options, provenance()).unwrap();
        assert!(matches!(reopened, Opened::Finished(found) if found == manifest));
    }
}

#[test]
fn interrupted_images_are_those_of_an_uninterrupted_run() {
    let scenes = scenes();
    for layout in [BopLayout::Scenes, WEB] {
        let whole = tempfile::tempdir().unwrap();
        let manifest = write_scenes(whole.path(), layout, &scenes);
        let expected = files(whole.path());
        assert!(expected.keys().all(|name| !name.contains("partial")), "{:?}", expected.keys());
        for stops in [&[1][..], &[5, 6], &[12, 20]] {
            let folder = tempfile::tempdir().unwrap();
            for &stop in stops {
                let (mut writer, skip) = open_bop(folder.path(), bop_options(layout));
                assert!(skip <= stop);
                push_scenes(&mut writer, &scenes, skip, stop);
            }
            let (mut writer, skip) = open_bop(folder.path(), bop_options(layout));
            push_scenes(&mut writer, &scenes, skip, u64::MAX);
            writer.finish().unwrap();
            assert!(files(folder.path()) == expected, "{layout:?} {stops:?}");
            assert_eq!(verify_layout(folder.path()).unwrap(), manifest);
        }
    }
}

/// The damage that was told, and the samples that are left.
fn reopen_bop(folder: &Path, layout: BopLayout) -> (BopWriter, u64, String) {
    match BopWriter::open(folder, bop_options(layout), provenance()).unwrap() {
        Opened::Unfinished { writer, skip, damage: Some(damage) } => (writer, skip, damage.to_string()),
        other => panic!("{other:?}"),
    }
}

#[test]
fn damaged_files_of_a_finished_dataset_are_written_again() {
    let scenes = scenes();
    let cases = [
        (BopLayout::Scenes, "train/000001/mask/000002_000000.png", 5),
        (BopLayout::Scenes, "val/000002/scene_gt.json", 10),
        (BopLayout::Scenes, "models/obj_000002.ply", 0),
        (BopLayout::Scenes, "models/models_info.json", 20),
        (WEB, "train_web/shard-000001.tar", 3),
        (WEB, "val_web/key_to_shard.json", 20),
    ];
    for (layout, name, left) in cases {
        let folder = tempfile::tempdir().unwrap();
        let manifest = write_scenes(folder.path(), layout, &scenes);
        let expected = files(folder.path());
        for lose in [false, true] {
            let path = folder.path().join(name);
            if lose {
                fs::remove_file(&path).unwrap();
            } else {
                let mut bytes = fs::read(&path).unwrap();
                let middle = bytes.len() / 2;
                bytes[middle] ^= 1;
                fs::write(&path, bytes).unwrap();
            }
            assert_eq!(verify_layout(folder.path()).unwrap_err().kind(), StoreErrorKind::Stored);
            let (mut writer, skip, damage) = reopen_bop(folder.path(), layout);
            assert_eq!(skip, left, "{name}");
            let told = name.split('/').take(2).collect::<Vec<_>>().join("/");
            assert!(damage.contains(&told), "{damage}");
            push_scenes(&mut writer, &scenes, skip, u64::MAX);
            assert_eq!(writer.finish().unwrap(), (manifest.clone(), Vec::new()));
            assert!(files(folder.path()) == expected, "{name}");
        }
    }
}

#[test]
fn what_others_put_into_a_scene_s_folder_is_set_aside() {
    let scenes = scenes();
    let folder = tempfile::tempdir().unwrap();
    let manifest = write_scenes(folder.path(), BopLayout::Scenes, &scenes);
    let expected = files(folder.path());
    let note = "train/000001/mine/note.txt";
    fs::create_dir(folder.path().join(note).parent().unwrap()).unwrap();
    fs::write(folder.path().join(note), "mine").unwrap();
    let (mut writer, skip, damage) = reopen_bop(folder.path(), BopLayout::Scenes);
    assert!(skip == 5 && damage.contains("train/000001"), "{skip} {damage}");
    assert!(folder.path().join(note).exists(), "until it is written anew");
    push_scenes(&mut writer, &scenes, skip, u64::MAX);
    let aside = folder.path().join("set_aside/train/000001");
    assert_eq!(writer.finish().unwrap(), (manifest, vec![aside.clone()]));
    assert_eq!(fs::read(aside.join("mine/note.txt")).unwrap(), b"mine");
    fs::remove_dir_all(folder.path().join("set_aside")).unwrap();
    assert!(files(folder.path()) == expected);
}

#[test]
fn a_damaged_shard_of_an_interrupted_run_is_written_again() {
    let samples = samples(25);
    let options = crop_options(CropLayout::WebDataset, 10);
    let (whole, folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    write_crops(whole.path(), options.clone(), samples.clone());
    let (mut writer, _) = open_crops(folder.path(), options.clone());
    push_crops(&mut writer, samples[..35].to_vec());
    drop(writer);
    let first = folder.path().join("train-000001.tar");
    let bytes = fs::read(&first).unwrap();
    fs::write(&first, &bytes[..bytes.len() / 2]).unwrap();
    let Opened::Unfinished { mut writer, skip: 10, damage: Some(_) } =
        CropWriter::open(folder.path(), options, provenance()).unwrap()
    else {
        panic!("the second shard is damaged");
    };
    push_crops(&mut writer, samples[10..].to_vec());
    writer.finish().unwrap();
    assert!(files(folder.path()) == files(whole.path()));
}

#[test]
fn a_run_can_be_killed_as_it_begins_and_as_it_ends() {
    let options = crop_options(CropLayout::WebDataset, 10);
    let (whole, folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    write_crops(whole.path(), options.clone(), samples(5));
    fs::create_dir(folder.path().join(".partial")).unwrap();
    fs::write(folder.path().join("manifest.partial.json.tmp"), "{").unwrap();
    write_crops(folder.path(), options.clone(), samples(5));
    assert!(files(folder.path()) == files(whole.path()));

    fs::write(folder.path().join("manifest.partial.json"), "as it was before manifest.json").unwrap();
    let reopened = CropWriter::open(folder.path(), options, provenance()).unwrap();
    assert!(matches!(reopened, Opened::Finished(_)));
    assert!(files(folder.path()) == files(whole.path()));
}

#[test]
fn what_a_killed_run_left_is_cleared_away() {
    let options = crop_options(CropLayout::WebDataset, 10);
    let (whole, folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    write_crops(whole.path(), options.clone(), samples(25));
    let (mut writer, _) = open_crops(folder.path(), options.clone());
    push_crops(&mut writer, samples(25)[..10].to_vec());
    drop(writer);
    fs::create_dir(folder.path().join(".partial/stray")).unwrap();
    fs::write(folder.path().join("train-000000.tar"), "put in place, but not yet in the manifest").unwrap();
    fs::write(folder.path().join("manifest.json.tmp"), "cut sh").unwrap();
    let (mut writer, skip) = open_crops(folder.path(), options);
    assert_eq!(skip, 0);
    push_crops(&mut writer, samples(25));
    writer.finish().unwrap();
    assert!(files(folder.path()) == files(whole.path()));
}

#[test]
fn parts_are_claimed_over_what_a_killed_run_left_and_not_over_what_others_put_there() {
    let begin = |folder: &Path| Inventory::begin(folder, "avd", provenance()).unwrap();
    for left in ["manifest.partial.json.tmp", ".probe.tmp"] {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(left), "").unwrap();
        begin(folder.path()).claim().unwrap();
        assert_eq!(begin(folder.path()).before(), Some(&provenance()), "{left}");
        begin(folder.path()).claim().unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("thesis.tex"), "years of work").unwrap();
    assert!(matches!(begin(folder.path()).claim(), Err(StoreError::Foreign { .. })));
    assert_eq!(files(folder.path()).len(), 1);
}

//! Files that scipy, h5py and Pillow wrote from the published descriptions.

use nalgebra::Vector2;
use std::path::{Path, PathBuf};
use vantage_dataset::{InstanceId, Split};
use vantage_formats::avd::{Movement, read_scan};
use vantage_formats::bigbird::{object_folders, read_objects};
use vantage_formats::mat5::{self, Value};

const CEREALS: &str = "honey_bunches_of_oats_honey_roasted";

fn folder(name: &str) -> Option<PathBuf> {
    let root = std::env::var_os("VANTAGE_SHARED").map(PathBuf::from);
    let root = root.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"));
    let folder = root.join("data/formats/fixtures_SYNTHETIC").join(name);
    if !folder.is_dir() {
        let told = format!("SKIPPED: {} is absent; set VANTAGE_SHARED\n", folder.display());
        let _ = std::io::Write::write_all(&mut std::io::stderr(), told.as_bytes());
        return None;
    }
    Some(folder)
}

#[test]
fn a_bigbird_folder_reads() {
    let Some(root) = folder("bigbird") else { return };
    let folders = object_folders(&root).unwrap();
    let (set, report) = read_objects(&folders, Split::Train, &|_| true).unwrap();
    assert_eq!(report.skipped, []);
    assert_eq!(set.views.len(), 3);
    assert_eq!(
        (set.instances[0].id, set.instances[0].family.as_str()),
        (InstanceId::of_name(CEREALS), CEREALS)
    );
    for pair in set.views.windows(2) {
        let turned = (pair[1].viewpoint.azimuth() - pair[0].viewpoint.azimuth()).to_degrees().abs();
        assert!((turned - 3.0).abs() < 0.5, "{turned}");
        assert!(pair[0].crop.0.iter().filter(|byte| **byte > 0).count() > 1000);
    }
}

#[test]
fn a_changed_byte_of_hdf5_is_told() {
    let Some(root) = folder("bigbird") else { return };
    for (file, at, byte) in [("calibration.h5", 1760, 2), ("poses/NP5_0_pose.h5", 882, 6)] {
        let copy = tempfile::tempdir().unwrap();
        let object = copy.path().join(CEREALS);
        for (name, bytes) in crate::files(&root.join(CEREALS)) {
            let path = object.join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, bytes).unwrap();
        }
        let mut bytes = std::fs::read(object.join(file)).unwrap();
        bytes[at] = byte;
        std::fs::write(object.join(file), bytes).unwrap();
        let told = match read_objects(&[object], Split::Train, &|_| true) {
            Ok((_, report)) => format!("{:?}", report.skipped),
            Err(error) => error.to_string(),
        };
        assert!(told.contains(file) && told.contains("numbers, expected those of shape"), "{told}");
    }
}

#[test]
fn a_scan_reads() {
    let Some(root) = folder("avd") else { return };
    let scan = read_scan(&root.join("Home_001_1")).unwrap();
    assert_eq!(scan.report.skipped.len(), 1, "{:?}", scan.report);
    assert!(scan.report.skipped[0].reason.contains("not registered"));
    let episode = &scan.episode;
    assert_eq!(episode.observations.steps(), 11);
    assert_eq!(episode.truth.objects.len(), 1);
    assert_eq!(episode.truth.objects[0].family, CEREALS);
    assert_eq!(episode.observations.detections[0].bounding_box.min, Vector2::new(110.0, 200.0));
    assert_eq!(scan.movements.after(0, Movement::RotateCw), Some(1));
    assert_eq!(scan.movements.after(0, Movement::Backward), Some(6));
}

#[test]
fn every_field_of_the_structs_reads() {
    let Some(root) = folder("avd") else { return };
    let variables = mat5::read(&root.join("Home_001_1/image_structs.mat")).unwrap();
    assert_eq!(variables["scale"], Value::scalar(1500.0));
    let Value::Structs(structs) = &variables["image_structs"] else { panic!("{variables:?}") };
    assert_eq!((structs.fields.len(), structs.elements.len()), (16, 12));
    assert_eq!((structs.fields[0].as_str(), structs.fields[15].as_str()), ("image_name", "translate_left"));
    let second = &structs.elements[1];
    assert_eq!(second[0], Value::Text("000110000000201.jpg".to_owned()));
    let r = second[2].as_numbers().unwrap();
    assert!((r[2] - 0.5).abs() < 1e-6 && (r[6] + 0.5).abs() < 1e-6, "{r:?}");
    assert_eq!(second[12], Value::scalar(-1.0));
}

use super::*;
use crate::store::*;
use proptest::prelude::*;
use serde_json::json;

/// Every bit: `{:?}` writes floats with as many digits as tell them apart, and crops as their hash.
fn bits(value: &impl std::fmt::Debug) -> String {
    format!("{value:?}")
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 12, ..ProptestConfig::default() })]

    #[test]
    fn an_episode_reads_back_to_the_bit(seed: u64, steps in 1usize..6, objects in 0usize..4) {
        let folder = tempfile::tempdir().unwrap();
        let written = episode(Seed(seed), steps, objects);
        let provenance = Provenance::from([("scene".to_owned(), json!({"hash": "x", "options": [1, 0.1]}))]);
        let manifest = write_episode(folder.path(), &written, provenance).unwrap();
        prop_assert_eq!(verify(folder.path()).unwrap(), manifest);
        prop_assert_eq!(bits(&read_episode(folder.path()).unwrap()), bits(&written));
        prop_assert_eq!(bits(&read_observations(folder.path()).unwrap()), bits(&written.observations));
        prop_assert_eq!(bits(&read_truth(folder.path()).unwrap()), bits(&written.truth));
    }

    #[test]
    fn depths_read_back_and_without_them_no_byte_changes(seed: u64, steps in 2usize..6, objects in 1usize..4) {
        let [with, without] = [(); 2].map(|()| tempfile::tempdir().unwrap());
        let mut written = episode(Seed(seed), steps, objects);
        let before = write_episode(without.path(), &written, Provenance::new()).unwrap();
        let mut s = Seed(seed).stream("depth", 0);
        for detection in written.observations.detections.iter_mut().step_by(2) {
            detection.center_depth = Some(CenterDepth { meters: 0.1 + s.unit(), sigma: 1e-3 + s.unit() });
        }
        let mut after = write_episode(with.path(), &written, Provenance::new()).unwrap().files;
        prop_assert_eq!(bits(&read_episode(with.path()).unwrap()), bits(&written));
        prop_assert_eq!(after.remove("depths.csv").is_some(), !written.observations.detections.is_empty());
        prop_assert_eq!(after, before.files);
    }

    #[test]
    fn a_view_set_reads_back_to_the_bit(seed: u64, instances in 0usize..6) {
        let folder = tempfile::tempdir().unwrap();
        let written = view_set(Seed(seed), instances);
        write_views(folder.path(), &written, Provenance::new()).unwrap();
        prop_assert_eq!(bits(&read_views(folder.path()).unwrap()), bits(&written));
    }

    #[test]
    fn every_finite_float_survives(bits in any::<u64>()) {
        let value = f64::from_bits(bits);
        prop_assume!(value.is_finite());
        let folder = tempfile::tempdir().unwrap();
        let mut written = episode(Seed(0), 1, 1);
        written.observations.robot_from_camera.translation.vector.x = value;
        written.truth.world_from_robot[0].translation.vector.y = value;
        write_episode(folder.path(), &written, Provenance::new()).unwrap();
        let read = read_episode(folder.path()).unwrap();
        prop_assert_eq!(read.observations.robot_from_camera.translation.vector.x.to_bits(), bits);
        prop_assert_eq!(read.truth.world_from_robot[0].translation.vector.y.to_bits(), bits);
    }
}

#[test]
fn equal_episodes_make_equal_bytes_and_one_replaces_another() {
    let [a, b] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    write_episode(b.path(), &episode(Seed(4), 5, 3), Provenance::new()).unwrap();
    let manifests = [&a, &b].map(|folder| {
        write_episode(folder.path(), &episode(Seed(3), 4, 2), Provenance::new()).unwrap();
        fs::read(folder.path().join("manifest.json")).unwrap()
    });
    assert_eq!(manifests[0], manifests[1]);
    read_episode(b.path()).unwrap();
}

#[test]
fn an_estimator_needs_no_truth_and_truth_no_observations() {
    let folder = tempfile::tempdir().unwrap();
    write_episode(folder.path(), &episode(Seed(1), 3, 2), Provenance::new()).unwrap();
    fs::rename(folder.path().join("truth"), folder.path().join("elsewhere")).unwrap();
    read_observations(folder.path()).unwrap();
    assert_eq!(read_truth(folder.path()).unwrap_err().kind(), StoreErrorKind::Stored);
    fs::rename(folder.path().join("elsewhere"), folder.path().join("truth")).unwrap();
    fs::remove_file(folder.path().join("odometry.csv")).unwrap();
    read_truth(folder.path()).unwrap();
    assert_eq!(read_observations(folder.path()).unwrap_err().kind(), StoreErrorKind::Stored);
}

#[test]
fn the_layout_is_the_documented_one() {
    let folder = tempfile::tempdir().unwrap();
    let mut written = episode(Seed(1), 2, 1);
    written.truth.world_from_robot[0] = Pose::translation(0.5, -0.0, 1e-7);
    written.observations.timestamps = vec![0.0, 0.1];
    let manifest = write_episode(folder.path(), &written, Provenance::new()).unwrap();
    let files: Vec<_> = manifest.files.keys().map(String::as_str).collect();
    let expected = [
        "camera.json",
        "crops_boxed.npy",
        "crops_masked.npy",
        "detections.csv",
        "landmarks.csv",
        "odometry.csv",
        "timestamps.csv",
        "truth/detections.csv",
        "truth/extents.csv",
        "truth/landmarks.csv",
        "truth/objects.csv",
        "truth/robot.tum",
    ];
    assert_eq!(files, expected);
    let tum = fs::read_to_string(folder.path().join("truth/robot.tum")).unwrap();
    let mut lines = tum.lines();
    assert_eq!(lines.next(), Some("# timestamp tx ty tz qx qy qz qw"));
    assert_eq!(lines.next(), Some("0.0 0.5 -0.0 1e-7 0.0 0.0 0.0 1.0"));
    let npy = fs::read(folder.path().join("crops_masked.npy")).unwrap();
    assert_eq!(&npy[..8], b"\x93NUMPY\x01\x00");
    let header_bytes = 10 + usize::from(u16::from_le_bytes([npy[8], npy[9]]));
    assert_eq!((header_bytes % 64, npy[header_bytes - 1]), (0, b'\n'));
}

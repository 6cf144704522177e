use super::*;
use crate::store::*;

fn written(folder: &Path) -> Episode {
    let mut written = episode(Seed(2), 4, 3);
    written.truth.objects.iter_mut().for_each(|object| object.family = "mug".to_owned());
    write_episode(folder, &written, Provenance::new()).unwrap();
    written
}

/// What reading says of an episode after `change` to the text of `file`, for which the manifest vouches.
fn refusal(file: &str, change: impl FnOnce(String) -> String) -> String {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    forge(folder.path(), file, |bytes| change(String::from_utf8(bytes).unwrap()).into_bytes());
    let error = read_episode(folder.path()).unwrap_err();
    assert!(matches!(error, StoreError::Invalid { .. }), "{error}");
    error.to_string()
}

/// The text with field `column` of line `line` (from 1) replaced.
fn with_field(text: &str, line: usize, column: usize, field: &str, delimiter: &str) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut fields: Vec<&str> = lines[line - 1].split(delimiter).collect();
    fields[column] = field;
    lines[line - 1] = fields.join(delimiter);
    lines.join("\n")
}

#[test]
fn values_that_cannot_be_are_refused_where_they_stand() {
    let cases = [
        ("timestamps.csv", 3, 1, "NaN", "line 3, timestamp: got NaN, expected finite"),
        ("timestamps.csv", 4, 1, "-7", "line 4, timestamp: got -7, expected more than"),
        ("timestamps.csv", 4, 1, "soon", "line 4, timestamp: got \"soon\", expected a number"),
        ("timestamps.csv", 4, 0, "7", "line 4, step: got \"7\", expected 2"),
        ("odometry.csv", 3, 0, "0", "line 3, from, to: got 0, 2, expected 1, 2"),
        ("odometry.csv", 2, 1, "-1", "line 2, to: got \"-1\", expected a step"),
        ("odometry.csv", 2, 2, "inf", "line 2, tx ty tz: got inf, expected finite"),
        ("odometry.csv", 2, 8, "nan", "line 2, qx qy qz qw"),
        ("odometry.csv", 2, 8, "1.5", "expected a unit quaternion"),
        ("odometry.csv", 2, 9, "-1.0", "expected positive definite"),
        ("odometry.csv", 2, 9, "NaN", "line 2, covariance: got NaN, expected finite"),
        ("detections.csv", 3, 0, "99", "line 3, step: got 99, expected less than the 4 steps"),
        ("detections.csv", 3, 1, "18446744073709551615", "line 3, track"),
        ("detections.csv", 3, 1, "3", "expected less than the 3 objects"),
        ("detections.csv", 3, 2, "1e9", "expected min less than max"),
        ("detections.csv", 3, 6, "0", "line 3, mask_pixels: got 0, expected at least 1"),
        ("detections.csv", 3, 6, "1,1", "line 3, columns: got 8"),
        ("truth/objects.csv", 2, 1, "xyz", "line 2, instance: got \"xyz\", expected 16 hexadecimal digits"),
        ("truth/objects.csv", 2, 3, "cyclic_1", "expected an order of at least 2"),
        ("truth/objects.csv", 2, 3, "cyclic_999", "expected none, revolution, or cyclic_"),
        ("truth/objects.csv", 2, 4, "0", "line 2, size: got 0, expected positive"),
        ("truth/detections.csv", 2, 1, "1.01", "line 2, visible_fraction: got 1.01, expected in [0, 1]"),
    ];
    for (file, line, column, field, expected) in cases {
        let told = refusal(file, |text| with_field(&text, line, column, field, ","));
        assert!(told.contains(file) && told.contains(expected), "{told}\nlacks {expected}");
    }
    let told = refusal("truth/robot.tum", |text| with_field(&text, 3, 0, "9e9", " "));
    assert!(told.contains("truth/robot.tum, line 4, timestamp"), "{told}");
    let told = refusal("truth/robot.tum", |text| with_field(&text, 2, 0, "-1.0", " "));
    assert!(told.contains("expected those of timestamps.csv"), "{told}");
}

#[test]
fn depths_that_cannot_be_are_refused() {
    for (row, expected) in [
        ("99,1.0,0.1", "line 2, detection: got \"99\", expected the number of a detection"),
        ("0,0.0,0.1", "depth: got 0, expected positive and finite"),
        ("0,inf,0.1", "depth: got inf, expected positive and finite"),
        ("0,1.0,-0.1", "sigma: got -0.1, expected positive and finite"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let mut known = episode(Seed(2), 4, 3);
        known.observations.detections[0].center_depth = Some(CenterDepth { meters: 1.0, sigma: 0.1 });
        write_episode(folder.path(), &known, Provenance::new()).unwrap();
        forge(folder.path(), "depths.csv", |_| format!("detection,depth,sigma\n{row}\n").into_bytes());
        let told = read_episode(folder.path()).unwrap_err().to_string();
        assert!(told.contains("depths.csv") && told.contains(expected), "{told}\nlacks {expected}");
    }
}

#[test]
fn a_zero_quaternion_is_refused() {
    let zero = |text: String| (5..9).fold(text, |text, column| with_field(&text, 3, column, "0.0", ","));
    let told = refusal("odometry.csv", zero);
    assert!(told.contains("line 3") && told.contains("unit quaternion"), "{told}");
}

#[test]
fn rows_too_few_too_many_or_out_of_order_are_refused() {
    let shorter = |text: String| text.lines().take(2).map(|l| format!("{l}\n")).collect::<String>();
    for file in ["timestamps.csv", "detections.csv", "truth/robot.tum", "truth/objects.csv"] {
        let told = refusal(file, shorter);
        assert!(told.contains("manifest.json, counts."), "{told}");
    }
    let told = refusal("odometry.csv", shorter);
    assert!(told.contains("odometry.csv, rows: got 1, expected 3"), "{told}");
    let twice = |text: String| {
        let row = text.lines().nth(1).unwrap().to_owned();
        format!("{text}{row}\n")
    };
    for file in ["timestamps.csv", "odometry.csv", "detections.csv", "truth/robot.tum"] {
        refusal(file, twice);
    }
    let swapped = refusal("detections.csv", |text| {
        let mut lines: Vec<&str> = text.lines().collect();
        lines.swap(1, 2);
        lines.join("\n")
    });
    assert!(swapped.contains("ordered by step, then track"), "{swapped}");
    let renamed = refusal("timestamps.csv", |text| text.replace("timestamp", "time"));
    assert!(renamed.contains("expected 2 (step,timestamp)"), "{renamed}");
    assert!(refusal("timestamps.csv", |_| String::new()).contains("line 1, columns"));
}

#[test]
fn cameras_that_cannot_be_are_refused() {
    let changes = [("\"width\": 320", "\"width\": 0"), ("\"fx\": ", "\"fx\": -"), ("\"fy\": ", "\"zoom\": ")];
    for (from, to) in changes {
        let told = refusal("camera.json", |text| text.replace(from, to));
        assert!(told.contains("camera.json"), "{told}");
    }
}

#[test]
fn arrays_of_another_shape_or_a_giant_size_are_refused_before_they_are_held() {
    let n = episode(Seed(2), 4, 3).observations.detections.len();
    let changes = [
        (format!("({n}, 32, 32, 3)"), format!("({n}, 32, 16, 6)")),
        (format!("({n}, 32, 32, 3)"), format!("({}, 32, 32, 3)", n + 1)),
        ("|u1".to_owned(), "|i1".to_owned()),
        ("False".to_owned(), "True ".to_owned()),
    ];
    for (from, to) in changes {
        let folder = tempfile::tempdir().unwrap();
        written(folder.path());
        forge(folder.path(), "crops_boxed.npy", |mut bytes| {
            let header = String::from_utf8_lossy(&bytes[10..128]).replace(&from, &to);
            bytes[10..10 + header.len()].copy_from_slice(header.as_bytes());
            bytes
        });
        let error = read_episode(folder.path()).unwrap_err();
        assert!(error.to_string().contains("crops_boxed.npy, header"), "{error}");
    }
    for change in
        [|b: &mut Vec<u8>| b.truncate(200), |b: &mut Vec<u8>| b.truncate(3), |b: &mut Vec<u8>| b.push(0)]
    {
        let folder = tempfile::tempdir().unwrap();
        written(folder.path());
        forge(folder.path(), "crops_masked.npy", |mut bytes| {
            change(&mut bytes);
            bytes
        });
        let error = read_episode(folder.path()).unwrap_err();
        assert!(matches!(error, StoreError::Invalid { .. }), "{error}");
    }
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    forge_manifest(folder.path(), |manifest| {
        manifest.counts.insert("detections".to_owned(), u64::MAX);
        manifest.files.get_mut("crops_masked.npy").unwrap().bytes = u64::MAX;
    });
    assert_eq!(read_episode(folder.path()).unwrap_err().kind(), StoreErrorKind::Stored);
}

#[test]
fn no_name_in_a_manifest_leads_out_of_its_folder() {
    for name in ["../x", "/etc/passwd", "a/../../x", "", ".", "a//b", "a\\b", "C:x", "a/"] {
        let folder = tempfile::tempdir().unwrap();
        write_episode(folder.path(), &episode(Seed(2), 1, 1), Provenance::new()).unwrap();
        forge_manifest(folder.path(), |manifest| {
            let record = manifest.files["camera.json"].clone();
            manifest.files.insert(name.to_owned(), record);
        });
        for error in [verify(folder.path()).unwrap_err(), read_observations(folder.path()).unwrap_err()] {
            assert!(error.to_string().contains("a plain path inside the folder"), "{name:?}: {error}");
        }
    }
}

#[cfg(unix)]
#[test]
fn links_are_not_followed() {
    let [inner, outer] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let written = episode(Seed(2), 2, 1);
    for folder in [&inner, &outer] {
        write_episode(folder.path(), &written, Provenance::new()).unwrap();
    }
    fs::remove_dir_all(inner.path().join("truth")).unwrap();
    std::os::unix::fs::symlink(outer.path().join("truth"), inner.path().join("truth")).unwrap();
    assert!(read_truth(inner.path()).unwrap_err().to_string().contains("not a link"));
    fs::remove_file(inner.path().join("camera.json")).unwrap();
    std::os::unix::fs::symlink(outer.path().join("camera.json"), inner.path().join("camera.json")).unwrap();
    assert!(read_observations(inner.path()).unwrap_err().to_string().contains("not a link"));
}

#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_told_by_its_kind() {
    let folder = tempfile::tempdir().unwrap();
    write_episode(folder.path(), &episode(Seed(2), 2, 1), Provenance::new()).unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::remove_file(at("camera.json")).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(at("camera.json")).status().unwrap().success());
    let told = || read_observations(folder.path()).unwrap_err().to_string();
    let expected = "expected a regular file, not a link";
    let pipe = format!("camera.json, type: got a pipe, a socket or a device, {expected}");
    assert!(told().contains(&pipe), "{}", told());
    fs::remove_file(at("camera.json")).unwrap();
    fs::create_dir(at("camera.json")).unwrap();
    assert!(told().contains(&format!("camera.json, type: got a folder, {expected}")), "{}", told());
    fs::remove_dir_all(at("truth")).unwrap();
    fs::write(at("truth"), "").unwrap();
    let told = read_truth(folder.path()).unwrap_err().to_string();
    assert!(told.contains("truth, type: got a regular file, expected a folder, not a link"), "{told}");
}

#[test]
fn what_breaks_the_format_is_not_written() {
    let breaks: [fn(&mut Episode); 7] = [
        |e| e.observations.timestamps[1] = f64::NAN,
        |e| e.observations.odometry[0].covariance[(0, 1)] += 1e-3,
        |e| e.observations.odometry[0].covariance = Matrix6::zeros(),
        |e| e.truth.world_from_robot[0].translation.vector.x = f64::INFINITY,
        |e| e.truth.detections.truncate(1),
        |e| e.truth.objects.clear(),
        |e| e.observations.timestamps.clear(),
    ];
    for (i, spoil) in breaks.iter().enumerate() {
        let folder = tempfile::tempdir().unwrap();
        let mut spoilt = episode(Seed(2), 4, 3);
        spoil(&mut spoilt);
        let error = write_episode(folder.path(), &spoilt, Provenance::new()).unwrap_err();
        assert!(matches!(error, StoreError::Unfit { .. }), "{i}: {error}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{i}");
    }
    let breaks: [fn(&mut ViewSet); 5] = [
        |s| s.instances[1] = s.instances[0].clone(),
        |s| s.views[0].viewpoint.direction *= 2.0,
        |s| s.views.reverse(),
        |s| s.views[0].box_center_error[1] = f64::NAN,
        |s| s.views[0].instance = 99,
    ];
    for (i, spoil) in breaks.iter().enumerate() {
        let folder = tempfile::tempdir().unwrap();
        let mut spoilt = view_set(Seed(6), 5);
        spoil(&mut spoilt);
        let error = write_views(folder.path(), &spoilt, Provenance::new()).unwrap_err();
        assert!(matches!(error, StoreError::Unfit { .. }), "{i}: {error}");
    }
}

#[test]
fn one_kind_is_not_taken_for_another() {
    let folder = tempfile::tempdir().unwrap();
    write_views(folder.path(), &view_set(Seed(6), 2), Provenance::new()).unwrap();
    let error = read_observations(folder.path()).unwrap_err();
    assert!(error.to_string().contains("holds a view set: name a folder that holds an episode"), "{error}");
    assert_eq!(error.kind(), StoreErrorKind::Choice);
}

use super::*;
use crate::store::*;
use std::path::PathBuf;

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for path in fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
        if path.is_dir() { files.extend(self::files(&path)) } else { files.push(path) }
    }
    files
}

/// Changes the bytes of a file, or loses the file.
type Damage = fn(Vec<u8>) -> Option<Vec<u8>>;

const DAMAGES: [(&str, Damage); 4] = [
    ("a flipped bit", |mut bytes| {
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        Some(bytes)
    }),
    ("a lost end", |bytes| Some(bytes[..bytes.len() / 2].to_vec())),
    ("an addition", |bytes| Some([bytes, vec![b'0']].concat())),
    ("a loss", |_| None),
];

fn assert_every_damage_noticed(folder: &Path, read: impl Fn(&Path) -> Result<(), StoreError>) {
    for file in files(folder) {
        let name = file.file_name().unwrap().to_str().unwrap();
        let sound = fs::read(&file).unwrap();
        for (what, damage) in DAMAGES {
            match damage(sound.clone()) {
                Some(bytes) => fs::write(&file, bytes).unwrap(),
                None => fs::remove_file(&file).unwrap(),
            }
            for error in [read(folder).unwrap_err(), verify(folder).unwrap_err()] {
                assert_eq!(error.kind(), StoreErrorKind::Stored, "{what} in {name}: {error}");
                assert!(error.to_string().contains(name), "{what} in {name}: {error}");
            }
            fs::write(&file, &sound).unwrap();
            read(folder).unwrap();
        }
    }
}

#[test]
fn damage_to_any_file_of_an_episode_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    write_episode(folder.path(), &episode(Seed(5), 3, 2), Provenance::new()).unwrap();
    assert_eq!(files(folder.path()).len(), 13);
    assert_every_damage_noticed(folder.path(), |folder| read_episode(folder).map(drop));
}

#[test]
fn damage_to_any_file_of_a_view_set_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    write_views(folder.path(), &view_set(Seed(6), 5), Provenance::new()).unwrap();
    assert_eq!(files(folder.path()).len(), 5);
    assert_every_damage_noticed(folder.path(), |folder| read_views(folder).map(drop));
}

#[test]
fn any_bit_of_a_manifest_counts() {
    let folder = tempfile::tempdir().unwrap();
    write_views(folder.path(), &view_set(Seed(6), 1), Provenance::new()).unwrap();
    let path = folder.path().join("manifest.json");
    let sound = fs::read(&path).unwrap();
    let original = read_manifest(folder.path()).unwrap();
    for i in 0..sound.len() {
        let mut bytes = sound.clone();
        bytes[i] ^= 1;
        fs::write(&path, &bytes).unwrap();
        match read_manifest(folder.path()) {
            Ok(read) => assert!(sound[i].is_ascii_whitespace() && read == original, "byte {i}"),
            Err(error) => assert_eq!(error.kind(), StoreErrorKind::Stored),
        }
    }
}

#[test]
fn a_folder_is_finished_only_by_its_manifest() {
    let folder = tempfile::tempdir().unwrap();
    assert!(matches!(verify(folder.path()), Err(StoreError::Unfinished { .. })));
    write_episode(folder.path(), &episode(Seed(5), 3, 2), Provenance::new()).unwrap();
    fs::remove_file(folder.path().join("odometry.csv")).unwrap();
    fs::create_dir(folder.path().join("odometry.csv")).unwrap();
    let error = write_episode(folder.path(), &episode(Seed(5), 3, 2), Provenance::new()).unwrap_err();
    assert_eq!(error.kind(), StoreErrorKind::Unwritable, "{error}");
    assert!(matches!(read_episode(folder.path()), Err(StoreError::Unfinished { .. })));
}

#[test]
fn a_newer_format_is_refused_and_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    write_views(folder.path(), &view_set(Seed(6), 2), Provenance::new()).unwrap();
    let path = folder.path().join("manifest.json");
    let newer = br#"{"format": 2, "something": "else"}"#;
    fs::write(&path, newer).unwrap();
    let error = read_views(folder.path()).unwrap_err();
    assert!(matches!(error, StoreError::Newer { found: 2, supported: 1, .. }), "{error}");
    assert_eq!(fs::read(&path).unwrap(), newer);
    for other in ["{}", "[]", "{\"format\": 0}", "{\"format\": \"1\"}", "{\"format\": 1}", ""] {
        fs::write(&path, other).unwrap();
        assert!(matches!(read_views(folder.path()), Err(StoreError::Invalid { .. })), "{other}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_of_its_own() {
    let error = write_tum(Path::new("/dev/full"), &[0.0], &[Pose::identity()]).unwrap_err();
    assert_eq!(error.kind(), StoreErrorKind::Unwritable);
    assert!(error.to_string().contains("free some space"), "{error}");
}

#[test]
fn a_file_in_the_way_of_a_folder_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    for error in [
        write_episode(&file.join("episode"), &episode(Seed(5), 1, 0), Provenance::new()).unwrap_err(),
        Cache::open(&file).err().unwrap(),
    ] {
        assert_eq!(error.kind(), StoreErrorKind::Unwritable, "{error}");
    }
}

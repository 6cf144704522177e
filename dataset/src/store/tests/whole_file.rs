use crate::store::{read_regular, rename_durably, write_atomically};
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_file_is_written_whole_over_what_was_there_and_over_what_a_kill_left() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.json");
    fs::write(folder.path().join("a.json.tmp"), "cut sh").unwrap();
    for text in ["first", "second, longer", "3"] {
        write_atomically(&path, text.as_bytes()).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
        assert_eq!(names(folder.path()), ["a.json"]);
    }
    let to = folder.path().join("b.json");
    rename_durably(&path, &to).unwrap();
    assert_eq!(names(folder.path()), ["b.json"]);
}

#[test]
fn what_cannot_be_written_leaves_all_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir_all(folder.path().join("taken/inside")).unwrap();
    assert!(write_atomically(&folder.path().join("taken"), b"text").is_err());
    assert_eq!(names(folder.path()), ["taken"]);
    let missing = write_atomically(&folder.path().join("missing/a"), b"text").unwrap_err();
    assert_eq!(missing.kind(), ErrorKind::NotFound);
}

#[test]
fn a_file_of_the_limit_is_read_and_a_larger_one_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    fs::write(&path, "seven b").unwrap();
    assert_eq!(read_regular(&path, 7).unwrap(), b"seven b");
    assert_eq!(read_regular(&path, u64::MAX).unwrap(), b"seven b");
    let refused = read_regular(&path, 6).unwrap_err();
    assert_eq!(
        (refused.kind(), refused.to_string().as_str()),
        (ErrorKind::FileTooLarge, "it has more than 6 bytes")
    );
    assert_eq!(read_regular(&folder.path().join("b"), 6).unwrap_err().kind(), ErrorKind::NotFound);
}

#[cfg(unix)]
#[test]
fn a_pipe_a_device_and_a_folder_are_not_opened() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    assert!(std::process::Command::new("mkfifo").arg(at("pipe")).status().unwrap().success());
    std::os::unix::fs::symlink("/dev/zero", at("endless")).unwrap();
    fs::create_dir(at("folder")).unwrap();
    fs::write(at("file"), "text").unwrap();
    std::os::unix::fs::symlink(at("file"), at("link")).unwrap();
    for name in ["pipe", "endless", "folder"] {
        let refused = read_regular(&at(name), 1 << 20).unwrap_err();
        assert_eq!(refused.kind(), ErrorKind::InvalidInput, "{name}: {refused}");
    }
    assert_eq!(read_regular(&at("link"), 4).unwrap(), b"text");
}

use crate::store::{FolderLock, StoreErrorKind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

#[test]
fn one_at_a_time_writes_and_nothing_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let (inside, waits) = (AtomicU32::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                let tell = |waiting: &_| waits.lock().unwrap().push(format!("{waiting}"));
                let lock = FolderLock::take(folder.path(), &tell).unwrap();
                assert_eq!(inside.fetch_add(1, Ordering::SeqCst), 0, "two at a time");
                std::thread::sleep(Duration::from_millis(5));
                inside.fetch_sub(1, Ordering::SeqCst);
                drop(lock);
            });
        }
    });
    let waits = waits.into_inner().unwrap();
    assert!(waits.len() >= 7, "{waits:?}");
    assert!(waits.iter().all(|wait| wait.contains("waiting for")), "{waits:?}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn what_a_killed_run_left_is_taken_at_once() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(".bench.lock"), "4194304").unwrap();
    let lock = FolderLock::take(folder.path(), &|waiting| panic!("{waiting}")).unwrap();
    let name = std::fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap().file_name();
    assert!(FolderLock::is_named(&name), "{name:?}");
    drop(lock);
    let gone = FolderLock::take(&folder.path().join("missing"), &|_| ());
    assert_eq!(gone.err().unwrap().kind(), StoreErrorKind::Unwritable);
}

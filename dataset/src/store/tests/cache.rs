use super::*;
use crate::store::*;
use serde_json::json;
use std::env;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// Where the store of a test's other process is.
const ROOT: &str = "VANTAGE_TEST_CACHE";

fn key(n: u64) -> Key {
    Key::new("stage", &json!({ "seed": n })).unwrap()
}

fn put(folder: &Path, text: &str) -> Result<(), StoreError> {
    fs::create_dir_all(folder.join("sub")).unwrap();
    fs::write(folder.join("sub/result"), text).unwrap();
    Ok(())
}

fn get(folder: &Path) -> String {
    fs::read_to_string(folder.join("sub/result")).unwrap()
}

fn never(_: &Path) -> Result<(), StoreError> {
    panic!("built what was there")
}

#[test]
fn a_stage_runs_once_for_equal_inputs() {
    let root = tempfile::tempdir().unwrap();
    let cache = Cache::open(root.path()).unwrap();
    let built = cache.get_or_build(&key(1), |work| put(work, "one")).unwrap();
    assert_eq!((get(&built.folder).as_str(), &built.origin), ("one", &Origin::Built));
    let again = Cache::open(root.path()).unwrap().get_or_build(&key(1), never).unwrap();
    assert_eq!((again.folder, again.origin), (built.folder, Origin::Stored));
    let other = cache.get_or_build(&key(2), |work| put(work, "two")).unwrap();
    assert_eq!((get(&other.folder).as_str(), other.origin), ("two", Origin::Built));
}

#[test]
fn keys_are_pinned_and_tell_stages_and_inputs_apart() {
    let a = Key::new("a", &json!({"x": 1, "y": 2})).unwrap();
    assert_eq!(a, Key::new("a", &json!({"y": 2, "x": 1})).unwrap());
    assert_eq!(a.hash(), "49604d409c4c767c1c4b5df0a70accd177ac07bd5fe00871da0f2035cc7564c8");
    assert_ne!(a.hash(), Key::new("b", &json!({"x": 1, "y": 2})).unwrap().hash());
    assert_ne!(a.hash(), Key::new("a", &json!({"x": 1, "y": 3})).unwrap().hash());
    for stage in ["", "../up", "a/b", "A"] {
        assert_eq!(Key::new(stage, &1).unwrap_err().kind(), StoreErrorKind::Bug);
    }
}

#[test]
fn damage_is_set_aside_and_made_anew() {
    let damages: [fn(&Path); 5] = [
        |entry| fs::write(entry.join("sub/result"), "oxe").unwrap(),
        |entry| fs::write(entry.join("sub/result"), "on").unwrap(),
        |entry| fs::remove_file(entry.join("sub/result")).unwrap(),
        |entry| fs::remove_file(entry.join("entry.json")).unwrap(),
        |entry| fs::write(entry.join("entry.json"), "{").unwrap(),
    ];
    let root = tempfile::tempdir().unwrap();
    let cache = Cache::open(root.path()).unwrap();
    for (i, damage) in damages.iter().enumerate() {
        let entry = cache.get_or_build(&key(1), |work| put(work, "one")).unwrap();
        damage(&entry.folder);
        let rebuilt = cache.get_or_build(&key(1), |work| put(work, "one")).unwrap();
        let Origin::Rebuilt { damage, quarantined } = rebuilt.origin else {
            panic!("damage {i} not noticed: {:?}", rebuilt.origin)
        };
        assert!(!damage.is_empty() && quarantined.is_dir());
        assert_eq!(get(&rebuilt.folder), "one");
        assert_eq!(fs::read_dir(root.path().join("quarantine")).unwrap().count(), i + 1);
    }
}

#[test]
fn an_entry_put_at_the_place_of_another_is_not_taken_for_it() {
    let root = tempfile::tempdir().unwrap();
    let cache = Cache::open(root.path()).unwrap();
    let one = cache.get_or_build(&key(1), |work| put(work, "one")).unwrap().folder;
    fs::rename(&one, one.with_file_name(key(2).hash())).unwrap();
    let two = cache.get_or_build(&key(2), |work| put(work, "two")).unwrap();
    assert!(matches!(two.origin, Origin::Rebuilt { .. }) && get(&two.folder) == "two");
}

#[test]
fn newer_data_are_refused_and_left_alone() {
    let root = tempfile::tempdir().unwrap();
    let cache = Cache::open(root.path()).unwrap();
    let entry = cache.get_or_build(&key(1), |work| put(work, "one")).unwrap().folder;
    let newer = r#"{"format": 2}"#;
    fs::write(entry.join("entry.json"), newer).unwrap();
    let error = cache.get_or_build(&key(1), never).unwrap_err();
    assert!(matches!(error, StoreError::Newer { .. }), "{error}");
    assert_eq!(fs::read_to_string(entry.join("entry.json")).unwrap(), newer);
    fs::write(root.path().join("cache.json"), newer).unwrap();
    assert!(matches!(Cache::open(root.path()), Err(StoreError::Newer { .. })));
}

#[test]
fn a_failed_build_leaves_its_work_and_no_entry() {
    let root = tempfile::tempdir().unwrap();
    let cache = Cache::open(root.path()).unwrap();
    let full = cache.get_or_build(&key(1), |work| {
        put(work, "half")?;
        write_tum(Path::new("/dev/full"), &[0.0], &[Pose::identity()]).map(drop)
    });
    assert_eq!(full.unwrap_err().kind(), StoreErrorKind::Unwritable);
    let resumed = cache.get_or_build(&key(1), |work| {
        assert_eq!(get(work), "half");
        put(work, "whole")
    });
    let resumed = resumed.unwrap();
    assert_eq!((get(&resumed.folder).as_str(), resumed.origin), ("whole", Origin::Built));
    assert_eq!(fs::read_dir(root.path().join("work")).unwrap().count(), 0);
}

#[cfg(unix)]
#[test]
fn links_do_not_enter_the_cache() {
    let root = tempfile::tempdir().unwrap();
    let cache = Cache::open(root.path()).unwrap();
    let linked = cache.get_or_build(&key(1), |work| {
        std::os::unix::fs::symlink("/etc/passwd", work.join("link")).unwrap();
        Ok(())
    });
    assert!(matches!(linked, Err(StoreError::Unfit { .. })));
}

#[test]
fn threads_that_ask_at_once_build_once() {
    let root = tempfile::tempdir().unwrap();
    let builds = AtomicUsize::new(0);
    let waits = Arc::new(Mutex::new(Vec::new()));
    thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let waits = Arc::clone(&waits);
                let tell = move |waiting: &Waiting| waits.lock().unwrap().push(waiting.to_string());
                let cache = Cache::open(root.path()).unwrap().on_wait(tell);
                let entry = cache.get_or_build(&key(1), |work| {
                    builds.fetch_add(1, Ordering::SeqCst);
                    thread::sleep(Duration::from_millis(200));
                    put(work, "one")
                });
                assert_eq!(get(&entry.unwrap().folder), "one");
            });
        }
    });
    assert_eq!(builds.load(Ordering::SeqCst), 1);
    let waits = waits.lock().unwrap();
    // The holder names itself just after it has the lock: who asks between sees nobody's name.
    let named = format!("waiting for process {}, which makes stage", std::process::id());
    let holders = [named.as_str(), "waiting for another process, which makes stage"];
    let told = |wait: &String| holders.iter().any(|holder| wait.starts_with(holder));
    assert!(!waits.is_empty() && waits.iter().all(told), "{waits:?}");
}

/// This test once more, in a process of its own.
fn other_process(test: &str, root: &Path) -> Child {
    Command::new(env::current_exe().unwrap())
        .args(["--exact", &format!("store::tests::cache::{test}")])
        .env(ROOT, root)
        .stdout(Stdio::null())
        .spawn()
        .unwrap()
}

fn wait_for(path: &Path) {
    let start = Instant::now();
    while !path.exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "{} never came", path.display());
        thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn processes_that_ask_at_once_build_once() {
    let build = |root: &Path| {
        let entry = Cache::open(root).unwrap().get_or_build(&key(1), |work| {
            let once = fs::OpenOptions::new().write(true).create_new(true).open(root.join("built"));
            once.unwrap();
            thread::sleep(Duration::from_millis(200));
            put(work, "one")
        });
        assert_eq!(get(&entry.unwrap().folder), "one");
    };
    if let Some(root) = env::var_os(ROOT) {
        return build(Path::new(&root));
    }
    let root = tempfile::tempdir().unwrap();
    let others: Vec<_> =
        (0..3).map(|_| other_process("processes_that_ask_at_once_build_once", root.path())).collect();
    build(root.path());
    for mut other in others {
        assert!(other.wait().unwrap().success());
    }
}

#[test]
fn a_killed_build_is_taken_up_where_it_was() {
    if let Some(root) = env::var_os(ROOT) {
        let root = Path::new(&root);
        let endless = Cache::open(root).unwrap().get_or_build(&key(1), |work| {
            put(work, "half")?;
            fs::write(root.join("started"), "").unwrap();
            thread::sleep(Duration::from_secs(60));
            Ok::<_, StoreError>(())
        });
        panic!("not killed: {endless:?}");
    }
    let root = tempfile::tempdir().unwrap();
    let mut other = other_process("a_killed_build_is_taken_up_where_it_was", root.path());
    wait_for(&root.path().join("started"));
    let cache = Cache::open(root.path()).unwrap();
    assert!(cache.remove_abandoned_work(Duration::ZERO).unwrap().is_empty());
    other.kill().unwrap();
    other.wait().unwrap();
    let resumed = cache.get_or_build(&key(1), |work| {
        assert_eq!(get(work), "half");
        put(work, "whole")
    });
    assert_eq!(get(&resumed.unwrap().folder), "whole");
}

#[test]
fn abandoned_work_is_removed_when_it_has_rested() {
    let root = tempfile::tempdir().unwrap();
    let cache = Cache::open(root.path()).unwrap();
    let stop = StoreError::Unfinished { folder: "here".into() };
    cache.get_or_build(&key(1), |work| put(work, "half").and(Err(stop))).unwrap_err();
    assert!(cache.remove_abandoned_work(Duration::from_secs(60)).unwrap().is_empty());
    assert_eq!(cache.remove_abandoned_work(Duration::ZERO).unwrap().len(), 1);
    let fresh = cache.get_or_build(&key(1), |work| {
        assert!(!work.join("sub").exists());
        put(work, "one")
    });
    fresh.unwrap();
}

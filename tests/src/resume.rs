//! A run that is killed and gone on with, beside one that is not.

use crate::{Finished, SmallScene, files};
use std::path::Path;
use std::process::Stdio;
use std::thread;
use std::time::Duration;

/// Runs `bench dataset` with `args` into `whole`, and into `killed`, where it is killed once it is `under_way` there and then gone on
/// with; compares the two folders byte by byte.
///
/// # Panics
/// If a file differs, or the run ends before it can be killed.
pub fn assert_resumes(scene: &SmallScene, args: &[&str], under_way: impl Fn(&Path) -> bool) {
    let (whole, killed) = (scene.path("whole"), scene.path("killed"));
    Finished::of(&mut scene.dataset("whole", args)).expect(0, &[]);
    let mut run = scene.dataset("killed", args);
    let mut run = run.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program starts");
    while !under_way(&killed) {
        let ended = run.try_wait().expect("a state of the run");
        assert!(ended.is_none(), "the run ended before it could be killed");
        thread::sleep(Duration::from_millis(2));
    }
    run.kill().expect("the run can be killed");
    run.wait().expect("the run has ended");
    assert!(killed.join(".bench.lock").exists(), "it held the folder, and so was not done");
    Finished::of(&mut scene.dataset("killed", args)).expect(0, &[]);

    let (whole, resumed) = (files(&whole), files(&killed));
    assert!(whole.keys().eq(resumed.keys()), "{:?} and {:?}", whole.keys(), resumed.keys());
    for (name, bytes) in &whole {
        assert!(resumed[name] == *bytes, "{} differs", name.display());
    }
}

//! Scene files: a scene that can be simulated or an error, whatever the text.

#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use vantage_eval::scene_file::{SceneFile, parse};
use vantage_sim::checked::{CheckedScene, SceneSpec};

fuzz_target!(|text: &str| {
    let Ok(SceneFile { mut world, robot, sensors, views, .. }) = parse(text, Path::new("scene.yaml")) else {
        return;
    };
    // What a file names is not the fuzzer's to read.
    world.meshes.clear();
    world.fixtures.clear();
    let _ = CheckedScene::new(SceneSpec { world, robot, sensors, views }, Path::new(""), None, &mut |_| ());
});

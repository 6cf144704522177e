//! Scenes for tests.

use serde::Deserialize;
use std::fs;
use std::path::Path;
use vantage_sim::checked::{CheckedScene, SceneSpec};
use vantage_sim::scene::rule::Interval;
use vantage_sim::scene::{LightingSpec, PathSpec, RobotSpec, SensorSpec, ViewsSpec, WorldSpec};

/// The simulator's part of a scene file.
#[derive(Deserialize)]
struct SceneFile {
    world: WorldSpec,
    robot: RobotSpec,
    sensors: SensorSpec,
    views: ViewsSpec,
}

/// One of the scenes that come with the project.
pub fn shipped(name: &str) -> SceneSpec {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../scenes/{name}.yaml"));
    let text = fs::read_to_string(&path).unwrap();
    let file: SceneFile = serde_saphyr::from_str(&text).unwrap();
    SceneSpec { world: file.world, robot: file.robot, sensors: file.sensors, views: file.views }
}

/// The tabletop with few objects, steps and pixels.
pub fn small() -> SceneSpec {
    let mut spec = shipped("tabletop");
    spec.world.objects = 4;
    spec.robot.path = PathSpec::Circle { radius: 1.2 };
    spec.robot.laps = 1.0;
    spec.robot.speed = 0.5;
    spec.robot.steps = Some(8);
    spec.sensors.camera.width = 160;
    spec.sensors.camera.height = 120;
    spec.sensors.detector.min_mask_pixels = 20;
    spec
}

/// Checked, as it must be; without meshes.
pub fn checked(spec: SceneSpec) -> CheckedScene {
    CheckedScene::new(spec, Path::new(""), None, &mut |_| ()).unwrap()
}

/// The same light from everywhere, so that looks differ by viewpoint only.
pub fn even_light() -> LightingSpec {
    LightingSpec {
        ambient: Interval([1.0, 1.0]),
        directional: Interval([0.0, 0.0]),
        elevation_deg: Interval([45.0, 45.0]),
        tint: 0.0,
    }
}

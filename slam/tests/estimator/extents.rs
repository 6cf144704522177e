//! Objects as ellipsoids: extents from the edges of boxes.

use crate::model::TanhModel;
use crate::which::{Which, estimate};
use crate::world::{World, WorldSpec, matching_settings};
use nalgebra::{DVector, Vector2, Vector3};
use vantage_dataset::{BoundingBox, Seed};
use vantage_slam::factor::{BoxEdgesFactor, Factor};
use vantage_slam::noise::Kernel;
use vantage_slam::variable::{Value, Values};
use vantage_slam::{ExtentsSettings, Key, Outcome, Settings};

const AXES: [f64; 3] = [0.15, 0.15, 0.25];

fn spec() -> WorldSpec {
    WorldSpec { objects: 5, laps: 1.0, inward: true, ..WorldSpec::sparse_loop() }
}

fn settings() -> Settings {
    let mut settings = matching_settings(&spec());
    settings.geometry.extents = Some(ExtentsSettings { half_axis: 0.1, log_sigma: 0.7 });
    settings
}

/// Boxes of ellipsoids that stand upright; each edge is off by the noise of a bearing times `noise`.
fn of_ellipsoids(mut world: World, noise: f64, seed: Seed) -> World {
    let mut stream = seed.stream("edges", 0);
    let camera = world.observations.camera;
    let mount = world.observations.robot_from_camera;
    let (robot, object, extents) = (Key::Robot(0), Key::Object(0), Key::Extents(0));
    world.observations.detections.retain_mut(|detection| {
        let mut values = Values::default();
        values.insert(robot, Value::Pose(world.world_from_robot[detection.step]));
        let center = world.world_from_object[detection.track].translation.vector;
        values.insert(object, Value::Point(center));
        let logs = AXES.map(f64::ln).to_vec();
        values.insert(extents, Value::Vector(DVector::from_vec(logs)));
        let factor = BoxEdgesFactor::new([robot, object, extents], mount, [0.0; 4], 1.0, Kernel::Gaussian);
        let Some(bounds) = factor.residual(&values) else { return false };
        let mut edge = || noise * spec().bearing_sigma * stream.normal();
        let pixel = |x: f64, y: f64| Vector2::new(x * camera.fx + camera.cx, y * camera.fy + camera.cy);
        let min = pixel(bounds[0] + edge(), bounds[1] + edge());
        let max = pixel(bounds[2] + edge(), bounds[3] + edge());
        detection.bounding_box = BoundingBox { min, max };
        min.x < max.x && min.y < max.y
    });
    world
}

#[test]
fn axes_are_found_from_the_edges_of_boxes() {
    let world = of_ellipsoids(World::new(&spec(), None, Seed(1)), 0.5, Seed(1));
    let answer = estimate(&world.observations, Which::Geometric, None, &settings()).unwrap();
    assert_eq!(answer.outcome, Outcome::Converged);
    let mut found = 0;
    for object in answer.objects.iter().flatten() {
        let off = (object.extents.unwrap() - Vector3::from(AXES)).abs();
        assert!(off.max() < 0.03, "{:?}", object.extents);
        let axes = object.extents.unwrap();
        assert!((axes.x - axes.y).abs() < 1e-6, "no heading, and yet {axes}");
        found += 1;
    }
    assert!(found >= 4, "{found} placed");
    let plain = estimate(&world.observations, Which::Geometric, None, &matching_settings(&spec())).unwrap();
    assert!(plain.objects.iter().flatten().all(|object| object.extents.is_none()));
    println!("ATE {:.4} m by edges, {:.4} m by bearings", world.ate(&answer), world.ate(&plain));
    assert!(world.ate(&answer) < 1.2 * world.ate(&plain));
}

#[test]
fn semantic_estimators_have_them_and_too_little_does_not_break() {
    let model = TanhModel::new([4, 6, 8], 0.03, 5.0, Seed(1));
    let world = of_ellipsoids(World::new(&spec(), Some(&model), Seed(2)), 0.5, Seed(2));
    for which in [Which::Semantic, Which::Uninformative] {
        let answer = estimate(&world.observations, which, Some(&model), &settings()).unwrap();
        assert!(answer.objects.iter().flatten().all(|object| object.extents.is_some()), "{which:?}");
    }
    let mut few = world.observations.clone();
    few.detections.retain(|d| d.step < 3);
    let answer = estimate(&few, Which::Geometric, None, &settings()).unwrap();
    assert!(answer.world_from_robot.iter().all(|p| p.to_homogeneous().iter().all(|x| x.is_finite())));
    for object in answer.objects.iter().flatten() {
        assert!(object.extents.is_none_or(|axes| axes.iter().all(|a| a.is_finite() && *a > 0.0)));
    }
}

//! One lap outside of a ring and one inside.

use crate::scene::{checked, shipped};
use crate::sides::turned;
use vantage_dataset::{Seed, Split};
use vantage_sim::checked::SceneSpec;
use vantage_sim::error::SimError;
use vantage_sim::plan::body;
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::rollout::roll_out;
use vantage_sim::scene::{InsideAndOutsideSpec, PathSpec, PieceSpec, SurfaceSpec};
use vantage_sim::simulate;

const SEEDS: std::ops::Range<u64> = 0..8;

/// The shipped scene, seen by a small camera.
fn ring() -> SceneSpec {
    let mut spec = shipped("ring");
    spec.sensors.camera.width = 160;
    spec.sensors.camera.height = 120;
    spec.sensors.detector.min_mask_pixels = 25;
    spec
}

#[test]
fn the_ring_is_crossed_where_it_is_free_and_either_lap_comes_first() {
    let scene = checked(ring());
    let (mut outside_first, mut crossings) = (0, Vec::new());
    for seed in SEEDS {
        let roll = || roll_out(&scene, Seed(seed), Split::Test, &mut |_| ()).unwrap();
        let rollout = roll();
        let ground = rollout.world.ground(&scene.world().room);
        for pose in &rollout.drive.world_from_robot {
            let clearance = ground.clearance(&pose.translation.vector.xy());
            assert!(clearance > body::RADIUS + 0.1, "seed {seed}: {clearance} m");
        }
        assert_eq!(roll().drive, rollout.drive, "seed {seed}");
        let radius = |step: usize| rollout.drive.world_from_robot[step].translation.vector.xy().norm();
        let (first, last) = (radius(0), radius(rollout.steps() - 1));
        outside_first += usize::from(first > last);
        assert!((first.max(last) - 4.8).abs() < 0.1 && (first.min(last) - 1.6).abs() < 0.1, "{first} {last}");
        let middle = (rollout.drive.middle * (rollout.steps() - 1) as f64).round() as usize;
        assert!((2.8..3.6).contains(&radius(middle)), "seed {seed}: {} m", radius(middle));
        crossings.push(rollout.drive.world_from_robot[middle].translation.vector);
    }
    assert!((1..=7).contains(&outside_first), "{outside_first} of 8");
    assert!(crossings.windows(2).all(|pair| (pair[0] - pair[1]).norm() > 1e-3));
}

#[test]
fn the_second_lap_sees_objects_from_the_other_side_and_under_another_light() {
    let scene = checked(ring());
    for seed in 0..4 {
        let rollout = roll_out(&scene, Seed(seed), Split::Test, &mut |_| ()).unwrap();
        let degrees = turned(&ring(), seed, rollout.drive.middle);
        println!("seed {seed}: mean change of azimuth {degrees:.0} degrees");
        assert!(degrees > 150.0, "seed {seed}: {degrees}");
        let start = rollout.render_scene(&scene).light;
        let crossing = rollout.drive.middle * (rollout.steps() - 1) as f64;
        for step in 0..rollout.steps() {
            assert_eq!(
                rollout.light(step, &start) != start,
                step as f64 > crossing,
                "seed {seed}, step {step}"
            );
        }
    }
}

#[test]
fn every_object_is_seen_on_both_laps() {
    let scene = checked(shipped("ring"));
    let mut renderer = ReferenceRenderer::default();
    for seed in 0..2 {
        let rollout = roll_out(&scene, Seed(seed), Split::Test, &mut |_| ()).unwrap();
        let middle = (rollout.drive.middle * rollout.steps() as f64) as usize;
        let episode = simulate(&scene, Seed(seed), Split::Test, &mut renderer, &mut |_| ()).unwrap();
        let mut seen = vec![[0, 0]; episode.truth.objects.len()];
        for detection in &episode.observations.detections {
            seen[detection.track][usize::from(detection.step > middle)] += 1;
        }
        println!("seed {seed}: detections of each object on both laps {seen:?}");
        let twice = seen.iter().filter(|laps| laps.iter().all(|count| *count > 0)).count();
        assert!(twice >= 3, "seed {seed}: {seen:?}");
    }
}

#[test]
fn tables_in_a_ring_will_do_and_one_without_a_gap_is_refused() {
    let table = |at| PieceSpec::Table { at, size: [0.6, 0.6, 0.74] };
    let mut spec = ring();
    let path = InsideAndOutsideSpec { inner_radius: 1.2, outer_radius: 4.4, clearance: 0.1 };
    spec.robot.path = PathSpec::InsideAndOutside(path);
    let ring = |count: u32| {
        let angles = (0..count).map(move |i| std::f64::consts::TAU * f64::from(i) / f64::from(count));
        angles.map(|angle| [2.8 * libm::cos(angle), 2.8 * libm::sin(angle)])
    };
    spec.world.surface = SurfaceSpec::Furniture(ring(5).map(table).collect());
    let scene = checked(spec.clone());
    let rollout = roll_out(&scene, Seed(1), Split::Test, &mut |_| ()).unwrap();
    let ground = rollout.world.ground(&scene.world().room);
    let clearances =
        rollout.drive.world_from_robot.iter().map(|p| ground.clearance(&p.translation.vector.xy()));
    assert!(clearances.fold(f64::INFINITY, f64::min) > body::RADIUS);

    spec.world.surface = SurfaceSpec::Furniture(ring(17).map(table).collect());
    let said = vantage_sim::checked::CheckedScene::new(spec, std::path::Path::new(""), None, &mut |_| ());
    let said = said.unwrap_err().to_string();
    assert!(said.contains("wide enough to cross between the laps"), "{said}");
}

#[test]
fn no_gap_for_a_seed_is_an_error() {
    use vantage_sim::plan::furnishing::Furnishing;
    use vantage_sim::plan::ground::Ground;
    use vantage_sim::plan::stand::Outline;
    let spec = ring();
    let wall = (nalgebra::Vector2::zeros(), Outline::Disc { radius: 2.0 });
    let ground = Ground::new(&spec.world.room, vec![wall]);
    let mut physics = vantage_sim::physics::Physics::new(&Furnishing::default(), &[]);
    let got = vantage_sim::robot::drive(&mut physics, &spec.robot, &ground, Seed(0), &mut |_| ());
    assert!(matches!(got, Err(SimError::NoCrossing { .. })), "{got:?}");
}

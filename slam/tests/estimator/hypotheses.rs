//! The orientation search finds the mode, wherever the object points.

use crate::model::TanhModel;
use crate::which::{Which, estimate};
use crate::world::{World, WorldSpec, matching_settings};
use vantage_dataset::Seed;

#[test]
fn the_grid_finds_the_yaw_that_no_start_value_tells() {
    let model = TanhModel::new([8, 12, 32], 0.03, 5.0, Seed(1));
    let spec = WorldSpec { odometry_sigma: [0.002, 0.002], ..WorldSpec::sparse_loop() };
    let (mut right, mut all) = (0, 0);
    for seed in 0..6 {
        let world = World::new(&spec, Some(&model), Seed(100 + seed));
        let answer =
            estimate(&world.observations, Which::Semantic, Some(&model), &matching_settings(&spec)).unwrap();
        let errors = world.orientation_errors(&answer);
        right += errors.iter().filter(|e| e.to_degrees() < 10.0).count();
        all += errors.len();
        for object in answer.objects.iter().flatten() {
            assert!(object.orientation.unwrap().margin >= 0.0);
        }
    }
    println!("{right} of {all} orientations within 10 degrees");
    assert!(right * 10 >= all * 9);
}

#[test]
fn second_modes_repair_what_one_blurred_view_got_wrong() {
    let model = TanhModel::new([8, 4, 32], 0.2, 5.0, Seed(1));
    let spec = WorldSpec { semantic_sigma: 0.2, ..WorldSpec::sparse_loop() };
    let (mut lower, mut wrong_before, mut wrong_after) = (0, 0, 0);
    for seed in 0..6 {
        let world = World::new(&spec, Some(&model), Seed(seed));
        let with = |alternatives| {
            let mut settings = matching_settings(&spec);
            settings.orientation.views = 1;
            settings.orientation.alternatives = alternatives;
            estimate(&world.observations, Which::Semantic, Some(&model), &settings).unwrap()
        };
        let (without, tried) = (with(0), with(8));
        let wrong =
            |answer| world.orientation_errors(answer).iter().filter(|e| e.to_degrees() > 20.0).count();
        assert!(tried.cost <= without.cost);
        lower += usize::from(tried.cost < without.cost - 1.0);
        wrong_before += wrong(&without);
        wrong_after += wrong(&tried);
    }
    println!("wrong orientations of 48: {wrong_before} before trying second modes, {wrong_after} after");
    assert!(lower > 0 && wrong_after < wrong_before);
}

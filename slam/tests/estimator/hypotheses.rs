//! The orientation search finds the mode, wherever the object points.

use crate::model::TanhModel;
use crate::world::{World, WorldSpec, matching_spec};
use vantage_dataset::Seed;
use vantage_slam::{EstimatorSpec, Row, estimate};

#[test]
fn the_grid_finds_the_yaw_that_no_start_value_tells() {
    let model = TanhModel::new([8, 12, 32], 0.1, 5.0, Seed(1));
    let spec = WorldSpec { odometry_sigma: [0.002, 0.002], ..WorldSpec::sparse_loop() };
    let (mut right, mut all) = (0, 0);
    for seed in 0..6 {
        let world = World::new(&spec, Some(&model), Seed(100 + seed));
        let answer =
            estimate(&world.observations, Row::ViewpointDependent, Some(&model), &matching_spec(&spec))
                .unwrap();
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
fn trying_alternatives_never_raises_the_cost() {
    let model = TanhModel::new([8, 4, 32], 0.4, 5.0, Seed(1));
    let spec = WorldSpec { semantic_sigma: 0.4, ..WorldSpec::sparse_loop() };
    for seed in 0..3 {
        let world = World::new(&spec, Some(&model), Seed(seed));
        let with = |alternatives, ambiguous_margin| {
            let settings = EstimatorSpec { alternatives, ambiguous_margin, ..matching_spec(&spec) };
            estimate(&world.observations, Row::ViewpointDependent, Some(&model), &settings).unwrap()
        };
        let (without, tried) = (with(0, 0.0), with(8, 1e6));
        println!("cost without alternatives {:.4}, with {:.4}", without.cost, tried.cost);
        assert!(tried.cost <= without.cost);
        assert!(tried.iterations > without.iterations);
    }
}

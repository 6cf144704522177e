//! What an iteration costs at full size. Run by hand:
//! `cargo test --release -p vantage-slam --test estimator timing -- --ignored --nocapture`.

use crate::model::TanhModel;
use crate::world::{World, WorldSpec, matching_spec};
use nalgebra::DVector;
use std::time::Instant;
use vantage_dataset::Seed;
use vantage_slam::ObservationModel;
use vantage_slam::{Row, estimate};

#[test]
#[ignore = "prints times; nothing to fail on"]
fn timing_of_100_steps_12_objects_latent_128() {
    let model = TanhModel::new([128, 32, 128], 0.1, 5.0, Seed(1));
    let spec = WorldSpec { steps: 100, laps: 1.2, objects: 12, inward: true, ..WorldSpec::sparse_loop() };
    let mut world = World::new(&spec, Some(&model), Seed(1));
    let mut index = 0;
    world.observations.detections.retain(|_| {
        index += 1;
        index % 12 < 5
    });
    println!("{} detections", world.observations.detections.len());

    let (e, x) = (DVector::from_element(128, 0.1), [0.3; vantage_dataset::viewpoint::CONDITIONING]);
    let start = Instant::now();
    for _ in 0..500 {
        std::hint::black_box(model.linearize(&e, &x).unwrap());
    }
    println!("500 linearisations of the model alone: {:?}", start.elapsed());
    for row in Row::ALL {
        let start = Instant::now();
        let answer = estimate(&world.observations, row, Some(&model), &matching_spec(&spec)).unwrap();
        let views: usize = answer.objects.iter().flatten().map(|o| o.semantic_views).sum();
        println!(
            "{row}: {:?} in all, {} iterations, {}, {views} semantic views, ATE {:.4}",
            start.elapsed(),
            answer.iterations,
            answer.outcome,
            world.ate(&answer)
        );
    }
}

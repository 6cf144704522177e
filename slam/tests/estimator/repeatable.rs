//! The same episode gives the same bits, in whatever order its detections and odometry come.

use crate::model::TanhModel;
use crate::which::{Which, estimate};
use crate::world::{World, WorldSpec, matching_settings};
use vantage_dataset::Seed;
use vantage_slam::Estimate;

fn bits(answer: &Estimate) -> Vec<u64> {
    let mut numbers = vec![answer.cost];
    for pose in &answer.world_from_robot {
        numbers.extend(pose.translation.vector.iter().chain(pose.rotation.coords.iter()));
    }
    for covariance in answer.pose_covariances.iter().flatten() {
        numbers.extend(covariance.iter());
    }
    for object in answer.objects.iter().flatten() {
        numbers.extend(object.position.iter());
        numbers.extend(object.latent.iter().flat_map(|l| l.mean.iter().chain(l.variance.iter())));
        numbers.extend(object.orientation.iter().map(|o| o.margin));
    }
    numbers.into_iter().map(f64::to_bits).collect()
}

#[test]
fn runs_and_orders_do_not_matter() {
    let model = TanhModel::new([8, 12, 32], 0.03, 5.0, Seed(1));
    let spec = WorldSpec::sparse_loop();
    let mut world = World::new(&spec, Some(&model), Seed(8));
    let run = |world: &World| {
        let answer = estimate(&world.observations, Which::Semantic, Some(&model), &matching_settings(&spec));
        bits(&answer.unwrap())
    };
    let first = run(&world);
    assert_eq!(first, run(&world));
    let mut shuffle = Seed(4).stream("shuffle", 0);
    shuffle.shuffle(&mut world.observations.detections);
    shuffle.shuffle(&mut world.observations.odometry);
    assert_eq!(first, run(&world));
}

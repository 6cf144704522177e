//! Too little to go by: a typed outcome, finite numbers, never a panic.

use crate::model::TanhModel;
use crate::which::{Which, estimate};
use crate::world::{World, WorldSpec, matching_settings};
use proptest::prelude::*;
use vantage_dataset::{Observations, Seed};
use vantage_slam::{Estimate, Key, Outcome, UnresolvedReason};

fn small() -> WorldSpec {
    WorldSpec { steps: 12, laps: 0.4, ..WorldSpec::sparse_loop() }
}

fn run(observations: &Observations, which: Which) -> Estimate {
    let model = TanhModel::new([4, 6, 8], 0.03, 5.0, Seed(1));
    let answer = estimate(observations, which, Some(&model), &matching_settings(&small())).unwrap();
    assert_eq!(answer.world_from_robot.len(), observations.steps());
    assert_eq!(answer.objects.len(), observations.tracks());
    let finite = |x: &f64| x.is_finite();
    for pose in &answer.world_from_robot {
        assert!(pose.to_homogeneous().iter().all(finite));
    }
    for covariance in answer.pose_covariances.iter().flatten() {
        assert!(covariance.iter().all(finite));
    }
    for object in answer.objects.iter().flatten() {
        assert!(object.position.iter().all(finite));
        if let Some(latent) = &object.latent {
            assert!(latent.mean.iter().chain(&latent.variance).all(finite));
        }
    }
    answer
}

fn world() -> World {
    let model = TanhModel::new([4, 6, 8], 0.03, 5.0, Seed(1));
    World::new(&small(), Some(&model), Seed(2))
}

fn keep(observations: &mut Observations, mut wanted: impl FnMut(usize, usize) -> bool) {
    observations.detections.retain(|d| wanted(d.step, d.track));
}

#[test]
fn nothing_seen() {
    let mut world = world();
    world.observations.detections.clear();
    for which in Which::ALL {
        let expected = if which == Which::Odometry { Outcome::Converged } else { Outcome::NothingObserved };
        let answer = run(&world.observations, which);
        assert_eq!(answer.outcome, expected, "{which:?}");
        assert_eq!(answer.world_from_robot, run(&world.observations, Which::Odometry).world_from_robot);
    }
}

#[test]
fn an_object_seen_once_is_unresolved_and_the_rest_stands() {
    let mut world = world();
    let camera = world.observations.camera;
    let whole = |track: usize| {
        world
            .observations
            .detections
            .iter()
            .filter(|d| d.track == track && !d.bounding_box.is_truncated(&camera))
            .count()
    };
    let track = (0..world.observations.tracks()).find(|&track| whole(track) >= 2).unwrap();
    let mut seen = 0;
    world.observations.detections.retain(|d| {
        if d.track != track || d.bounding_box.is_truncated(&camera) {
            return true;
        }
        seen += 1;
        seen == 1
    });
    for which in [Which::Geometric, Which::Semantic, Which::Uninformative] {
        let answer = run(&world.observations, which);
        assert!(answer.objects[track].is_none());
        assert!(answer.unresolved.iter().any(|u| u.track == track && u.reason == UnresolvedReason::SeenOnce));
        assert!(answer.dropped_detections.unresolved >= 1);
        assert!(answer.objects.iter().flatten().count() > 0);
        assert_eq!(answer.outcome, Outcome::Converged, "{which:?}");
    }
}

#[test]
fn only_one_object_seen_once_is_nothing_observed() {
    let mut world = world();
    let first = world.observations.detections[0].clone();
    keep(&mut world.observations, |step, track| (step, track) == (first.step, first.track));
    assert_eq!(run(&world.observations, Which::Geometric).outcome, Outcome::NothingObserved);
}

#[test]
fn one_pose_and_none() {
    for steps in [0, 1] {
        let mut world = world();
        world.observations.timestamps.truncate(steps);
        world.observations.odometry.clear();
        keep(&mut world.observations, |step, _| step < steps);
        for which in Which::ALL {
            let answer = run(&world.observations, which);
            let odometry = if steps == 0 { Outcome::NothingObserved } else { Outcome::Converged };
            let expected = if which == Which::Odometry { odometry } else { Outcome::NothingObserved };
            assert_eq!(answer.outcome, expected, "{which:?}, {steps} steps");
        }
    }
}

#[test]
fn a_gap_in_the_odometry_names_the_first_pose_behind_it() {
    let mut world = world();
    world.observations.odometry.retain(|o| o.to != 7);
    world.observations.detections.retain(|d| d.step < 7);
    for which in Which::ALL {
        let answer = run(&world.observations, which);
        assert_eq!(answer.outcome, Outcome::Underconstrained { near: Key::Robot(7) }, "{which:?}");
    }
}

#[test]
fn a_part_that_one_landmark_alone_ties_to_the_rest_is_underconstrained() {
    let mut world = world();
    world.observations.odometry.retain(|o| o.to != 7);
    let shared = (0..8).find(|&track| {
        let near =
            |range: std::ops::Range<usize>| {
                let camera = world.observations.camera;
                world.observations.detections.iter().any(|d| {
                    d.track == track && range.contains(&d.step) && !d.bounding_box.is_truncated(&camera)
                })
            };
        near(5..7) && near(7..9)
    });
    let shared = shared.expect("some object is seen from both sides of the gap");
    keep(&mut world.observations, |_, track| track == shared);
    let answer = run(&world.observations, Which::Geometric);
    assert!(
        matches!(answer.outcome, Outcome::Underconstrained { .. } | Outcome::NothingObserved),
        "{}",
        answer.outcome
    );
}

#[test]
fn a_robot_that_stands_still_places_nothing() {
    let mut world = world();
    let still = world.observations.detections.iter().map(|d| d.step).min().unwrap();
    let seen: Vec<_> = world.observations.detections.iter().filter(|d| d.step == still).cloned().collect();
    world.observations.detections = (0..12)
        .flat_map(|step| seen.iter().cloned().map(move |d| vantage_dataset::Detection { step, ..d }))
        .collect();
    for odometry in &mut world.observations.odometry {
        odometry.robot_from_robot = vantage_dataset::Pose::identity();
    }
    let answer = run(&world.observations, Which::Semantic);
    assert_eq!(answer.outcome, Outcome::NothingObserved);
    assert!(answer.objects.iter().all(Option::is_none));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn any_part_of_an_episode_gives_finite_numbers(
        detections in proptest::collection::vec(any::<bool>(), 64),
        odometry in proptest::collection::vec(0..10usize, 11),
        which in 1..4usize,
    ) {
        let mut world = world();
        let mut index = 0;
        world.observations.detections.retain(|_| {
            index += 1;
            detections[index % detections.len()]
        });
        world.observations.odometry.retain(|o| odometry[o.from] > 0);
        run(&world.observations, Which::ALL[which]);
    }
}

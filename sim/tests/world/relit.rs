//! Light that changes during the drive.

use crate::scene::{checked, shipped, small};
use vantage_dataset::{Detection, Episode, Seed, Split};
use vantage_sim::checked::SceneSpec;
use vantage_sim::render::Light;
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::rollout::roll_out;
use vantage_sim::simulate;

/// The small tabletop on which the objects are seen from beginning to end.
fn episode(relit_at: Option<f64>) -> Episode {
    let mut spec: SceneSpec = small();
    spec.world.relit_at = relit_at;
    let mut renderer = ReferenceRenderer::default();
    simulate(&checked(spec), Seed(4), Split::Test, &mut renderer, &mut |_| ()).unwrap()
}

#[test]
fn another_light_changes_crops_from_its_share_of_the_drive_on_and_nothing_else() {
    let (plain, relit) = (episode(None), episode(Some(0.5)));
    assert_eq!(format!("{:?}", plain.truth), format!("{:?}", relit.truth));
    assert_eq!(plain.observations.odometry, relit.observations.odometry);
    let pairs = || plain.observations.detections.iter().zip(&relit.observations.detections);
    assert_eq!(plain.observations.detections.len(), relit.observations.detections.len());
    let geometry = |d: &Detection| (d.step, d.track, d.bounding_box, d.mask_pixels);
    assert!(pairs().all(|(a, b)| geometry(a) == geometry(b)));
    // Of eight steps, 0 to 3 are within half of the drive.
    let same =
        |(a, b): (&Detection, &Detection)| (a.masked_crop == b.masked_crop) && (a.boxed_crop == b.boxed_crop);
    for pair in pairs() {
        assert_eq!(same(pair), pair.0.step < 4, "step {}, track {}", pair.0.step, pair.0.track);
    }
    for half in [0..4, 4..8] {
        assert!(pairs().any(|(a, _)| half.contains(&a.step)), "nothing is seen in {half:?}");
    }
    let late = episode(Some(1.0));
    let seen = |episode: &Episode| format!("{:?}", episode.observations.detections);
    assert_eq!(seen(&late), seen(&plain));
}

#[test]
fn views_and_the_match_of_a_model_do_not_know_of_it() {
    let mut spec = shipped("sparse_loop");
    let before = checked(spec.clone());
    spec.world.relit_at = Some(0.5);
    assert_eq!(checked(spec).view_conditions(), before.view_conditions());
    let text = serde_json::to_string(before.world()).unwrap();
    assert!(!text.contains("relit_at"), "{text}");
}

#[test]
fn a_ring_that_is_not_driven_to_its_end_is_relit_where_it_would_be() {
    let relit = |laps: f64, steps: u32| {
        let mut spec = shipped("ring");
        (spec.robot.laps, spec.robot.steps, spec.world.relit_at) = (laps, Some(steps), Some(0.5));
        let scene = checked(spec);
        let rollout = roll_out(&scene, Seed(3), Split::Test, &mut |_| ()).unwrap();
        let start: Light = rollout.render_scene(&scene).light;
        let first =
            (0..rollout.steps()).find(|step| rollout.light(*step, &start).direction != start.direction);
        first.map(|step| rollout.drive.world_from_robot[step].translation.vector)
    };
    let whole = relit(1.0, 401).unwrap();
    let most = relit(0.9, 361).unwrap();
    assert!((whole - most).norm() < 0.3, "{whole} and {most}");
    assert_eq!(relit(0.2, 81), None, "the place lies beyond the drive");
}

//! Noise of the sensors: each its own switch, each its own stream.

use crate::scene::{checked, small};
use nalgebra::{Point3, Vector3};
use vantage_dataset::{Episode, Seed, Split};
use vantage_sim::checked::SceneSpec;
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::scene::{DetectorFaultsSpec, ImageSpec, LandmarkSpec, SlipSpec};
use vantage_sim::simulate;

fn episode(change: impl Fn(&mut SceneSpec)) -> Episode {
    let mut spec = small();
    change(&mut spec);
    let mut renderer = ReferenceRenderer::default();
    simulate(&checked(spec), Seed(2), Split::Test, &mut renderer, &mut |_| ()).unwrap()
}

fn with_landmarks(spec: &mut SceneSpec) {
    spec.sensors.landmarks = Some(LandmarkSpec { count: 300, pixel_sigma: 0.5, max_range: 10.0 });
}

#[test]
fn no_noise_disturbs_what_another_one_decides() {
    let plain = episode(|_| ());
    let noisy = episode(|spec| {
        spec.sensors.camera.image =
            Some(ImageSpec { exposure_stops: 0.3, blur_pixels: 0.7, noise_levels: 5.0 });
        with_landmarks(spec);
    });
    assert_eq!(plain.observations.odometry, noisy.observations.odometry);
    assert_eq!(plain.truth.world_from_robot, noisy.truth.world_from_robot);
    assert_eq!(plain.observations.detections.len(), noisy.observations.detections.len());
    for (a, b) in plain.observations.detections.iter().zip(&noisy.observations.detections) {
        assert_eq!((a.step, a.track, a.bounding_box), (b.step, b.track, b.bounding_box));
        assert_ne!(a.masked_crop, b.masked_crop);
    }
    let slipping = episode(|spec| {
        spec.sensors.odometry.slip = Some(SlipSpec { probability: 0.5, excess: 0.5 });
    });
    assert_ne!(plain.observations.odometry, slipping.observations.odometry);
    let crops = |e: &Episode| format!("{:?}", e.observations.detections);
    assert_eq!(crops(&plain), crops(&slipping));
}

#[test]
fn false_detections_have_tracks_of_their_own_and_no_object() {
    let faulty = episode(|spec| {
        spec.sensors.detector.faults = Some(DetectorFaultsSpec {
            box_jitter: 0.05,
            miss_probability: 0.3,
            false_per_image: 1.0,
            misassigned: 0.0,
        });
    });
    let plain = episode(|_| ());
    let objects = faulty.truth.objects.len();
    let pairs = || faulty.observations.detections.iter().zip(&faulty.truth.detections);
    let false_tracks: Vec<usize> = pairs().map(|(d, _)| d.track).filter(|track| *track >= objects).collect();
    assert!(!false_tracks.is_empty());
    let nothing = || pairs().map(|(d, _)| d).filter(|d| d.track >= objects);
    assert!(nothing().all(|d| d.masked_crop != d.boxed_crop));
    assert!(false_tracks.iter().copied().eq(objects..objects + false_tracks.len()), "{false_tracks:?}");
    assert!(pairs().all(|(d, truth)| (d.track >= objects) == (truth.visible_fraction <= 0.0)));
    let real = faulty.observations.detections.len() - false_tracks.len();
    assert!(real < plain.observations.detections.len());
}

#[test]
fn misassigned_detections_take_the_tracks_of_objects_seen_before_and_change_nothing_else() {
    let with = |misassigned: f64| {
        episode(|spec| {
            spec.robot.steps = Some(40);
            let faults = DetectorFaultsSpec {
                box_jitter: 0.05,
                miss_probability: 0.3,
                false_per_image: 1.0,
                misassigned,
            };
            spec.sensors.detector.faults = Some(faults);
        })
    };
    let (own, given) = (with(0.0), with(0.5));
    let all = |e: &Episode| {
        let pairs = e.observations.detections.iter().cloned().zip(e.truth.detections.clone());
        let mut sorted: Vec<_> =
            pairs.map(|(d, t)| (d.step, d.bounding_box.min.x, t.visible_fraction, d)).collect();
        sorted.sort_by(|a, b| (a.0, a.1).partial_cmp(&(b.0, b.1)).unwrap());
        sorted
    };
    let objects = own.truth.objects.len();
    let mut misassigned = 0;
    for (a, b) in all(&own).iter().zip(&all(&given)) {
        assert_eq!((a.0, a.1, a.2), (b.0, b.1, b.2));
        assert!(a.3.masked_crop == b.3.masked_crop && a.3.boxed_crop == b.3.boxed_crop);
        if a.2 > 0.0 {
            assert_eq!(a.3.track, b.3.track);
        } else if b.3.track < objects {
            misassigned += 1;
            assert_eq!(b.3.center_depth, None);
            let earlier = all(&given).iter().any(|c| c.0 < b.0 && c.3.track == b.3.track && c.2 > 0.0);
            assert!(earlier, "track {} at step {}", b.3.track, b.0);
        }
    }
    assert!((3..30).contains(&misassigned), "{misassigned}");
    let tracks: Vec<_> = given.observations.detections.iter().map(|d| (d.step, d.track)).collect();
    assert!(tracks.windows(2).all(|pair| pair[0] < pair[1]), "no track twice in an image");
    let nothing = given.truth.detections.iter().filter(|truth| truth.visible_fraction <= 0.0).count();
    let mut false_tracks: Vec<_> = tracks.iter().map(|(_, track)| *track).filter(|t| *t >= objects).collect();
    false_tracks.sort_unstable();
    assert!(false_tracks.into_iter().eq(objects..objects + nothing - misassigned));
    let shown = |(number, d)| given.truth.shown(number, d).is_some();
    let count = given.observations.detections.iter().enumerate().filter(|pair| shown(*pair)).count();
    assert_eq!(count, given.observations.detections.len() - nothing);
    assert_eq!(given.samples(Split::Test).count(), count);
    let observed = vantage_dataset::episode_views(&given, Split::Test, &|_| true);
    assert!(observed.views.iter().all(|view| view.visible_fraction > 0.0));
}

#[test]
fn landmarks_are_seen_where_they_are_and_not_through_furniture() {
    let seen = episode(with_landmarks);
    let (observed, truth) = (&seen.observations, &seen.truth);
    assert_eq!(truth.landmarks.len(), 300);
    assert!(observed.landmarks.len() > 100, "{} sightings", observed.landmarks.len());
    let mut squares = 0.0;
    let mut hidden = 0;
    for sighting in &observed.landmarks {
        let world_from_camera = truth.world_from_robot[sighting.step] * observed.robot_from_camera;
        let in_camera = world_from_camera.inverse() * truth.landmarks[sighting.landmark];
        let exact = observed.camera.project(&in_camera).unwrap();
        squares += (sighting.pixel - exact).norm_squared() / 2.0;
    }
    let spread = (squares / observed.landmarks.len() as f64).sqrt();
    assert!((spread - 0.5).abs() < 0.05, "{spread} pixels");
    let top = Point3::from(Vector3::new(0.0, 0.0, 0.72));
    for (step, pose) in truth.world_from_robot.iter().enumerate() {
        let camera = (pose * observed.robot_from_camera).translation.vector;
        for (i, landmark) in truth.landmarks.iter().enumerate() {
            // The ray passes through the middle of the solid table.
            let along = landmark.coords - camera;
            let at = (top.z - 0.1 - camera.z) / along.z;
            let through = camera + along * at;
            if (0.0..1.0).contains(&at) && through.xy().norm() < 0.5 && landmark.z < 0.5 {
                hidden += usize::from(landmark.coords.xy().norm() > 0.7);
                let sighted = observed.landmarks.iter().any(|s| (s.step, s.landmark) == (step, i));
                assert!(!sighted || landmark.coords.xy().norm() < 0.7, "{i} at {landmark} from step {step}");
            }
        }
    }
    assert!(hidden > 0);
}

#[test]
fn extents_hold_every_vertex() {
    let seen = episode(|_| ());
    for object in &seen.truth.objects {
        let extents = object.extents.unwrap();
        let ratio = extents.semi_axes.component_div(&extents.half_sides);
        assert!((ratio.max() - ratio.min()).abs() < 1e-9);
        assert!((1.0..=3f64.sqrt() + 1e-6).contains(&ratio.x), "{}: {ratio:?}", object.family);
        assert!(extents.half_sides.norm() * 2.0 >= object.size - 1e-6);
    }
}

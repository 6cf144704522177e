use super::*;
use nalgebra::Vector3;
use vantage_dataset::{InstanceId, Split};
use vantage_learn::gaussian_process::{GaussianProcess, Hyperparameters};

fn trial(error: f64, nearest: f64, inside: bool) -> KnownViewTrial {
    let viewpoint = ViewpointTrial {
        family: "mug".into(),
        symmetry: Symmetry::None,
        azimuth: 0.0,
        found: Some(error.to_radians()),
    };
    KnownViewTrial { viewpoint, inside, nearest: nearest.to_radians() }
}

#[test]
fn scores_tell_how_far_off_and_how_far_from_what_is_known() {
    let mut trials = vec![trial(2.0, 3.0, true), trial(70.0, 40.0, false), trial(20.0, 40.0, true)];
    trials.push(KnownViewTrial {
        viewpoint: ViewpointTrial { symmetry: Symmetry::Revolution, ..trials[0].viewpoint.clone() },
        ..trials[0].clone()
    });
    let scores = known_view_scores(&trials);
    let degrees = |metric: Metric| scores.get(&metric).map(|value| value.to_degrees().round());
    assert_eq!(degrees(Metric::ViewpointMedian), Some(20.0));
    assert_eq!(degrees(Metric::ViewpointMedianNear15), Some(2.0));
    assert_eq!(degrees(Metric::ViewpointMedianNear60), Some(45.0));
    assert_eq!(degrees(Metric::ViewpointMedianFar), None);
    assert!((scores[&Metric::AzimuthInside95] - 2.0 / 3.0).abs() < 1e-12);
    assert!((scores[&Metric::ViewpointWithin60] - 2.0 / 3.0).abs() < 1e-12);
    assert!(known_view_scores(&trials[3..]).is_empty());
}

/// Objects of smooth looks: bright and dark patches that move, grow and shrink with the azimuth, each object's in its own way.
fn look(object: usize, azimuth: f64) -> Crop {
    let mut crop = Crop::black();
    let own = 0.7 * object as f64;
    for (i, pixel) in crop.0.as_chunks_mut::<3>().0.iter_mut().enumerate() {
        let (x, y) = ((i % 32) as f64 / 31.0 - 0.5, (i / 32) as f64 / 31.0 - 0.5);
        if x.hypot(y) > 0.45 + 0.05 * (azimuth + own).sin() {
            continue;
        }
        let grey = 120.0
            + 60.0 * (4.0 * x - 2.0 * azimuth.cos() + own).sin()
            + 50.0 * (5.0 * y + azimuth.sin() + 2.0 * own).cos();
        let red = 0.7 * grey + 40.0 * (3.0 * x + azimuth).sin() + 45.0;
        *pixel = [red, grey, 0.9 * grey].map(|value| value.clamp(1.0, 255.0) as u8);
    }
    crop
}

/// Six objects, forty views each, every other one of another session.
fn set() -> ViewSet {
    let mut stream = Seed(3).stream("azimuths", 0);
    let view = |number: usize| {
        let (instance, azimuth) = (number / 40, stream.uniform(-PI, PI));
        let direction = Vector3::new(azimuth.cos(), azimuth.sin(), 0.3).normalize();
        View {
            instance,
            session: number % 2,
            viewpoint: Viewpoint { direction, roll: 0.0, log_distance: 1.0 },
            crop: look(instance, azimuth),
            visible_fraction: 1.0,
            box_center_error: [0.0; 2],
            sighting: None,
        }
    };
    let instance =
        |id| InstanceRecord { id: InstanceId(id), family: "blob".into(), symmetry: Symmetry::None };
    ViewSet {
        split: Split::Test,
        instances: (0..6).map(instance).collect(),
        views: (0..240).map(view).collect(),
    }
}

#[test]
fn azimuths_are_found_from_known_views_and_more_known_views_tell_more() {
    let set = set();
    let median = |known: usize| {
        let trials = known_view_trials(&set, known, GaussianProcess::fitted(), false, 1.0, &|| ()).unwrap();
        assert_eq!(trials.len(), 24);
        known_view_scores(&trials)[&Metric::ViewpointMedian].to_degrees()
    };
    let (one, many) = (median(1), median(20));
    assert!(many < 15.0 && many < 0.5 * one, "{many} of 20 known views, {one} of one");
    assert!(known_view_trials(&set, 21, GaussianProcess::fitted(), false, 1.0, &|| ()).unwrap().is_empty());
}

#[test]
fn a_frame_of_its_own_makes_no_difference_to_a_model_without_one() {
    let mut set = set();
    set.instances.truncate(1);
    set.views.retain(|view| view.instance == 0);
    let found = |free: bool| -> Vec<f64> {
        let trials = known_view_trials(&set, 8, GaussianProcess::fitted(), free, 1.0, &|| ()).unwrap();
        trials.iter().map(|trial| trial.viewpoint.error().unwrap()).collect()
    };
    for (fixed, free) in found(false).into_iter().zip(found(true)) {
        assert!((fixed - free).abs() < 3f64.to_radians(), "{fixed} {free}");
    }
}

#[test]
fn a_model_that_is_too_sure_counts_for_less() {
    let set = set();
    let sure = |share: f64| {
        let fitted = Hyperparameters::FITTED;
        let noise = fitted.noise.map(|deviation| share * deviation);
        let model = GaussianProcess::new(Hyperparameters { noise, ..fitted }).unwrap();
        information_scale(&set, 8, &model, false, &|| ()).unwrap()
    };
    let (too_little, too_sure) = (sure(6.0), sure(0.1));
    assert!(too_sure < too_little, "{too_sure} for {too_little}");
}

#[test]
fn a_crop_that_cannot_be_measured_costs_its_view_alone() {
    let mut set = set();
    set.views.iter_mut().take(2).for_each(|view| view.crop = Crop::black());
    let trials = known_view_trials(&set, 8, GaussianProcess::fitted(), false, 1.0, &|| ()).unwrap();
    let unanswered = trials.iter().filter(|trial| trial.viewpoint.found.is_none()).count();
    assert_eq!((trials.len(), unanswered), (24, 1));
}

#[test]
fn views_of_one_session_are_known_and_asked_in_random_order_and_none_is_both() {
    let mut set = set();
    set.views.iter_mut().for_each(|view| view.session = 0);
    let azimuths =
        |views: Vec<&View>| views.into_iter().map(|view| view.viewpoint.azimuth()).collect::<Vec<_>>();
    let (known, asked) = known_and_asked(&set, 2, 8);
    let (known, asked) = (azimuths(known), azimuths(asked));
    assert_eq!((known.len(), asked.len()), (8, 32));
    assert!(known.iter().all(|azimuth| !asked.contains(azimuth)));
    let first: Vec<f64> = set.views[80..88].iter().map(|view| view.viewpoint.azimuth()).collect();
    assert_ne!(known, first);
}

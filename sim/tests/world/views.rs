use crate::scene::{checked, shipped};
use std::collections::BTreeSet;
use vantage_dataset::{Seed, Split, ViewSet};
use vantage_sim::checked::ViewConditions;
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::views::training_views;

pub fn conditions() -> ViewConditions {
    let mut spec = shipped("tabletop");
    spec.views.views_per_instance = 6;
    spec.views.sessions = 2;
    checked(spec).view_conditions()
}

pub fn make(conditions: &ViewConditions, split: Split, instances: usize, seed: u64) -> ViewSet {
    let mut renderer = ReferenceRenderer::default();
    training_views(conditions, split, instances, Seed(seed), &mut renderer, &mut |_| ()).unwrap()
}

fn digest(set: &ViewSet) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    for view in &set.views {
        hasher.update(&*view.crop.0);
        for x in view.viewpoint.conditioning() {
            hasher.update(&x.to_bits().to_le_bytes());
        }
    }
    hasher.finalize()
}

#[test]
fn views_are_the_same_under_any_number_of_threads() {
    let digests = [1, 2].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| digest(&make(&conditions(), Split::Train, 5, 1)))
    });
    assert_eq!(digests[0], digests[1]);
    assert_ne!(digests[0], digest(&make(&conditions(), Split::Train, 5, 2)));
}

#[test]
fn more_instances_leave_the_first_as_they_were() {
    let few = make(&conditions(), Split::Train, 3, 1);
    let mut more = make(&conditions(), Split::Train, 40, 1);
    assert_eq!(more.instances.len(), 40);
    more.views.retain(|view| view.instance < 3);
    assert_eq!(digest(&few), digest(&more));
}

#[test]
fn a_share_of_composites_takes_the_place_of_the_world_s_kinds_but_not_in_tests() {
    let mut mixed = conditions();
    mixed.views.composites = 0.75;
    for (split, expected) in [(Split::Train, 6), (Split::Validation, 6), (Split::Test, 0)] {
        let set = make(&mixed, split, 8, 1);
        let families: Vec<&str> = set.instances.iter().map(|instance| instance.family.as_str()).collect();
        let composites = families.iter().filter(|&&family| family == "composite").count();
        assert_eq!(composites, expected, "{split:?}: {families:?}");
    }
    let plain = make(&conditions(), Split::Train, 2, 1);
    let families = |set: &ViewSet| -> Vec<String> {
        let instances = set.instances.iter().filter(|instance| instance.family != "composite");
        instances.map(|instance| instance.family.clone()).collect()
    };
    assert_eq!(families(&make(&mixed, Split::Train, 8, 1)), families(&plain));
}

#[test]
fn splits_share_no_instance() {
    let sets = [Split::Train, Split::Validation, Split::Test].map(|split| make(&conditions(), split, 40, 1));
    for (i, set) in sets.iter().enumerate() {
        let ids: BTreeSet<_> = set.instances.iter().map(|instance| instance.id).collect();
        assert_eq!(ids.len(), 40);
        for other in &sets[..i] {
            assert_eq!(set.shared_instances(other), []);
        }
    }
}

#[test]
fn views_keep_to_their_ranges() {
    let conditions = conditions();
    let set = make(&conditions, Split::Train, 64, 1);
    let spec = &conditions.views;
    assert!(set.views.len() > 64 * 6 * 9 / 10, "{} of {} views", set.views.len(), 64 * 6);
    assert!(set.views.is_sorted_by_key(|view| view.instance));
    let mut occluded = 0;
    for view in &set.views {
        let elevation = view.viewpoint.elevation().to_degrees();
        assert!(
            spec.elevation_deg.low() - 1e-9 <= elevation && elevation <= spec.elevation_deg.high() + 1e-9
        );
        let lean = view.viewpoint.roll.to_degrees().abs();
        assert!(lean < 40.0, "perspective leans objects at the image's sides, but not by {lean} degrees");
        assert!((conditions.detector.min_visible_fraction..=1.0).contains(&view.visible_fraction));
        assert!(view.session < 2);
        assert!(view.box_center_error.iter().all(|error| error.abs() < 0.5), "{:?}", view.box_center_error);
        occluded += usize::from(view.visible_fraction < 0.95);
    }
    let share = occluded as f64 / set.views.len() as f64;
    assert!((0.02..0.4).contains(&share), "{share} of the views are occluded");
    let quadrants: BTreeSet<_> =
        set.views.iter().map(|view| (view.viewpoint.azimuth() / 0.7).floor() as i32).collect();
    assert_eq!(quadrants.len(), 10, "azimuths come from all around");
}

#[test]
fn box_centres_are_unbiased_bearings_where_nothing_is_hidden() {
    let mut conditions = conditions();
    conditions.views.occluder_probability = 0.0;
    let set = make(&conditions, Split::Train, 64, 1);
    let mean = |axis: usize| {
        set.views.iter().map(|view| view.box_center_error[axis]).sum::<f64>() / set.views.len() as f64
    };
    assert!(mean(0).abs() < 0.01, "{}", mean(0));
    assert!(mean(1).abs() < 0.05, "{}", mean(1));
}

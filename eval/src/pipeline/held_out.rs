//! Views of known instances that no model is trained on.

use std::collections::BTreeMap;
use vantage_dataset::{Seed, View, ViewSet};

/// Moves every fourth view of each session of the first instances out of a set.
pub fn held_out(set: &mut ViewSet, instances: usize) -> ViewSet {
    let mut seen: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    let (held, kept) = set.views.drain(..).partition(|view| {
        let count = seen.entry((view.instance, view.session)).or_default();
        *count += 1;
        view.instance < instances && count.is_multiple_of(4)
    });
    set.views = kept;
    ViewSet {
        split: set.split,
        instances: set.instances.iter().take(instances).cloned().collect(),
        views: held,
    }
}

/// The views of known instances as azimuths are asked of them: those that were trained on as session 0, those held out as session 1, each
/// instance's in random order.
pub fn recalled(training: &ViewSet, held: &ViewSet) -> ViewSet {
    let known = training.views.iter().filter(|view| view.instance < held.instances.len());
    let known = known.map(|view| View { session: 0, ..view.clone() });
    let asked = held.views.iter().map(|view| View { session: 1, ..view.clone() });
    let mut of_instance: Vec<Vec<View>> = vec![Vec::new(); held.instances.len()];
    known.chain(asked).for_each(|view| of_instance[view.instance].push(view));
    for (instance, views) in of_instance.iter_mut().enumerate() {
        Seed(0).stream("recalled views", instance as u64).shuffle(views);
    }
    ViewSet { split: held.split, instances: held.instances.clone(), views: of_instance.concat() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use vantage_dataset::views::InstanceRecord;
    use vantage_dataset::{Crop, InstanceId, Pose, Split, Symmetry, Viewpoint};

    #[test]
    fn every_fourth_view_of_each_session_of_the_first_instances_is_held_out() {
        let camera = Pose::new(Vector3::new(1.0, 0.0, 0.5), Vector3::y() * -1.8);
        let viewpoint = Viewpoint::new(&camera, 0.2).unwrap();
        let view = |number: usize| View {
            instance: number / 16,
            session: number % 2,
            viewpoint,
            crop: Crop::black(),
            visible_fraction: number as f64,
            box_center_error: [0.0; 2],
            sighting: None,
        };
        let instance =
            |id| InstanceRecord { id: InstanceId(id), family: "mug".into(), symmetry: Symmetry::None };
        let mut set = ViewSet {
            split: Split::Train,
            instances: (0..3).map(instance).collect(),
            views: (0..48).map(view).collect(),
        };
        let held = held_out(&mut set, 2);
        let numbers: Vec<f64> = held.views.iter().map(|view| view.visible_fraction).collect();
        assert_eq!(numbers, [6.0, 7.0, 14.0, 15.0, 22.0, 23.0, 30.0, 31.0]);
        assert_eq!((held.instances.len(), set.views.len(), set.instances.len()), (2, 40, 3));
        assert!(set.views.iter().all(|view| !numbers.contains(&view.visible_fraction)));

        let asked = recalled(&set, &held);
        assert_eq!(asked.instances, held.instances);
        let of_session = |session: usize| -> Vec<f64> {
            let of_first = asked.views.iter().filter(|view| view.session == session && view.instance == 0);
            of_first.map(|view| view.visible_fraction).collect()
        };
        let (known, mut queries) = (of_session(0), of_session(1));
        assert!(known.len() == 12 && known.iter().all(|number| !numbers.contains(number)));
        assert!(!known.is_sorted(), "the first ones are all round the object: {known:?}");
        queries.sort_by(f64::total_cmp);
        assert_eq!(queries, numbers[..4]);
        assert_eq!(asked.views.len(), 32);
    }
}

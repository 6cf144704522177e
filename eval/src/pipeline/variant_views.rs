//! What a variant of a study is trained on.

use crate::scene_file::study::Variant;
use vantage_dataset::{View, ViewSet};
use vantage_sim::scene::Family;

/// The instances that a variant is trained on, with their views.
pub fn of_variant(set: &ViewSet, variant: &Variant, families: &[Family]) -> ViewSet {
    let composite = Family::Composite.name();
    let first: Vec<&str> =
        families.iter().map(|family| family.name()).filter(|&name| name != composite).collect();
    let first = &first[..variant.families.unwrap_or(first.len()).min(first.len())];
    let mut composites = 0;
    let mut is_chosen = |family: &str| {
        if family == composite {
            composites += 1;
            return variant.composites.is_none_or(|most| composites <= most);
        }
        variant.families.is_none() || first.contains(&family)
    };
    let mut moved = vec![None; set.instances.len()];
    let mut instances = Vec::new();
    for (instance, moved) in set.instances.iter().zip(&mut moved) {
        let full = variant.instances.is_some_and(|most| instances.len() >= most);
        if !full && is_chosen(&instance.family) {
            *moved = Some(instances.len());
            instances.push(instance.clone());
        }
    }
    let views =
        set.views.iter().filter_map(|view| Some(View { instance: moved[view.instance]?, ..view.clone() }));
    ViewSet { split: set.split, instances, views: views.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use vantage_dataset::views::InstanceRecord;
    use vantage_dataset::{Crop, InstanceId, Pose, Split, Symmetry, Viewpoint};

    #[test]
    fn a_variant_is_trained_on_the_families_and_composites_that_it_names() {
        let families = [Family::Mug, Family::Composite, Family::Book];
        let names = ["mug", "composite", "book", "composite", "mug", "composite"];
        let instance = |(id, family): (usize, &&str)| InstanceRecord {
            id: InstanceId(id as u64),
            family: (*family).to_owned(),
            symmetry: Symmetry::None,
        };
        let camera = Pose::new(Vector3::new(1.0, 0.0, 0.5), Vector3::y() * -1.8);
        let viewpoint = Viewpoint::new(&camera, 0.2).unwrap();
        let view = |instance: usize| View {
            instance,
            session: 0,
            viewpoint,
            crop: Crop::black(),
            visible_fraction: instance as f64,
            box_center_error: [0.0; 2],
            sighting: None,
        };
        let set = ViewSet {
            split: Split::Train,
            instances: names.iter().enumerate().map(instance).collect(),
            views: (0..6).map(view).collect(),
        };
        let chosen = |text: &str| -> Vec<f64> {
            let variant: Variant =
                serde_json::from_str(&format!("{{\"name\": \"a\", \"note\": \"b\"{text}}}")).unwrap();
            let kept = of_variant(&set, &variant, &families);
            let numbers = kept.views.iter().map(|view| kept.instances[view.instance].id.0 as f64);
            let seen: Vec<f64> = kept.views.iter().map(|view| view.visible_fraction).collect();
            assert_eq!(numbers.collect::<Vec<_>>(), seen);
            seen
        };
        assert_eq!(chosen(""), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(chosen(", \"families\": 1, \"composites\": 2"), [0.0, 1.0, 3.0, 4.0]);
        assert_eq!(chosen(", \"families\": 0"), [1.0, 3.0, 5.0]);
        assert_eq!(chosen(", \"composites\": 0, \"instances\": 2"), [0.0, 2.0]);
    }
}

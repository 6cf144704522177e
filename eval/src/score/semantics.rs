//! What SLAM believes of objects after an episode, P(e | H) or P(c | H), against their classes.

use super::clustering::cluster_scores;
use super::embedding::Scores;
use super::grounding::ground_objects;
use super::retrieval::{are_comparable, squared_distance};
use super::ward::ward_clusters;
use crate::result::metric::Metric;
use std::collections::BTreeMap;
use vantage_dataset::Seed;

/// The name of the table of semantics.
pub const SEMANTICS: &str = "semantics";
/// Its columns.
pub const COLUMNS: [Metric; 6] = [
    Metric::ClassRecallAt1,
    Metric::ClassOf1Tag,
    Metric::ClassOf3Tags,
    Metric::ClassAri,
    Metric::ClassRight,
    Metric::ClassProbability,
];

/// Most objects that are clustered; of more, those of the latest episodes.
const CLUSTERED: usize = 1000;

/// What an episode left of one object.
#[derive(Clone, Debug, PartialEq)]
pub struct Belief {
    /// Its true class: the family.
    pub class: String,
    /// The mean of P(e | H), without what turns with the object's heading; of an estimator with latents.
    pub latent: Option<Vec<f32>>,
    /// Of an estimator with classes.
    pub named: Option<Named>,
}

/// What P(c | H) says of an object's true class.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Named {
    /// Its probability; 0 of a class that the estimator does not know.
    pub probability: f64,
    /// Whether it is the most probable one.
    pub is_right: bool,
}

impl Named {
    /// Of the probabilities of classes of these names.
    pub fn new(probabilities: &[f64], names: &[String], truth: &str) -> Self {
        let own = names.iter().position(|name| name == truth);
        let probability = own.and_then(|own| probabilities.get(own)).copied().unwrap_or(0.0);
        let is_less = |(i, other): (usize, &f64)| Some(i) == own || *other < probability;
        Self { probability, is_right: own.is_some() && probabilities.iter().enumerate().all(is_less) }
    }
}

/// The scores of an episode's beliefs, given those of earlier episodes, the earliest first. Tags are drawn under `seed`.
pub fn semantic_scores(believed: &[Belief], earlier: &[Belief], seed: Seed) -> Scores {
    let named: Vec<Named> = believed.iter().filter_map(|belief| belief.named).collect();
    let mean = |of: &dyn Fn(&Named) -> f64| {
        (!named.is_empty()).then(|| named.iter().map(of).sum::<f64>() / named.len() as f64)
    };
    let tagged = ground_objects(&latents(earlier), &latents(believed), seed);
    let scores = [
        (Metric::ClassRecallAt1, class_recall(believed, earlier)),
        (Metric::ClassOf1Tag, tagged.map(|[one, _]| one)),
        (Metric::ClassOf3Tags, tagged.map(|[_, three]| three)),
        (Metric::ClassAri, class_ari(believed, earlier)),
        (Metric::ClassRight, mean(&|named| f64::from(u8::from(named.is_right)))),
        (Metric::ClassProbability, mean(&|named| named.probability)),
    ];
    scores.into_iter().filter_map(|(metric, score)| Some((metric, score?))).collect()
}

/// Share of `believed` whose nearest of `earlier` is of their class, by Euclidean distance, among those whose class `earlier` holds.
///
/// A wrong one at the same distance as the right one comes before it: beliefs that are all the same recall nothing.
///
/// `None` where no class can be found again, or a latent is not finite or of another length.
pub fn class_recall(believed: &[Belief], earlier: &[Belief]) -> Option<f64> {
    let (own, gallery) = (latents(believed), latents(earlier));
    if !are_comparable(&own.iter().chain(&gallery).map(|(_, latent)| latent).collect::<Vec<_>>()) {
        return None;
    }
    let (mut hits, mut queries) = (0usize, 0usize);
    for (class, latent) in own {
        let nearest = |of_class: bool| {
            let candidates = gallery.iter().filter(|(other, _)| (*other == class) == of_class);
            let distances = candidates.map(|(_, other)| squared_distance(latent, other));
            distances.fold(f64::INFINITY, f64::min)
        };
        let right = nearest(true);
        queries += usize::from(right.is_finite());
        hits += usize::from(right < nearest(false));
    }
    (queries > 0).then(|| hits as f64 / queries as f64)
}

/// Adjusted Rand index of the classes of `believed` and the last of `earlier`, and of as many clusters of their latents by Ward's linkage.
///
/// `None` where nothing is believed, there is one class alone, or no class twice, or a latent is not finite or of another length.
pub fn class_ari(believed: &[Belief], earlier: &[Belief]) -> Option<f64> {
    let own = latents(believed);
    if own.is_empty() {
        return None;
    }
    let mut all = latents(earlier);
    all.extend(own);
    let all = &all[all.len().saturating_sub(CLUSTERED)..];
    let mut numbers = BTreeMap::new();
    let classes: Vec<usize> = all
        .iter()
        .map(|(class, _)| {
            let next = numbers.len();
            *numbers.entry(*class).or_insert(next)
        })
        .collect();
    if numbers.len() < 2 || numbers.len() == all.len() {
        return None;
    }
    let embeddings: Vec<Vec<f32>> = all.iter().map(|(_, latent)| latent.to_vec()).collect();
    Some(cluster_scores(&classes, &ward_clusters(&embeddings, numbers.len())?)?.ari)
}

/// Classes and latents of the objects that have one.
fn latents(beliefs: &[Belief]) -> Vec<(&str, &[f32])> {
    beliefs.iter().filter_map(|belief| Some((&*belief.class, &**belief.latent.as_ref()?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn belief(class: &str, latent: &[f32]) -> Belief {
        Belief { class: class.to_owned(), latent: Some(latent.to_vec()), named: None }
    }

    #[test]
    fn those_whose_class_was_seen_are_asked_for_it() {
        let earlier = [belief("mug", &[0.0]), belief("book", &[4.0]), belief("mug", &[10.0])];
        let recall = |believed: &[Belief]| class_recall(believed, &earlier);
        assert_eq!(recall(&[belief("mug", &[1.0])]), Some(1.0));
        assert_eq!(recall(&[belief("mug", &[1.0]), belief("mug", &[3.5])]), Some(0.5));
        assert_eq!(recall(&[belief("mug", &[9.0]), belief("shoe", &[4.0])]), Some(1.0));
        assert_eq!(recall(&[belief("mug", &[2.0])]), Some(0.0), "as near to a book");
    }

    #[test]
    fn noise_is_at_chance_and_beliefs_that_are_all_the_same_recall_nothing() {
        let mut stream = Seed(1).stream("noise", 0);
        let mut noise = |count: usize| -> Vec<Belief> {
            let draw = |i: usize| belief(&format!("{}", i % 4), &[stream.normal() as f32]);
            (0..count).map(draw).collect()
        };
        let random = class_recall(&noise(2000), &noise(200)).unwrap();
        assert!((random - 0.25).abs() < 0.04, "{random}");
        let same = [belief("a", &[0.0]), belief("b", &[0.0])];
        assert_eq!(class_recall(&same, &same), Some(0.0));
    }

    #[test]
    fn undefined_is_none() {
        let one = [belief("a", &[0.0])];
        for (believed, earlier) in [
            (&[][..], &one[..]),
            (&one[..], &[][..]),
            (&one[..], &[belief("b", &[0.0])][..]),
            (&one[..], &[belief("a", &[0.0, 1.0])][..]),
            (&[belief("a", &[f32::NAN])][..], &one[..]),
        ] {
            assert_eq!(class_recall(believed, earlier), None);
        }
    }

    #[test]
    fn clusters_are_compared_with_classes_over_all_episodes() {
        let earlier = [belief("mug", &[0.0]), belief("book", &[4.0])];
        let ari = |believed: &[Belief]| class_ari(believed, &earlier);
        assert_eq!(ari(&[belief("mug", &[0.5]), belief("book", &[4.5])]), Some(1.0));
        let mixed = ari(&[belief("book", &[0.5]), belief("mug", &[4.5])]).unwrap();
        assert!(mixed < 0.0, "{mixed}");
        let twice = [belief("mug", &[0.0]), belief("mug", &[0.1]), belief("book", &[4.0])];
        assert_eq!(class_ari(&[], &twice), None, "nothing of its own");
        assert_eq!(ari(&[belief("shoe", &[9.0])]), None, "no class twice");
        assert_eq!(class_ari(&[belief("a", &[0.0]), belief("a", &[1.0])], &[]), None, "one class alone");
        assert_eq!(ari(&[belief("mug", &[f32::NAN])]), None);
        let same: Vec<Belief> = (0..40).map(|i| belief(&format!("{}", i % 4), &[0.0])).collect();
        assert!(class_ari(&same, &[]).unwrap().abs() < 0.1);
    }

    #[test]
    fn of_many_objects_the_latest_are_clustered() {
        let early: Vec<Belief> = (0..CLUSTERED).map(|i| belief(&format!("{}", i % 2), &[0.0])).collect();
        let late = |i: usize| belief(&format!("{}", i % 2), &[(i % 2) as f32]);
        let late: Vec<Belief> = (0..CLUSTERED).map(late).collect();
        assert_eq!(class_ari(&late, &early), Some(1.0));
    }

    #[test]
    fn a_class_is_right_where_no_other_is_as_probable() {
        let names = ["mug".to_owned(), "book".to_owned()];
        let named = |probabilities: &[f64], truth: &str| {
            let named = Named::new(probabilities, &names, truth);
            (named.probability, named.is_right)
        };
        assert_eq!(named(&[0.75, 0.25], "mug"), (0.75, true));
        assert_eq!(named(&[0.75, 0.25], "book"), (0.25, false));
        assert_eq!(named(&[0.5, 0.5], "mug"), (0.5, false));
        assert_eq!(named(&[0.75, 0.25], "shoe"), (0.0, false));
        let told = |probability, is_right| Belief {
            class: "mug".to_owned(),
            latent: None,
            named: Some(Named { probability, is_right }),
        };
        let scores = semantic_scores(&[told(0.75, true), told(0.25, false)], &[], Seed(0));
        assert_eq!(scores, Scores::from([(Metric::ClassRight, 0.5), (Metric::ClassProbability, 0.5)]));
    }
}

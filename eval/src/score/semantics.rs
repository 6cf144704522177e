//! What SLAM believes of objects after an episode, P(e | H): whether it finds objects of the same class in earlier episodes.

use super::retrieval::squared_distance;
use crate::result::metric::Metric;

/// The name of the table of semantics.
pub const SEMANTICS: &str = "semantics";
/// Its columns.
pub const COLUMNS: [Metric; 1] = [Metric::ClassRecallAt1];

/// What an episode left of one object.
#[derive(Clone, Debug, PartialEq)]
pub struct Belief {
    /// Its true class: the family.
    pub class: String,
    /// The mean of P(e | H), without what turns with the object's heading.
    pub latent: Vec<f32>,
}

/// Share of `believed` whose nearest of `earlier` is of their class, by Euclidean distance, among those whose class `earlier` holds.
///
/// A wrong one at the same distance as the right one comes before it: beliefs that are all the same recall nothing.
///
/// `None` where no class can be found again, or a latent is not finite or of another length.
pub fn class_recall(believed: &[Belief], earlier: &[Belief]) -> Option<f64> {
    let length = believed.first()?.latent.len();
    let comparable = |b: &Belief| b.latent.len() == length && b.latent.iter().all(|x| x.is_finite());
    if !believed.iter().chain(earlier).all(comparable) {
        return None;
    }
    let (mut hits, mut queries) = (0usize, 0usize);
    for query in believed {
        let nearest = |of_class: bool| {
            let candidates = earlier.iter().filter(|other| (other.class == query.class) == of_class);
            let distances = candidates.map(|other| squared_distance(&query.latent, &other.latent));
            distances.fold(f64::INFINITY, f64::min)
        };
        let right = nearest(true);
        queries += usize::from(right.is_finite());
        hits += usize::from(right < nearest(false));
    }
    (queries > 0).then(|| hits as f64 / queries as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_dataset::Seed;

    fn belief(class: &str, latent: &[f32]) -> Belief {
        Belief { class: class.to_owned(), latent: latent.to_vec() }
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
}

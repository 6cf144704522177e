//! Recall@k: whether an instance's nearest embeddings hold another view of it.

/// Which embeddings a query may be answered by. Never itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gallery<'a> {
    /// All others.
    Any,
    /// All others but those of the query's own instance and lighting session, so that a match has to bridge a
    /// change of light. Views of other instances stay, whatever their session. One session an embedding.
    OtherSession(&'a [usize]),
}

/// Share of queries whose `k` nearest hold their instance, of those whose instance is in their gallery, by Euclidean distance; each
/// embedding is a query against all others. O(n^2 d).
///
/// A wrong embedding at the same distance as the right one comes before it: an encoder that maps all to one point
/// has recall 0, whatever the order of its views.
///
/// `None` where no query can be answered, or the embeddings are not finite and of one length.
///
/// # Panics
/// If there is not one instance (and session) an embedding.
pub fn recall_at(
    k: usize,
    embeddings: &[Vec<f32>],
    instances: &[usize],
    gallery: Gallery<'_>,
) -> Option<f64> {
    assert_eq!(embeddings.len(), instances.len(), "each embedding needs its instance");
    if let Gallery::OtherSession(sessions) = gallery {
        assert_eq!(embeddings.len(), sessions.len(), "each embedding needs its session");
    }
    if !are_comparable(embeddings) {
        return None;
    }
    let (mut hits, mut queries) = (0, 0);
    for (query, embedding) in embeddings.iter().enumerate() {
        let mut right = f64::INFINITY;
        let mut wrong = Vec::new();
        for (other, candidate) in embeddings.iter().enumerate() {
            let same_instance = instances[other] == instances[query];
            let same_session =
                matches!(gallery, Gallery::OtherSession(sessions) if sessions[other] == sessions[query]);
            if other == query || (same_instance && same_session) {
                continue;
            }
            let distance = squared_distance(embedding, candidate);
            if same_instance {
                right = right.min(distance);
            } else {
                wrong.push(distance);
            }
        }
        if right.is_infinite() {
            continue;
        }
        queries += 1;
        let before = wrong.iter().filter(|&&distance| distance <= right).count();
        hits += usize::from(before < k);
    }
    (queries > 0).then(|| hits as f64 / queries as f64)
}

/// Whether distances between the embeddings are defined.
pub(super) fn are_comparable<E: AsRef<[f32]>>(embeddings: &[E]) -> bool {
    let length = embeddings.first().map_or(0, |e| e.as_ref().len());
    embeddings.iter().map(AsRef::as_ref).all(|e| e.len() == length && e.iter().all(|x| x.is_finite()))
}

/// Squared Euclidean distance, summed in `f64` over eight lanes: the same bits on every processor.
pub(super) fn squared_distance(a: &[f32], b: &[f32]) -> f64 {
    let mut lanes = [0.0f64; 8];
    let (a_blocks, b_blocks) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest = a_blocks.remainder().iter().zip(b_blocks.remainder());
    let rest: f64 = rest.map(|(x, y)| (f64::from(*x) - f64::from(*y)).powi(2)).sum();
    for (x, y) in a_blocks.zip(b_blocks) {
        for lane in 0..8 {
            let difference = f64::from(x[lane]) - f64::from(y[lane]);
            lanes[lane] += difference * difference;
        }
    }
    lanes.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_dataset::Seed;

    fn points(xs: &[f32]) -> Vec<Vec<f32>> {
        xs.iter().map(|&x| vec![x]).collect()
    }

    fn recall(k: usize, xs: &[f32], instances: &[usize], gallery: Gallery<'_>) -> Option<f64> {
        recall_at(k, &points(xs), instances, gallery)
    }

    #[test]
    fn distinct_instances_are_found_and_random_ones_at_chance() {
        let perfect = recall(1, &[0.0, 0.1, 5.0, 5.1], &[0, 0, 1, 1], Gallery::Any);
        assert_eq!(perfect, Some(1.0));
        let mut stream = Seed(1).stream("noise", 0);
        let noise: Vec<f32> = (0..600).map(|_| stream.normal() as f32).collect();
        let instances: Vec<usize> = (0..600).map(|i| i % 30).collect();
        let random = recall(1, &noise, &instances, Gallery::Any).unwrap();
        assert!((random - 19.0 / 599.0).abs() < 0.025, "{random}");
    }

    #[test]
    fn k_counts_wrong_neighbours_before_the_first_right_one() {
        let xs = [0.0, 1.0, 2.0, 3.5];
        let instances = [0, 1, 1, 0];
        let at = |k| recall(k, &xs, &instances, Gallery::Any);
        assert_eq!((at(1), at(2), at(3)), (Some(0.25), Some(0.5), Some(1.0)));
    }

    #[test]
    fn an_answer_from_the_same_session_does_not_count() {
        let xs = [0.0, 0.1, 9.0, 4.0];
        let instances = [0, 0, 0, 1];
        let sessions = [0, 0, 1, 0];
        assert_eq!(recall(1, &xs, &instances, Gallery::Any), Some(2.0 / 3.0));
        // The fourth has no match in any session, and is no query.
        assert_eq!(recall(1, &xs, &instances, Gallery::OtherSession(&sessions)), Some(0.0));
        assert_eq!(recall(2, &xs, &instances, Gallery::OtherSession(&sessions)), Some(1.0));
    }

    #[test]
    fn a_collapsed_encoder_recalls_nothing() {
        assert_eq!(recall(1, &[3.0; 6], &[0, 0, 0, 1, 1, 1], Gallery::Any), Some(0.0));
    }

    #[test]
    fn undefined_is_none() {
        assert_eq!(recall_at(1, &[], &[], Gallery::Any), None);
        assert_eq!(recall(1, &[0.0, 1.0], &[0, 1], Gallery::Any), None);
        assert_eq!(recall_at(1, &points(&[0.0, f32::NAN]), &[0, 0], Gallery::Any), None);
    }

    #[test]
    fn distance_covers_blocks_and_rest() {
        let a: Vec<f32> = (0..19).map(|i| i as f32).collect();
        assert_eq!(squared_distance(&a, &[0.0; 19]), (0..19).map(|i| f64::from(i * i)).sum::<f64>());
    }
}

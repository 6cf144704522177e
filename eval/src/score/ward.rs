//! Clusters of embeddings, the number of instances known: agglomerative with Ward's linkage.
//!
//! Deterministic: no start values.

use super::retrieval::{are_comparable, squared_distance};
use kodama::{Method, linkage};

/// A cluster index in `0..clusters` for each embedding, numbered by first occurrence; `None` where `clusters` is 0
/// or more than there are embeddings, or the embeddings are not finite and of one length.
///
/// Merges, again and again, the two clusters whose union adds least to the sum of squared distances from the
/// cluster means: O(n^2 d) time, `4 n^2` bytes of memory.
pub fn ward_clusters(embeddings: &[Vec<f32>], clusters: usize) -> Option<Vec<usize>> {
    let n = embeddings.len();
    if clusters == 0 || clusters > n || !are_comparable(embeddings) {
        return None;
    }
    let mut distances = Vec::with_capacity(n * (n - 1) / 2);
    for (i, a) in embeddings.iter().enumerate() {
        distances.extend(embeddings[i + 1..].iter().map(|b| squared_distance(a, b).sqrt()));
    }
    // By rising height, so that the first n - k merges leave k clusters; merge `i` makes cluster `n + i`.
    let merges = linkage(&mut distances, n, Method::Ward);
    let mut parent: Vec<usize> = (0..2 * n).collect();
    for (made, merge) in (n..).zip(&merges.steps()[..n - clusters]) {
        (parent[merge.cluster1], parent[merge.cluster2]) = (made, made);
    }
    let mut names = vec![None; 2 * n];
    let mut next = 0;
    let named = (0..n).map(|i| {
        *names[root(&parent, i)].get_or_insert_with(|| {
            next += 1;
            next - 1
        })
    });
    Some(named.collect())
}

fn root(parent: &[usize], mut i: usize) -> usize {
    while parent[i] != i {
        i = parent[i];
    }
    i
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::clustering::cluster_scores;
    use proptest::prelude::*;
    use vantage_dataset::Seed;

    /// Ward's definition, word for word: merge the pair whose union adds least to the sum of squares.
    fn reference(embeddings: &[Vec<f32>], clusters: usize) -> Vec<usize> {
        let sum_of_squares = |members: &[usize]| -> f64 {
            let dimensions = embeddings[0].len();
            (0..dimensions)
                .map(|d| {
                    let values: Vec<f64> = members.iter().map(|&i| f64::from(embeddings[i][d])).collect();
                    let mean = values.iter().sum::<f64>() / values.len() as f64;
                    values.iter().map(|v| (v - mean).powi(2)).sum::<f64>()
                })
                .sum()
        };
        let mut groups: Vec<Vec<usize>> = (0..embeddings.len()).map(|i| vec![i]).collect();
        while groups.len() > clusters {
            let mut best = (f64::INFINITY, 0, 0);
            for i in 0..groups.len() {
                for j in 0..i {
                    let union = [groups[i].clone(), groups[j].clone()].concat();
                    let added =
                        sum_of_squares(&union) - sum_of_squares(&groups[i]) - sum_of_squares(&groups[j]);
                    if added < best.0 {
                        best = (added, j, i);
                    }
                }
            }
            let gone = groups.remove(best.2);
            groups[best.1].extend(gone);
        }
        let mut labels = vec![0; embeddings.len()];
        for (label, group) in groups.iter().enumerate() {
            group.iter().for_each(|&i| labels[i] = label);
        }
        labels
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn agrees_with_the_definition(seed: u64, n in 1usize..14, k in 1usize..14) {
            let k = k.min(n);
            let mut stream = Seed(seed).stream("embeddings", 0);
            let embeddings: Vec<Vec<f32>> =
                (0..n).map(|_| (0..3).map(|_| stream.normal() as f32).collect()).collect();
            let ours = ward_clusters(&embeddings, k).unwrap();
            prop_assert_eq!(cluster_scores(&reference(&embeddings, k), &ours).unwrap().ari, 1.0);
            prop_assert_eq!(ours.iter().max(), Some(&(k - 1)));
        }
    }

    #[test]
    fn far_blobs_are_found_and_equal_points_do_not_loop() {
        let blobs: Vec<Vec<f32>> = (0..40).map(|i| vec![(i % 4) as f32 * 10.0, 0.0]).collect();
        let truth: Vec<usize> = (0..40).map(|i| i % 4).collect();
        assert_eq!(ward_clusters(&blobs, 4), Some(truth));
        let same = vec![vec![1.0; 2]; 9];
        assert_eq!(ward_clusters(&same, 1), Some(vec![0; 9]));
    }

    #[test]
    fn impossible_requests_are_none() {
        let two = vec![vec![0.0], vec![1.0]];
        assert_eq!(ward_clusters(&two, 0), None);
        assert_eq!(ward_clusters(&two, 3), None);
        assert_eq!(ward_clusters(&[vec![0.0], vec![f32::NAN]], 1), None);
        assert_eq!(ward_clusters(&[vec![0.0], vec![1.0, 2.0]], 1), None);
    }
}

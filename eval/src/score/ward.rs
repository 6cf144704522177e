//! Clusters of embeddings, the number of instances known: agglomerative with Ward's linkage.
//!
//! Deterministic: no start values, and ties go to the lowest index.

/// A cluster index in `0..clusters` for each embedding, numbered by first occurrence; `None` where `clusters` is 0
/// or more than there are embeddings, or the embeddings are not finite and of one length.
///
/// Merges, again and again, the two clusters whose union adds least to the sum of squared distances from the
/// cluster means. By nearest-neighbour chains: O(n^2 d) time, `4 n^2` bytes of memory.
pub fn ward_clusters(embeddings: &[Vec<f32>], clusters: usize) -> Option<Vec<usize>> {
    let n = embeddings.len();
    if clusters == 0 || clusters > n || !super::retrieval::are_comparable(embeddings) {
        return None;
    }
    let mut merges = merges(embeddings);
    // Ward's heights never fall along a chain of merges, so the lowest n - k of them are a valid prefix.
    merges.sort_by(|a, b| a.height.total_cmp(&b.height));
    let mut parent: Vec<usize> = (0..n).collect();
    for merge in &merges[..n - clusters] {
        let (a, b) = (root(&parent, merge.a), root(&parent, merge.b));
        parent[a.max(b)] = a.min(b);
    }
    let mut names = vec![None; n];
    let mut next = 0;
    let named = (0..n).map(|i| {
        *names[root(&parent, i)].get_or_insert_with(|| {
            next += 1;
            next - 1
        })
    });
    Some(named.collect())
}

/// Two clusters, each named by one of its members, merged at a height.
struct Merge {
    a: usize,
    b: usize,
    height: f64,
}

fn merges(embeddings: &[Vec<f32>]) -> Vec<Merge> {
    let n = embeddings.len();
    let mut distance = Condensed::new(embeddings);
    let mut size = vec![1.0; n];
    let mut alive: Vec<usize> = (0..n).collect();
    let mut chain: Vec<usize> = Vec::new();
    let mut merges = Vec::with_capacity(n.saturating_sub(1));
    while alive.len() > 1 {
        let tip = match chain.last() {
            Some(&tip) => tip,
            None => {
                chain.push(alive[0]);
                alive[0]
            }
        };
        let before = chain.len().checked_sub(2).map(|i| chain[i]);
        // The link before the tip wins ties, so that a chain never runs in a circle.
        let mut nearest = before.unwrap_or(usize::MAX);
        let mut height = before.map_or(f64::INFINITY, |b| distance.get(tip, b));
        for &other in &alive {
            if other != tip && distance.get(tip, other) < height {
                (nearest, height) = (other, distance.get(tip, other));
            }
        }
        if before != Some(nearest) {
            chain.push(nearest);
            continue;
        }
        chain.truncate(chain.len() - 2);
        let (kept, gone) = (tip.min(nearest), tip.max(nearest));
        merges.push(Merge { a: kept, b: gone, height });
        alive.retain(|&i| i != gone);
        // Lance and Williams' update of Ward's squared distances.
        for &other in alive.iter().filter(|&&i| i != kept) {
            let (k, g, o) = (size[kept], size[gone], size[other]);
            let updated = ((k + o) * distance.get(kept, other) + (g + o) * distance.get(gone, other)
                - o * height)
                / (k + g + o);
            distance.set(kept, other, updated);
        }
        size[kept] += size[gone];
    }
    merges
}

fn root(parent: &[usize], mut i: usize) -> usize {
    while parent[i] != i {
        i = parent[i];
    }
    i
}

/// The lower triangle of a symmetric matrix of squared distances.
struct Condensed(Vec<f64>);

impl Condensed {
    fn new(embeddings: &[Vec<f32>]) -> Self {
        let mut lower = Vec::with_capacity(embeddings.len() * embeddings.len().saturating_sub(1) / 2);
        for (i, a) in embeddings.iter().enumerate() {
            lower.extend(embeddings[..i].iter().map(|b| super::retrieval::squared_distance(a, b)));
        }
        Self(lower)
    }

    fn index(i: usize, j: usize) -> usize {
        let (low, high) = (i.min(j), i.max(j));
        high * (high - 1) / 2 + low
    }

    fn get(&self, i: usize, j: usize) -> f64 {
        self.0[Self::index(i, j)]
    }

    fn set(&mut self, i: usize, j: usize, value: f64) {
        self.0[Self::index(i, j)] = value;
    }
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

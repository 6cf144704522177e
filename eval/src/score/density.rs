//! Clusters of embeddings, their number unknown: HDBSCAN (Campello et al. 2013), as scikit-learn does it.

use super::retrieval::{are_comparable, squared_distance};
use hdbscan::{DistanceMetric, Hdbscan, HdbscanHyperParams};

/// Fewest members of a cluster, and neighbours that make a place dense: scikit-learn's default, not tuned.
pub const LEAST: usize = 5;

/// What HDBSCAN found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DensityClusters {
    /// The cluster of each embedding, numbered by first occurrence; `None` for noise, which belongs to none.
    pub found: Vec<Option<usize>>,
    /// Clusters found.
    pub clusters: usize,
}

impl DensityClusters {
    /// One label an embedding, each piece of noise a cluster of its own.
    ///
    /// HDBSCAN says of noise that it goes with nothing it has seen: no pair of pieces is said to be of one instance.
    /// As one cluster they would be said to be, and leaving them out would score only what was easy. So noise costs
    /// completeness and ARI, as a view that a robot could not put anywhere does, and never homogeneity.
    pub fn labels(&self) -> Vec<usize> {
        let mut next = self.clusters;
        let label = |found: &Option<usize>| {
            found.unwrap_or_else(|| {
                next += 1;
                next - 1
            })
        };
        self.found.iter().map(label).collect()
    }

    /// Share of embeddings that are noise.
    pub fn noise(&self) -> f64 {
        let noise = self.found.iter().filter(|found| found.is_none()).count();
        noise as f64 / self.found.len() as f64
    }
}

/// Clusters by Euclidean distance. O(n^2 d) time, `8 n^2` bytes of memory. Places equally dense are joined in the order of
/// the embeddings, so that another order can move a few at the edges of clusters that touch.
///
/// `None` for fewer embeddings than a cluster needs, or where they are not finite and of one length.
pub fn density_clusters(embeddings: &[Vec<f32>]) -> Option<DensityClusters> {
    if embeddings.len() < LEAST || !are_comparable(embeddings) {
        return None;
    }
    let row = |a: &Vec<f32>| embeddings.iter().map(|b| squared_distance(a, b).sqrt()).collect();
    let distances: Vec<Vec<f64>> = embeddings.iter().map(row).collect();
    let settings = HdbscanHyperParams::builder()
        .min_cluster_size(LEAST)
        .min_samples(LEAST)
        .dist_metric(DistanceMetric::Precalculated)
        .build();
    let labels = Hdbscan::new(&distances, settings).cluster().ok()?;
    let mut names: Vec<i32> = Vec::new();
    let found = labels
        .iter()
        .map(|&label| {
            if label < 0 {
                return None;
            }
            let known = names.iter().position(|&name| name == label);
            Some(known.unwrap_or_else(|| {
                names.push(label);
                names.len() - 1
            }))
        })
        .collect();
    Some(DensityClusters { found, clusters: names.len() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::clustering::cluster_scores;
    use vantage_dataset::Seed;

    /// `n` points round each of the corners of a square of side `side`, in turn.
    fn blobs(n: usize, side: f64) -> (Vec<Vec<f32>>, Vec<usize>) {
        let mut stream = Seed(5).stream("blobs", 0);
        let truth: Vec<usize> = (0..4 * n).map(|i| i % 4).collect();
        let point = |&corner: &usize| {
            let (x, y) = ((corner % 2) as f64 * side, (corner / 2) as f64 * side);
            vec![(x + stream.normal()) as f32, (y + stream.normal()) as f32]
        };
        (truth.iter().map(point).collect(), truth)
    }

    #[test]
    fn far_blobs_are_found_with_their_number() {
        let (embeddings, truth) = blobs(30, 100.0);
        let clusters = density_clusters(&embeddings).unwrap();
        assert_eq!(clusters.clusters, 4);
        let scores = cluster_scores(&truth, &clusters.labels()).unwrap();
        assert_eq!(scores.purity, 1.0);
        assert!(scores.ari > 0.95, "{scores:?}");
    }

    #[test]
    fn order_changes_no_cluster_that_stands_apart() {
        let (embeddings, _) = blobs(20, 50.0);
        let mut order: Vec<usize> = (0..embeddings.len()).collect();
        Seed(6).stream("order", 0).shuffle(&mut order);
        let shuffled: Vec<Vec<f32>> = order.iter().map(|&i| embeddings[i].clone()).collect();
        let (here, there) = (density_clusters(&embeddings).unwrap(), density_clusters(&shuffled).unwrap());
        let back: Vec<usize> = order.iter().map(|&i| here.labels()[i]).collect();
        assert_eq!(cluster_scores(&back, &there.labels()).unwrap().ari, 1.0);
        assert_eq!(here.noise(), there.noise());
    }

    #[test]
    fn noise_is_of_no_cluster_and_each_piece_for_itself() {
        let (mut embeddings, mut truth) = blobs(10, 50.0);
        embeddings.extend([vec![1e3, 0.0], vec![0.0, -2e3], vec![-4e3, 0.0]]);
        truth.extend([0, 0, 0]);
        let clusters = density_clusters(&embeddings).unwrap();
        assert_eq!(clusters.found[40..], [None; 3]);
        let labels = clusters.labels();
        let mut last: Vec<usize> = labels[40..].to_vec();
        last.dedup();
        assert_eq!(last.len(), 3);
        assert!(last.iter().all(|l| *l >= clusters.clusters && !labels[..40].contains(l)));
        assert!(clusters.noise() >= 3.0 / 43.0);
        let scores = cluster_scores(&truth, &labels).unwrap();
        assert!(scores.purity == 1.0 && scores.completeness < 1.0, "{scores:?}");
    }

    #[test]
    fn equal_few_and_broken_points_are_survived() {
        let same = density_clusters(&vec![vec![2.0; 3]; 12]).unwrap();
        assert!(same.clusters <= 1);
        assert_eq!(density_clusters(&vec![vec![0.0]; LEAST - 1]), None);
        assert_eq!(density_clusters(&vec![vec![f32::NAN]; 9]), None);
    }
}

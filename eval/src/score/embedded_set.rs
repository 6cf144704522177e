//! The embeddings of a set of views, and the clusters that are scored of them.

use super::density::{DensityClusters, LEAST, density_clusters};
use super::embedding::Labels;
use super::ward::ward_clusters;
use std::collections::BTreeSet;

/// Clusters of embeddings.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Clusters {
    /// Their number given: [`ward_clusters`]. `None` where each instance has one view, so that clusters would be the views whatever the
    /// embeddings, or where they are undefined.
    pub given: Option<Vec<usize>>,
    /// Their number found: [`density_clusters`]. `None` where an instance has fewer views than a cluster needs, so that none could be right, or
    /// where they are undefined.
    pub found: Option<DensityClusters>,
}

impl Clusters {
    /// Of embeddings of these instances.
    pub fn of(embeddings: &[Vec<f32>], instances: &[usize]) -> Self {
        let count = instances.iter().collect::<BTreeSet<_>>().len();
        let scarce = |own| instances.iter().filter(|&other| other == own).count() < LEAST;
        Self {
            given: (count < instances.len()).then(|| ward_clusters(embeddings, count)).flatten(),
            found: if instances.iter().any(scarce) { None } else { density_clusters(embeddings) },
        }
    }
}

/// Embeddings, one a view.
#[derive(Clone, Debug, PartialEq)]
pub struct EmbeddedSet {
    /// What made them: a model's name, or that of the floor.
    pub name: String,
    /// `[n][d]`.
    pub embeddings: Vec<Vec<f32>>,
    /// What is known of each.
    pub labels: Labels,
    /// Their clusters.
    pub clusters: Clusters,
}

impl EmbeddedSet {
    /// With their clusters.
    pub fn new(name: String, embeddings: Vec<Vec<f32>>, labels: Labels) -> Self {
        let clusters = Clusters::of(&embeddings, &labels.instances);
        Self { name, embeddings, labels, clusters }
    }
}

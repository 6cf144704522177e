//! All that embeddings are scored by, whatever made them.

use super::clustering::{ClusterScores, cluster_scores};
use super::embedded_set::Clusters;
use super::grounding::ground;
use super::instance_posterior::{KnownInstances, instance_posterior};
use super::retrieval::{Gallery, recall_at};
use super::silhouette::silhouette;
use crate::result::metric::Metric;
use std::collections::{BTreeMap, BTreeSet};
use vantage_dataset::{Seed, ViewSet};

/// Scores by metric; an undefined one is absent.
pub type Scores = BTreeMap<Metric, f64>;

/// What is known of each embedding, one number an embedding each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Labels {
    /// The instance.
    pub instances: Vec<usize>,
    /// The instance's lighting session.
    pub sessions: Vec<usize>,
    /// The instance's class.
    pub classes: Vec<usize>,
}

impl Labels {
    /// Of the views of a set, families as classes.
    pub fn of(set: &ViewSet) -> Self {
        let names: BTreeSet<&str> = set.instances.iter().map(|instance| instance.family.as_str()).collect();
        let class = |instance: usize| names.range(..set.instances[instance].family.as_str()).count();
        Self {
            instances: set.views.iter().map(|view| view.instance).collect(),
            sessions: set.views.iter().map(|view| view.session).collect(),
            classes: set.views.iter().map(|view| class(view.instance)).collect(),
        }
    }
}

/// Scores of one set of embeddings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EmbeddingScores {
    /// Clusters (their number given), neighbours, and known instances under another light.
    pub given: Scores,
    /// Clusters, their number found: [`Clusters`].
    pub density: Scores,
    /// Classes from a few tags: [`ground`].
    pub grounding: Scores,
}

/// Scores embeddings, `[n][d]`, against their labels. Tags are drawn under `seed`.
///
/// # Panics
/// If there is not one label of each kind an embedding.
pub fn score_embeddings(embeddings: &[Vec<f32>], labels: &Labels, seed: Seed) -> EmbeddingScores {
    let truth = &labels.instances;
    let instances = truth.iter().collect::<BTreeSet<_>>().len();
    let clusters = Clusters::of(embeddings, truth);
    let mut given = Scores::new();
    if let Some(found) = clusters.given.and_then(|found| cluster_scores(truth, &found)) {
        insert_clusters(&mut given, &found);
        given.insert(Metric::Nmi, found.nmi);
    }
    given.extend(silhouette(embeddings, truth).map(|value| (Metric::Silhouette, value)));
    let other = Gallery::OtherSession(&labels.sessions);
    for (metric, k, gallery) in [
        (Metric::RecallAt1, 1, Gallery::Any),
        (Metric::RecallAt5, 5, Gallery::Any),
        (Metric::RecallAt1AcrossLight, 1, other),
        (Metric::RecallAt5AcrossLight, 5, other),
    ] {
        let recall = recall_at(k, embeddings, truth, gallery);
        given.extend(recall.map(|recall| (metric, recall)));
    }
    given.extend(known_instances(embeddings, labels));

    let mut density = Scores::new();
    if let Some(found) = clusters.found {
        if let Some(scores) = cluster_scores(truth, &found.labels()) {
            insert_clusters(&mut density, &scores);
        }
        density.insert(Metric::Noise, found.noise());
        let off = found.clusters.abs_diff(instances) as f64 / instances as f64;
        density.insert(Metric::ClusterCount, off);
    }

    let mut grounding = Scores::new();
    if let Some(found) = ground(embeddings, truth, &labels.classes, seed) {
        let nearest = [Metric::NearestOf1, Metric::NearestOf2, Metric::NearestOf5, Metric::NearestOf10];
        // With one tag the two are the same.
        let gaussian = [Metric::GaussianOf2, Metric::GaussianOf5, Metric::GaussianOf10];
        let shares = nearest.into_iter().zip(found.nearest);
        let shares = shares.chain(gaussian.into_iter().zip(found.gaussian[1..].iter().copied()));
        grounding.extend(shares.filter_map(|(metric, share)| Some((metric, share?))));
    }
    EmbeddingScores { given, density, grounding }
}

fn insert_clusters(scores: &mut Scores, found: &ClusterScores) {
    scores.extend([
        (Metric::Ari, found.ari),
        (Metric::VMeasure, found.v_measure),
        (Metric::Homogeneity, found.homogeneity),
        (Metric::Completeness, found.completeness),
        (Metric::Purity, found.purity),
    ]);
}

/// The posterior over instances known from their even sessions, of the embeddings of their odd sessions (Eq. 14).
fn known_instances(embeddings: &[Vec<f32>], labels: &Labels) -> Scores {
    let mut names: BTreeMap<usize, usize> = BTreeMap::new();
    for &instance in &labels.instances {
        let next = names.len();
        names.entry(instance).or_insert(next);
    }
    let of = |session: usize| -> (Vec<Vec<f32>>, Vec<usize>) {
        let all = embeddings.iter().zip(&labels.instances).zip(&labels.sessions);
        let own = all.filter(|(_, s)| **s % 2 == session);
        own.map(|((embedding, instance), _)| (embedding.clone(), names[instance])).unzip()
    };
    let ((known, named), (asked, right)) = (of(0), of(1));
    let found = KnownInstances::fit(&known, &named, names.len())
        .and_then(|known| instance_posterior(&asked, &right, &known.means, known.sigma));
    found
        .map(|f| [(Metric::InstanceRight, f.accuracy), (Metric::InstanceProbability, f.probability)])
        .into_iter()
        .flatten()
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 6 instances of 3 classes, 4 sessions of 6 views.
    fn labels() -> Labels {
        let instances: Vec<usize> = (0..144).map(|i| i / 24).collect();
        let classes = instances.iter().map(|i| i / 2).collect();
        Labels { sessions: (0..144).map(|i| i / 6 % 4).collect(), instances, classes }
    }

    #[test]
    fn embeddings_that_tell_all_are_perfect_in_all() {
        let labels = labels();
        let mut stream = Seed(1).stream("jitter", 0);
        let embeddings: Vec<Vec<f32>> = (0..144)
            .map(|i| {
                let jitter = 0.01 * stream.normal() as f32;
                vec![1e3 * labels.classes[i] as f32, 10.0 * labels.instances[i] as f32 + jitter]
            })
            .collect();
        let scores = score_embeddings(&embeddings, &labels, Seed(0));
        for (metric, value) in scores.given.iter().chain(&scores.grounding) {
            assert!(*value > 0.99 && *value <= 1.0, "{metric:?} {value}");
        }
        assert_eq!((scores.given.len(), scores.grounding.len()), (13, 7));
        assert_eq!(scores.density[&Metric::ClusterCount], 0.0);
        assert!(scores.density[&Metric::Ari] > 0.8 && scores.density[&Metric::Noise] < 0.2, "{scores:?}");
        assert_eq!(scores.density[&Metric::Purity], 1.0);
    }

    #[test]
    fn noise_tells_nothing() {
        let mut stream = Seed(2).stream("noise", 0);
        let noise: Vec<Vec<f32>> =
            (0..144).map(|_| (0..6).map(|_| stream.normal() as f32).collect()).collect();
        let scores = score_embeddings(&noise, &labels(), Seed(0));
        for (metric, chance) in [
            (Metric::Ari, 0.0),
            (Metric::Silhouette, 0.0),
            (Metric::RecallAt1, 1.0 / 6.0),
            (Metric::InstanceRight, 1.0 / 6.0),
        ] {
            assert!((scores.given[&metric] - chance).abs() < 0.12, "{metric:?}: {scores:?}");
        }
        assert!((scores.grounding[&Metric::NearestOf10] - 1.0 / 3.0).abs() < 0.12, "{scores:?}");
        assert!(scores.density[&Metric::Ari] < 0.1, "{scores:?}");
    }

    #[test]
    fn no_embedding_and_nan_have_no_score() {
        let none = Labels { instances: vec![], sessions: vec![], classes: vec![] };
        assert_eq!(score_embeddings(&[], &none, Seed(0)), EmbeddingScores::default());
        let broken = vec![vec![f32::NAN]; 144];
        assert_eq!(score_embeddings(&broken, &labels(), Seed(0)), EmbeddingScores::default());
    }
}

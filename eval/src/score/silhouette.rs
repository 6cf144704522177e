//! Silhouette: whether embeddings lie nearer to their own instance's than to those of the next one.

use super::retrieval::{are_comparable, squared_distance};
use std::collections::BTreeMap;

/// The mean over all embeddings of `(b - a) / max(a, b)`, in `[-1, 1]`: `a` is the mean Euclidean distance to the others
/// of the same label, `b` that to those of the nearest other label (Rousseeuw 1987). An embedding that is alone with its
/// label counts 0, as in scikit-learn. O(n^2 d).
///
/// Given the true instances it asks how well the space keeps them apart, without any clustering.
///
/// `None` where there are fewer than two labels, or one for each embedding, or the embeddings are not finite and of one
/// length.
///
/// # Panics
/// If there is not one label an embedding.
pub fn silhouette(embeddings: &[Vec<f32>], labels: &[usize]) -> Option<f64> {
    assert_eq!(embeddings.len(), labels.len(), "each embedding needs its label");
    let mut index = BTreeMap::new();
    for &label in labels {
        let next = index.len();
        index.entry(label).or_insert(next);
    }
    let groups = index.len();
    if groups < 2 || groups == embeddings.len() || !are_comparable(embeddings) {
        return None;
    }
    let group: Vec<usize> = labels.iter().map(|label| index[label]).collect();
    let mut size = vec![0usize; groups];
    group.iter().for_each(|&g| size[g] += 1);
    let mut values: Vec<f64> = (0..embeddings.len())
        .map(|i| {
            let mut sums = vec![0.0; groups];
            for (j, other) in embeddings.iter().enumerate().filter(|&(j, _)| j != i) {
                sums[group[j]] += squared_distance(&embeddings[i], other).sqrt();
            }
            let own = group[i];
            if size[own] == 1 {
                return 0.0;
            }
            let a = sums[own] / (size[own] - 1) as f64;
            let others = (0..groups).filter(|&g| g != own).map(|g| sums[g] / size[g] as f64);
            let b = others.fold(f64::INFINITY, f64::min);
            let scale = a.max(b);
            if scale > 0.0 { (b - a) / scale } else { 0.0 }
        })
        .collect();
    values.sort_by(f64::total_cmp);
    Some(values.iter().sum::<f64>() / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use vantage_dataset::Seed;

    fn points(xs: &[[f32; 2]]) -> Vec<Vec<f32>> {
        xs.iter().map(|x| x.to_vec()).collect()
    }

    /// `sklearn.metrics.silhouette_score` 1.9 of the same points.
    #[test]
    fn values_are_those_of_scikit_learn() {
        let xs =
            points(&[[0.0, 0.0], [1.0, 0.5], [0.2, 0.9], [4.0, 4.0], [5.0, 3.5], [2.0, 2.0], [9.0, 0.0]]);
        assert_relative_eq!(
            silhouette(&xs, &[0, 0, 0, 1, 1, 1, 2]).unwrap(),
            0.46046314174531655,
            epsilon = 1e-7
        );
        assert_relative_eq!(
            silhouette(&xs, &[0, 1, 2, 0, 1, 2, 0]).unwrap(),
            -0.25434787714801355,
            epsilon = 1e-7
        );
    }

    #[test]
    fn far_blobs_score_1_and_random_labels_about_0() {
        let mut stream = Seed(1).stream("blobs", 0);
        let labels: Vec<usize> = (0..300).map(|i| i % 6).collect();
        let blobs: Vec<Vec<f32>> =
            labels.iter().map(|&l| vec![1e4 * l as f32, stream.normal() as f32]).collect();
        assert!(silhouette(&blobs, &labels).unwrap() > 0.999);
        let labels: Vec<usize> = (0..600).map(|i| i % 3).collect();
        let noise: Vec<Vec<f32>> =
            labels.iter().map(|_| (0..3).map(|_| stream.normal() as f32).collect()).collect();
        assert!(silhouette(&noise, &labels).unwrap().abs() < 0.05);
    }

    #[test]
    fn names_change_no_bit_and_order_only_the_last_ones() {
        let mut stream = Seed(2).stream("noise", 0);
        let xs: Vec<Vec<f32>> = (0..40).map(|_| (0..5).map(|_| stream.normal() as f32).collect()).collect();
        let labels: Vec<usize> = (0..40).map(|i| i * i % 7).collect();
        let renamed: Vec<usize> = labels.iter().map(|l| 100 - l).collect();
        assert_eq!(silhouette(&xs, &labels), silhouette(&xs, &renamed));
        let mut order: Vec<usize> = (0..40).collect();
        stream.shuffle(&mut order);
        let shuffled: Vec<Vec<f32>> = order.iter().map(|&i| xs[i].clone()).collect();
        let moved: Vec<usize> = order.iter().map(|&i| labels[i]).collect();
        let (a, b) = (silhouette(&xs, &labels).unwrap(), silhouette(&shuffled, &moved).unwrap());
        assert_relative_eq!(a, b, epsilon = 1e-12);
    }

    #[test]
    fn undefined_is_none_and_a_collapsed_encoder_scores_0() {
        let same = points(&[[1.0, 1.0]; 4]);
        assert_eq!(silhouette(&same, &[0, 0, 1, 1]), Some(0.0));
        assert_eq!(silhouette(&same, &[0; 4]), None);
        assert_eq!(silhouette(&same, &[0, 1, 2, 3]), None);
        assert_eq!(silhouette(&[], &[]), None);
        assert_eq!(silhouette(&points(&[[f32::NAN, 0.0]; 3]), &[0, 0, 1]), None);
    }
}

//! t-SNE (van der Maaten and Hinton 2008): embeddings laid out in the plane, near ones near.

use crate::score::pca::Pca;
use bhtsne::{Neighbor, tSNE};
use vantage_dataset::Seed;

/// Neighbours that count for each point, where there are points enough: the method's usual value.
const PERPLEXITY: f64 = 30.0;
const EPOCHS: usize = 1000;
/// Of Barnes and Hut: cells seen under a smaller ratio of size to distance are taken as one point.
const THETA: f64 = 0.5;
/// Spread of the start, as usual; and of the jitter that tells equal points apart.
const START: f64 = 1e-4;
const JITTER: f64 = 1e-6;
/// With fewer points there are no neighbourhoods to keep.
const LEAST: usize = 8;

/// One point of the plane for each embedding, in no unit. From the first two principal components, so that the same
/// embeddings give the same points, bit by bit on one machine, at any number of threads.
///
/// `None` for fewer than 8 embeddings, or where they are not finite and of one length.
pub fn tsne(embeddings: &[Vec<f32>]) -> Option<Vec<[f64; 2]>> {
    let n = embeddings.len();
    if n < LEAST {
        return None;
    }
    let start = start(embeddings)?;
    let perplexity = PERPLEXITY.min(((n - 1) / 3) as f64);
    let neighbors = neighbors(embeddings, (3.0 * perplexity) as usize);
    // On one thread, as sums are taken in an order that depends on their number.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().ok()?;
    let flat = pool.install(|| {
        tSNE::<f64, Vec<f32>, 2>::new(embeddings)
            .perplexity(perplexity)
            .epochs(EPOCHS)
            .initial_embedding(start)
            .barnes_hut_with_neighbors(THETA, &neighbors)
            .embedding()
    });
    let points: Vec<[f64; 2]> = flat.chunks_exact(2).map(|point| [point[0], point[1]]).collect();
    points.iter().flatten().all(|x| x.is_finite()).then_some(points)
}

/// Row-major `[n][2]`.
fn start(embeddings: &[Vec<f32>]) -> Option<Vec<f64>> {
    let pca = Pca::fit(embeddings, 2)?;
    let mut points: Vec<[f64; 2]> = embeddings
        .iter()
        .map(|embedding| {
            let projected = pca.project(embedding);
            [0, 1].map(|axis| projected.get(axis).map_or(0.0, |&x| f64::from(x)))
        })
        .collect();
    let squares = points.iter().map(|point| point[0] * point[0]).sum::<f64>() / points.len() as f64;
    let scale = if squares > 0.0 { START / squares.sqrt() } else { 0.0 };
    let mut stream = Seed(0).stream("tsne", 0);
    points.iter_mut().flatten().for_each(|x| *x = *x * scale + JITTER * stream.normal());
    Some(points.into_iter().flatten().collect())
}

/// The `k` nearest of each embedding, by rising distance; ties by index.
fn neighbors(embeddings: &[Vec<f32>], k: usize) -> Vec<Vec<Neighbor<f64>>> {
    let nearest = |i: usize| {
        let others = (0..embeddings.len()).filter(|&j| j != i);
        let mut row: Vec<Neighbor<f64>> = others
            .map(|index| Neighbor { index, distance: distance(&embeddings[i], &embeddings[index]) })
            .collect();
        row.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.index.cmp(&b.index)));
        row.truncate(k);
        row
    };
    (0..embeddings.len()).map(nearest).collect()
}

fn distance(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (f64::from(*x) - f64::from(*y)).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 5 blobs of 20 points in 8 dimensions.
    fn blobs() -> Vec<Vec<f32>> {
        let mut stream = Seed(1).stream("blobs", 0);
        (0..100)
            .map(|i| {
                (0..8).map(|j| (f64::from(u8::from(j == i % 5)) * 20.0 + stream.normal()) as f32).collect()
            })
            .collect()
    }

    #[test]
    fn blobs_stay_together() {
        let points = tsne(&blobs()).unwrap();
        let squared = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
        for (i, point) in points.iter().enumerate() {
            let others = (0..points.len()).filter(|&j| j != i);
            let nearest =
                others.min_by(|&a, &b| squared(point, &points[a]).total_cmp(&squared(point, &points[b])));
            assert_eq!(nearest.unwrap() % 5, i % 5, "point {i}");
        }
    }

    #[test]
    fn the_same_points_at_any_number_of_threads() {
        let blobs = blobs();
        let here = tsne(&blobs).unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        assert_eq!(pool.install(|| tsne(&blobs)), Some(here));
    }

    #[test]
    fn few_equal_and_broken_embeddings_are_survived() {
        assert_eq!(tsne(&vec![vec![1.0; 3]; LEAST - 1]), None);
        assert_eq!(tsne(&vec![vec![f32::NAN; 3]; 20]), None);
        if let Some(points) = tsne(&vec![vec![1.0; 3]; 20]) {
            assert!(points.iter().flatten().all(|x| x.is_finite()));
        }
    }
}

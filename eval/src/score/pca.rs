//! Principal components of raw pixels: the floor that a learned embedding has to beat.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// The mean and the leading principal axes of a set of samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Pca {
    mean: Vec<f64>,
    /// `[components][dimensions]`, orthonormal rows, by falling variance.
    axes: Vec<Vec<f64>>,
}

/// Share of the largest variance below which a direction counts as rounding noise.
const VARIANCE_FLOOR: f64 = 1e-12;

impl Pca {
    /// Fits at most `components` axes to `samples`, `[n][d]`; fewer where the samples span fewer directions. `None`
    /// for no sample, or samples that are not finite and of one length.
    ///
    /// Eigenvectors of the smaller of the covariance and the Gram matrix: O(n d m + m^3) with `m = min(n, d)`; 512
    /// images of 3072 numbers take about a second.
    pub fn fit(samples: &[Vec<f32>], components: usize) -> Option<Self> {
        let n = samples.len();
        let d = samples.first()?.len();
        if !super::retrieval::are_comparable(samples) {
            return None;
        }
        let mean: Vec<f64> =
            (0..d).map(|j| samples.iter().map(|s| f64::from(s[j])).sum::<f64>() / n as f64).collect();
        let rows: Vec<Vec<f64>> =
            samples.iter().map(|s| s.iter().zip(&mean).map(|(x, m)| f64::from(*x) - m).collect()).collect();
        let eigen = if n < d {
            SymmetricEigen::new(products(&rows))
        } else {
            let columns: Vec<Vec<f64>> = (0..d).map(|j| rows.iter().map(|r| r[j]).collect()).collect();
            SymmetricEigen::new(products(&columns))
        };
        let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
        order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
        let floor = order.first().map_or(0.0, |&i| eigen.eigenvalues[i] * VARIANCE_FLOOR).max(0.0);
        let axes = order
            .into_iter()
            .take(components)
            .filter(|&i| eigen.eigenvalues[i] > floor)
            .map(|i| {
                let vector = DVector::from_column_slice(eigen.eigenvectors.column(i).as_slice());
                let axis = if n < d { combine(&rows, &vector) } else { vector.as_slice().to_vec() };
                unit(axis)
            })
            .collect();
        Some(Self { mean, axes })
    }

    /// Coordinates along the axes, `[components]`.
    ///
    /// # Panics
    /// If the sample is of another length than those fitted.
    pub fn project(&self, sample: &[f32]) -> Vec<f32> {
        assert_eq!(sample.len(), self.mean.len(), "the sample has other dimensions than those fitted");
        let centered: Vec<f64> = sample.iter().zip(&self.mean).map(|(x, m)| f64::from(*x) - m).collect();
        self.axes.iter().map(|axis| dot(axis, &centered) as f32).collect()
    }
}

/// The matrix of dot products of the vectors with each other.
fn products(vectors: &[Vec<f64>]) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(vectors.len(), vectors.len());
    for (i, a) in vectors.iter().enumerate() {
        for (j, b) in vectors[..=i].iter().enumerate() {
            let product = dot(a, b);
            matrix[(i, j)] = product;
            matrix[(j, i)] = product;
        }
    }
    matrix
}

fn combine(rows: &[Vec<f64>], weights: &DVector<f64>) -> Vec<f64> {
    let mut sum = vec![0.0; rows[0].len()];
    for (row, weight) in rows.iter().zip(weights.iter()) {
        sum.iter_mut().zip(row).for_each(|(s, x)| *s += weight * x);
    }
    sum
}

/// The vector scaled to length 1, its largest entry positive, which fixes the sign that an eigenvector leaves free.
fn unit(mut vector: Vec<f64>) -> Vec<f64> {
    let largest = vector.iter().copied().fold(0.0f64, |a, b| if b.abs() > a.abs() { b } else { a });
    let scale = dot(&vector, &vector).sqrt().copysign(largest);
    vector.iter_mut().for_each(|x| *x /= scale);
    vector
}

/// A dot product over eight lanes: the same bits on every processor.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0f64; 8];
    let (a_blocks, b_blocks) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a_blocks.remainder().iter().zip(b_blocks.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a_blocks.zip(b_blocks) {
        for lane in 0..8 {
            lanes[lane] += x[lane] * y[lane];
        }
    }
    lanes.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use vantage_dataset::Seed;

    /// `n` samples in `d` dimensions with standard deviations 4, 2 and 1 along the first three, and 0.01 elsewhere.
    fn samples(n: usize, d: usize) -> Vec<Vec<f32>> {
        let mut stream = Seed(5).stream("samples", 0);
        let deviation = |j: usize| [4.0, 2.0, 1.0].get(j).copied().unwrap_or(0.01);
        (0..n).map(|_| (0..d).map(|j| (7.0 + deviation(j) * stream.normal()) as f32).collect()).collect()
    }

    fn deviation(values: impl Iterator<Item = f32> + Clone) -> f64 {
        let n = values.clone().count() as f64;
        let mean = values.clone().map(f64::from).sum::<f64>() / n;
        (values.map(|v| (f64::from(v) - mean).powi(2)).sum::<f64>() / n).sqrt()
    }

    #[test]
    fn axes_follow_the_variance_whether_by_covariance_or_gram() {
        for (n, d) in [(400, 6), (60, 200)] {
            let samples = samples(n, d);
            let pca = Pca::fit(&samples, 3).unwrap();
            let projected: Vec<Vec<f32>> = samples.iter().map(|s| pca.project(s)).collect();
            for (component, expected) in [4.0, 2.0, 1.0].into_iter().enumerate() {
                let measured = deviation(projected.iter().map(|p| p[component]));
                assert_relative_eq!(measured, expected, max_relative = 0.25);
                assert!(pca.axes[component][component] > 0.97, "axis {component} of {n} x {d}");
            }
            let mixed: f64 = dot(&pca.axes[0], &pca.axes[1]);
            assert!(mixed.abs() < 1e-9 && (dot(&pca.axes[0], &pca.axes[0]) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn covariance_and_gram_give_the_same_axes() {
        let wide = samples(20, 24);
        let tall: Vec<Vec<f32>> = wide.iter().cycle().take(60).cloned().collect();
        let (gram, covariance) = (Pca::fit(&wide, 5).unwrap(), Pca::fit(&tall, 5).unwrap());
        for (a, b) in gram.axes.iter().zip(&covariance.axes) {
            assert_relative_eq!(dot(a, b).abs(), 1.0, epsilon = 1e-9);
        }
    }

    #[test]
    fn no_axis_is_made_of_rounding_noise() {
        let line: Vec<Vec<f32>> = (0..10).map(|i| vec![i as f32, 2.0 * i as f32, 0.0, 1.0]).collect();
        assert_eq!(Pca::fit(&line, 4).unwrap().axes.len(), 1);
        assert_eq!(Pca::fit(&vec![vec![1.0; 4]; 5], 4).unwrap().axes.len(), 0);
        assert_eq!(Pca::fit(&[], 4), None);
        assert_eq!(Pca::fit(&[vec![f32::INFINITY]], 1), None);
    }
}

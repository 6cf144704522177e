//! The noise of the reduced measurement: a multivariate Student t on `r = m(z) - m(e, x_rel)`.
//!
//! Residuals of a learned model are correlated between their numbers and heavy-tailed; as independent
//! Gaussians they claim far too much.

use nalgebra::{Cholesky, DMatrix};
use serde::{Deserialize, Serialize, Serializer};
use serde_saphyr::FlowSeq;
use std::cmp::Ordering;
use vantage_model::MeasurementNoise;

/// Least residuals for each dimension that a fit takes.
pub const RESIDUALS_PER_DIMENSION: usize = 4;

const DEGREES: (f64, f64) = (1.0, 200.0);
/// Of the diagonal of `R`, so that whatever is computed of it, or of its logarithm, stays finite.
const DIAGONAL: (f64, f64) = (1e-9, 1e9);
const ROUNDS: usize = 200;
const CONVERGED: f64 = 1e-9;
/// Of the mean variance; keeps the scale matrix invertible where a number never varies.
const FLOOR: f64 = 1e-6;

/// A Student t over residuals as a manifest holds it, and how it was fitted: `p(r) ~ (1 + |R r|^2 / nu)^(-(nu + d) / 2)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResidualNoise {
    /// `nu`, between 1 (Cauchy) and 200 (all but Gaussian).
    pub degrees_of_freedom: f64,
    /// `R`, upper triangular, row by row: `R^T R` is the inverse of the scale matrix.
    #[serde(serialize_with = "a_row_a_line")]
    pub sqrt_information: Vec<Vec<f64>>,
    /// Residuals it was fitted to.
    pub residuals: usize,
}

impl ResidualNoise {
    /// The maximum-likelihood scale matrix and degrees of freedom of zero-mean residuals, `[n, d]`.
    ///
    /// Expectation maximisation for the scale, a line search on the likelihood itself for the degrees of
    /// freedom (ECME, Liu and Rubin 1995). `None` with fewer than `4 d` residuals,
    /// or where they are not finite.
    pub fn fit(residuals: &DMatrix<f64>) -> Option<Self> {
        let (n, d) = residuals.shape();
        if n < RESIDUALS_PER_DIMENSION * d || residuals.iter().any(|r| !r.is_finite()) {
            return None;
        }
        let floor = FLOOR * residuals.norm_squared() / (n * d) as f64 + f64::MIN_POSITIVE;
        let floored = |scale: DMatrix<f64>| scale + DMatrix::identity(d, d) * floor;
        let mut degrees = 8.0;
        let mut factor = Cholesky::new(floored(residuals.tr_mul(residuals) / n as f64))?;
        let mut likelihood = f64::NEG_INFINITY;
        for _ in 0..ROUNDS {
            let distances = squared_distances(&factor, residuals);
            degrees = most_likely_degrees(&distances, d);
            let log_determinant = factor.l_dirty().diagonal().map(f64::ln).sum() * 2.0;
            let reached = log_likelihood(&distances, d, degrees) - 0.5 * n as f64 * log_determinant;
            if reached - likelihood < CONVERGED * n as f64 {
                break;
            }
            likelihood = reached;
            let mut weighted = residuals.clone();
            for (mut row, distance) in weighted.row_iter_mut().zip(&distances) {
                row *= (degrees + d as f64) / (degrees + distance);
            }
            factor = Cholesky::new(floored(residuals.tr_mul(&weighted) / n as f64))?;
        }
        let information = Cholesky::new(factor.inverse())?;
        let upper = information.l().transpose();
        Some(Self {
            degrees_of_freedom: degrees,
            sqrt_information: upper.row_iter().map(|row| row.iter().copied().collect()).collect(),
            residuals: n,
        })
    }

    /// Numbers of a residual.
    pub fn dimension(&self) -> usize {
        self.sqrt_information.len()
    }

    /// The law of residuals, of a checked record.
    pub(crate) fn law(&self) -> MeasurementNoise {
        let d = self.dimension();
        let sqrt_information = DMatrix::from_fn(d, d, |row, column| self.sqrt_information[row][column]);
        MeasurementNoise::new(sqrt_information, self.degrees_of_freedom).expect("a checked record is a law")
    }

    /// What is wrong with it as noise of `dimension` numbers, if anything: a field, what it holds, what it should.
    pub(crate) fn fault(&self, dimension: usize) -> Option<[String; 3]> {
        let fault = |field: &str, got: String, expected: String| Some([field.to_owned(), got, expected]);
        if self.sqrt_information.len() != dimension
            || self.sqrt_information.iter().any(|row| row.len() != dimension)
        {
            let longest = self.sqrt_information.iter().map(Vec::len).max().unwrap_or(0);
            let got = format!("{} rows of up to {longest} numbers", self.sqrt_information.len());
            return fault("sqrt_information", got, format!("{dimension} x {dimension}"));
        }
        for (row, numbers) in self.sqrt_information.iter().enumerate() {
            for (column, &number) in numbers.iter().enumerate() {
                let expected = match row.cmp(&column) {
                    Ordering::Greater if number == 0.0 => continue,
                    Ordering::Equal if (DIAGONAL.0..=DIAGONAL.1).contains(&number) => continue,
                    Ordering::Less if number.abs() <= DIAGONAL.1 => continue,
                    Ordering::Greater => "0, below the diagonal of an upper triangular matrix".to_owned(),
                    Ordering::Equal => format!("{:e} to {:e}, on the diagonal", DIAGONAL.0, DIAGONAL.1),
                    Ordering::Less => format!("-{0:e} to {0:e}", DIAGONAL.1),
                };
                return fault(&format!("sqrt_information[{row}][{column}]"), format!("{number:e}"), expected);
            }
        }
        if !(DEGREES.0..=DEGREES.1).contains(&self.degrees_of_freedom) {
            let expected = format!("{} to {}", DEGREES.0, DEGREES.1);
            return fault("degrees_of_freedom", self.degrees_of_freedom.to_string(), expected);
        }
        None
    }
}

fn a_row_a_line<S: Serializer>(rows: &[Vec<f64>], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(rows.iter().map(FlowSeq))
}

/// `r^T S^-1 r` of each row.
fn squared_distances(factor: &Cholesky<f64, nalgebra::Dyn>, residuals: &DMatrix<f64>) -> Vec<f64> {
    let mut columns = residuals.transpose();
    factor.l_dirty().solve_lower_triangular_mut(&mut columns);
    columns.column_iter().map(|column: nalgebra::DVectorView<f64>| column.norm_squared()).collect()
}

/// Log likelihood but for the determinant of the scale.
fn log_likelihood(distances: &[f64], dimension: usize, degrees: f64) -> f64 {
    let d = dimension as f64;
    let constant = libm::lgamma((degrees + d) / 2.0)
        - libm::lgamma(degrees / 2.0)
        - d / 2.0 * (degrees * std::f64::consts::PI).ln();
    distances.iter().map(|distance| constant - (degrees + d) / 2.0 * (distance / degrees).ln_1p()).sum()
}

/// Golden-section search over the logarithm of the degrees of freedom.
fn most_likely_degrees(distances: &[f64], dimension: usize) -> f64 {
    let shrink = (5f64.sqrt() - 1.0) / 2.0;
    let value = |log: f64| log_likelihood(distances, dimension, log.exp());
    let (mut low, mut high) = (DEGREES.0.ln(), DEGREES.1.ln());
    for _ in 0..40 {
        let (a, b) = (high - shrink * (high - low), low + shrink * (high - low));
        if value(a) > value(b) { high = b } else { low = a }
    }
    (0.5 * (low + high)).exp().clamp(DEGREES.0, DEGREES.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;
    use vantage_dataset::Seed;

    /// `n` draws of a t with scale matrix `L L^T`.
    fn draws(n: usize, degrees: usize, lower: &DMatrix<f64>) -> DMatrix<f64> {
        let mut stream = Seed(3).stream("residual", 0);
        let mut residuals = DMatrix::zeros(n, lower.nrows());
        for mut row in residuals.row_iter_mut() {
            let normal = DVector::from_fn(lower.nrows(), |_, _| stream.normal());
            let chi: f64 = (0..degrees).map(|_| stream.normal().powi(2)).sum();
            row.copy_from(&(lower * normal / (chi / degrees as f64).sqrt()).transpose());
        }
        residuals
    }

    #[test]
    fn a_fit_recovers_scale_and_degrees_of_freedom() {
        let lower = DMatrix::from_row_slice(3, 3, &[2.0, 0.0, 0.0, 0.5, 1.0, 0.0, -0.3, 0.2, 0.1]);
        let noise = ResidualNoise::fit(&draws(8000, 5, &lower)).unwrap();
        assert!((noise.degrees_of_freedom - 5.0).abs() < 0.8, "{}", noise.degrees_of_freedom);
        let whitened = noise.law().sqrt_information() * &lower;
        let identity = &whitened * whitened.transpose();
        assert!((identity - DMatrix::identity(3, 3)).norm() < 0.12, "{whitened}");
        assert_eq!(noise.fault(3), None);
    }

    #[test]
    fn gaussian_residuals_have_many_degrees_of_freedom() {
        let mut stream = Seed(4).stream("residual", 1);
        let residuals = DMatrix::from_fn(4000, 4, |_, _| stream.normal());
        assert!(ResidualNoise::fit(&residuals).unwrap().degrees_of_freedom > 40.0);
    }

    #[test]
    fn too_few_or_non_finite_residuals_are_refused_and_constant_ones_survive() {
        let mut residuals = draws(16, 5, &DMatrix::identity(4, 4));
        assert!(ResidualNoise::fit(&residuals).is_some());
        assert!(ResidualNoise::fit(&residuals.rows(0, 15).into_owned()).is_none());
        residuals.column_mut(2).fill(0.0);
        assert_eq!(ResidualNoise::fit(&residuals).unwrap().fault(4), None);
        residuals[(3, 1)] = f64::NAN;
        assert!(ResidualNoise::fit(&residuals).is_none());
    }

    #[test]
    fn faults_are_named() {
        let good = ResidualNoise::fit(&draws(40, 5, &DMatrix::identity(2, 2))).unwrap();
        assert_eq!(good.fault(2), None);
        assert_eq!(good.fault(3).unwrap(), ["sqrt_information", "2 rows of up to 2 numbers", "3 x 3"]);
        for (row, column, number, expected) in [
            (1, 1, 0.0, "1e-9 to 1e9"),
            (1, 1, -1.0, "1e-9 to 1e9"),
            (0, 0, 1e308, "1e-9 to 1e9"),
            (1, 1, 1e-320, "1e-9 to 1e9"),
            (1, 1, f64::NAN, "1e-9 to 1e9"),
            (0, 1, -1e308, "-1e9 to 1e9"),
            (1, 0, 1e-3, "0, below the diagonal"),
            (1, 0, f64::NAN, "0, below the diagonal"),
        ] {
            let mut bad = good.clone();
            bad.sqrt_information[row][column] = number;
            let [field, got, told] = bad.fault(2).unwrap();
            assert_eq!((field, got), (format!("sqrt_information[{row}][{column}]"), format!("{number:e}")));
            assert!(told.starts_with(expected), "{told}");
        }
        let mut ragged = good.clone();
        ragged.sqrt_information[1].pop();
        assert_eq!(ragged.fault(2).unwrap()[0], "sqrt_information");
        let loose = ResidualNoise { degrees_of_freedom: 0.0, ..good };
        assert_eq!(loose.fault(2).unwrap()[..2], ["degrees_of_freedom", "0"]);
    }
}

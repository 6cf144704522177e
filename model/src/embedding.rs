//! Numbers of a crop that are near for views of one object, and far for views of two.

use crate::AnswerError;
use nalgebra::DVector;
use vantage_dataset::Crop;

/// `p(y_1..y_n | one object) = integral N(u; 0, diag(spread)) prod_i N(y_i; u, I) du`, K numbers.
///
/// The two-covariance model of probabilistic linear discriminant analysis (Prince and Elder, ICCV 2007), in the basis in which both are diagonal.
pub trait Embedding: Send + Sync {
    /// Variances between objects, `[K]`, where those of an object's views are 1.
    fn spread(&self) -> &DVector<f64>;

    /// `y`, `[K]`.
    ///
    /// # Errors
    /// A model that does not answer with numbers.
    fn embed(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError>;
}

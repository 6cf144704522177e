//! Derivatives of a graph that comes without its Jacobian.

use crate::error::ModelError;
use nalgebra::{DMatrix, DVector};

/// Where `f32` outputs of order 1 have about as much rounding as curvature in a central difference.
const STEP: f64 = 4e-3;

/// `d f / d x` at `x`, `[outputs, x.len()]`, by central differences: `2 x.len()` runs of `f`.
///
/// Exact to about 1e-4 of the largest derivative where `f` is smooth.
pub(crate) fn central_differences(
    x: &[f64],
    f: impl Fn(&[f64]) -> Result<DVector<f64>, ModelError>,
) -> Result<DMatrix<f64>, ModelError> {
    let columns = (0..x.len()).map(|index| {
        let step = STEP * x[index].abs().max(1.0);
        let moved = |step: f64| {
            let mut moved = x.to_vec();
            moved[index] += step;
            f(&moved)
        };
        Ok((moved(step)? - moved(-step)?) / (2.0 * step))
    });
    Ok(DMatrix::from_columns(&columns.collect::<Result<Vec<_>, ModelError>>()?))
}

//! Landmark error: where the map's point landmarks are.

use super::pairs::Pairs;
use super::root_mean_square;
use nalgebra::Point3;

/// Root mean square distance, metres, of estimated landmarks from the true ones, once the first estimated robot pose is laid on the
/// first true one. `estimates` has the number of each, which is its index in `truth`; one that is not there is left out. `None` where
/// there are none.
pub fn landmark_error(
    pairs: &Pairs,
    truth: &[Point3<f64>],
    estimates: impl IntoIterator<Item = (usize, Point3<f64>)>,
) -> Option<f64> {
    let first_from_true_world = pairs.truth().first().map(|p| p.inverse()).unwrap_or_default();
    let first_from_world = pairs.estimate().first().map(|p| p.inverse()).unwrap_or_default();
    let square = |(landmark, estimate): (usize, Point3<f64>)| {
        let true_point = first_from_true_world * truth.get(landmark)?;
        Some((first_from_world * estimate - true_point).norm_squared())
    };
    let squares: Vec<f64> = estimates.into_iter().filter_map(square).collect();
    root_mean_square(squares.into_iter())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::Vector3;
    use vantage_dataset::Pose;

    #[test]
    fn landmarks_are_measured_from_the_first_pose() {
        let frame = Pose::new(Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.0, 0.3, 1.0));
        let first = Pose::new(Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.0, 0.0, 0.4));
        let pairs = Pairs::by_step(&[first], &[frame * first]).unwrap();
        let truth = [Point3::new(1.0, 2.0, 0.0), Point3::new(0.0, -1.0, 2.0), Point3::origin()];
        let off = [(1, frame * Point3::new(0.0, -1.0, 2.4)), (0, frame * Point3::new(1.3, 2.0, 0.0))];
        let error = landmark_error(&pairs, &truth, off.into_iter().chain([(9, Point3::origin())]));
        assert_relative_eq!(error.unwrap(), (0.25f64 / 2.0).sqrt(), epsilon = 1e-12);
        assert_eq!(landmark_error(&pairs, &truth, []), None);
    }
}

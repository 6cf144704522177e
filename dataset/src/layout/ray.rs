//! Where several lines of sight meet.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

/// Rounds of reweighting.
const ROUNDS: usize = 20;
/// Directions must differ by about the square root of this, radians, for their meeting point to be told.
const LEAST_SPREAD: f64 = 1e-4;

/// A line of sight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    /// Where the camera is.
    pub(super) origin: Point3<f64>,
    /// Unit vector.
    pub(super) direction: Vector3<f64>,
}

impl Ray {
    /// Projects on the plane across the ray.
    fn across(&self) -> Matrix3<f64> {
        Matrix3::identity() - self.direction * self.direction.transpose()
    }
}

/// The point nearest to most rays: least squares with Cauchy's weights, whose scale is the median distance. None
/// where the rays are too few or too alike.
pub(super) fn meeting_point(rays: &[Ray]) -> Option<Point3<f64>> {
    let mut weights = vec![1.0; rays.len()];
    let mut point = None;
    for _ in 0..ROUNDS {
        let total: f64 = weights.iter().sum();
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (ray, weight) in rays.iter().zip(&weights) {
            let across = ray.across() * (weight / total);
            normal += across;
            right += across * ray.origin.coords;
        }
        if !normal.iter().chain(&right).all(|entry| entry.is_finite())
            || SymmetricEigen::new(normal).eigenvalues.min() < LEAST_SPREAD
        {
            return None;
        }
        let met = Point3::from(normal.cholesky()?.solve(&right));
        let distances: Vec<f64> = rays.iter().map(|ray| (ray.across() * (met - ray.origin)).norm()).collect();
        let scale = median(distances.clone())?.max(1e-9);
        weights = distances.iter().map(|distance| 1.0 / (1.0 + (distance / (2.0 * scale)).powi(2))).collect();
        point = Some(met);
    }
    point
}

/// The median, the mean of the middle two of an even number; none of nothing.
pub(super) fn median(values: Vec<f64>) -> Option<f64> {
    let mut sorted = values;
    sorted.sort_by(f64::total_cmp);
    let upper = *sorted.get(sorted.len() / 2)?;
    Some(if sorted.len() % 2 == 1 { upper } else { (sorted[sorted.len() / 2 - 1] + upper) / 2.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(origin: [f64; 3], target: [f64; 3]) -> Ray {
        let (origin, target) = (Point3::from(origin), Point3::from(target));
        Ray { origin, direction: (target - origin).normalize() }
    }

    #[test]
    fn outliers_do_not_move_the_meeting_point() {
        let target = [0.1, -0.2, 0.3];
        let mut rays: Vec<Ray> = (0..20)
            .map(|i| {
                let angle = f64::from(i) * 0.3;
                ray([angle.cos(), angle.sin(), 0.2 * f64::from(i % 3)], target)
            })
            .collect();
        rays.push(ray([1.0, 0.0, 0.0], [0.0, 0.9, 0.0]));
        rays.push(ray([0.0, 1.0, 0.0], [0.8, 0.0, 0.0]));
        let met = meeting_point(&rays).unwrap();
        assert!((met - Point3::from(target)).norm() < 1e-6, "{met}");
    }

    #[test]
    fn parallel_rays_meet_nowhere() {
        let rays = [ray([0.0, 0.0, 0.0], [1.0, 0.0, 0.0]), ray([0.0, 0.1, 0.0], [1.0, 0.1, 0.0])];
        assert!(meeting_point(&rays).is_none());
        assert!(meeting_point(&[]).is_none());
    }

    #[test]
    fn medians() {
        assert_eq!(median(vec![]), None);
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), Some(2.5));
    }
}

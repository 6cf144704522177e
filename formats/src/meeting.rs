//! Where most of several lines of sight meet.

use nalgebra::{Point3, SymmetricEigen};
use vantage_dataset::median::median;
use vantage_dataset::ray::{Meeting, Ray};

/// Rounds of reweighting.
const ROUNDS: usize = 20;
/// Directions must differ by about the square root of this, radians, for their meeting point to be told.
const LEAST_SPREAD: f64 = 1e-4;

/// The point nearest to most rays: least squares with Cauchy's weights, whose scale is the median distance. None
/// where the rays are too few or too alike.
pub(crate) fn meeting_point(rays: &[Ray]) -> Option<Point3<f64>> {
    let mut weights = vec![1.0; rays.len()];
    let mut point = None;
    for _ in 0..ROUNDS {
        let total: f64 = weights.iter().sum();
        let meeting = Meeting::of(rays.iter().zip(&weights).map(|(ray, weight)| (*ray, weight / total)));
        if !meeting.normal.iter().chain(&meeting.right).all(|entry| entry.is_finite())
            || SymmetricEigen::new(meeting.normal).eigenvalues.min() < LEAST_SPREAD
        {
            return None;
        }
        let met = meeting.point()?;
        let distances: Vec<f64> = rays.iter().map(|ray| (ray.across() * (met - ray.origin)).norm()).collect();
        let scale = median(distances.clone())?.max(1e-9);
        weights = distances.iter().map(|distance| 1.0 / (1.0 + (distance / (2.0 * scale)).powi(2))).collect();
        point = Some(met);
    }
    point
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
}

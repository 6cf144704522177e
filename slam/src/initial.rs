//! First values: dead reckoning for the robot, triangulation for the objects.

use crate::estimate::UnresolvedReason;
use crate::variable::{Key, Value, Values};
use nalgebra::Vector3;
use std::collections::VecDeque;
use vantage_dataset::ray::{Meeting, Ray};
use vantage_dataset::{Observations, Odometry, Pose};

/// The robot's poses by odometry alone, the first at the origin.
///
/// A step that no odometry reaches starts where the step before it is.
pub fn dead_reckoning(steps: usize, odometry: &[Odometry]) -> Vec<Pose> {
    let mut sorted: Vec<&Odometry> = odometry.iter().collect();
    sorted.sort_by_key(|o| (o.from, o.to));
    let mut motions: Vec<Vec<(usize, Pose)>> = vec![Vec::new(); steps];
    for o in sorted {
        motions[o.from].push((o.to, o.robot_from_robot));
        motions[o.to].push((o.from, o.robot_from_robot.inverse()));
    }
    let mut poses: Vec<Option<Pose>> = vec![None; steps];
    let mut previous = Pose::identity();
    let mut queue = VecDeque::new();
    for start in 0..steps {
        if poses[start].is_none() {
            poses[start] = Some(previous);
            queue.push_back((start, previous));
        }
        while let Some((at, world_from_robot)) = queue.pop_front() {
            for &(next, motion) in &motions[at] {
                if poses[next].is_none() {
                    let mut moved = world_from_robot * motion;
                    moved.rotation.renormalize();
                    poses[next] = Some(moved);
                    queue.push_back((next, moved));
                }
            }
        }
        previous = poses[start].unwrap_or(previous);
    }
    poses.into_iter().map(|pose| pose.unwrap_or(previous)).collect()
}

/// The robot's poses by odometry alone, as variables.
pub fn start_poses(observations: &Observations) -> Values {
    let mut values = Values::default();
    for (step, pose) in dead_reckoning(observations.steps(), &observations.odometry).into_iter().enumerate() {
        values.insert(Key::Robot(step), Value::Pose(pose));
    }
    values
}

/// The point nearest to all rays (least squares of the distances).
pub fn triangulate(rays: &[Ray], minimum_parallax: f64) -> Result<Vector3<f64>, UnresolvedReason> {
    if rays.len() < 2 {
        return Err(UnresolvedReason::SeenOnce);
    }
    let baseline = rays.iter().map(|r| (r.origin - rays[0].origin).norm()).fold(0.0, f64::max);
    if parallax(rays) < minimum_parallax || baseline < 1e-6 {
        return Err(UnresolvedReason::NoParallax);
    }
    let point =
        Meeting::of(rays.iter().map(|ray| (*ray, 1.0))).point().ok_or(UnresolvedReason::NoParallax)?.coords;
    if is_in_front(rays, &point) { Ok(point) } else { Err(UnresolvedReason::BehindCamera) }
}

/// Whether a point lies ahead on most of the rays.
pub fn is_in_front(rays: &[Ray], point: &Vector3<f64>) -> bool {
    2 * rays.iter().filter(|r| r.direction.dot(&(point - r.origin.coords)) > 0.0).count() > rays.len()
}

/// About the largest angle between two rays: that from the ray farthest from the first.
fn parallax(rays: &[Ray]) -> f64 {
    let farthest = |from: &Ray| {
        rays.iter()
            .map(|r| {
                (r, libm::atan2(from.direction.cross(&r.direction).norm(), from.direction.dot(&r.direction)))
            })
            .fold((*from, 0.0), |best, (r, angle)| if angle > best.1 { (*r, angle) } else { best })
    };
    farthest(&farthest(&rays[0]).0).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::Matrix6;

    fn ray(origin: Vector3<f64>, through: Vector3<f64>) -> Ray {
        Ray { origin: origin.into(), direction: (through - origin).normalize() }
    }

    #[test]
    fn rays_meet_where_they_cross() {
        let point = Vector3::new(1.0, 3.0, 0.5);
        let rays: Vec<Ray> = (0..4).map(|i| ray(Vector3::new(f64::from(i), 0.0, 0.0), point)).collect();
        assert_relative_eq!(triangulate(&rays, 0.03).unwrap(), point, epsilon = 1e-12);
    }

    #[test]
    fn rays_that_do_not_tell_depth_are_refused() {
        let (a, b) = (Vector3::zeros(), Vector3::x());
        let ahead = Vector3::y() * 5.0;
        assert_eq!(triangulate(&[], 0.03), Err(UnresolvedReason::SeenOnce));
        assert_eq!(triangulate(&[ray(a, ahead)], 0.03), Err(UnresolvedReason::SeenOnce));
        assert_eq!(triangulate(&[ray(a, ahead), ray(a, ahead)], 0.03), Err(UnresolvedReason::NoParallax));
        assert_eq!(
            triangulate(&[ray(a, a + ahead), ray(b, b + ahead)], 0.03),
            Err(UnresolvedReason::NoParallax)
        );
        let apart = [ray(a, Vector3::new(-1.0, 1.0, 0.0)), ray(b, Vector3::new(2.0, 1.0, 0.0))];
        assert_eq!(triangulate(&apart, 0.03), Err(UnresolvedReason::BehindCamera));
        let turning = [ray(a, Vector3::x()), ray(a, Vector3::y())];
        assert_eq!(triangulate(&turning, 0.03), Err(UnresolvedReason::NoParallax));
    }

    #[test]
    fn dead_reckoning_follows_odometry_either_way_and_bridges_gaps() {
        let motion = Pose::new(Vector3::x(), Vector3::z() * 0.3);
        let step = |from, to, robot_from_robot| Odometry {
            from,
            to,
            robot_from_robot,
            covariance: Matrix6::identity(),
        };
        let odometry = [step(2, 1, motion.inverse()), step(0, 1, motion), step(3, 4, motion)];
        let poses = dead_reckoning(5, &odometry);
        assert_relative_eq!(poses[2], motion * motion, epsilon = 1e-12);
        assert_relative_eq!(poses[3], poses[2], epsilon = 1e-12);
        assert_relative_eq!(poses[4], poses[2] * motion, epsilon = 1e-12);
        assert!(dead_reckoning(0, &[]).is_empty());
        assert_eq!(dead_reckoning(1, &[]), [Pose::identity()]);
    }
}

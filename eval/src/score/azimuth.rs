//! Azimuth error: the sides from which the robot saw its objects, and those from which it thinks that it did, radians.

use nalgebra::Point3;
use std::f64::consts::{FRAC_PI_2, PI};
use vantage_dataset::{ObjectTruth, Pose};

/// A detection that shows an object.
#[derive(Clone, Copy, Debug)]
pub struct SeenSide {
    /// When.
    pub step: usize,
    /// The number of the object that it shows.
    pub object: usize,
    /// The number of the estimated object that it was taken for.
    pub taken_for: Option<usize>,
}

/// Mean distance of the estimated azimuth from the true one over an object's views, mean over the objects that were seen.
///
/// The azimuth is the direction from the object's centre to the camera, about the vertical. Where an estimate has the object's front is free:
/// each object's azimuths are first turned by one angle, the circular mean of their differences. So what counts is by how much the side
/// changes between views, and no orientation is asked for. A view whose object the estimate lacks is off by a right angle, as by chance.
/// `truth` holds `world_from_robot` at each step and `robot_from_camera`, `estimate` poses and the objects' centres in the world. `None`
/// where nothing was seen.
pub fn azimuth_error(
    views: &[SeenSide],
    objects: &[ObjectTruth],
    truth: (&[Pose], &Pose),
    estimate: (&[Pose], &[Option<Point3<f64>>]),
) -> Option<f64> {
    let ((true_poses, mount), (poses, centers)) = (truth, estimate);
    let mut means = Vec::new();
    for (number, object) in objects.iter().enumerate() {
        let of_it = || views.iter().filter(|view| view.object == number);
        let off = |view: &SeenSide| {
            let center = (*centers.get(view.taken_for?)?)?;
            let true_center = object.world_from_object.translation.vector.into();
            let estimated = azimuth(&center, &(poses[view.step] * mount));
            Some(estimated - azimuth(&true_center, &(true_poses[view.step] * mount)))
        };
        let off: Vec<f64> = of_it().filter_map(off).collect();
        let sum = |of: fn(f64) -> f64| off.iter().map(|off| of(*off)).sum::<f64>();
        let turn = libm::atan2(sum(libm::sin), sum(libm::cos));
        let distances = off.iter().map(|off| ((off - turn + PI).rem_euclid(2.0 * PI) - PI).abs());
        let seen = of_it().count();
        let lost = (seen - off.len()) as f64 * FRAC_PI_2;
        if seen > 0 {
            means.push((distances.sum::<f64>() + lost) / seen as f64);
        }
    }
    (!means.is_empty()).then(|| means.iter().sum::<f64>() / means.len() as f64)
}

fn azimuth(center: &Point3<f64>, world_from_camera: &Pose) -> f64 {
    let camera = world_from_camera.translation.vector;
    libm::atan2(camera.y - center.y, camera.x - center.x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::Vector3;
    use vantage_dataset::{InstanceId, Symmetry};

    const CENTER: Point3<f64> = Point3::new(1.0, 2.0, 0.0);

    fn object() -> ObjectTruth {
        let world_from_object = Pose::new(CENTER.coords, Vector3::z());
        let (family, symmetry) = ("mug".to_owned(), Symmetry::None);
        ObjectTruth { instance: InstanceId(1), family, world_from_object, size: 0.2, symmetry, extents: None }
    }

    /// A robot whose camera, 0.5 m before it, is three metres from the object in such a direction and looks at it.
    fn robot(angle: f64) -> Pose {
        let back = Vector3::new(libm::cos(angle), libm::sin(angle), 0.0) * 3.5;
        Pose::new(CENTER.coords + back, Vector3::z() * (angle + PI))
    }

    fn error(
        estimated: &[Pose],
        views: &[(usize, Option<usize>)],
        centers: &[Option<Point3<f64>>],
    ) -> Option<f64> {
        let truth = [robot(0.1), robot(0.2), robot(3.0), robot(-3.1)];
        let views: Vec<SeenSide> =
            views.iter().map(|&(step, taken_for)| SeenSide { step, object: 0, taken_for }).collect();
        let mount = Pose::translation(0.5, 0.0, 0.0);
        azimuth_error(&views, &[object()], (&truth, &mount), (estimated, centers))
    }

    const ALL: [(usize, Option<usize>); 4] = [(0, Some(0)), (1, Some(0)), (2, Some(0)), (3, Some(0))];

    #[test]
    fn where_the_front_is_is_free_and_what_changes_between_views_counts() {
        let turned = |by: [f64; 4]| -> Vec<Pose> {
            [0.1, 0.2, 3.0, -3.1].iter().zip(by).map(|(angle, by)| robot(angle + by)).collect()
        };
        let center = [Some(CENTER)];
        assert_relative_eq!(error(&turned([0.0; 4]), &ALL, &center).unwrap(), 0.0, epsilon = 1e-12);
        assert_relative_eq!(error(&turned([2.0; 4]), &ALL, &center).unwrap(), 0.0, epsilon = 1e-12);
        // The second pass is half a radian off, against the first.
        assert_relative_eq!(
            error(&turned([0.0, 0.0, 0.5, 0.5]), &ALL, &center).unwrap(),
            0.25,
            epsilon = 1e-12
        );
        assert_relative_eq!(
            error(&turned([0.0, 0.0, 0.5, 0.5]), &ALL[..2], &center).unwrap(),
            0.0,
            epsilon = 1e-12
        );
        assert_eq!(error(&turned([0.0; 4]), &[], &center), None);
    }

    #[test]
    fn what_was_lost_is_off_by_chance_and_what_was_split_is_one() {
        let truth = [robot(0.1), robot(0.2), robot(3.0), robot(-3.1)];
        let lost = [(0, Some(0)), (1, Some(0)), (2, None), (3, Some(7))];
        assert_relative_eq!(error(&truth, &lost, &[Some(CENTER)]).unwrap(), FRAC_PI_2 / 2.0, epsilon = 1e-12);
        assert_relative_eq!(error(&truth, &ALL, &[None]).unwrap(), FRAC_PI_2, epsilon = 1e-12);
        let split = [(0, Some(0)), (1, Some(0)), (2, Some(1)), (3, Some(1))];
        let centers = [Some(CENTER), Some(CENTER)];
        assert_relative_eq!(error(&truth, &split, &centers).unwrap(), 0.0, epsilon = 1e-12);
    }
}

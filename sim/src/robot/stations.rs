//! Images taken at given places: the protocols of BigBIRD's turntable and of the Active Vision dataset.

use super::Drive;
use super::mount::looking;
use crate::error::SimError;
use crate::plan::body;
use crate::plan::ground::Ground;
use crate::scene::{PathSpec, RobotSpec};
use nalgebra::{Translation3, UnitQuaternion, Vector2, Vector3};
use std::f64::consts::PI;
use vantage_dataset::Pose;

/// Puts the camera at every station, a second apart.
pub fn visit(spec: &RobotSpec, ground: &Ground) -> Result<Drive, SimError> {
    let world_from_robot: Vec<Pose> = match &spec.path {
        PathSpec::Turntable { distance, elevations_deg, angles } => {
            let camera_from_robot = spec.camera.robot_from_camera().inverse();
            let cameras = turntable(*distance, elevations_deg, *angles, spec.camera.height);
            cameras.iter().map(|world_from_camera| world_from_camera * camera_from_robot).collect()
        }
        PathSpec::Grid { spacing, headings, clearance } => {
            let points = grid_points(*spacing, body::RADIUS + clearance, ground);
            if points.is_empty() {
                return Err(SimError::NoStation { clearance: *clearance });
            }
            points.iter().flat_map(|point| turns(point, *headings)).collect()
        }
        _ => return Err(SimError::NoTrack),
    };
    let timestamps = (0..world_from_robot.len()).map(|i| i as f64).collect();
    Ok(Drive { timestamps, world_from_robot, middle: 0.5, carried: None })
}

/// `world_from_camera` for each angle, and at each angle for each elevation: the camera looks at the point `height` metres
/// above the world's origin, and goes round as the object on the table would turn clockwise.
pub fn turntable(distance: f64, elevations_deg: &[f64], angles: u32, height: f64) -> Vec<Pose> {
    let camera = |angle: u32, elevation_deg: f64| {
        let azimuth = 2.0 * PI * f64::from(angle) / f64::from(angles);
        let elevation = elevation_deg.to_radians();
        let across = distance * libm::cos(elevation);
        let at = Translation3::new(
            across * libm::cos(azimuth),
            across * libm::sin(azimuth),
            height + distance * libm::sin(elevation),
        );
        Pose::from_parts(at, looking(azimuth + PI, -elevation))
    };
    (0..angles).flat_map(|angle| elevations_deg.iter().map(move |e| camera(angle, *e))).collect()
}

/// The free points of a grid through the origin, row by row.
pub fn grid_points(spacing: f64, margin: f64, ground: &Ground) -> Vec<Vector2<f64>> {
    let [columns, rows]: [i64; 2] = ground.half_extents().map(|half| (half / spacing) as i64).into();
    let at = |row: i64, column: i64| Vector2::new(column as f64, row as f64) * spacing;
    (-rows..=rows)
        .flat_map(|row| (-columns..=columns).map(move |column| at(row, column)))
        .filter(|point| ground.clearance(point) >= margin)
        .collect()
}

fn turns(point: &Vector2<f64>, headings: u32) -> impl Iterator<Item = Pose> {
    let at = Translation3::new(point.x, point.y, 0.0);
    (0..headings).map(move |i| {
        let heading = 2.0 * PI * f64::from(i) / f64::from(headings);
        Pose::from_parts(at, UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn every_camera_of_the_turntable_looks_at_the_object_upright() {
        let cameras = turntable(0.8, &[0.0, 30.0, 75.0], 8, 0.9);
        assert_eq!(cameras.len(), 24);
        for camera in &cameras {
            let seen = camera.inverse() * Point3::new(0.0, 0.0, 0.9);
            assert!(seen.coords.xy().norm() < 1e-9 && (seen.z - 0.8).abs() < 1e-9);
            assert!((camera * Vector3::y()).z < 0.0);
        }
        assert!((cameras[1].translation.z - 1.3).abs() < 1e-12);
    }

    #[test]
    fn two_turns_are_half_a_circle_apart() {
        let [east, west]: [Pose; 2] =
            turns(&Vector2::new(1.0, 2.0), 2).collect::<Vec<_>>().try_into().unwrap();
        assert!((east * Vector3::x() + west * Vector3::x()).norm() < 1e-9);
        assert_eq!(west.translation.vector, Vector3::new(1.0, 2.0, 0.0));
    }
}

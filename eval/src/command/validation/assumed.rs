//! Episodes whose odometry and boxes are as the estimator assumes them: what a right posterior is worth there.

use super::Trial;
use nalgebra::{Point3, Vector2};
use vantage_dataset::seed::Stream;
use vantage_dataset::{Observations, Seed, Tangent, se3};
use vantage_slam::Settings;

/// The trial's true path and objects, with odometry and centres of boxes drawn anew from the settings' own distributions. What stands
/// for no object stays.
pub fn as_assumed(Trial { observations, truth }: &Trial, settings: &Settings) -> Observations {
    let world = truth.objects.first().map_or(0, |object| object.instance.0);
    let mut stream = Seed(world).stream("as assumed", 0);
    let mut drawn = observations.clone();
    let shared = Vector2::from_fn(|_, _| stream.normal());
    for odometry in &mut drawn.odometry {
        let motion = truth.world_from_robot[odometry.from].inv_mul(&truth.world_from_robot[odometry.to]);
        odometry.robot_from_robot = motion;
        let bias = settings.odometry.bias;
        let white = bias.map_or(odometry.covariance, |bias| bias.white(odometry));
        let mut error = white.cholesky().map_or_else(Tangent::zeros, |root| root.l() * standard(&mut stream));
        error += bias.map_or_else(Tangent::zeros, |bias| bias.response(odometry) * shared);
        odometry.robot_from_robot = motion * se3::exp(&error);
    }
    let focal_length = drawn.camera.focal_length();
    for (number, detection) in drawn.detections.iter_mut().enumerate() {
        let Some(object) = truth.shown(number, detection) else { continue };
        let world_from_camera = truth.world_from_robot[detection.step] * drawn.robot_from_camera;
        let center = Point3::from(object.world_from_object.translation.vector);
        let Some(pixel) = drawn.camera.project(&world_from_camera.inverse_transform_point(&center)) else {
            continue;
        };
        let angular_size = detection.bounding_box.side() / focal_length;
        let sigma = settings.geometry.bearing_noise.sigma(angular_size) * focal_length;
        let center = pixel + Vector2::from_fn(|_, _| sigma * stream.normal());
        let shift = center - detection.bounding_box.center();
        detection.bounding_box.min += shift;
        detection.bounding_box.max += shift;
    }
    drawn
}

fn standard(stream: &mut Stream) -> Tangent {
    Tangent::from_fn(|_, _| stream.normal())
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_dataset::{Camera, Odometry, Pose, Truth};

    #[test]
    fn motion_is_off_by_its_covariance_and_no_more() {
        let path: Vec<Pose> = (0..2000).map(|i| Pose::translation(0.1 * f64::from(i), 0.0, 0.0)).collect();
        let covariance = nalgebra::Matrix6::identity() * 0.01f64.powi(2);
        let step =
            |from: usize| Odometry { from, to: from + 1, robot_from_robot: Pose::identity(), covariance };
        let observations = Observations {
            timestamps: (0..2000).map(f64::from).collect(),
            camera: Camera::with_horizontal_fov(64, 48, 1.0),
            robot_from_camera: Pose::identity(),
            odometry: (0..1999).map(step).collect(),
            detections: Vec::new(),
            landmarks: Vec::new(),
        };
        let truth = Truth {
            world_from_robot: path,
            objects: Vec::new(),
            landmarks: Vec::new(),
            detections: Vec::new(),
        };
        let drawn = as_assumed(&Trial { observations, truth }, &Settings::default());
        let off = |o: &Odometry| {
            se3::log(&Pose::translation(-0.1, 0.0, 0.0).inverse().inv_mul(&o.robot_from_robot))
        };
        let squares: f64 = drawn.odometry.iter().map(|o| off(o).norm_squared()).sum();
        let deviation = (squares / (6.0 * 1999.0)).sqrt();
        assert!((deviation / 0.01 - 1.0).abs() < 0.03, "{deviation}");
    }
}

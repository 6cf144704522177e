//! Every factor's derivatives against central differences, at residuals far from zero.

use crate::sensors::LinearClasses;
use crate::steerable::Steerable;
use nalgebra::{DVector, Matrix6, UnitQuaternion, Vector2, Vector3};
use vantage_dataset::{Camera, CenterDepth, LandmarkSighting, Odometry, Pose, Seed, Stream, Tangent, se3};
use vantage_model::{AzimuthReading, PairModel};
use vantage_slam::bearing_offset::BearingOffset;
use vantage_slam::discrepancy::Discrepant;
use vantage_slam::factor::semantic::SemanticScaling;
use vantage_slam::factor::{
    AzimuthFactor, BearingFactor, BetweenFactor, BiasedBetweenFactor, BoxEdgesFactor, ClassFactor,
    DepthFactor, ExtentsPrior, Factor, OffsetBearingFactor, PairFactor, PosePrior, ProjectionFactor,
    StandardNormalPrior, UprightFactor,
};
use vantage_slam::noise::Kernel;
use vantage_slam::odometry_bias::OdometryBias;
use vantage_slam::variable::{Value, Values};
use vantage_slam::{AzimuthDiscrepancy, Key};

const STEP: f64 = 1e-6;

/// Compares each block with central differences; returns the norm of the residual.
pub fn check(factor: &dyn Factor, values: &Values) -> f64 {
    let linear = factor.linearize(values).expect("the factor is defined here");
    let residual = factor.residual(values).unwrap();
    assert!((&linear.residual - &residual).amax() < 1e-12, "linearize and residual disagree");
    for (key, jacobian) in factor.keys().iter().zip(&linear.jacobians) {
        let dim = values.get(*key).unwrap().dim();
        assert_eq!(jacobian.shape(), (residual.len(), dim));
        for column in 0..dim {
            let at = |sign: f64| {
                let mut step = vec![0.0; dim];
                step[column] = sign * STEP;
                let mut moved = values.clone();
                moved.retract(*key, &step);
                factor.residual(&moved).unwrap()
            };
            let numeric = (at(1.0) - at(-1.0)) / (2.0 * STEP);
            let scale = 1.0 + numeric.amax();
            let difference = (numeric - jacobian.column(column)).amax() / scale;
            assert!(difference < 1e-6, "{key}, column {column}: off by {difference} of {scale}");
        }
    }
    residual.norm()
}

pub fn random_tangent(stream: &mut Stream, rotation: f64, translation: f64) -> Tangent {
    Tangent::from_fn(|i, _| if i < 3 { rotation } else { translation } * stream.normal())
}

fn random_information(stream: &mut Stream) -> Matrix6<f64> {
    Matrix6::from_fn(|i, j| if i == j { stream.uniform(5.0, 20.0) } else { stream.normal() })
}

#[test]
fn between() {
    let mut stream = Seed(1).stream("between", 0);
    for _ in 0..20 {
        let mut values = Values::default();
        for step in 0..2 {
            values.insert(Key::Robot(step), Value::Pose(se3::exp(&random_tangent(&mut stream, 0.8, 3.0))));
        }
        let measured = se3::exp(&random_tangent(&mut stream, 0.3, 1.0));
        let factor =
            BetweenFactor::new(Key::Robot(0), Key::Robot(1), measured, random_information(&mut stream));
        assert!(check(&factor, &values) > 1.0);
    }
}

#[test]
fn priors() {
    let mut stream = Seed(2).stream("prior", 0);
    for _ in 0..20 {
        let mut values = Values::default();
        values.insert(Key::Robot(0), Value::Pose(se3::exp(&random_tangent(&mut stream, 0.8, 3.0))));
        values.insert(Key::Latent(0), Value::Vector(DVector::from_fn(5, |_, _| stream.normal())));
        let mean = se3::exp(&random_tangent(&mut stream, 0.3, 1.0));
        let factor = PosePrior::new(Key::Robot(0), mean, random_information(&mut stream));
        assert!(check(&factor, &values) > 1.0);
        assert!(check(&StandardNormalPrior::new(Key::Latent(0)), &values) > 0.1);
    }
}

#[test]
fn upright() {
    let mut stream = Seed(3).stream("upright", 0);
    for _ in 0..20 {
        let mut values = Values::default();
        values.insert(Key::Object(0), Value::Pose(se3::exp(&random_tangent(&mut stream, 0.5, 3.0))));
        let reference = UnitQuaternion::from_scaled_axis(Vector3::z() * stream.uniform(-1.0, 1.0));
        for yaw_sigma in [UprightFactor::FREE_YAW, 0.05] {
            assert!(check(&UprightFactor::new(Key::Object(0), [0.05, yaw_sigma], reference), &values) > 0.1);
        }
    }
}

#[test]
fn bearing_to_points_and_poses_at_any_angle() {
    let mut stream = Seed(4).stream("bearing", 0);
    let mut widest: f64 = 0.0;
    for round in 0..200 {
        let mut values = Values::default();
        values.insert(Key::Robot(0), Value::Pose(se3::exp(&random_tangent(&mut stream, 1.0, 1.0))));
        let object = se3::exp(&random_tangent(&mut stream, 1.0, 3.0));
        let as_point = Value::Point(object.translation.vector);
        values.insert(Key::Object(0), if round % 2 == 0 { Value::Pose(object) } else { as_point });
        let ray = Vector3::new(stream.normal(), stream.normal(), 1.0);
        let mount = se3::exp(&random_tangent(&mut stream, 1.0, 0.2));
        let kernel = Kernel::Huber { threshold: 2.0 };
        let factor = BearingFactor::new(Key::Robot(0), Key::Object(0), mount, &ray, 1.0, kernel);
        widest = widest.max(check(&factor, &values));
    }
    assert!(widest > 2.0, "the test should meet objects behind the camera, the farthest was {widest}");
}

#[test]
fn depth_of_points_and_poses_on_either_side_of_the_camera() {
    let mut stream = Seed(7).stream("depth", 0);
    for round in 0..100 {
        let mut values = Values::default();
        values.insert(Key::Robot(0), Value::Pose(se3::exp(&random_tangent(&mut stream, 1.0, 1.0))));
        let object = se3::exp(&random_tangent(&mut stream, 1.0, 3.0));
        let as_point = Value::Point(object.translation.vector);
        values.insert(Key::Object(0), if round % 2 == 0 { Value::Pose(object) } else { as_point });
        let mount = se3::exp(&random_tangent(&mut stream, 1.0, 0.2));
        let depth = CenterDepth { meters: stream.uniform(10.0, 20.0), sigma: 0.3 };
        let factor =
            DepthFactor::new(Key::Robot(0), Key::Object(0), mount, depth, Kernel::Huber { threshold: 2.0 });
        assert!(check(&factor, &values) > 1.0);
    }
}

#[test]
fn edges_of_ellipsoids_at_points_and_poses_and_their_prior() {
    let mut stream = Seed(8).stream("edges", 0);
    for round in 0..100 {
        let robot = se3::exp(&random_tangent(&mut stream, 1.0, 1.0));
        let mount = se3::exp(&random_tangent(&mut stream, 1.0, 0.2));
        let ahead = Pose::translation(stream.normal(), stream.normal(), stream.uniform(1.5, 4.0));
        let object = robot * mount * ahead * se3::exp(&random_tangent(&mut stream, 1.0, 0.0));
        let mut values = Values::default();
        values.insert(Key::Robot(0), Value::Pose(robot));
        let as_point = Value::Point(object.translation.vector);
        values.insert(Key::Object(0), if round % 2 == 0 { Value::Pose(object) } else { as_point });
        let logs = DVector::from_fn(3, |_, _| stream.uniform(-3.0, -0.2));
        values.insert(Key::Extents(0), Value::Vector(logs));
        let edges = [-0.2, -0.1, 0.1, 0.3];
        let keys = [Key::Robot(0), Key::Object(0), Key::Extents(0)];
        let factor = BoxEdgesFactor::new(keys, mount, edges, 0.05, Kernel::Huber { threshold: 2.0 });
        assert!(check(&factor, &values) > 0.5);
        assert!(check(&ExtentsPrior::new(Key::Extents(0), 0.1, 0.5), &values) > 0.01);
        values.insert(Key::Extents(0), Value::Vector(DVector::from_element(3, 3.0)));
        assert!(factor.residual(&values).is_none(), "the camera is inside");
    }
}

#[test]
fn projection_of_landmarks_before_the_camera_and_none_behind() {
    let mut stream = Seed(6).stream("projection", 0);
    let camera = Camera { width: 640, height: 480, fx: 500.0, fy: 400.0, cx: 310.0, cy: 250.0 };
    let mut widest: f64 = 0.0;
    for _ in 0..100 {
        let robot = se3::exp(&random_tangent(&mut stream, 1.0, 2.0));
        let mount = se3::exp(&random_tangent(&mut stream, 1.0, 0.2));
        let p = Vector3::new(stream.normal(), stream.normal(), stream.uniform(0.5, 4.0));
        let pixel = Vector2::new(stream.uniform(0.0, 640.0), stream.uniform(0.0, 480.0));
        let sighting = LandmarkSighting { step: 2, landmark: 7, pixel, sigma: 30.0 };
        let factor = ProjectionFactor::new(&sighting, camera, mount, Kernel::Huber { threshold: 2.0 });
        let at = |z: f64| {
            let mut values = Values::default();
            values.insert(Key::Robot(2), Value::Pose(robot));
            let point = (robot * mount).transform_point(&Vector3::new(p.x, p.y, z).into());
            values.insert(Key::Landmark(7), Value::Point(point.coords));
            values
        };
        widest = widest.max(check(&factor, &at(p.z)));
        assert!(factor.residual(&at(-p.z)).is_none() && factor.linearize(&at(-p.z)).is_none());
    }
    assert!(widest > 10.0, "the farthest was {widest}");
}

#[test]
fn a_bearing_residual_is_the_image_error_over_sigma_to_first_order() {
    let mut values = Values::default();
    values.insert(Key::Robot(0), Value::Pose(Pose::identity()));
    values.insert(Key::Object(0), Value::Point(Vector3::new(1.2, -0.6, 2.0)));
    let at = |du: f64, dv: f64| {
        let ray = Vector3::new(0.6 + du, -0.3 + dv, 1.0);
        let keys = (Key::Robot(0), Key::Object(0));
        let factor = BearingFactor::new(keys.0, keys.1, Pose::identity(), &ray, 0.01, Kernel::Gaussian);
        factor.residual(&values).unwrap().norm()
    };
    assert!(at(0.0, 0.0) < 1e-12);
    for (du, dv) in [(1e-4, 0.0), (0.0, 1e-4), (6e-5, -8e-5)] {
        assert!((at(du, dv) - 0.01).abs() < 1e-5, "{}", at(du, dv));
    }
}

#[test]
fn pair() {
    pair_of(&Steerable::of_pairs(Seed(9)));
}

#[test]
fn pair_with_a_discrepancy() {
    let model = Steerable::of_pairs(Seed(9));
    pair_of(&Discrepant::new(&model, &AzimuthDiscrepancy { sigma: 0.3, concentration: 2.0 }));
}

fn pair_of(model: &dyn PairModel) {
    let mut stream = Seed(9).stream("pair", 0);
    let mut tested = 0;
    while tested < 20 {
        let mut values = Values::default();
        let mount = se3::exp(&random_tangent(&mut stream, 0.5, 0.2));
        let object = se3::exp(&random_tangent(&mut stream, 1.0, 1.0));
        for step in 0..2 {
            let camera = object
                * se3::exp(&random_tangent(&mut stream, 1.0, 0.1))
                * Pose::translation(stream.normal() * 0.3, stream.normal() * 0.3, -2.0);
            values.insert(Key::Robot(step), Value::Pose(camera * mount.inverse()));
        }
        let as_point = Value::Point(object.translation.vector);
        values.insert(Key::Object(0), if tested % 2 == 0 { Value::Pose(object) } else { as_point });
        let latent = DVector::from_fn(model.latent_dim(), |_, _| stream.normal());
        values.insert(Key::Latent(0), Value::Vector(latent));
        let measured = [0; 2].map(|_| DVector::from_fn(4, |_, _| stream.normal()));
        let scaling = SemanticScaling { noise: 1.3, information: 0.7 };
        let keys = [Key::Robot(0), Key::Robot(1), Key::Object(0), Key::Latent(0)];
        let factor = PairFactor::new(keys, model, measured, mount, 0.4, scaling);
        if factor.residual(&values).is_some() {
            assert!(check(&factor, &values) > 1.0);
            tested += 1;
        }
    }
}

#[test]
fn bearing_with_an_offset() {
    let mut stream = Seed(6).stream("offset bearing", 0);
    let offset = BearingOffset { horizontal: 0.3, vertical: 0.7, length: 0.6, smoothness: 2.0 };
    for round in 0..100 {
        let mut values = Values::default();
        values.insert(Key::Robot(0), Value::Pose(se3::exp(&random_tangent(&mut stream, 1.0, 1.0))));
        let object = se3::exp(&random_tangent(&mut stream, 1.0, 3.0));
        let as_point = Value::Point(object.translation.vector);
        values.insert(Key::Object(0), if round % 2 == 0 { Value::Pose(object) } else { as_point });
        let coefficients = DVector::from_fn(OffsetBearingFactor::dim(&offset), |_, _| stream.normal());
        values.insert(Key::Offset(0), Value::Vector(coefficients));
        let ray = Vector3::new(stream.normal(), stream.normal(), 1.0);
        let mount = se3::exp(&random_tangent(&mut stream, 1.0, 0.2));
        let kernel = Kernel::Huber { threshold: 2.0 };
        let bearing = BearingFactor::new(Key::Robot(0), Key::Object(0), mount, &ray, 1.0, kernel);
        let without = bearing.residual(&values).unwrap();
        let factor = OffsetBearingFactor::new(bearing, 0, &offset, 0.8, 1.0);
        check(&factor, &values);
        assert!((factor.residual(&values).unwrap() - without).norm() > 1e-3, "the offset counts");
    }
}

#[test]
fn an_offset_moves_the_box_that_is_expected() {
    let offset = BearingOffset { horizontal: 0.02, vertical: 0.05, length: 100.0, smoothness: 2.0 };
    let mut values = Values::default();
    values.insert(Key::Robot(0), Value::Pose(Pose::identity()));
    values.insert(Key::Object(0), Value::Point(Vector3::new(0.6, -0.3, 2.0)));
    let mut coefficients = DVector::zeros(OffsetBearingFactor::dim(&offset));
    let constant = [0, coefficients.len() / 2];
    (coefficients[constant[0]], coefficients[constant[1]]) = (2.0, -1.0);
    values.insert(Key::Offset(0), Value::Vector(coefficients));
    let (size, sigma) = (0.1, 0.001);
    let expected = Vector3::new(0.3 + size * 0.02 * 2.0, -0.15 - size * 0.05, 1.0);
    let bearing = BearingFactor::new(
        Key::Robot(0),
        Key::Object(0),
        Pose::identity(),
        &expected,
        sigma,
        Kernel::Gaussian,
    );
    let factor = OffsetBearingFactor::new(bearing, 0, &offset, size, sigma);
    assert!(factor.residual(&values).unwrap().norm() < 0.02, "{}", factor.residual(&values).unwrap());
}

#[test]
fn biased_between() {
    let mut stream = Seed(7).stream("biased between", 0);
    let bias = OdometryBias { translation_per_metre: 0.2, rotation_deg_per_metre: 20.0 };
    for _ in 0..20 {
        let mut values = Values::default();
        for step in 0..2 {
            values.insert(Key::Robot(step), Value::Pose(se3::exp(&random_tangent(&mut stream, 0.8, 3.0))));
        }
        values.insert(Key::OdometryBias, Value::Vector(DVector::from_fn(2, |_, _| stream.normal())));
        let robot_from_robot = se3::exp(&random_tangent(&mut stream, 0.3, 1.0));
        let odometry = Odometry { from: 0, to: 1, robot_from_robot, covariance: Matrix6::identity() };
        let (from, to) = (Key::Robot(0), Key::Robot(1));
        let information = random_information(&mut stream);
        let response = bias.response(&odometry);
        let factor = BiasedBetweenFactor::new(from, to, robot_from_robot, information, &response);
        assert!(check(&factor, &values) > 1.0);
    }
}

#[test]
fn a_bias_explains_the_error_that_it_makes() {
    let bias = OdometryBias { translation_per_metre: 0.1, rotation_deg_per_metre: 5.0 };
    let motion = Pose::new(Vector3::new(0.5, 0.0, 0.0), Vector3::z() * 0.1);
    let plain = Odometry { from: 0, to: 1, robot_from_robot: motion, covariance: Matrix6::identity() };
    let numbers = Vector2::new(1.5, -0.5);
    let measured = motion * se3::exp(&(bias.response(&plain) * numbers));
    let biased = Odometry { robot_from_robot: measured, ..plain };
    let mut values = Values::default();
    values.insert(Key::Robot(0), Value::Pose(Pose::identity()));
    values.insert(Key::Robot(1), Value::Pose(motion));
    values.insert(Key::OdometryBias, Value::Vector(DVector::from_column_slice(numbers.as_slice())));
    let response = bias.response(&biased);
    let keys = (Key::Robot(0), Key::Robot(1));
    let factor = BiasedBetweenFactor::new(keys.0, keys.1, measured, Matrix6::identity(), &response);
    let unexplained = se3::log(&measured.inv_mul(&motion)).norm();
    assert!(unexplained > 0.05 && factor.residual(&values).unwrap().norm() < 0.2 * unexplained);
}

#[test]
fn azimuth_and_class() {
    let mut stream = Seed(6).stream("azimuth", 0);
    let model = LinearClasses::new(3, 5, 0.2, Seed(6));
    let mut tested = 0;
    while tested < 20 {
        let mut values = Values::default();
        let robot = se3::exp(&random_tangent(&mut stream, 0.5, 1.0));
        let mount = se3::exp(&random_tangent(&mut stream, 0.5, 0.2));
        let ahead = robot * mount * Pose::translation(stream.normal() * 0.3, stream.normal() * 0.3, 2.0);
        values.insert(Key::Robot(0), Value::Pose(robot));
        values.insert(Key::Object(0), Value::Pose(ahead * se3::exp(&random_tangent(&mut stream, 1.0, 0.1))));
        let keys = [Key::Robot(0), Key::Object(0)];
        let measurement = DVector::from_fn(5, |_, _| stream.normal());
        let scaling = SemanticScaling { noise: 1.3, information: 0.7 };
        let of_class = ClassFactor::new(keys, (&model, tested % 3), measurement, mount, 0.4, scaling);
        if of_class.residual(&values).is_none() {
            continue;
        }
        assert!(check(&of_class, &values) > 1.0);
        let reading = AzimuthReading { azimuth: stream.uniform(-3.0, 3.0), sigma: 0.2 };
        let of_azimuth = AzimuthFactor::new(keys, reading, mount, 4.0, 0.7);
        let residual = check(&of_azimuth, &values);
        assert!(residual > 1e-3 && residual <= std::f64::consts::PI / 0.2);
        tested += 1;
    }
}

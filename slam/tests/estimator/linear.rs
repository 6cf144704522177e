//! The reduced sparse solution against the dense one, and marginals against the dense inverse.

use crate::model::TanhModel;
use nalgebra::{DMatrix, DVector, Matrix6, UnitQuaternion, Vector3};
use std::collections::BTreeMap;
use vantage_dataset::{Odometry, Pose, Seed, Tangent, se3};
use vantage_slam::Key;
use vantage_slam::bearing_offset::BearingOffset;
use vantage_slam::covariance::Marginals;
use vantage_slam::factor::semantic::SemanticScaling;
use vantage_slam::factor::{
    BearingFactor, BetweenFactor, BiasedBetweenFactor, OffsetBearingFactor, PosePrior, SemanticFactor,
    StandardNormalPrior, UprightFactor,
};
use vantage_slam::graph::Graph;
use vantage_slam::linear::{Memory, Structure, least_constrained};
use vantage_slam::noise::Kernel;
use vantage_slam::odometry_bias::OdometryBias;
use vantage_slam::variable::{Value, Values};

/// Four poses, odometry's bias, and two objects with latents, the second with an offset of its boxes too; it is not seen from the
/// first two poses.
fn small_graph(model: &TanhModel) -> (Graph<'_>, Values) {
    let mut stream = Seed(11).stream("small graph", 0);
    let mut graph = Graph::default();
    let mut values = Values::default();
    let mut random = |size: f64| Tangent::from_fn(|_, _| size * stream.normal());
    for step in 0..4 {
        let pose = Pose::translation(0.3 * step as f64, 0.0, 0.0) * se3::exp(&random(0.05));
        values.insert(Key::Robot(step), Value::Pose(pose));
    }
    for track in 0..2 {
        let pose = Pose::translation(0.2 + track as f64, 0.1, 3.0) * se3::exp(&random(0.05));
        values.insert(Key::Object(track), Value::Pose(pose));
        values.insert(Key::Latent(track), Value::Vector(DVector::from_fn(5, |i, _| 0.1 * i as f64)));
    }
    graph.push(PosePrior::new(Key::Robot(0), Pose::identity(), Matrix6::identity() * 100.0));
    for step in 1..4 {
        let motion = Pose::translation(0.3, 0.0, 0.0);
        let (from, to) = (Key::Robot(step - 1), Key::Robot(step));
        let odometry =
            Odometry { from: step - 1, to: step, robot_from_robot: motion, covariance: Matrix6::identity() };
        let bias = OdometryBias { translation_per_metre: 0.2, rotation_deg_per_metre: 10.0 };
        let information = Matrix6::identity() * 20.0;
        let response = bias.response(&odometry);
        graph.push(BiasedBetweenFactor::new(from, to, motion, information, &response));
    }
    values.insert(Key::OdometryBias, Value::Vector(DVector::from_element(2, 0.3)));
    graph.push(StandardNormalPrior::new(Key::OdometryBias));
    let offset = BearingOffset { horizontal: 0.2, vertical: 0.3, length: 1.0, smoothness: 2.0 };
    let coefficients = DVector::from_fn(OffsetBearingFactor::dim(&offset), |i, _| 0.2 - 0.1 * i as f64);
    values.insert(Key::Offset(1), Value::Vector(coefficients));
    graph.push(StandardNormalPrior::new(Key::Offset(1)));
    for (step, track) in [(0, 0), (1, 0), (2, 0), (2, 1), (3, 1)] {
        let (robot, object) = (Key::Robot(step), Key::Object(track));
        let ray = Vector3::new(0.1 * track as f64, 0.05, 1.0);
        let kernel = Kernel::Huber { threshold: 2.0 };
        let bearing = BearingFactor::new(robot, object, Pose::identity(), &ray, 0.1, kernel);
        match track {
            1 => graph.push(OffsetBearingFactor::new(bearing, 1, &offset, 0.3, 0.1)),
            _ => graph.push(bearing),
        }
        let measurement = DVector::from_fn(4, |i, _| 0.3 * (i + step) as f64 - 0.5);
        let scaling = SemanticScaling { noise: 1.0, information: 0.8 };
        let keys = [robot, object, Key::Latent(track)];
        graph.push(SemanticFactor::new(keys, model, measurement, Pose::identity(), 0.4, scaling));
    }
    for track in 0..2 {
        graph.push(StandardNormalPrior::new(Key::Latent(track)));
        graph.push(UprightFactor::new(
            Key::Object(track),
            [0.2, UprightFactor::FREE_YAW],
            UnitQuaternion::identity(),
        ));
    }
    (graph, values)
}

/// `H`, `g` and the first column of each variable, written out densely.
pub fn dense(graph: &Graph<'_>, values: &Values) -> (DMatrix<f64>, DVector<f64>, BTreeMap<Key, usize>) {
    let mut first = BTreeMap::new();
    let mut size = 0;
    for (key, value) in values.iter() {
        first.insert(key, size);
        size += value.dim();
    }
    let (mut hessian, mut gradient) = (DMatrix::zeros(size, size), DVector::zeros(size));
    for factor in graph.factors() {
        let linear = factor.linearize(values).unwrap();
        let s = linear.residual.norm_squared();
        let weight = factor.information_scale() * factor.kernel().weight(s, linear.residual.len());
        let mut row = DMatrix::zeros(linear.residual.len(), size);
        for (key, jacobian) in factor.keys().iter().zip(&linear.jacobians) {
            row.columns_mut(first[key], jacobian.ncols()).copy_from(jacobian);
        }
        hessian += weight * row.tr_mul(&row);
        gradient += weight * row.tr_mul(&linear.residual);
    }
    (hessian, gradient, first)
}

#[test]
fn a_step_solves_the_dense_normal_equations() {
    let model = TanhModel::new([5, 4, 8], 0.2, 3.0, Seed(12));
    let (graph, values) = small_graph(&model);
    let (hessian, gradient, first) = dense(&graph, &values);
    let structure = Structure::new(&graph, &values, |_| true).unwrap();
    for local in [Key::Latent(0), Key::Latent(1), Key::Offset(1)] {
        assert!(structure.local_index(local).is_some(), "{local} stays in the sparse system");
    }
    let system = structure.linearize(&graph, &values).unwrap();
    for lambda in [0.0, 1e-3, 1.0] {
        let mut damping = hessian.diagonal() * lambda;
        for (key, value) in values.iter().filter(|(key, _)| matches!(key, Key::Latent(_))) {
            damping.rows_mut(first[&key], value.dim()).scale_mut(1e4);
        }
        let damped = &hessian + DMatrix::from_diagonal(&damping);
        let expected = -damped.cholesky().unwrap().solve(&gradient);
        let predicted = -(gradient.dot(&expected) + expected.dot(&(&hessian * &expected)) / 2.0);
        let step = system.step(lambda, &mut Memory::default()).unwrap();
        assert!((step.predicted_decrease - predicted).abs() < 1e-8 * predicted, "lambda {lambda}");
        let moved = structure.retract(&values, &step);
        for (key, value) in values.iter() {
            let part = expected.rows(first[&key], value.dim()).into_owned();
            let (got, wanted) = (moved.get(key).unwrap(), value.retract(part.as_slice()));
            let close = match (got, &wanted) {
                (Value::Pose(a), Value::Pose(b)) => se3::log(&a.inv_mul(b)).norm() < 1e-7,
                (Value::Vector(a), Value::Vector(b)) => (a - b).norm() < 1e-7,
                _ => false,
            };
            assert!(close, "{key}: got {got:?}, expected {wanted:?}");
        }
    }
}

#[test]
fn held_variables_do_not_move() {
    let model = TanhModel::new([5, 4, 8], 0.2, 3.0, Seed(12));
    let (graph, values) = small_graph(&model);
    let structure = Structure::new(&graph, &values, |key| key == Key::Object(1)).unwrap();
    let step = structure.linearize(&graph, &values).unwrap().step(0.0, &mut Memory::default()).unwrap();
    let moved = structure.retract(&values, &step);
    for (key, value) in values.iter() {
        assert_eq!(moved.get(key) == Some(value), key != Key::Object(1), "{key}");
    }
}

#[test]
fn marginals_are_blocks_of_the_dense_inverse() {
    let model = TanhModel::new([5, 4, 8], 0.2, 3.0, Seed(12));
    let (graph, values) = small_graph(&model);
    let (hessian, _, first) = dense(&graph, &values);
    let inverse = hessian.cholesky().unwrap().inverse();
    let structure = Structure::new(&graph, &values, |_| true).unwrap();
    let system = structure.linearize(&graph, &values).unwrap();
    assert_eq!(least_constrained(&system, &mut Memory::default()), None);
    let marginals = Marginals::new(&system).unwrap();
    let keys = [Key::Robot(3), Key::Object(0), Key::Latent(0), Key::Robot(1)];
    for (key, block) in keys.iter().zip(marginals.covariances(&keys)) {
        let expected = inverse.view((first[key], first[key]), (6, 6));
        match block {
            Some(block) => assert!((&block - expected).amax() < 1e-8 * expected.amax(), "{key}"),
            None => assert_eq!(*key, Key::Latent(0)),
        }
    }
    for track in 0..2 {
        let expected = inverse.diagonal().rows(first[&Key::Latent(track)], 5).into_owned();
        let variance = marginals.latent_variance(Key::Latent(track)).unwrap();
        assert!((variance - expected).amax() < 1e-10);
    }
    assert_eq!(marginals.latent_variance(Key::Robot(0)), None);
}

#[test]
fn a_flat_direction_is_named() {
    let mut graph = Graph::default();
    let mut values = Values::default();
    for step in 0..3 {
        values.insert(Key::Robot(step), Value::Pose(Pose::translation(step as f64, 0.0, 0.0)));
    }
    graph.push(PosePrior::new(Key::Robot(0), Pose::identity(), Matrix6::identity()));
    for step in 1..3 {
        let motion = Pose::translation(1.0, 0.0, 0.0);
        graph.push(BetweenFactor::new(Key::Robot(step - 1), Key::Robot(step), motion, Matrix6::identity()));
    }
    values.insert(Key::Object(7), Value::Point(Vector3::new(0.3, 0.1, 2.0)));
    let ray = Vector3::new(0.1, 0.05, 1.0);
    let seen = |step| {
        BearingFactor::new(Key::Robot(step), Key::Object(7), Pose::identity(), &ray, 0.01, Kernel::Gaussian)
    };
    graph.push(seen(0));
    let near = |graph: &Graph<'_>| {
        let structure = Structure::new(graph, &values, |_| true).unwrap();
        least_constrained(&structure.linearize(graph, &values).unwrap(), &mut Memory::default())
    };
    assert_eq!(near(&graph), Some(Key::Object(7)));
    graph.push(seen(2));
    assert_eq!(near(&graph), None);
}

//! The growing problem against the whole one: solutions and marginals after every step, by dense algebra, and the maximum that the
//! tree settles at, with latents.

use crate::model::TanhModel;
use nalgebra::{DMatrix, DVector, Matrix6, UnitQuaternion, Vector3};
use std::collections::BTreeMap;
use vantage_dataset::{Pose, Seed, se3};
use vantage_slam::Outcome;
use vantage_slam::covariance::Marginals;
use vantage_slam::factor::semantic::SemanticScaling;
use vantage_slam::factor::{
    BearingFactor, BetweenFactor, Factor, PosePrior, SemanticFactor, StandardNormalPrior, UprightFactor,
};
use vantage_slam::graph::Graph;
use vantage_slam::incremental::{Place, Smoother, Term, Thresholds, Tree};
use vantage_slam::laplace::{log_evidence, log_evidence_of_all};
use vantage_slam::linear::Structure;
use vantage_slam::noise::Kernel;
use vantage_slam::solve::{Limits, solve};
use vantage_slam::variable::{Key, Value, Values};

/// A linear problem as it should be: all terms, solved at once.
#[derive(Default)]
struct Dense {
    dims: BTreeMap<usize, usize>,
    terms: BTreeMap<usize, Term>,
}

impl Dense {
    fn starts(&self) -> BTreeMap<usize, usize> {
        let mut next = 0;
        let start = |(&variable, dim): (&usize, &usize)| {
            next += dim;
            (variable, next - dim)
        };
        self.dims.iter().map(start).collect()
    }

    /// The solution and its covariance.
    fn solve(&self) -> (DVector<f64>, DMatrix<f64>) {
        let (starts, n) = (self.starts(), self.dims.values().sum());
        let (mut hessian, mut gradient) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for term in self.terms.values() {
            let mut whole = DMatrix::zeros(term.constant.len(), n);
            for (variable, jacobian) in term.variables.iter().zip(&term.jacobians) {
                whole.columns_mut(starts[variable], jacobian.ncols()).copy_from(jacobian);
            }
            hessian += whole.tr_mul(&whole);
            gradient += whole.tr_mul(&term.constant);
        }
        let covariance = hessian.cholesky().unwrap().inverse();
        (-&covariance * gradient, covariance)
    }

    fn check(&self, tree: &Tree) {
        let (solution, covariance) = self.solve();
        for (&variable, &start) in &self.starts() {
            let dim = self.dims[&variable];
            let got = DVector::from_column_slice(tree.solution(variable));
            let error = (got - solution.rows(start, dim)).amax();
            assert!(error < 1e-9, "variable {variable}: {error}");
            let got = tree.covariance(variable).unwrap();
            let expected = covariance.view((start, start), (dim, dim));
            let error = DMatrix::from_fn(dim, dim, |i, j| got[(i, j)] - expected[(i, j)]).amax();
            assert!(error < 1e-9, "covariance of variable {variable}: {error}");
        }
    }
}

#[test]
fn every_step_of_a_loop_has_the_solution_and_the_marginals_of_the_whole_problem() {
    let mut stream = Seed(3).stream("incremental", 0);
    let (mut tree, mut dense) = (Tree::default(), Dense::default());
    let mut random = |rows: usize, columns: usize| DMatrix::from_fn(rows, columns, |_, _| stream.normal());
    let add = |tree: &mut Tree, dense: &mut Dense, term: Term| {
        let index = tree.add_term(term.clone());
        dense.terms.insert(index, term);
        index
    };
    let bias = tree.add_variable(2, Place::Shared);
    dense.dims.insert(bias, 2);
    let prior = Term {
        variables: vec![bias],
        jacobians: vec![DMatrix::identity(2, 2)],
        constant: DVector::from_element(2, 0.3),
    };
    add(&mut tree, &mut dense, prior);
    let (steps, objects) = (40, 7);
    let mut poses: Vec<usize> = Vec::new();
    let mut seen: BTreeMap<usize, [usize; 2]> = BTreeMap::new();
    for step in 0..steps {
        let pose = tree.add_variable(3, Place::Chain);
        dense.dims.insert(pose, 3);
        let mut variables = vec![pose];
        variables.extend(poses.last());
        variables.push(bias);
        let jacobians = variables.iter().map(|v| random(4, if *v == bias { 2 } else { 3 })).collect();
        let constant = random(4, 1).column(0).into_owned();
        add(&mut tree, &mut dense, Term { variables, jacobians, constant });
        poses.push(pose);
        // Round twice, so that each object is seen again when it has long been out of view.
        let object = step / 3 % objects;
        let variables = *seen.entry(object).or_insert_with(|| {
            let made = [3, 5].map(|dim| (tree.add_variable(dim, Place::Object(object)), dim));
            dense.dims.extend(made);
            let jacobians = made.map(|(_, dim)| random(8, dim)).to_vec();
            let variables = made.map(|(variable, _)| variable);
            let constant = random(8, 1).column(0).into_owned();
            add(&mut tree, &mut dense, Term { variables: variables.to_vec(), jacobians, constant });
            variables
        });
        let jacobians = vec![random(4, 3), random(4, 3), random(4, 5)];
        let constant = random(4, 1).column(0).into_owned();
        let view = Term { variables: vec![pose, variables[0], variables[1]], jacobians, constant };
        let index = add(&mut tree, &mut dense, view.clone());
        if step % 5 == 4 {
            let jacobians = view.jacobians.iter().map(|j| j * 1.3).collect();
            let changed = Term { jacobians, ..view };
            tree.replace_term(index - 3, dense.terms[&(index - 3)].clone());
            tree.replace_term(index, changed.clone());
            dense.terms.insert(index, changed);
        }
        tree.factorize().unwrap();
        tree.solve(0.0);
        dense.check(&tree);
    }
    for object in [0, 4] {
        for term in tree.remove_object(object) {
            dense.terms.remove(&term);
        }
        seen[&object].iter().for_each(|variable| {
            dense.dims.remove(variable);
        });
    }
    tree.factorize().unwrap();
    tree.solve(0.0);
    dense.check(&tree);
}

/// Of a measurement's noise.
const SIGMA: f64 = 0.1;

/// A robot that passes two objects, with bearings and views that agree but for noise; values are the truth.
fn passing_two_objects(model: &TanhModel) -> (Graph<'_>, Values) {
    let mut stream = Seed(14).stream("passing", 0);
    let (mut graph, mut values) = (Graph::default(), Values::default());
    for track in 0..2 {
        let object = Pose::translation(0.6 + track as f64, 0.1, 3.0);
        values.insert(Key::Object(track), Value::Pose(object));
        values.insert(Key::Latent(track), Value::Vector(DVector::from_fn(5, |_, _| stream.normal())));
        graph.push(StandardNormalPrior::new(Key::Latent(track)));
        graph.push(UprightFactor::new(
            Key::Object(track),
            [0.2, UprightFactor::FREE_YAW],
            UnitQuaternion::identity(),
        ));
    }
    let motion = Pose::translation(0.3, 0.0, 0.0);
    for step in 0..8 {
        let robot = Pose::translation(0.3 * step as f64, 0.0, 0.0);
        values.insert(Key::Robot(step), Value::Pose(robot));
        match step.checked_sub(1).map(Key::Robot) {
            Some(before) => {
                let information = Matrix6::identity() * 20.0;
                graph.push(BetweenFactor::new(before, Key::Robot(step), motion, information));
            }
            None => graph.push(PosePrior::new(Key::Robot(0), robot, Matrix6::identity() * 100.0)),
        }
        for track in 0..2 {
            let keys = [Key::Robot(step), Key::Object(track), Key::Latent(track)];
            let place = values.get(keys[1]).unwrap().position().unwrap() - robot.translation.vector;
            let ray = place.normalize() + 0.03 * Vector3::new(stream.normal(), stream.normal(), 0.0);
            let kernel = Kernel::Huber { threshold: 2.0 };
            graph.push(BearingFactor::new(keys[0], keys[1], Pose::identity(), &ray, 0.05, kernel));
            let view = |measurement| {
                let scaling = SemanticScaling { noise: 1.0, information: 0.8 };
                SemanticFactor::new(keys, model, measurement, Pose::identity(), 0.4, scaling)
            };
            let predicted = view(DVector::zeros(12)).residual(&values).unwrap() * -SIGMA;
            graph.push(view(predicted + DVector::from_fn(12, |_, _| 0.5 * SIGMA * stream.normal())));
        }
    }
    (graph, values)
}

/// Every variable moved by numbers of a standard deviation.
fn away_from(values: &Values, deviation: f64, seed: Seed) -> Values {
    let mut stream = seed.stream("away", 0);
    let mut moved = values.clone();
    for (key, value) in values.iter() {
        let step: Vec<f64> = (0..value.dim()).map(|_| deviation * stream.normal()).collect();
        moved.retract(key, &step);
    }
    moved
}

#[test]
fn latents_settle_at_the_maximum_and_the_marginals_of_the_whole_problem() {
    let model = TanhModel::new([5, 12, 24], SIGMA, 30.0, Seed(12));
    let (graph, start) = passing_two_objects(&model);
    let limits = Limits { iterations: 500, tolerance: 1e-13 };
    let whole = solve(&graph, start, |_| true, limits);
    assert_eq!(whole.outcome, Outcome::Converged);
    let structure = Structure::new(&graph, &whole.values, |_| true).unwrap();
    let system = structure.linearize(&graph, &whole.values).unwrap();
    let marginals = Marginals::new(&system).unwrap();
    let keys: Vec<Key> = whole.values.iter().map(|(key, _)| key).collect();
    let dense = log_evidence(&graph, &whole.values, &keys).unwrap();
    let sparse = log_evidence_of_all(&graph, &whole.values).unwrap();
    assert!((sparse - dense).abs() < 1e-8, "{sparse} for {dense}");

    let first = away_from(&whole.values, 1e-3, Seed(13));
    let mut smoother =
        Smoother::new(Thresholds { relinearization: 0.01, propagation: 1e-5, iterations: 2, rejections: 8 });
    assert_eq!(smoother.add(passing_two_objects(&model).0, &first), 0);
    smoother.update().unwrap();
    assert!(smoother.settle(1e-14, 200).unwrap());
    for (key, value) in whole.values.iter() {
        let covariance = smoother.covariance(key).unwrap();
        let apart = match (value, smoother.values().get(key).unwrap()) {
            (Value::Pose(a), Value::Pose(b)) => {
                DVector::from_column_slice(se3::log(&a.inv_mul(b)).as_slice())
            }
            (Value::Vector(a), Value::Vector(b)) => b - a,
            other => panic!("{key}: {other:?}"),
        };
        let variance = covariance.diagonal();
        for (apart, variance) in apart.iter().zip(variance.iter()) {
            assert!(apart.abs() < 1e-5 * variance.sqrt(), "{key}: {apart} of {}", variance.sqrt());
        }
        let expected = match key {
            Key::Latent(_) | Key::Offset(_) => marginals.latent_variance(key).unwrap(),
            _ => marginals.covariances(&[key])[0].as_ref().unwrap().diagonal(),
        };
        for (got, expected) in variance.iter().zip(expected.iter()) {
            assert!((got / expected - 1.0).abs() < 1e-5, "{key}: variance {got}, expected {expected}");
        }
    }
}

/// From each of these starts batch Levenberg-Marquardt converges. Whole steps settle from no more than three quarters of them.
#[test]
fn far_from_the_maximum_steps_are_damped_and_settle() {
    let model = TanhModel::new([5, 12, 24], SIGMA, 30.0, Seed(12));
    let (graph, truth) = passing_two_objects(&model);
    let limits = Limits { iterations: 500, tolerance: 1e-13 };
    for seed in 0..20 {
        let first = away_from(&truth, 0.1, Seed(seed));
        assert_eq!(
            solve(&graph, first.clone(), |_| true, limits).outcome,
            Outcome::Converged,
            "start {seed}"
        );
        let thresholds =
            Thresholds { relinearization: 0.002, propagation: 2e-5, iterations: 2, rejections: 8 };
        let mut smoother = Smoother::new(thresholds);
        assert_eq!(smoother.add(passing_two_objects(&model).0, &first), 0);
        smoother.update().unwrap();
        assert!(smoother.settle(1e-6, 400).unwrap(), "start {seed}");
        let cost = graph.cost(smoother.values()).unwrap();
        let least = solve(&graph, smoother.values().clone(), |_| true, limits).cost;
        assert!(cost - least < 0.01, "start {seed}: {cost} nats, and {least} at the maximum there");
    }
}

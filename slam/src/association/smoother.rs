//! The estimate of one hypothesis over any factors: a smoother whose copies share their history.

use super::estimator::{Addition, LocalEstimator, Moved, Unsolved};
use super::local::Local;
use super::marginal::joint_covariance;
use super::places::Places;
use super::shared::Shared;
use super::tree::{Indefinite, Tree};
use super::whole::maximum;
use crate::factor::Factor;
use crate::incremental::Term;
use crate::variable::{Key, Value, Values};
use nalgebra::DVector;
use std::f64::consts::PI;
use std::rc::Rc;

/// When work is worth its while.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thresholds {
    /// Distance, in whitened numbers, of a factor's residual from what its linearisation says, from which on it is linearised anew.
    pub relinearization: f64,
    /// Change of a coordinate, radians or metres or deviations of a latent, below which what depends on it is left.
    pub propagation: f64,
    /// Most linearisations of a factor in one update.
    pub rounds: usize,
}

impl Default for Thresholds {
    fn default() -> Self {
        Self { relinearization: 0.1, propagation: 1e-4, rounds: 10 }
    }
}

#[derive(Clone, Debug)]
struct Variable {
    key: Key,
    /// Where its coordinates are 0.
    base: Value,
    value: Value,
}

/// A factor, and where it was linearised.
struct Linearization {
    /// Coordinates of its variables, one behind the other.
    at: Vec<f64>,
    /// How far the residual moves at most with each variable's coordinates.
    reach: Vec<f64>,
    /// Of the cost, what is not in the squares.
    offset: f64,
}

#[derive(Clone)]
struct Held<'m> {
    factor: Rc<dyn Factor + 'm>,
    linearization: Rc<Linearization>,
    /// Bound of the residual's change from which on it is looked at.
    next: f64,
}

/// The maximum of a posterior that grows, with its evidence and its marginals.
#[derive(Clone)]
pub struct SharedSmoother<'m> {
    thresholds: Thresholds,
    tree: Tree,
    places: Places,
    variables: Shared<Variable>,
    /// By their terms.
    factors: Shared<Held<'m>>,
    offset: f64,
    newest: Option<usize>,
}

impl<'m> SharedSmoother<'m> {
    /// Without variables.
    pub fn new(thresholds: Thresholds) -> Self {
        Self {
            thresholds,
            tree: Tree::default(),
            places: Places::default(),
            variables: Shared::default(),
            factors: Shared::default(),
            offset: 0.0,
            newest: None,
        }
    }

    /// All variables with their values.
    pub fn values(&self) -> impl Iterator<Item = (Key, &Value)> {
        self.variables.iter().map(|variable| (variable.key, &variable.value))
    }

    /// Factors taken in.
    pub fn factors(&self) -> usize {
        self.factors.len()
    }

    /// Fronts of the factorisation, and how many of them are one and the same in another estimate.
    pub fn shared_fronts(&self, other: &Self) -> (usize, usize) {
        self.tree.shared_fronts(&other.tree)
    }

    fn add_variable(&mut self, key: Key, value: &Value) {
        let variable = self.tree.add_variable(value.dim());
        self.places.insert(key, variable);
        self.variables.push(Variable { key, base: value.clone(), value: value.clone() });
        if matches!(key, Key::Robot(_)) {
            self.newest = Some(variable);
        }
    }

    fn local_values(&self, factor: &dyn Factor) -> Values {
        let mut values = Values::default();
        for &key in factor.keys() {
            if let Some(variable) = self.places.get(key) {
                values.insert(key, self.variables[variable].value.clone());
            }
        }
        values
    }

    /// A factor about the values.
    fn linearize(&self, factor: &dyn Factor) -> Option<(Term, Linearization)> {
        let mut linear = factor.linearize(&self.local_values(factor))?;
        let squared = linear.residual.norm_squared();
        let root = root_weight(factor, &linear.residual);
        let loss = factor.kernel().loss(squared, linear.residual.len());
        linear.residual *= root;
        let offset = factor.information_scale() * loss - linear.residual.norm_squared() / 2.0;
        let mut constant = linear.residual.clone();
        let mut term = Term { variables: Vec::new(), jacobians: Vec::new(), constant: DVector::zeros(0) };
        let (mut at, mut reach) = (Vec::new(), Vec::new());
        for (key, mut jacobian) in factor.keys().iter().zip(linear.jacobians) {
            let variable = self.places.get(*key)?;
            let coordinates = self.tree.solution(variable);
            jacobian *= root;
            for (column, x) in jacobian.column_iter().zip(coordinates) {
                constant.axpy(-x, &column, 1.0);
            }
            at.extend_from_slice(coordinates);
            reach.push(jacobian.norm());
            term.variables.push(variable);
            term.jacobians.push(jacobian);
        }
        term.constant = constant;
        Some((term, Linearization { at, reach, offset }))
    }

    fn relinearize(&mut self, index: usize) {
        let factor = Rc::clone(&self.factors[index].factor);
        let Some((term, linearization)) = self.linearize(&*factor) else { return };
        self.offset += linearization.offset - self.factors[index].linearization.offset;
        let held = self.factors.get_mut(index);
        held.linearization = Rc::new(linearization);
        held.next = self.thresholds.relinearization;
        self.tree.replace_term(index, term);
    }

    /// Bound of how far the residual is from where it was linearised.
    fn change(&self, index: usize) -> f64 {
        let linearization = &self.factors[index].linearization;
        let (mut start, mut bound) = (0, 0.0);
        for (&variable, reach) in self.tree.term(index).variables.iter().zip(&linearization.reach) {
            let coordinates = self.tree.solution(variable);
            let at = &linearization.at[start..start + coordinates.len()];
            let squared: f64 = coordinates.iter().zip(at).map(|(x, y)| (x - y) * (x - y)).sum();
            bound += reach * squared.sqrt();
            start += coordinates.len();
        }
        bound
    }

    /// Whether the residual is farther from its linearisation than the threshold.
    fn is_off(&mut self, index: usize) -> bool {
        let change = self.change(index);
        let held = &self.factors[index];
        if change <= held.next {
            return false;
        }
        let term = self.tree.term(index);
        let mut predicted = term.constant.clone();
        for (&variable, jacobian) in term.variables.iter().zip(&term.jacobians) {
            for (column, x) in jacobian.column_iter().zip(self.tree.solution(variable)) {
                predicted.axpy(*x, &column, 1.0);
            }
        }
        let Some(residual) = held.factor.residual(&self.local_values(&*held.factor)) else { return false };
        let root = root_weight(&*held.factor, &residual);
        let off = (residual * root - predicted).norm();
        let limit = self.thresholds.relinearization;
        if off > limit {
            return true;
        }
        // The error grows with the square of the change.
        let growth = (limit / off.max(1e-300)).sqrt().clamp(1.0, 2.0);
        self.factors.get_mut(index).next = change * growth;
        false
    }

    /// Poses are linearised about their value alone, so what depends on one that moved is linearised anew.
    fn rebase(&mut self, due: &mut Vec<usize>) {
        let mut extended = Vec::new();
        for &index in due.iter() {
            for place in 0..self.tree.term(index).variables.len() {
                let variable = self.tree.term(index).variables[place];
                let Variable { base, value, .. } = &self.variables[variable];
                if matches!(base, Value::Pose(_)) && base != value {
                    self.tree.reset(variable);
                    let moved = self.variables.get_mut(variable);
                    moved.base = moved.value.clone();
                    extended.extend_from_slice(self.tree.terms_of(variable));
                }
            }
        }
        due.extend(extended);
        due.sort_unstable();
        due.dedup();
    }

    /// Puts variables elsewhere, and linearises anew what joins them.
    fn set_down(&mut self, moved: &Moved) {
        let mut due = Vec::new();
        for (key, value) in moved.iter() {
            let Some(variable) = self.places.get(key) else { continue };
            self.tree.reset(variable);
            let held = self.variables.get_mut(variable);
            (held.base, held.value) = (value.clone(), value);
            due.extend_from_slice(self.tree.terms_of(variable));
        }
        due.sort_unstable();
        due.dedup();
        due.into_iter().for_each(|index| self.relinearize(index));
    }

    /// One step of Gauss and Newton; true where every factor is near its linearisation.
    fn step(&mut self) -> Result<bool, Unsolved> {
        let free = |Indefinite { variable }| Unsolved::Free(self.variables[variable].key);
        self.tree.factorize().map_err(free)?;
        let mut due = Vec::new();
        for variable in self.tree.solve(self.thresholds.propagation) {
            let coordinates = self.tree.solution(variable);
            let value = self.variables[variable].base.retract(coordinates);
            self.variables.get_mut(variable).value = value;
            due.extend_from_slice(self.tree.terms_of(variable));
        }
        due.sort_unstable();
        due.dedup();
        due.retain(|&index| self.is_off(index));
        self.rebase(&mut due);
        due.iter().for_each(|&index| self.relinearize(index));
        Ok(due.is_empty())
    }

    /// Solves all from some values by Levenberg and Marquardt: steps of Gauss and Newton did not settle, or met what nothing fixes.
    fn solve_all(&mut self, start: Shared<Variable>) -> Result<(), Unsolved> {
        let mut values = Values::default();
        start.iter().for_each(|variable| values.insert(variable.key, variable.value.clone()));
        let values = maximum(self.factors.iter().map(|held| &held.factor), values);
        for variable in 0..self.variables.len() {
            let Some(value) = values.get(self.variables[variable].key) else { continue };
            let held = self.variables.get_mut(variable);
            (held.base, held.value) = (value.clone(), value.clone());
            self.tree.reset(variable);
        }
        self.tree.forget();
        (0..self.factors.len()).for_each(|index| self.relinearize(index));
        self.step().map(|_| ())
    }
}

impl<'m> LocalEstimator<'m> for SharedSmoother<'m> {
    fn add(&mut self, addition: &Addition<'m>) -> Result<(), Unsolved> {
        let mut late = Vec::new();
        self.set_down(&addition.moved);
        for (key, value) in &addition.fresh {
            self.add_variable(*key, value);
        }
        for factor in &addition.factors {
            let first = factor.keys().first().copied().unwrap_or(Key::OdometryBias);
            let (term, linearization) = self.linearize(&**factor).ok_or(Unsolved::Undefined(first))?;
            late.extend(term.variables.iter().copied().filter(|&variable| {
                !matches!(self.variables[variable].key, Key::Robot(_)) || Some(variable) == self.newest
            }));
            self.offset += linearization.offset;
            self.tree.add_term(term);
            let linearization = Rc::new(linearization);
            let next = self.thresholds.relinearization;
            self.factors.push(Held { factor: Rc::clone(factor), linearization, next });
        }
        late.extend(self.newest);
        self.tree.expect(late);
        Ok(())
    }

    fn update(&mut self) -> Result<(), Unsolved> {
        let before = self.variables.clone();
        for _ in 0..self.thresholds.rounds {
            match self.step() {
                Ok(true) => return Ok(()),
                Ok(false) => {}
                // Whole steps led to where nothing is fixed.
                Err(_) => break,
            }
        }
        self.solve_all(before)
    }

    fn solve_anew(&mut self) -> Result<(), Unsolved> {
        self.solve_all(self.variables.clone())
    }

    fn log_evidence(&self) -> f64 {
        let (cost, log_det) = self.tree.minimum();
        self.tree.numbers() as f64 / 2.0 * libm::log(2.0 * PI) - cost - self.offset - log_det
    }

    fn value(&self, key: Key) -> Option<Value> {
        Some(self.variables[self.places.get(key)?].value.clone())
    }

    fn joint(&self, keys: &[Key]) -> Option<Local> {
        let variables: Option<Vec<usize>> = keys.iter().map(|key| self.places.get(*key)).collect();
        let variables = variables?;
        let covariance = joint_covariance(&self.tree, &variables)?;
        let named = keys.iter().zip(&variables).map(|(key, v)| (*key, self.variables[*v].value.clone()));
        Local::new(named.collect(), covariance)
    }

    fn distance(&self, other: &Self) -> f64 {
        let far = f64::INFINITY;
        let (Some(own), Some(newest)) = (self.newest, other.newest) else { return 0.0 };
        if self.variables[own].key != other.variables[newest].key {
            return far;
        }
        let (Value::Vector(a), Value::Vector(b)) =
            (&self.variables[own].value, &other.variables[newest].value)
        else {
            return far;
        };
        let root = joint_covariance(&self.tree, &[own]).and_then(nalgebra::Cholesky::new);
        root.map_or(far, |root| (b - a).dot(&root.solve(&(b - a))).sqrt())
    }
}

/// The square root of what multiplies the squared residual, by the kernel.
fn root_weight(factor: &dyn Factor, residual: &DVector<f64>) -> f64 {
    (factor.information_scale() * factor.kernel().weight(residual.norm_squared(), residual.len())).sqrt()
}

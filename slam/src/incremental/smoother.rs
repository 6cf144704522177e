//! The nonlinear problem over the tree: each factor keeps the linearisation that it has until its own residual says otherwise.

use super::chart::Chart;
use super::descent::Damping;
use super::linearized::{Linearization, Linearized, cost, root_weight};
use super::term::Term;
use super::tree::{Indefinite, Place, Tree};
use super::update::{Thresholds, Update};
use crate::factor::{Factor, LinearFactor};
use crate::graph::Graph;
use crate::variable::{Key, Value, Values};
use nalgebra::{DMatrix, DVector};
use std::collections::{BTreeMap, BTreeSet};

/// A posterior that grows, and its maximum.
pub struct Smoother<'m> {
    thresholds: Thresholds,
    pub(super) tree: Tree,
    pub(super) charts: Vec<Chart>,
    index: BTreeMap<Key, usize>,
    /// By their terms.
    pub(super) factors: Vec<Option<Linearized<'m>>>,
    pub(super) values: Values,
    /// Terms that are to be made anew.
    pub(super) waiting: BTreeSet<usize>,
    pub(super) damping: Damping,
}

impl<'m> Smoother<'m> {
    /// Without variables.
    pub fn new(thresholds: Thresholds) -> Self {
        Self {
            thresholds,
            tree: Tree::default(),
            charts: Vec::new(),
            index: BTreeMap::new(),
            factors: Vec::new(),
            values: Values::default(),
            waiting: BTreeSet::new(),
            damping: Damping::default(),
        }
    }

    /// The maximum as of the last update, with the first values of what was added since.
    pub fn values(&self) -> &Values {
        &self.values
    }

    /// Adds a variable at a first value.
    pub fn add_variable(&mut self, key: Key, value: Value) {
        let place = match key {
            Key::Object(track) | Key::Latent(track) | Key::Extents(track) | Key::Offset(track) => {
                Place::Object(2 * track)
            }
            Key::Landmark(landmark) => Place::Object(2 * landmark + 1),
            Key::OdometryBias | Key::Domain => Place::Shared,
            Key::Robot(_) => Place::Chain,
        };
        let variable = self.tree.add_variable(value.dim(), place);
        self.index.insert(key, variable);
        self.charts.push(Chart::new(key, value.dim()));
        self.values.insert(key, value);
    }

    /// Adds the factors of a graph, and variables that `first` has and that are new; returns the number of factors left out, since they
    /// are undefined there.
    pub fn add(&mut self, graph: Graph<'m>, first: &Values) -> usize {
        let mut left_out = 0;
        for factor in graph.into_factors() {
            for &key in factor.keys() {
                if let (false, Some(value)) = (self.index.contains_key(&key), first.get(key)) {
                    self.add_variable(key, value.clone());
                }
                if let (Some(&variable), Some(value)) = (self.index.get(&key), self.values.get(key)) {
                    self.charts[variable].anchor(value, factor.keys());
                }
            }
            match self.linearize(&*factor) {
                Some(near) => {
                    let at = numbers(&self.tree, &near.term).flatten().copied().collect();
                    let made = Linearized::new(factor, &near, at, self.thresholds.relinearization);
                    let index = self.tree.add_term(near.term);
                    self.factors.resize_with(index, || None);
                    self.factors.push(Some(made));
                }
                None => left_out += 1,
            }
        }
        left_out
    }

    /// Removes an object's variables and all their factors.
    pub fn remove_object(&mut self, track: usize) {
        for term in self.tree.remove_object(2 * track) {
            self.factors[term] = None;
            self.waiting.remove(&term);
        }
        for key in [Key::Object(track), Key::Latent(track), Key::Extents(track), Key::Offset(track)] {
            if let Some(variable) = self.index.remove(&key) {
                self.damping.forget(variable);
            }
            self.values.remove(key);
        }
    }

    /// Puts variables at other values; all factors are linearised anew when the maximum is brought up to date.
    pub fn move_to(&mut self, values: impl IntoIterator<Item = (Key, Value)>) {
        for (key, value) in values {
            if self.values.get(key).is_some_and(|now| now.is_like(&value)) {
                self.values.insert(key, value);
            }
        }
        self.waiting.extend(0..self.factors.len());
    }

    /// Brings the maximum up to date with what was added.
    pub fn update(&mut self) -> Result<Update, Indefinite> {
        self.update_until(self.thresholds, |_| false)
    }

    /// Updates until an undamped step promises to lower the cost by at most `promise` nats, or so many `iterations` had their step taken, or
    /// refused; true if one does.
    pub fn settle(&mut self, promise: f64, iterations: usize) -> Result<bool, Indefinite> {
        self.waiting.extend(0..self.factors.len());
        self.factors.iter_mut().flatten().for_each(Linearized::forget);
        let thresholds =
            Thresholds { relinearization: 0.0, propagation: 0.0, iterations, rejections: iterations };
        Ok(!self.update_until(thresholds, |decrease| decrease <= promise)?.is_unfinished)
    }

    /// Settles with some variables at other values; where that is not more probable, from where it was. True if all is settled.
    pub fn try_settle(
        &mut self,
        values: impl IntoIterator<Item = (Key, Value)>,
        promise: f64,
        iterations: usize,
    ) -> Result<bool, Indefinite> {
        let (best, cost) = (self.values.clone(), self.cost());
        self.move_to(values);
        let settled = self.settle(promise, iterations);
        let is_lower = self.cost().zip(cost).is_some_and(|(now, before)| now < before);
        match settled {
            Ok(is_settled) if is_lower => Ok(is_settled),
            _ => {
                self.move_to(best.iter().map(|(key, value)| (key, value.clone())));
                self.settle(promise, iterations)
            }
        }
    }

    /// Updates until nothing is left to do, or `is_enough` says so of what an undamped step promised.
    fn update_until(
        &mut self,
        thresholds: Thresholds,
        is_enough: impl Fn(f64) -> bool,
    ) -> Result<Update, Indefinite> {
        let Thresholds { relinearization: limit, propagation, iterations, rejections } = thresholds;
        let mut update = Update::default();
        let (mut taken, mut rejected, mut is_released) = (0, 0, false);
        self.damping.restore(&mut self.tree);
        loop {
            for term in std::mem::take(&mut self.waiting) {
                update.relinearized += usize::from(self.relinearize(term, limit));
            }
            self.tree.factorize()?;
            let solved = self.tree.solve(propagation);
            update.solved += solved.moved.len();
            let was_damped = !self.damping.is_none();
            let is_taken = self.judge(&solved, limit);
            *(if is_taken { &mut taken } else { &mut rejected }) += 1;
            let is_enough = is_enough(solved.decrease);
            let is_stuck = is_enough && was_damped && is_released;
            if is_enough {
                // Damping alone may make a promise small: asked again without, once.
                self.damping.release(&mut self.tree);
                is_released = true;
            } else if is_taken {
                is_released = false;
            }
            let is_done = is_taken && self.damping.is_none() && self.waiting.is_empty();
            update.is_unfinished = was_damped || !(is_done || is_enough);
            if !update.is_unfinished || is_stuck || taken >= iterations || rejected >= rejections {
                break;
            }
        }
        self.damping.lift(&mut self.tree);
        self.tree.factorize()?;
        Ok(update)
    }

    /// The negative log-posterior up to a constant, nats; `None` where any factor is undefined.
    pub fn cost(&self) -> Option<f64> {
        self.factors.iter().flatten().map(|linearized| linearized.factor.cost(&self.values)).sum()
    }

    /// The same with some variables at other values, of the factors that these are in.
    pub fn cost_with(&self, others: &Values) -> Option<f64> {
        let mut values = self.values.clone();
        others.iter().for_each(|(key, value)| values.insert(key, value.clone()));
        let factors = self.factors.iter().flatten().map(|linearized| &linearized.factor);
        let concerned = factors.filter(|factor| factor.keys().iter().any(|key| others.get(*key).is_some()));
        concerned.map(|factor| factor.cost(&values)).sum()
    }

    /// The covariance of a variable's right perturbation, of a point in the world; `None` of what is not there.
    pub fn covariance(&self, key: Key) -> Option<DMatrix<f64>> {
        let variable = *self.index.get(&key)?;
        let covariance = self.tree.covariance(variable)?;
        let n = covariance.nrows();
        let by_coordinates = DMatrix::from_fn(n, n, |i, j| (covariance[(i, j)] + covariance[(j, i)]) / 2.0);
        Some(match self.charts[variable].axes(&self.values) {
            Some(axes) => &axes * by_coordinates * axes.transpose(),
            None => by_coordinates,
        })
    }

    /// Linearises a factor anew; it is looked at again once its residual may be off by `limit`.
    fn relinearize(&mut self, index: usize, limit: f64) -> bool {
        let Some(linearized) = &self.factors[index] else { return false };
        let Some(near) = self.linearize(&*linearized.factor) else { return false };
        let at = numbers(&self.tree, &near.term).flatten().copied().collect();
        if let Some(linearized) = &mut self.factors[index] {
            linearized.renew(&near, at, limit);
        }
        self.tree.replace_term(index, near.term);
        true
    }

    /// A factor about the values; `None` where it is undefined.
    fn linearize(&self, factor: &dyn Factor) -> Option<Linearization> {
        let LinearFactor { mut residual, jacobians } = factor.linearize(&self.values)?;
        let (cost, root) = (cost(factor, &residual), root_weight(factor, &residual));
        residual *= root;
        let mut constant = residual.clone();
        let mut term = Term { variables: Vec::new(), jacobians: Vec::new(), constant: DVector::zeros(0) };
        for (key, jacobian) in factor.keys().iter().zip(jacobians) {
            let variable = *self.index.get(key)?;
            let coordinates = self.tree.solution(variable);
            let jacobian = self.charts[variable].by_coordinates(jacobian, &self.values) * root;
            constant -= &jacobian * DVector::from_column_slice(coordinates);
            term.variables.push(variable);
            term.jacobians.push(jacobian);
        }
        term.constant = constant;
        Some(Linearization { term, residual, cost })
    }
}

/// The numbers of a term's variables.
pub(super) fn numbers<'t>(tree: &'t Tree, term: &'t Term) -> impl Iterator<Item = &'t [f64]> {
    term.variables.iter().map(|&variable| tree.solution(variable))
}

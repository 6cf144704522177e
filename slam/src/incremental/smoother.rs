//! The nonlinear problem over the tree: each factor keeps the linearisation that it has until its own residual says otherwise.

use super::chart::Chart;
use super::term::Term;
use super::tree::{Indefinite, Place, Tree};
use crate::factor::{Factor, LinearFactor};
use crate::graph::Graph;
use crate::variable::{Key, Value, Values};
use nalgebra::{DMatrix, DVector, DVectorView};
use std::collections::{BTreeMap, BTreeSet};

/// When work is worth its while.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thresholds {
    /// Distance, in whitened numbers, of a factor's residual from that of its linearisation, from which on it is linearised anew.
    pub relinearization: f64,
    /// Change of a coordinate, radians, metres or deviations of a latent, below which what depends on it is left.
    pub propagation: f64,
    /// Most linearisations of a factor in one update.
    pub rounds: usize,
}

/// What an update did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Update {
    /// Factors linearised anew.
    pub relinearized: usize,
    /// Variables solved for.
    pub solved: usize,
    /// Whether some factors still wait to be linearised anew: the next update does so.
    pub is_unfinished: bool,
}

struct Linearized<'m> {
    factor: Box<dyn Factor + 'm>,
    /// The residual where the term was made, weighted as there.
    residual: DVector<f64>,
    /// Its variables, and how far the residual moves with each at most.
    reach: Vec<(usize, f64)>,
    /// Bound of how far the residual has moved since the term was made.
    path: f64,
    /// Where on that path it is looked at next.
    next: f64,
}

impl<'m> Linearized<'m> {
    /// Just made, to be looked at once the residual may have moved by `limit`.
    fn new(factor: Box<dyn Factor + 'm>, term: &Term, residual: DVector<f64>, limit: f64) -> Self {
        // The largest singular value is no more than this.
        let bound = |jacobian: &DMatrix<f64>| (jacobian * jacobian.transpose()).norm().sqrt();
        let reach = term.variables.iter().copied().zip(term.jacobians.iter().map(bound)).collect();
        Self { factor, residual, reach, path: 0.0, next: limit }
    }

    /// Takes note that a variable moved; true where it is time to look.
    fn move_on(&mut self, variable: usize, distance: f64) -> bool {
        let reach = self.reach.iter().find(|(of, _)| *of == variable).map_or(0.0, |(_, reach)| *reach);
        self.path += reach * distance;
        self.path > self.next
    }

    /// Looked at: the residual changed by `change` since the term was made, and is `off` the term by no more than `limit`, which is taken to
    /// grow with the square of the change.
    fn look_later(&mut self, change: f64, off: f64, limit: f64) {
        let growth = ((limit / off).sqrt() - 1.0).clamp(0.0, 1.0);
        self.next = self.path + limit.max(growth * change);
    }
}

/// A posterior that grows, and its maximum.
pub struct Smoother<'m> {
    thresholds: Thresholds,
    tree: Tree,
    charts: Vec<Chart>,
    index: BTreeMap<Key, usize>,
    /// By their terms.
    factors: Vec<Option<Linearized<'m>>>,
    values: Values,
    waiting: BTreeSet<usize>,
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
            Key::OdometryBias => Place::Shared,
            Key::Robot(_) => Place::Chain,
        };
        let variable = self.tree.add_variable(value.dim(), place);
        self.index.insert(key, variable);
        self.values.insert(key, value.clone());
        self.charts.push(Chart { key, base: value });
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
            }
            match self.linearize(&*factor) {
                Some((term, residual)) => {
                    let made = Linearized::new(factor, &term, residual, self.thresholds.relinearization);
                    let index = self.tree.add_term(term);
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
            self.index.remove(&key);
            self.values.remove(key);
        }
    }

    /// Brings the maximum up to date with what was added.
    pub fn update(&mut self) -> Result<Update, Indefinite> {
        self.update_within(self.thresholds)
    }

    /// Updates until no residual is farther than `relinearization` from its linearisation, or `rounds` are over; true if none is.
    pub fn settle(&mut self, relinearization: f64, rounds: usize) -> Result<bool, Indefinite> {
        self.waiting.extend(0..self.factors.len());
        let thresholds = Thresholds { relinearization, propagation: 0.0, rounds };
        Ok(!self.update_within(thresholds)?.is_unfinished)
    }

    fn update_within(&mut self, thresholds: Thresholds) -> Result<Update, Indefinite> {
        let mut update = Update::default();
        for round in 0.. {
            for term in std::mem::take(&mut self.waiting) {
                update.relinearized += usize::from(self.relinearize(term, thresholds.relinearization));
            }
            self.tree.factorize()?;
            let moved = self.tree.solve(thresholds.propagation);
            update.solved += moved.len();
            let mut due = Vec::new();
            for &(variable, distance) in &moved {
                let Chart { key, .. } = self.charts[variable];
                self.values.insert(key, self.charts[variable].at(self.tree.solution(variable)));
                let factors = &mut self.factors;
                due.extend(self.tree.terms_of(variable).filter(|&term| {
                    factors[term].as_mut().is_some_and(|factor| factor.move_on(variable, distance))
                }));
            }
            self.rebase(&moved);
            due.sort_unstable();
            due.dedup();
            due.retain(|term| self.is_off(*term, thresholds.relinearization));
            self.waiting.extend(due);
            if self.waiting.is_empty() || round + 1 >= thresholds.rounds {
                break;
            }
        }
        update.is_unfinished = !self.waiting.is_empty();
        Ok(update)
    }

    /// The covariance of a variable's right perturbation; `None` of what is not there.
    pub fn covariance(&self, key: Key) -> Option<DMatrix<f64>> {
        let variable = *self.index.get(&key)?;
        let covariance = self.tree.covariance(variable)?;
        let (n, coordinates) = (covariance.nrows(), self.tree.solution(variable));
        let by_coordinates = DMatrix::from_fn(n, n, |i, j| (covariance[(i, j)] + covariance[(j, i)]) / 2.0);
        let chart = &self.charts[variable];
        // d perturbation / d coordinates is the inverse of what `by_coordinates` multiplies with.
        let outward = chart.by_coordinates(DMatrix::identity(n, n), coordinates);
        Some(&outward * by_coordinates * outward.transpose())
    }

    /// Poses that have turned too far get a chart about where they are.
    fn rebase(&mut self, moved: &[(usize, f64)]) {
        for &(variable, _) in moved {
            if !self.charts[variable].is_left(self.tree.solution(variable)) {
                continue;
            }
            let Some(value) = self.values.get(self.charts[variable].key) else { continue };
            self.charts[variable].base = value.clone();
            self.tree.set_solution(variable, &vec![0.0; value.dim()]);
            let terms: Vec<usize> = self.tree.terms_of(variable).collect();
            self.waiting.extend(terms);
        }
    }

    /// Linearises a factor anew; it is looked at again once its residual may have moved by `limit`.
    fn relinearize(&mut self, index: usize, limit: f64) -> bool {
        let Some(linearized) = &self.factors[index] else { return false };
        let Some((term, residual)) = self.linearize(&*linearized.factor) else { return false };
        if let Some(Linearized { factor, .. }) = self.factors[index].take() {
            self.factors[index] = Some(Linearized::new(factor, &term, residual, limit));
        }
        self.tree.replace_term(index, term);
        true
    }

    /// A factor about the values, and its residual there; `None` where it is undefined.
    fn linearize(&self, factor: &dyn Factor) -> Option<(Term, DVector<f64>)> {
        let LinearFactor { mut residual, jacobians } = factor.linearize(&self.values)?;
        let root = root_weight(factor, &residual);
        residual *= root;
        let mut constant = residual.clone();
        let mut term = Term { variables: Vec::new(), jacobians: Vec::new(), constant: DVector::zeros(0) };
        for (key, jacobian) in factor.keys().iter().zip(jacobians) {
            let variable = *self.index.get(key)?;
            let coordinates = self.tree.solution(variable);
            let jacobian = self.charts[variable].by_coordinates(jacobian, coordinates) * root;
            constant -= &jacobian * DVector::from_column_slice(coordinates);
            term.variables.push(variable);
            term.jacobians.push(jacobian);
        }
        term.constant = constant;
        Some((term, residual))
    }

    /// Whether the residual is farther than `limit` from that of the linearisation.
    fn is_off(&mut self, index: usize, limit: f64) -> bool {
        let (Some(term), Some(linearized)) = (self.tree.term(index), &mut self.factors[index]) else {
            return false;
        };
        let mut predicted = term.constant.clone();
        for (&variable, jacobian) in term.variables.iter().zip(&term.jacobians) {
            predicted.gemv(
                1.0,
                jacobian,
                &DVectorView::from_slice(self.tree.solution(variable), jacobian.ncols()),
                1.0,
            );
        }
        let change = (&predicted - &linearized.residual).norm();
        // What did not change by more than the limit is taken as linear.
        let residual = if change <= limit { None } else { linearized.factor.residual(&self.values) };
        let off = residual.map_or(0.0, |residual| {
            let root = root_weight(&*linearized.factor, &residual);
            (residual * root - predicted).norm()
        });
        linearized.look_later(change, off, limit);
        off > limit
    }
}

/// The square root of what multiplies the squared residual, by the kernel.
fn root_weight(factor: &dyn Factor, residual: &DVector<f64>) -> f64 {
    (factor.information_scale() * factor.kernel().weight(residual.norm_squared(), residual.len())).sqrt()
}

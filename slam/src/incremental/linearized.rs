//! A factor with the linearisation that it has, and when it is to be looked at again.

use super::descent::Excess;
use super::term::Term;
use crate::factor::Factor;
use crate::variable::Values;
use nalgebra::{DMatrix, DVector, DVectorView};

/// Share of the limit that a residual is expected to be off by when it is looked at.
const EXPECTED: f64 = 0.25;
/// Of costs that are subtracted from each other, what rounding makes of the difference.
const ROUNDING: f64 = 1e-13;
/// The bound where it is looked at next, over that of the last time, at most.
const GROWTH: f64 = 2.0;

/// A factor, where its term was made and how far its residual may have moved since.
pub struct Linearized<'m> {
    /// The factor.
    pub factor: Box<dyn Factor + 'm>,
    /// The residual where the term was made, weighted as there.
    residual: DVector<f64>,
    /// The factor's cost there, nats.
    cost: f64,
    /// Its variables, and how far the residual moves with each at most.
    reach: Vec<(usize, f64)>,
    /// Numbers of its variables where the term was made.
    at: Vec<f64>,
    /// Bound of how far the residual is from where the term was made, to first order.
    path: f64,
    /// Whether its variables stayed where the term was made, as far as it was looked at.
    is_fresh: bool,
    /// The bound at which it is looked at next.
    next: f64,
    /// The bound where it was seen last, and how far the residual was off the term there.
    seen: (f64, f64),
}

/// What a look at a factor tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// The norm of the difference of the weighted residual from that of the term.
    pub off: f64,
    /// By how much the factor's cost rose more than the term's since that was made.
    pub excess: Excess,
}

/// A factor near a point: its term, and its weighted residual and cost there.
pub struct Linearization {
    /// Over coordinates.
    pub term: Term,
    /// `[n]`.
    pub residual: DVector<f64>,
    /// Nats.
    pub cost: f64,
}

impl<'m> Linearized<'m> {
    /// A new factor, to be looked at once its residual may have moved by `limit`.
    pub fn new(factor: Box<dyn Factor + 'm>, of: &Linearization, at: Vec<f64>, limit: f64) -> Self {
        let (reach, residual) = (reach(&of.term), of.residual.clone());
        Self {
            factor,
            residual,
            cost: of.cost,
            reach,
            at,
            path: 0.0,
            is_fresh: true,
            next: limit,
            seen: (0.0, 0.0),
        }
    }

    /// Linearised anew; its residual is taken to bend as it did before.
    pub fn renew(&mut self, of: &Linearization, at: Vec<f64>, limit: f64) {
        self.residual.clone_from(&of.residual);
        self.cost = of.cost;
        self.reach = reach(&of.term);
        self.at = at;
        self.path = 0.0;
        self.is_fresh = true;
        self.next = limit.max(self.expected(limit));
    }

    /// Where the residual is taken to be off by its share of `limit`, if that grows with the square of the bound.
    fn expected(&self, limit: f64) -> f64 {
        let (path, off) = self.seen;
        path * (EXPECTED * limit / off).sqrt().min(GROWTH)
    }

    /// Takes note that a variable moved by a distance.
    pub fn move_on(&mut self, variable: usize, distance: f64) {
        let reach = self.reach.iter().find(|(of, _)| *of == variable).map_or(0.0, |(_, reach)| *reach);
        self.path += reach * distance;
    }

    /// Takes note of where its variables are: nearer to where the term was made than the ways that they went may be long.
    pub fn move_to<'a>(&mut self, numbers: impl Iterator<Item = &'a [f64]>) {
        let mut at = self.at.as_slice();
        self.path = 0.0;
        for ((_, reach), now) in self.reach.iter().zip(numbers) {
            let (before, rest) = at.split_at(now.len());
            at = rest;
            let square: f64 = now.iter().zip(before).map(|(now, before)| (now - before).powi(2)).sum();
            self.path += reach * square.sqrt();
        }
    }

    /// Whether its variables are where the term was made; taken note of.
    pub fn is_fresh(&mut self) -> bool {
        self.is_fresh = self.path == 0.0;
        self.is_fresh
    }

    /// Whether it is time to look.
    pub fn is_due(&self) -> bool {
        self.path > self.next
    }

    /// Does away with what earlier looks told.
    pub fn forget(&mut self) {
        self.seen = (0.0, 0.0);
    }

    /// How far the factor is off its term at `values`, of coordinates `numbers`; `None` where it did not move by more than `limit`,
    /// and is taken as linear.
    pub fn look<'a>(
        &self,
        term: &Term,
        numbers: impl Iterator<Item = &'a [f64]>,
        values: &Values,
        limit: f64,
    ) -> Option<Look> {
        let mut predicted = term.constant.clone();
        for (jacobian, numbers) in term.jacobians.iter().zip(numbers) {
            predicted.gemv(1.0, jacobian, &DVectorView::from_slice(numbers, numbers.len()), 1.0);
        }
        if (&predicted - &self.residual).norm() <= limit {
            return None;
        }
        // It may have been off by less than the limit before.
        let before = if self.is_fresh { 0.0 } else { limit * self.residual.norm() };
        let undefined = Look { off: f64::INFINITY, excess: Excess { nats: f64::INFINITY, doubt: 0.0 } };
        let Some(residual) = self.factor.residual(values) else { return Some(undefined) };
        let (now, root) = (cost(&*self.factor, &residual), root_weight(&*self.factor, &residual));
        let parts = [now, -self.cost, -predicted.norm_squared() / 2.0, self.residual.norm_squared() / 2.0];
        Some(Look {
            off: (residual * root - predicted).norm(),
            excess: Excess {
                nats: parts.iter().sum(),
                doubt: ROUNDING * parts.iter().map(|part| part.abs()).sum::<f64>() + before,
            },
        })
    }

    /// Looked at where its variables stay, and off its term by so much, or by nothing worth telling: says when next.
    pub fn look_later(&mut self, off: Option<f64>, limit: f64) {
        self.is_fresh = false;
        let next = match off {
            Some(off) => {
                self.seen = (self.path, off);
                self.expected(limit)
            }
            None => GROWTH * self.path,
        };
        self.next = next.max(self.path + limit);
    }

    /// It is not to be looked at until it is linearised anew.
    pub fn look_no_more(&mut self) {
        self.next = f64::INFINITY;
    }
}

/// The variables of a term, and bounds of the largest singular values of their derivatives.
fn reach(term: &Term) -> Vec<(usize, f64)> {
    let bound = |jacobian: &DMatrix<f64>| (jacobian * jacobian.transpose()).norm().sqrt();
    term.variables.iter().copied().zip(term.jacobians.iter().map(bound)).collect()
}

/// A factor's cost at a residual, nats.
pub fn cost(factor: &dyn Factor, residual: &DVector<f64>) -> f64 {
    factor.information_scale() * factor.kernel().loss(residual.norm_squared(), residual.len())
}

/// The square root of what multiplies the squared residual, by the kernel.
pub fn root_weight(factor: &dyn Factor, residual: &DVector<f64>) -> f64 {
    (factor.information_scale() * factor.kernel().weight(residual.norm_squared(), residual.len())).sqrt()
}

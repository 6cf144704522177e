//! A Gaussian over a few variables: what a choice is judged by before anything is solved.

use super::estimator::Moved;
use crate::factor::{Factor, LinearFactor};
use crate::variable::{Key, Value, Values};
use nalgebra::{Cholesky, DMatrix, DVector};
use std::f64::consts::PI;
use std::rc::Rc;

/// Most linearisations of a choice.
const ROUNDS: usize = 5;
/// Distance of whitened residuals from their linearisation that counts as none.
const SETTLED: f64 = 1e-3;

/// The joint marginal of a few variables: `value * Exp(d)`, or a sum, with `d` normal about 0.
#[derive(Clone, Debug)]
pub struct Local {
    keys: Vec<Key>,
    starts: Vec<usize>,
    values: Values,
    /// Of `d`, `[n x n]`.
    covariance: DMatrix<f64>,
}

/// Factors weighed against a [`Local`].
#[derive(Clone, Debug)]
pub struct Weighed {
    /// `log` of the integral of `exp(-cost)` over the marginal and over the new variables.
    pub log_evidence: f64,
    /// Twice the cost at the maximum: of Gaussian factors, the squared Mahalanobis distance.
    pub distance: f64,
    /// What the factors do to the marginal.
    effect: Effect,
}

/// The maximum is at `-C J^T gain`, and `C J^T information J C^T` is taken off the covariance; `C` is that of all variables with those joined.
#[derive(Clone, Debug)]
struct Effect {
    columns: Vec<usize>,
    jacobian: DMatrix<f64>,
    gain: DVector<f64>,
    information: DMatrix<f64>,
}

/// All factors of a choice about some values, one below the other.
struct Stacked {
    residual: DVector<f64>,
    /// By the variables of the marginal that they join.
    old: DMatrix<f64>,
    /// By the new variables.
    new: DMatrix<f64>,
    /// Of the cost, what is not in the squares.
    offset: f64,
}

impl Local {
    /// A marginal of these variables with this covariance, `[n x n]`; `None` where it is of another size or not finite.
    pub fn new(variables: Vec<(Key, Value)>, covariance: DMatrix<f64>) -> Option<Self> {
        let mut starts = vec![0];
        let mut keys = Vec::new();
        let mut values = Values::default();
        for (key, value) in variables {
            starts.push(starts[keys.len()] + value.dim());
            keys.push(key);
            values.insert(key, value);
        }
        let n = starts[keys.len()];
        let fits = covariance.shape() == (n, n) && covariance.iter().all(|x| x.is_finite());
        fits.then_some(Self { keys, starts, values, covariance })
    }

    /// The values at the maximum.
    pub fn values(&self) -> &Values {
        &self.values
    }

    /// The covariance of a variable, `[dim x dim]`.
    pub fn covariance(&self, key: Key) -> Option<DMatrix<f64>> {
        let columns = self.columns(key)?;
        let (start, n) = (columns.start, columns.len());
        Some(self.covariance.view((start, start), (n, n)).into_owned())
    }

    /// The same with some variables elsewhere: a right perturbation does not change with a motion of the world.
    pub fn moved(&self, moved: &Moved) -> Self {
        let mut elsewhere = self.clone();
        for (key, value) in moved.iter().filter(|(key, _)| self.keys.contains(key)) {
            elsewhere.values.insert(key, value);
        }
        elsewhere
    }

    /// Weighs factors over variables of the marginal and `fresh` ones, linearised about their own maximum, not that of the marginal. `None` where a
    /// factor is undefined, joins another variable, or leaves a new one free.
    pub fn weigh<'m>(&self, factors: &[Rc<dyn Factor + 'm>], fresh: &[(Key, Value)]) -> Option<Weighed> {
        let joined: Vec<Key> = (self.keys.iter().copied())
            .filter(|key| factors.iter().any(|factor| factor.keys().contains(key)))
            .collect();
        let mut values = Values::default();
        for key in &joined {
            values.insert(*key, self.values.get(*key)?.clone());
        }
        fresh.iter().for_each(|(key, value)| values.insert(*key, value.clone()));
        let columns: Vec<usize> = joined.iter().filter_map(|key| self.columns(*key)).flatten().collect();
        let covariance =
            DMatrix::from_fn(columns.len(), columns.len(), |i, j| self.covariance[(columns[i], columns[j])]);
        let mut d = DVector::zeros(columns.len());
        let mut v = DVector::zeros(fresh.iter().map(|(_, value)| value.dim()).sum());
        let mut last = None;
        for _ in 0..ROUNDS {
            let Stacked { residual, old, new, offset } = stack(factors, &joined, fresh, &values)?;
            // Where d and v are 0.
            let constant = &residual - &old * &d - &new * &v;
            let across = &covariance * old.transpose();
            let mut spread = &old * &across;
            (0..spread.nrows()).for_each(|i| spread[(i, i)] += 1.0);
            let spread = Cholesky::new(spread)?;
            let mut information = spread.inverse();
            let mut log_evidence = -half_log_det(&spread) - offset;
            let mut gain = &information * &constant;
            if !v.is_empty() {
                let solved = &information * &new;
                let of_new = Cholesky::new(new.transpose() * &solved)?;
                v = -of_new.solve(&(solved.transpose() * &constant));
                gain += &solved * &v;
                log_evidence += v.len() as f64 / 2.0 * libm::log(2.0 * PI) - half_log_det(&of_new);
                information -= &solved * of_new.solve(&solved.transpose());
            }
            let distance = constant.dot(&gain);
            log_evidence -= distance / 2.0;
            d = -(across * &gain);
            let off = (&constant + &old * &d + &new * &v - &residual).norm();
            last = Some((log_evidence, distance, old, gain, information));
            if off <= SETTLED {
                break;
            }
            let bases = joined.iter().map(|key| self.values.get(*key).map(|value| (*key, value)));
            let bases: Option<Vec<_>> = bases.collect();
            move_all(&mut values, bases?.into_iter(), &d);
            move_all(&mut values, fresh.iter().map(|(key, value)| (*key, value)), &v);
        }
        let (log_evidence, distance, jacobian, gain, information) = last?;
        let effect = Effect { columns, jacobian, gain, information };
        log_evidence.is_finite().then_some(Weighed { log_evidence, distance, effect })
    }

    /// The marginal once the weighed factors are taken in, without their new variables.
    pub fn conditioned(&self, weighed: &Weighed) -> Self {
        let Effect { columns, jacobian, gain, information } = &weighed.effect;
        let across = self.covariance.select_columns(columns) * jacobian.transpose();
        let step = -(&across * gain);
        let mut conditioned = self.clone();
        conditioned.covariance -= &across * information * across.transpose();
        for (key, span) in self.keys.iter().zip(self.starts.windows(2)) {
            conditioned.values.retract(*key, &step.as_slice()[span[0]..span[1]]);
        }
        conditioned
    }

    fn columns(&self, key: Key) -> Option<std::ops::Range<usize>> {
        let at = self.keys.iter().position(|other| *other == key)?;
        Some(self.starts[at]..self.starts[at + 1])
    }
}

fn half_log_det(cholesky: &Cholesky<f64, nalgebra::Dyn>) -> f64 {
    cholesky.l_dirty().diagonal().iter().map(|x| libm::log(*x)).sum()
}

/// Sets variables to their bases moved by a step, one behind the other.
fn move_all<'a>(values: &mut Values, bases: impl Iterator<Item = (Key, &'a Value)>, step: &DVector<f64>) {
    let mut start = 0;
    for (key, base) in bases {
        values.insert(key, base.retract(&step.as_slice()[start..start + base.dim()]));
        start += base.dim();
    }
}

fn stack<'m>(
    factors: &[Rc<dyn Factor + 'm>],
    joined: &[Key],
    fresh: &[(Key, Value)],
    values: &Values,
) -> Option<Stacked> {
    let linear: Option<Vec<LinearFactor>> = factors.iter().map(|factor| factor.linearize(values)).collect();
    let linear = linear?;
    let starts_of = |keys: &mut dyn Iterator<Item = Key>| -> Option<Vec<(Key, usize)>> {
        let mut start = 0;
        keys.map(|key| {
            let own = start;
            start += values.get(key)?.dim();
            Some((key, own))
        })
        .collect()
    };
    let of_old = starts_of(&mut joined.iter().copied())?;
    let of_new = starts_of(&mut fresh.iter().map(|(key, _)| *key))?;
    let rows = linear.iter().map(|linear| linear.residual.len()).sum();
    let width = |starts: &[(Key, usize)]| -> Option<usize> {
        starts.last().map_or(Some(0), |(key, start)| Some(start + values.get(*key)?.dim()))
    };
    let mut stacked = Stacked {
        residual: DVector::zeros(rows),
        old: DMatrix::zeros(rows, width(&of_old)?),
        new: DMatrix::zeros(rows, width(&of_new)?),
        offset: 0.0,
    };
    let mut row = 0;
    for (factor, linear) in factors.iter().zip(linear) {
        let (n, squared) = (linear.residual.len(), linear.residual.norm_squared());
        let weight = factor.information_scale() * factor.kernel().weight(squared, n);
        let root = weight.sqrt();
        stacked.offset +=
            factor.information_scale() * factor.kernel().loss(squared, n) - weight * squared / 2.0;
        stacked.residual.rows_mut(row, n).copy_from(&(linear.residual * root));
        for (key, jacobian) in factor.keys().iter().zip(linear.jacobians) {
            let find =
                |starts: &[(Key, usize)]| starts.iter().find(|(other, _)| other == key).map(|(_, s)| *s);
            let (matrix, start) = match (find(&of_old), find(&of_new)) {
                (Some(start), _) => (&mut stacked.old, start),
                (None, Some(start)) => (&mut stacked.new, start),
                (None, None) => return None,
            };
            let mut target = matrix.view_mut((row, start), jacobian.shape());
            target += jacobian * root;
        }
        row += n;
    }
    Some(stacked)
}

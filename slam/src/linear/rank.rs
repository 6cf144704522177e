//! Which variable the factors leave free, if any.

use super::cholesky::{Cholesky, Memory};
use super::reduced::Reduced;
use super::system::System;
use crate::variable::Key;
use faer::Mat;

/// Smallest eigenvalue, of the reduced system scaled to a unit diagonal, that counts as constrained. A free
/// direction shows as rounding, about 1e-15; 1000 steps of odometry without a closure as 1e-11.
const RANK_TOLERANCE: f64 = 1e-13;
const INVERSE_ITERATIONS: usize = 6;

/// The variable that moves most along the flattest direction of the posterior, where that direction is flat
/// to rounding; `None` where every variable is constrained.
///
/// Found by inverse iteration from a fixed start.
pub fn least_constrained(system: &System<'_>, memory: &mut Memory) -> Option<Key> {
    let structure = system.structure;
    if structure.columns == 0 {
        return None;
    }
    let Some(mut reduced) = Reduced::new(system, 0.0, memory) else {
        return structure.locals.first().map(|local| local.key);
    };
    let diagonal: Vec<f64> =
        (0..structure.columns).map(|c| reduced.hessian[structure.column_starts[c]]).collect();
    if let Some(column) = diagonal.iter().position(|d| !d.is_normal() || *d < 0.0) {
        return Some(owner(system, column));
    }
    let root: Vec<f64> = diagonal.iter().map(|d| 1.0 / d.sqrt()).collect();
    let scaled = &mut reduced.hessian;
    for column in 0..structure.columns {
        let entries = structure.column_starts[column]..structure.column_starts[column + 1];
        for entry in entries {
            scaled[entry] *= root[column] * root[structure.row_indices[entry]];
        }
    }
    let mut shift = RANK_TOLERANCE;
    let factor = loop {
        for column in 0..structure.columns {
            scaled[structure.column_starts[column]] = 1.0 + shift;
        }
        match Cholesky::new(structure, scaled, memory) {
            Some(factor) => break factor,
            None if shift < 1.0 => shift *= 10.0,
            None => return Some(owner(system, 0)),
        }
    };
    let mut vector = Mat::from_fn(structure.columns, 1, |i, _| 1.0 + (i % 7) as f64 / 10.0);
    let mut eigenvalue = 1.0;
    for _ in 0..INVERSE_ITERATIONS {
        let norm = vector.norm_l2();
        vector *= faer::Scale(1.0 / norm);
        factor.solve_in_place(vector.as_mut());
        eigenvalue = 1.0 / vector.norm_l2() - shift;
    }
    let constrained = eigenvalue > RANK_TOLERANCE && shift <= RANK_TOLERANCE;
    (!constrained).then(|| {
        let energy = |column: usize| vector[(column, 0)] * vector[(column, 0)];
        let mut best = (structure.kept[0].key, f64::NEG_INFINITY);
        for kept in &structure.kept {
            let total: f64 = (kept.column..kept.column + kept.dim).map(energy).sum();
            if total > best.1 {
                best = (kept.key, total);
            }
        }
        best.0
    })
}

fn owner(system: &System<'_>, column: usize) -> Key {
    let kept = &system.structure.kept;
    kept[kept.partition_point(|k| k.column <= column) - 1].key
}

//! The damped step.

use super::cholesky::Memory;
use super::reduced::Reduced;
use super::structure::Structure;
use super::system::{System, local_damping_scale};
use crate::variable::Values;

/// A step of all free variables.
pub struct Step {
    kept: Vec<f64>,
    locals: Vec<Vec<f64>>,
    /// By how much the linearised problem's cost would fall, nats.
    pub predicted_decrease: f64,
}

impl System<'_> {
    /// The step of `(H + lambda D) delta = -g`, or `None` where that is not positive definite.
    pub fn step(&self, lambda: f64, memory: &mut Memory) -> Option<Step> {
        let reduced = Reduced::new(self, lambda, memory)?;
        let solved = reduced.solve(memory);
        reduced.recycle(memory);
        let (kept, locals) = solved?;
        let mut model = 0.0;
        for (column, delta) in kept.iter().enumerate() {
            model += delta * (lambda * self.scale(column) * delta - self.gradient[column]);
        }
        for ((local, layout), delta) in self.locals.iter().zip(&self.structure.locals).zip(&locals) {
            for (i, d) in delta.iter().enumerate() {
                let scale = local_damping_scale(layout.key, local.hessian[(i, i)]);
                model += d * (lambda * scale * d - local.gradient[i]);
            }
        }
        let predicted_decrease = model / 2.0;
        predicted_decrease.is_finite().then_some(Step { kept, locals, predicted_decrease })
    }
}

impl Structure {
    /// `values` moved by `step`.
    pub fn retract(&self, values: &Values, step: &Step) -> Values {
        let mut moved = values.clone();
        for kept in &self.kept {
            moved.retract(kept.key, &step.kept[kept.column..kept.column + kept.dim]);
        }
        for (local, delta) in self.locals.iter().zip(&step.locals) {
            moved.retract(local.key, delta);
        }
        moved
    }
}

//! The maximum of all factors at once: where steps of Gauss and Newton do not settle, and for the end.

use crate::factor::{Factor, LinearFactor};
use crate::graph::Graph;
use crate::noise::Kernel;
use crate::solve::{Limits, solve};
use crate::variable::{Key, Values};
use nalgebra::DVector;
use std::rc::Rc;

const LIMITS: Limits = Limits { iterations: 100, tolerance: 1e-6 };

/// The maximum from a start, by Levenberg and Marquardt.
pub(super) fn maximum<'a, 'm: 'a>(
    factors: impl Iterator<Item = &'a Rc<dyn Factor + 'm>>,
    start: Values,
) -> Values {
    let mut graph = Graph::default();
    factors.for_each(|factor| graph.push(SharedFactor(Rc::clone(factor))));
    solve(&graph, start, |_| true, LIMITS).values
}

/// A factor that others hold too.
struct SharedFactor<'m>(Rc<dyn Factor + 'm>);

impl Factor for SharedFactor<'_> {
    fn keys(&self) -> &[Key] {
        self.0.keys()
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        self.0.residual(values)
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        self.0.linearize(values)
    }

    fn kernel(&self) -> Kernel {
        self.0.kernel()
    }

    fn information_scale(&self) -> f64 {
        self.0.information_scale()
    }

    fn is_anchor(&self) -> bool {
        self.0.is_anchor()
    }
}

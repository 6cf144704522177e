//! A factor of each object's own on the noise of its crops: some look less like what the model makes of them than others.

use super::Added;
use crate::graph::Graph;
use crate::laplace::log_evidence;
use crate::posterior::Posterior;
use crate::semantics::{SemanticObject, Semantics};
use crate::settings::SolverSettings;
use crate::solve::solve;
use crate::variable::{Key, Values};
use std::collections::BTreeMap;

/// Most times that factors are chosen and the maximum under them is sought.
const ROUNDS: usize = 3;
/// Steps of the logarithm of a factor to either side of none, and their length.
const STEPS: i32 = 10;
const STEP: f64 = 0.1;

/// Gives each object the factor under which its crops are most probable, and solves again, until none changes. The logarithm of a factor is
/// normal of deviation `spread`. Semantic factors are those of the graph from `first` on.
pub(super) fn refit_noise<'m>(
    semantics: &Semantics<'_, 'm>,
    posterior: &mut Posterior<'m>,
    added: &mut BTreeMap<usize, Added>,
    (first, spread): (usize, f64),
    solver: &SolverSettings,
) {
    let Posterior { graph, solution, .. } = posterior;
    for _ in 0..ROUNDS {
        let mut changed = false;
        for Added { object, .. } in added.values_mut() {
            let factor = most_probable(semantics, object, &solution.values, spread);
            changed |= factor != object.noise_factor;
            object.noise_factor = factor;
        }
        if !changed {
            return;
        }
        graph.truncate(first);
        for (&track, Added { object, .. }) in added.iter() {
            let Some(pose) = solution.values.pose(Key::Object(track)) else { continue };
            semantics.add_factors(graph, object, &object.views, pose.rotation);
        }
        let before = solution.iterations;
        *solution = solve(graph, solution.values.clone(), |_| true, solver.limits());
        solution.iterations += before;
    }
}

/// With all but the object's latent held, over which Laplace's method integrates; as it is where none is defined.
fn most_probable(
    semantics: &Semantics<'_, '_>,
    object: &SemanticObject,
    values: &Values,
    spread: f64,
) -> f64 {
    let numbers = (object.views.len() * semantics.model.measurement_dim()) as f64;
    let Some(pose) = values.pose(Key::Object(object.track)) else { return object.noise_factor };
    let probable = |step: i32| {
        let log_factor = f64::from(step) * STEP;
        let object = SemanticObject { noise_factor: libm::exp(log_factor), ..object.clone() };
        let mut graph = Graph::default();
        semantics.add_factors(&mut graph, &object, &object.views, pose.rotation);
        let evidence = log_evidence(&graph, values, &[Key::Latent(object.track)])?;
        let off = log_factor / spread;
        let whitening = semantics.settings.information_scale * numbers * log_factor;
        Some((object.noise_factor, evidence - whitening - off * off / 2.0))
    };
    let tried = (-STEPS..=STEPS).filter_map(probable);
    tried.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(object.noise_factor, |(factor, _)| factor)
}

//! Whether a maximum is plausible, and which of two is more so.

use crate::estimate::UnresolvedReason;
use crate::posterior::Posterior;
use crate::settings::SolverSettings;
use crate::solve::Outcome;
use std::cmp::Ordering;

/// The 99.9% quantile of the standard normal law.
const NORMAL_QUANTILE: f64 = 3.0902;

impl Posterior<'_> {
    /// Whether no object or landmark was left out because it seems to be behind the cameras that see it, and the maximum [fits](Self::fits).
    pub(crate) fn is_plausible(&self) -> bool {
        let objects = self.unresolved.iter().map(|lost| lost.reason);
        let landmarks = self.unresolved_landmarks.iter().map(|lost| lost.reason);
        self.fits() && objects.chain(landmarks).all(|reason| reason != UnresolvedReason::BehindCamera)
    }

    /// This or another posterior of the same observations: that which ended at a number, then that which fits, then that of the lower
    /// [misfit](Self::misfit), by more than counts as none.
    pub(crate) fn or(self, other: Self, solver: &SolverSettings) -> Self {
        let iterations = self.solution.iterations + other.solution.iterations;
        let rank = |of: &Self| (of.solution.outcome != Outcome::Diverged, of.fits());
        let is_better = match rank(&other).cmp(&rank(&self)) {
            Ordering::Equal => {
                self.misfit() - other.misfit() > 2.0 * solver.tolerance * self.solution.cost.max(1.0)
            }
            unequal => unequal == Ordering::Greater,
        };
        let mut best = if is_better { other } else { self };
        best.solution.iterations = iterations;
        best
    }

    /// Whether residuals are no larger than noise makes them, if it is Gaussian: twice the cost is below the 99.9% quantile of chi-square. Kernels that
    /// grow more slowly make it a threshold, not a probability.
    fn fits(&self) -> bool {
        2.0 * self.solution.cost <= chi_square_quantile(self.freedom())
    }

    /// Twice the cost less the degrees of freedom, that posteriors of different factors can be compared. A sighting that is left out counts as one that
    /// is as far off as one in a thousand, so that each that is used takes as much away.
    fn misfit(&self) -> f64 {
        2.0 * self.solution.cost - self.freedom() - chi_square_quantile(2.0) * self.used() as f64
    }

    /// Numbers of residuals less those of variables, at least 1.
    fn freedom(&self) -> f64 {
        let values = &self.solution.values;
        let residuals = self.graph.factors().filter_map(|factor| factor.residual(values));
        let residuals: usize = residuals.map(|residual| residual.len()).sum();
        residuals.saturating_sub(values.iter().map(|(_, value)| value.dim()).sum()).max(1) as f64
    }

    /// Sightings of objects and landmarks that are in the graph.
    fn used(&self) -> usize {
        self.sightings.values().map(Vec::len).sum::<usize>() + self.landmarks.values().sum::<usize>()
    }
}

/// The 99.9% quantile of chi-square, by the cube root that is nearly normal (Wilson and Hilferty 1931).
fn chi_square_quantile(freedom: f64) -> f64 {
    let variance = 2.0 / (9.0 * freedom);
    freedom * (1.0 - variance + NORMAL_QUANTILE * variance.sqrt()).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::{Dropped, Unresolved};
    use crate::factor::PosePrior;
    use crate::graph::Graph;
    use crate::solve::Solution;
    use crate::variable::{Key, Value, Values};
    use approx::assert_relative_eq;
    use nalgebra::Matrix6;
    use vantage_dataset::Pose;

    const SOLVER: SolverSettings =
        SolverSettings { max_iterations: 100, tolerance: 1e-6, covariances: false };

    /// Of a pose that `priors` are of, and as many sightings of landmarks.
    fn posterior(priors: usize, landmarks: usize, cost: f64, outcome: Outcome) -> Posterior<'static> {
        let mut graph = Graph::default();
        for _ in 0..priors {
            graph.push(PosePrior::new(Key::Robot(0), Pose::identity(), Matrix6::identity()));
        }
        let mut values = Values::default();
        values.insert(Key::Robot(0), Value::Pose(Pose::identity()));
        Posterior {
            graph,
            solution: Solution { values, cost, outcome, iterations: 7 },
            unanchored: None,
            sightings: [].into(),
            unresolved: Vec::new(),
            landmarks: (0..landmarks).map(|landmark| (landmark, 1)).collect(),
            unresolved_landmarks: Vec::new(),
            dropped: Dropped::default(),
        }
    }

    #[test]
    fn the_bound_is_the_quantile_of_chi_square() {
        // scipy.stats.chi2.ppf(0.999, n)
        for (freedom, quantile) in [(10.0, 29.588), (100.0, 149.449), (1000.0, 1143.917)] {
            assert_relative_eq!(chi_square_quantile(freedom), quantile, max_relative = 6e-3);
        }
    }

    #[test]
    fn residuals_above_noise_and_objects_behind_cameras_are_not_plausible() {
        // 18 residuals of 6 variables: 12 degrees of freedom, a quantile of 32.9.
        let of = |cost| posterior(3, 1, cost, Outcome::Converged);
        assert!(of(16.0).is_plausible() && !of(17.0).is_plausible() && !of(f64::NAN).is_plausible());
        let lost = |reason| Posterior { unresolved: vec![Unresolved { track: 0, reason }], ..of(1.0) };
        assert!(lost(UnresolvedReason::NoParallax).is_plausible());
        assert!(!lost(UnresolvedReason::BehindCamera).is_plausible());
    }

    #[test]
    fn what_ends_and_fits_is_taken_then_the_better_fit_with_what_is_left_out() {
        let (converged, diverged) = (Outcome::Converged, Outcome::Diverged);
        let of = |landmarks, cost| posterior(3, landmarks, cost, converged);
        let taken = |one: Posterior<'static>, other: Posterior<'static>| {
            let best = one.or(other, &SOLVER);
            assert_eq!(best.solution.iterations, 14);
            (best.landmarks.len(), best.solution.cost)
        };
        assert_eq!(taken(of(1, 5.0), of(1, 4.0)), (1, 4.0));
        assert_eq!(taken(of(1, 5.0), of(1, 5.0 - 1e-9)), (1, 5.0), "less than counts");
        assert_eq!(taken(of(1, 5.0), of(1, 6.0)), (1, 5.0));
        assert_eq!(taken(of(1, 5.0), of(2, 6.0)), (2, 6.0));
        assert_eq!(taken(of(1, 5.0), of(2, 60.0)), (1, 5.0), "more in it that does not fit");
        assert_eq!(taken(of(2, 5.0), of(1, 4.0)), (2, 5.0));
        assert_eq!(taken(of(1, 60.0), of(2, 65.0)), (2, 65.0), "a sighting more for ten of twice the cost");
        assert_eq!(taken(of(1, 60.0), of(2, 600.0)), (1, 60.0), "nor for a thousand");
        assert_eq!(taken(posterior(3, 1, f64::NAN, diverged), of(1, 60.0)), (1, 60.0));
        assert_eq!(taken(of(1, 60.0), posterior(3, 2, 1.0, diverged)), (1, 60.0));
        // Six more residuals may cost three nats more.
        assert_eq!(taken(of(1, 5.0), posterior(4, 1, 7.5, converged)), (1, 7.5));
    }
}

//! What the factorisation is for: the solution, and marginals.

use super::{Solved, Tree};
use faer::Mat;
use std::collections::BTreeMap;
use std::ops::Range;

impl Tree {
    /// Solves for all variables that depend on what changed by more than `tolerance`.
    pub fn solve(&mut self, tolerance: f64) -> Solved {
        self.before.clone_from(&self.solution);
        let mut solved = Solved::default();
        let mut waiting: Vec<usize> =
            self.nodes.iter().filter(|(_, node)| node.parent.is_none()).map(|(index, _)| *index).collect();
        while let Some(index) = waiting.pop() {
            let Some(node) = self.nodes.get_mut(&index) else { continue };
            let spans = |of: &[usize]| -> Vec<Range<usize>> {
                of.iter().map(|&variable| self.variables[variable].span()).collect()
            };
            let (own, others) = (spans(&node.eliminated), spans(&node.separator));
            let given = gathered(&self.solution, &others);
            let is_same = node.solved_for.as_ref().is_some_and(|before| {
                before.iter().zip(&given).all(|(before, now)| (before - now).abs() <= tolerance)
            });
            if is_same {
                continue;
            }
            if node.solved_for.is_none() {
                let (own, others) = (gathered(&self.before, &own), gathered(&self.before, &others));
                solved.decrease += node.front.excess(&own, &others);
            }
            let numbers = node.front.solve(&given);
            node.solved_for = Some(given);
            let mut rest = numbers.as_slice();
            for (&variable, span) in node.eliminated.iter().zip(own) {
                let (now, others) = rest.split_at(span.len());
                rest = others;
                let before = &mut self.solution[span];
                let distance: f64 = before.iter().zip(now).map(|(before, now)| (now - before).powi(2)).sum();
                before.copy_from_slice(now);
                solved.moved.push((variable, distance.sqrt()));
            }
            waiting.extend(&node.children);
        }
        solved
    }

    /// Takes variables that were solved for back to where they were before; they are solved for again the next time.
    pub fn take_back(&mut self, moved: &[(usize, f64)]) {
        for &(variable, _) in moved {
            let span = self.variables[variable].span();
            self.solution[span.clone()].copy_from_slice(&self.before[span]);
            if let Some(node) = self.variables[variable].node.and_then(|node| self.nodes.get_mut(&node)) {
                node.solved_for = None;
            }
        }
    }

    /// The covariance of a variable, `[dim x dim]`: down the path from the root.
    pub fn covariance(&self, variable: usize) -> Option<Mat<f64>> {
        let mut path = vec![self.variables[variable].node?];
        while let Some(parent) = path.last().and_then(|node| self.nodes.get(node)?.parent) {
            path.push(parent);
        }
        let mut known: BTreeMap<usize, usize> = BTreeMap::new();
        let mut joint = Mat::<f64>::zeros(0, 0);
        for index in path.iter().rev() {
            let node = self.nodes.get(index)?;
            let numbers = |variable: &usize| {
                let start = known[variable];
                start..start + self.variables[*variable].dim
            };
            let places: Vec<usize> = node.separator.iter().flat_map(numbers).collect();
            let given = Mat::from_fn(places.len(), places.len(), |i, j| joint[(places[i], places[j])]);
            joint = node.front.covariance(given.as_ref());
            known.clear();
            let mut start = 0;
            for &variable in node.eliminated.iter().chain(&node.separator) {
                known.insert(variable, start);
                start += self.variables[variable].dim;
            }
        }
        let (start, dim) = (known[&variable], self.variables[variable].dim);
        Some(joint.submatrix(start, start, dim, dim).to_owned())
    }
}

fn gathered(numbers: &[f64], spans: &[Range<usize>]) -> Vec<f64> {
    spans.iter().flat_map(|span| &numbers[span.clone()]).copied().collect()
}

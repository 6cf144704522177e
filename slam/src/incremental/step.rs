//! A step of the smoother: taken where it lowers the cost, or taken back, with what stands in its way damped.

use super::descent::{Verdict, judge};
use super::linearized::Look;
use super::smoother::{Smoother, numbers};
use super::tree::Solved;
use crate::linear::more_damped;
use crate::variable::Value;
use std::collections::BTreeSet;

impl Smoother<'_> {
    /// Takes a solution if that lowers the cost, and goes back to where it was if not; what is to be linearised anew waits.
    pub(super) fn judge(&mut self, solved: &Solved, limit: f64) -> bool {
        let before = self.show(&solved.moved);
        let due = self.due(&solved.moved);
        let looks: Vec<(usize, Option<Look>)> =
            due.into_iter().map(|term| (term, self.look(term, limit))).collect();
        let off = looks.iter().filter_map(|&(term, look)| Some((term, look.filter(|l| l.off > limit)?)));
        let off: Vec<(usize, Look)> = off.collect();
        match judge(solved.decrease, off.iter().map(|(_, look)| look.excess)) {
            Verdict::Refused => {
                self.tree.take_back(&solved.moved);
                self.take_back(before);
                self.refuse(&off);
                return false;
            }
            // A point that whole steps lead away from is held until it is reached.
            Verdict::TakenInDoubt => {}
            Verdict::Taken { gain } => self.damping.relax(&mut self.tree, gain),
        }
        for (term, look) in looks {
            if let Some(linearized) = &mut self.factors[term] {
                linearized.look_later(look.map(|look| look.off), limit);
            }
        }
        self.waiting.extend(off.iter().map(|(term, _)| term));
        true
    }

    /// Has the factors that were off after a step linearised anew where that started, or their variables damped where they are.
    fn refuse(&mut self, off: &[(usize, Look)]) {
        let mut fresh: BTreeSet<usize> = BTreeSet::new();
        for &(term, _) in off {
            let (Some(of), Some(linearized)) = (self.tree.term(term), &mut self.factors[term]) else {
                continue;
            };
            linearized.move_to(numbers(&self.tree, of));
            if linearized.is_fresh() {
                fresh.extend(&of.variables);
            } else if linearized.factor.residual(&self.values).is_some() {
                self.waiting.insert(term);
            } else {
                linearized.look_no_more();
            }
        }
        if fresh.is_empty() {
            return;
        }
        let Self { charts, tree, damping, .. } = self;
        damping.raise(tree, fresh.into_iter().map(|variable| (variable, more_damped(charts[variable].key))));
    }

    /// Has the values of variables that moved follow the solution; returns what they were.
    fn show(&mut self, moved: &[(usize, f64)]) -> Vec<(usize, Value)> {
        let Self { tree, charts, values, .. } = self;
        let mut before = Vec::with_capacity(moved.len());
        let mut now = Vec::with_capacity(moved.len());
        for &(variable, _) in moved {
            let chart = &mut charts[variable];
            if let (Some(value), Some(of)) =
                (chart.advance(tree.solution(variable), values), values.get(chart.key))
            {
                before.push((variable, of.clone()));
                now.push((chart.key, value));
            }
        }
        now.into_iter().for_each(|(key, value)| values.insert(key, value));
        before
    }

    /// Has values be what they were before they followed the solution, which was taken back.
    fn take_back(&mut self, before: Vec<(usize, Value)>) {
        for (variable, value) in before {
            let chart = &mut self.charts[variable];
            chart.take_back(self.tree.solution(variable));
            self.values.insert(chart.key, value);
        }
    }

    /// The factors of what moved that are to be looked at.
    fn due(&mut self, moved: &[(usize, f64)]) -> Vec<usize> {
        let Self { tree, factors, .. } = self;
        let mut due = Vec::new();
        for &(variable, distance) in moved {
            for term in tree.terms_of(variable) {
                if let Some(factor) = &mut factors[term] {
                    factor.move_on(variable, distance);
                    due.extend(factor.is_due().then_some(term));
                }
            }
        }
        due.sort_unstable();
        due.dedup();
        due.retain(|&index| match (tree.term(index), &mut factors[index]) {
            (Some(term), Some(factor)) => {
                factor.move_to(numbers(tree, term));
                factor.is_due()
            }
            _ => false,
        });
        due
    }

    /// How far a factor is off its term; `None` where it did not move by more than `limit`.
    fn look(&self, index: usize, limit: f64) -> Option<Look> {
        let (term, linearized) = (self.tree.term(index)?, self.factors[index].as_ref()?);
        linearized.look(term, numbers(&self.tree, term), &self.values, limit)
    }
}

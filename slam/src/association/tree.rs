//! A least-squares problem that grows, as an elimination tree that copies share.
//!
//! A change renews only the fronts from what it touches to the root (Kaess et al., iSAM2, IJRR 2012); those below stay, and stay shared with
//! other copies. Sums over the fronts give the evidence of the whole at no further cost.

mod planting;

use super::front::{Eliminated, spans};
use super::order::{cliques, order};
use super::shared::Shared;
use crate::incremental::Term;
use std::rc::Rc;

const NONE: usize = usize::MAX;

/// The equations are not positive definite near a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Indefinite {
    pub variable: usize,
}

#[derive(Clone, Debug)]
struct Variable {
    dim: usize,
    start: usize,
    /// Where it is eliminated, or [`NONE`].
    node: usize,
    terms: Vec<usize>,
}

#[derive(Clone, Debug)]
pub(super) struct Node {
    pub front: Rc<Eliminated>,
    pub parent: usize,
    children: Vec<usize>,
    /// The separator's numbers that the eliminated ones were solved for, if they were.
    solved_for: Option<Vec<f64>>,
}

/// The problem, its factorisation and its solution.
#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    variables: Shared<Variable>,
    terms: Shared<Rc<Term>>,
    nodes: Shared<Option<Node>>,
    free: Vec<usize>,
    roots: Vec<usize>,
    solution: Vec<f64>,
    touched: Vec<usize>,
    late: Vec<usize>,
    /// `sum |c|^2 / 2` over the terms.
    start_cost: f64,
    gain: f64,
    log_det: f64,
}

impl Tree {
    /// Adds a variable of `dim` numbers, 0 at first.
    pub fn add_variable(&mut self, dim: usize) -> usize {
        let variable = self.variables.len();
        self.variables.push(Variable { dim, start: self.solution.len(), node: NONE, terms: Vec::new() });
        self.solution.resize(self.solution.len() + dim, 0.0);
        self.touched.push(variable);
        variable
    }

    /// Adds a term.
    pub fn add_term(&mut self, term: Term) -> usize {
        let index = self.terms.len();
        for &variable in &term.variables {
            self.variables.get_mut(variable).terms.push(index);
            self.touched.push(variable);
        }
        self.start_cost += term.constant.norm_squared() / 2.0;
        self.terms.push(Rc::new(term));
        index
    }

    /// Puts another in the place of a term, over the same variables.
    pub fn replace_term(&mut self, index: usize, term: Term) {
        self.start_cost += (term.constant.norm_squared() - self.terms[index].constant.norm_squared()) / 2.0;
        self.touched.extend_from_slice(&term.variables);
        *self.terms.get_mut(index) = Rc::new(term);
    }

    /// Variables that the next change is likely to touch: they are eliminated last.
    pub fn expect(&mut self, variables: Vec<usize>) {
        self.late = variables;
    }

    pub fn term(&self, index: usize) -> &Term {
        &self.terms[index]
    }

    pub fn terms_of(&self, variable: usize) -> &[usize] {
        &self.variables[variable].terms
    }

    /// The numbers of a variable.
    pub fn solution(&self, variable: usize) -> &[f64] {
        let Variable { dim, start, .. } = self.variables[variable];
        &self.solution[start..start + dim]
    }

    /// Sets the numbers of a variable; its terms are to be replaced.
    pub fn reset(&mut self, variable: usize) {
        let Variable { dim, start, .. } = self.variables[variable];
        self.solution[start..start + dim].fill(0.0);
    }

    pub fn dim(&self, variable: usize) -> usize {
        self.variables[variable].dim
    }

    /// Numbers of all variables.
    pub fn numbers(&self) -> usize {
        self.solution.len()
    }

    /// Fronts, and how many of them another copy has too.
    pub fn shared_fronts(&self, other: &Self) -> (usize, usize) {
        let count = self.nodes.iter().flatten().count();
        let pairs = self.nodes.iter().zip(other.nodes.iter());
        let is_shared = |(a, b): (&Option<Node>, &Option<Node>)| match (a, b) {
            (Some(a), Some(b)) => Rc::ptr_eq(&a.front, &b.front),
            _ => false,
        };
        (count, pairs.filter(|pair| is_shared(*pair)).count())
    }

    /// The least cost, and `log det L` of the Cholesky factor of the information.
    pub fn minimum(&self) -> (f64, f64) {
        (self.start_cost - self.gain, self.log_det)
    }

    pub fn node_of(&self, variable: usize) -> Option<usize> {
        let node = self.variables[variable].node;
        (node != NONE).then_some(node)
    }

    pub fn node(&self, node: usize) -> Option<&Node> {
        self.nodes[node].as_ref()
    }

    /// Forgets the factorisation: all is to be factorised anew.
    pub fn forget(&mut self) {
        (self.nodes, self.free, self.roots) = (Shared::default(), Vec::new(), Vec::new());
        (self.gain, self.log_det) = (0.0, 0.0);
        (0..self.variables.len()).for_each(|variable| self.variables.get_mut(variable).node = NONE);
        self.touched = (0..self.variables.len()).collect();
    }

    /// Factorises what changed. After an error the tree is of no use until it [forgets](Self::forget).
    pub fn factorize(&mut self) -> Result<(), Indefinite> {
        if self.touched.is_empty() {
            return Ok(());
        }
        let mut touched = std::mem::take(&mut self.touched);
        touched.sort_unstable();
        touched.dedup();
        let (affected, orphans) = self.cut(&touched);
        let mut local = vec![NONE; self.variables.len()];
        affected.iter().enumerate().for_each(|(i, &variable)| local[variable] = i);
        let (meets, terms) = self.meetings(&affected, &local, &orphans);
        let mut is_last = vec![false; affected.len()];
        for &variable in self.late.iter().filter(|variable| local[**variable] != NONE) {
            is_last[local[variable]] = true;
        }
        let dims: Vec<usize> = affected.iter().map(|&variable| self.variables[variable].dim).collect();
        let order = order(&meets, &is_last);
        let fronts = cliques(&meets, &order, &dims);
        self.plant(&affected, fronts, &terms, &orphans)
    }

    /// Removes the nodes from the touched variables' to the root; returns what they eliminated with what had no node, sorted, and the nodes that
    /// lost their parents.
    fn cut(&mut self, touched: &[usize]) -> (Vec<usize>, Vec<usize>) {
        let mut affected = Vec::new();
        let mut is_cut = vec![false; self.nodes.len()];
        let mut cut = Vec::new();
        for &variable in touched {
            let mut at = self.variables[variable].node;
            if at == NONE {
                affected.push(variable);
            }
            while at != NONE && !is_cut[at] {
                is_cut[at] = true;
                cut.push(at);
                at = self.nodes[at].as_ref().map_or(NONE, |node| node.parent);
            }
        }
        let mut orphans = Vec::new();
        for &index in &cut {
            let Some(node) = self.nodes.get_mut(index).take() else { continue };
            self.gain -= node.front.gain;
            self.log_det -= node.front.log_det;
            for &variable in &node.front.variables {
                self.variables.get_mut(variable).node = NONE;
                affected.push(variable);
            }
            orphans.extend(node.children.iter().copied().filter(|child| !is_cut[*child]));
            self.free.push(index);
        }
        self.roots.retain(|root| !is_cut[*root]);
        affected.sort_unstable();
        orphans.sort_unstable();
        (affected, orphans)
    }

    /// Solves from the roots down, leaving what depends on changes below `threshold`; returns the variables solved for.
    pub fn solve(&mut self, threshold: f64) -> Vec<usize> {
        let mut solved = Vec::new();
        let mut waiting = self.roots.clone();
        let mut given = Vec::new();
        while let Some(index) = waiting.pop() {
            let Some(node) = &self.nodes[index] else { continue };
            given.clear();
            for &variable in &node.front.separator {
                given.extend_from_slice(self.solution(variable));
            }
            let is_near = |(a, b): (&f64, &f64)| (a - b).abs() <= threshold;
            if node.solved_for.as_ref().is_some_and(|old| old.iter().zip(&given).all(is_near)) {
                continue;
            }
            let front = Rc::clone(&node.front);
            waiting.extend_from_slice(&node.children);
            let values = front.solve(&given);
            let dims = front.variables.iter().map(|&variable| self.variables[variable].dim);
            for (&variable, span) in front.variables.iter().zip(spans(dims)) {
                let start = self.variables[variable].start;
                self.solution[start..start + span.len()].copy_from_slice(&values[span]);
                solved.push(variable);
            }
            if let Some(node) = self.nodes.get_mut(index) {
                node.solved_for = Some(given.clone());
            }
        }
        solved
    }
}

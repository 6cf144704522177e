//! A least-squares problem that grows, as an elimination tree that copies share.
//!
//! A change renews only the fronts from what it touches to the root (Kaess et al., iSAM2, IJRR 2012); those below stay, and stay shared with
//! other copies. Sums over the fronts give the evidence of the whole at no further cost.

use super::front::{Eliminated, Front, spans};
use super::order::{Clique, cliques, order};
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

    /// Factorises what changed. After an error the tree is of no use.
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

    /// Which of the affected variables meet, and the terms that no orphan holds.
    fn meetings(
        &self,
        affected: &[usize],
        local: &[usize],
        orphans: &[usize],
    ) -> (Vec<Vec<usize>>, Vec<usize>) {
        let mut meets: Vec<Vec<usize>> = vec![Vec::new(); affected.len()];
        let mut connect = |joined: &[usize]| {
            for &a in joined {
                meets[a].extend(joined.iter().copied().filter(|b| *b != a));
            }
        };
        let mut terms = Vec::new();
        let mut joined = Vec::new();
        for (i, &variable) in affected.iter().enumerate() {
            for &index in &self.variables[variable].terms {
                joined.clear();
                joined.extend(self.terms[index].variables.iter().map(|&other| local[other]));
                if joined.iter().all(|other| *other != NONE && *other >= i) {
                    terms.push(index);
                    connect(&joined);
                }
            }
        }
        for node in orphans.iter().filter_map(|&orphan| self.nodes[orphan].as_ref()) {
            joined.clear();
            joined.extend(node.front.separator.iter().map(|&other| local[other]));
            connect(&joined);
        }
        for row in &mut meets {
            row.sort_unstable();
            row.dedup();
        }
        (meets, terms)
    }

    /// Eliminates the cliques of affected variables, of which each comes before its parent.
    fn plant(
        &mut self,
        affected: &[usize],
        fronts: Vec<Clique>,
        terms: &[usize],
        orphans: &[usize],
    ) -> Result<(), Indefinite> {
        let mut clique_of = vec![NONE; self.variables.len()];
        for (i, clique) in fronts.iter().enumerate() {
            clique.eliminated.iter().for_each(|&variable| clique_of[affected[variable]] = i);
        }
        let first = |variables: &[usize]| variables.iter().map(|&variable| clique_of[variable]).min();
        let mut terms_in: Vec<Vec<usize>> = vec![Vec::new(); fronts.len()];
        for &term in terms {
            if let Some(clique) = first(&self.terms[term].variables) {
                terms_in[clique].push(term);
            }
        }
        let mut children_in: Vec<Vec<usize>> = vec![Vec::new(); fronts.len()];
        for &orphan in orphans {
            match self.nodes[orphan].as_ref().and_then(|node| first(&node.front.separator)) {
                Some(clique) => children_in[clique].push(orphan),
                None => {
                    if let Some(node) = self.nodes.get_mut(orphan) {
                        node.parent = NONE;
                    }
                    self.roots.push(orphan);
                }
            }
        }
        let mut start_in = vec![NONE; self.variables.len()];
        let mut memory = Vec::new();
        for (i, clique) in fronts.into_iter().enumerate() {
            let named = |variables: Vec<usize>| -> Vec<usize> {
                variables.into_iter().map(|variable| affected[variable]).collect()
            };
            let (eliminated, separator) = (named(clique.eliminated), named(clique.separator));
            let mut sizes = [0, 0];
            for (size, variables) in [(0, &eliminated), (1, &separator)] {
                for &variable in variables {
                    start_in[variable] = sizes[0] + sizes[1];
                    sizes[size] += self.variables[variable].dim;
                }
            }
            let mut front = Front::new(sizes[0], sizes[1], memory);
            let mut starts = Vec::new();
            for &term in &terms_in[i] {
                let term = &self.terms[term];
                starts.clear();
                starts.extend(term.variables.iter().map(|&variable| start_in[variable]));
                front.add_term(term, &starts);
            }
            let children = std::mem::take(&mut children_in[i]);
            let index = self.free.pop().unwrap_or_else(|| {
                self.nodes.push(None);
                self.nodes.len() - 1
            });
            for &child in &children {
                let Some(node) = self.nodes.get_mut(child) else { continue };
                node.parent = index;
                let places: Vec<usize> = (node.front.separator.iter())
                    .flat_map(|&variable| {
                        let start = start_in[variable];
                        start..start + self.variables[variable].dim
                    })
                    .collect();
                front.add_rest(&node.front, &places);
            }
            let variable = eliminated[0];
            let above = first(&separator);
            let done = front.eliminate(eliminated, separator).ok_or(Indefinite { variable })?;
            memory = front.into_memory();
            self.gain += done.gain;
            self.log_det += done.log_det;
            for &variable in &done.variables {
                self.variables.get_mut(variable).node = index;
            }
            match above {
                Some(parent) => children_in[parent].push(index),
                None => self.roots.push(index),
            }
            let node = Node { front: Rc::new(done), parent: NONE, children, solved_for: None };
            *self.nodes.get_mut(index) = Some(node);
        }
        Ok(())
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

//! A least-squares problem that grows: its elimination tree, of which a change renews only the path to the root.
//!
//! Variables of an object are eliminated first, in a leaf of their own. Of the others, the renewed ones are ordered afresh, those that the
//! change touches last: they are what the next change touches too (Kaess et al., iSAM2, IJRR 2012, with fronts in place of cliques).

mod elimination;
mod solution;

use super::front::Eliminated;
use super::object::ObjectEquations;
use super::term::Term;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Which variables are eliminated together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Inside the object of this number, before all others.
    Object(usize),
    /// By the order that makes least fill.
    Chain,
    /// After all others: what many terms share.
    Shared,
}

/// What a solution changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solved {
    /// The variables that were solved for, and how far each moved.
    pub moved: Vec<(usize, f64)>,
    /// By how much the least-squares cost, with that of moving what is damped, fell.
    pub decrease: f64,
}

/// The equations are not positive definite near a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Indefinite {
    /// The variable.
    pub variable: usize,
}

#[derive(Clone, Debug)]
struct Variable {
    dim: usize,
    /// First number in the solution.
    start: usize,
    place: Place,
    /// Where it is eliminated.
    node: Option<usize>,
    terms: BTreeSet<usize>,
    /// What is added to its diagonal, as a share.
    damping: f64,
}

impl Variable {
    /// Where it is in the solution.
    fn span(&self) -> Range<usize> {
        self.start..self.start + self.dim
    }
}

#[derive(Clone, Debug)]
struct Node {
    eliminated: Vec<usize>,
    separator: Vec<usize>,
    front: Eliminated,
    parent: Option<usize>,
    children: BTreeSet<usize>,
    /// The separator's numbers that the eliminated ones were solved for; none where they were not.
    solved_for: Option<Vec<f64>>,
}

#[derive(Clone, Debug, Default)]
struct Object {
    variables: Vec<usize>,
    /// Sums of its terms; to be made anew where absent.
    equations: Option<ObjectEquations>,
}

/// The problem, its factorisation and its solution.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    variables: Vec<Variable>,
    terms: BTreeMap<usize, Term>,
    next_term: usize,
    objects: BTreeMap<usize, Object>,
    nodes: BTreeMap<usize, Node>,
    next_node: usize,
    /// Nodes to be renewed, with all above them.
    stale: BTreeSet<usize>,
    /// Variables whose terms changed.
    touched: BTreeSet<usize>,
    solution: Vec<f64>,
    /// The solution before it was last solved for.
    before: Vec<f64>,
    /// What the next front is assembled in.
    memory: Vec<f64>,
}

impl Tree {
    /// Adds a variable of `dim` numbers, 0 at first.
    pub fn add_variable(&mut self, dim: usize, place: Place) -> usize {
        let variable = self.variables.len();
        let start = self.solution.len();
        self.solution.extend(std::iter::repeat_n(0.0, dim));
        self.variables.push(Variable { dim, start, place, node: None, terms: BTreeSet::new(), damping: 0.0 });
        self.touch(variable);
        if let Place::Object(object) = place {
            let object = self.objects.entry(object).or_default();
            object.variables.push(variable);
            object.equations = None;
        }
        variable
    }

    /// Removes all variables of an object, with their terms, which are returned.
    pub fn remove_object(&mut self, object: usize) -> Vec<usize> {
        let Some(Object { variables, .. }) = self.objects.remove(&object) else { return Vec::new() };
        let terms: BTreeSet<usize> =
            variables.iter().flat_map(|&variable| self.variables[variable].terms.iter().copied()).collect();
        for &term in &terms {
            self.remove_term(term);
        }
        for variable in variables {
            self.touched.remove(&variable);
            if let Some(node) = self.variables[variable].node.take() {
                self.mark(node);
            }
        }
        terms.into_iter().collect()
    }

    /// Adds a term over variables of at most one object.
    pub fn add_term(&mut self, term: Term) -> usize {
        let index = self.next_term;
        self.next_term += 1;
        self.put(index, term);
        index
    }

    /// Puts another in the place of a term, over the same variables.
    pub fn replace_term(&mut self, index: usize, term: Term) {
        if let Some(object) = self.terms.get(&index).and_then(|term| self.object_of(term)) {
            self.objects.entry(object).or_default().equations = None;
        }
        self.terms.remove(&index);
        self.put(index, term);
    }

    fn put(&mut self, index: usize, term: Term) {
        for &variable in &term.variables {
            self.touch(variable);
            self.variables[variable].terms.insert(index);
        }
        if let Some(equations) =
            self.object_of(&term).and_then(|object| self.objects.get_mut(&object)?.equations.as_mut())
        {
            equations.add(&term);
        }
        self.terms.insert(index, term);
    }

    fn remove_term(&mut self, index: usize) {
        let Some(term) = self.terms.remove(&index) else { return };
        for &variable in &term.variables {
            self.touch(variable);
            self.variables[variable].terms.remove(&index);
        }
    }

    /// A term.
    pub fn term(&self, index: usize) -> Option<&Term> {
        self.terms.get(&index)
    }

    /// The terms of a variable.
    pub fn terms_of(&self, variable: usize) -> impl Iterator<Item = usize> {
        self.variables[variable].terms.iter().copied()
    }

    /// The numbers of a variable.
    pub fn solution(&self, variable: usize) -> &[f64] {
        &self.solution[self.variables[variable].span()]
    }

    fn object_of(&self, term: &Term) -> Option<usize> {
        term.variables.iter().find_map(|&variable| match self.variables[variable].place {
            Place::Object(object) => Some(object),
            _ => None,
        })
    }

    fn touch(&mut self, variable: usize) {
        self.touched.insert(variable);
        if let Some(node) = self.variables[variable].node {
            self.mark(node);
        }
    }

    fn mark(&mut self, node: usize) {
        let mut at = Some(node);
        while let Some(node) = at {
            if !self.stale.insert(node) {
                break;
            }
            at = self.nodes[&node].parent;
        }
    }

    /// Factorises what changed; all of it the next time, after an error.
    pub fn factorize(&mut self) -> Result<(), Indefinite> {
        let renewed = self.renew();
        if renewed.is_err() {
            self.nodes.clear();
            self.stale.clear();
            for variable in 0..self.variables.len() {
                self.variables[variable].node = None;
                if self.is_alive(variable) {
                    self.touched.insert(variable);
                }
            }
        }
        renewed
    }

    /// Whether a variable was not removed with its object.
    fn is_alive(&self, variable: usize) -> bool {
        match self.variables[variable].place {
            Place::Object(object) => self.objects.contains_key(&object),
            _ => true,
        }
    }

    /// Has a variable move less than its equations ask for: `damping` is what is added to their diagonal, as a share.
    pub fn damp(&mut self, variable: usize, damping: f64) {
        self.variables[variable].damping = damping;
        self.touch(variable);
    }
}

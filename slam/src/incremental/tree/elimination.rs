//! The elimination of what changed: objects in leaves, and the others above what is left below.

use super::{Indefinite, Node, Object, Place, Tree, Variable};
use crate::incremental::front::Front;
use crate::incremental::object::ObjectEquations;
use crate::incremental::order::Meetings;
use std::collections::{BTreeMap, BTreeSet};

/// Damping, relative to the diagonal, tried in turn where a front is not positive definite: what is free then stays near where it is.
const LEAST_DAMPING: f64 = 1e-12;
const MOST_DAMPING: f64 = 1e-3;

impl Tree {
    pub(super) fn renew(&mut self) -> Result<(), Indefinite> {
        let touched = std::mem::take(&mut self.touched);
        let mut renewed: BTreeSet<usize> = touched.clone();
        let mut below: BTreeSet<usize> = BTreeSet::new();
        for node in std::mem::take(&mut self.stale) {
            let Some(node) = self.nodes.remove(&node) else { continue };
            for &variable in &node.eliminated {
                self.variables[variable].node = None;
            }
            renewed.extend(node.eliminated.iter().copied().filter(|&variable| self.is_alive(variable)));
            below.extend(node.children);
        }
        below.retain(|node| self.nodes.contains_key(node));

        let mut objects = BTreeSet::new();
        let mut chain: Vec<usize> = Vec::new();
        for &variable in &renewed {
            match self.variables[variable].place {
                Place::Object(object) => {
                    objects.insert(object);
                }
                _ => chain.push(variable),
            }
        }
        let mut recent: BTreeSet<usize> = touched;
        for object in objects {
            let node = self.eliminate_object(object)?;
            recent.extend(&self.nodes[&node].separator);
            below.insert(node);
        }
        self.eliminate_chain(&chain, &recent, &below)
    }

    fn eliminate_object(&mut self, object: usize) -> Result<usize, Indefinite> {
        let Some(Object { variables, equations }) = self.objects.get_mut(&object) else {
            unreachable!("a variable's object is there")
        };
        let equations = match equations {
            Some(equations) => equations,
            None => {
                let own: Vec<(usize, usize)> =
                    variables.iter().map(|&variable| (variable, self.variables[variable].dim)).collect();
                let terms: BTreeSet<usize> = variables
                    .iter()
                    .flat_map(|&variable| self.variables[variable].terms.iter().copied())
                    .collect();
                let mut made = ObjectEquations::new(&own);
                terms.iter().for_each(|term| made.add(&self.terms[term]));
                equations.insert(made)
            }
        };
        let front = equations.front(std::mem::take(&mut self.memory));
        let (eliminated, separator) = (equations.eliminated().to_vec(), equations.separator().to_vec());
        self.add_node(eliminated, separator, front)
    }

    /// Orders and eliminates variables that are not of objects, above the nodes that are left `below`.
    fn eliminate_chain(
        &mut self,
        chain: &[usize],
        recent: &BTreeSet<usize>,
        below: &BTreeSet<usize>,
    ) -> Result<(), Indefinite> {
        let local: BTreeMap<usize, usize> =
            chain.iter().enumerate().map(|(i, &variable)| (variable, i)).collect();
        let mut meetings = Meetings::new(chain.len());
        let mut own_terms = BTreeSet::new();
        for &variable in chain {
            for &term in &self.variables[variable].terms {
                let places: Option<Vec<usize>> =
                    self.terms[&term].variables.iter().map(|other| local.get(other).copied()).collect();
                if let Some(places) = places.filter(|_| own_terms.insert(term)) {
                    meetings.connect(&places);
                }
            }
        }
        for node in below {
            let separator: Vec<usize> = self.nodes[node].separator.iter().map(|v| local[v]).collect();
            meetings.connect(&separator);
        }
        let newest = chain.iter().copied().filter(|v| self.variables[*v].place == Place::Chain).max();
        let rank: Vec<usize> = chain
            .iter()
            .map(|variable| match self.variables[*variable].place {
                Place::Shared => 3,
                _ if Some(*variable) == newest => 2,
                _ => usize::from(recent.contains(variable)),
            })
            .collect();
        let order = meetings.order(&rank);
        let mut position = vec![0; chain.len()];
        for (at, &variable) in order.iter().enumerate() {
            position[variable] = at;
        }
        let first_of = |variables: &[usize]| -> Option<usize> {
            variables.iter().map(|variable| local[variable]).min_by_key(|&variable| position[variable])
        };
        let mut terms_at: Vec<Vec<usize>> = vec![Vec::new(); chain.len()];
        for &term in &own_terms {
            if let Some(first) = first_of(&self.terms[&term].variables) {
                terms_at[first].push(term);
            }
        }
        let mut nodes_at: Vec<Vec<usize>> = vec![Vec::new(); chain.len()];
        for &node in below {
            if let Some(first) = first_of(&self.nodes[&node].separator) {
                nodes_at[first].push(node);
            }
        }
        let dims: Vec<usize> = chain.iter().map(|&variable| self.variables[variable].dim).collect();
        let mut starts = vec![0; chain.len()];
        for clique in meetings.cliques(&order, &dims) {
            let mut n = 0;
            for &variable in clique.eliminated.iter().chain(&clique.separator) {
                starts[variable] = n;
                n += dims[variable];
            }
            let own: usize = clique.eliminated.iter().map(|&variable| dims[variable]).sum();
            let mut front = Front::new(own, n - own, std::mem::take(&mut self.memory));
            let mut children = Vec::new();
            for &variable in &clique.eliminated {
                for term in &terms_at[variable] {
                    let term = &self.terms[term];
                    let at: Vec<usize> = term.variables.iter().map(|other| starts[local[other]]).collect();
                    front.add_term(term, &at);
                }
                for &node in &nodes_at[variable] {
                    let child = &self.nodes[&node];
                    let numbers = |other: &usize| {
                        let other = local[other];
                        starts[other]..starts[other] + dims[other]
                    };
                    let places: Vec<usize> = child.separator.iter().flat_map(numbers).collect();
                    front.add_rest(&child.front, &places);
                    children.push(node);
                }
            }
            let named =
                |variables: &[usize]| variables.iter().map(|&variable| chain[variable]).collect::<Vec<_>>();
            let node = self.add_node(named(&clique.eliminated), named(&clique.separator), front)?;
            for &child in &children {
                if let Some(child) = self.nodes.get_mut(&child) {
                    child.parent = Some(node);
                }
            }
            if let Some(node) = self.nodes.get_mut(&node) {
                node.children.extend(children);
            }
            if let Some(&first) = clique.separator.iter().min_by_key(|&&variable| position[variable]) {
                nodes_at[first].push(node);
            }
        }
        Ok(())
    }

    fn add_node(
        &mut self,
        eliminated: Vec<usize>,
        separator: Vec<usize>,
        mut front: Front,
    ) -> Result<usize, Indefinite> {
        let mut first = 0;
        for &variable in &eliminated {
            let Variable { dim, damping, .. } = self.variables[variable];
            if damping > 0.0 {
                front.hold(first, self.solution(variable), damping);
            }
            first += dim;
        }
        let mut damping = LEAST_DAMPING;
        let done = loop {
            if let Some(done) = front.eliminate() {
                break done;
            }
            if damping > MOST_DAMPING {
                return Err(Indefinite { variable: eliminated[0] });
            }
            front.damp(damping);
            damping *= 100.0;
        };
        self.memory = front.numbers;
        let index = self.next_node;
        self.next_node += 1;
        for &variable in &eliminated {
            self.variables[variable].node = Some(index);
        }
        let children = BTreeSet::new();
        self.nodes.insert(
            index,
            Node { eliminated, separator, front: done, parent: None, children, solved_for: None },
        );
        Ok(index)
    }
}

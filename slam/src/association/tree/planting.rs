//! New fronts in the place of those that a change cut off.

use super::{Indefinite, NONE, Node, Tree};
use crate::association::front::Front;
use crate::association::order::Clique;
use std::rc::Rc;

impl Tree {
    /// Which of the affected variables meet, and the terms that no orphan holds.
    pub(super) fn meetings(
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
    pub(super) fn plant(
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
}

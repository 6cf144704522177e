//! The symbolic half: which variable sits where, and which entries of the reduced system can be non-zero.

use crate::graph::Graph;
use crate::variable::{Key, Values};
use faer::Side;
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::cholesky::{SymbolicCholesky, factorize_symbolic_cholesky};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// A variable that stays in the sparse system.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kept {
    pub key: Key,
    /// First column of the reduced system.
    pub column: usize,
    pub dim: usize,
}

/// A latent or an offset that is eliminated inside its own object.
#[derive(Clone, Debug)]
pub(super) struct Local {
    pub key: Key,
    pub dim: usize,
    /// Kept variables its factors touch: index in [`Structure::kept`] and first column of the coupling block.
    pub neighbours: BTreeMap<usize, usize>,
    /// Columns of the coupling block.
    pub width: usize,
}

/// Where a free variable sits; held variables have no place.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place {
    Kept(usize),
    Local(usize),
}

/// The layout of the normal equations of one graph over its free variables.
pub struct Structure {
    pub(super) kept: Vec<Kept>,
    pub(super) locals: Vec<Local>,
    pub(super) places: BTreeMap<Key, Place>,
    /// Columns of the reduced system.
    pub(super) columns: usize,
    /// Lower triangle, compressed columns.
    pub(super) column_starts: Vec<usize>,
    pub(super) row_indices: Vec<usize>,
    /// For a block (row block, column block) below the diagonal: rows before it in each of its columns, not
    /// counting the diagonal block's.
    pub(super) block_offsets: BTreeMap<(usize, usize), usize>,
    pub(super) symbolic: Option<SymbolicCholesky<usize>>,
}

impl Structure {
    /// Lays out the variables for which `is_free` holds; `None` if the system is too large to index.
    pub fn new(graph: &Graph<'_>, values: &Values, is_free: impl Fn(Key) -> bool) -> Option<Self> {
        let locals = local_keys(graph, &is_free);
        let mut structure = Structure {
            kept: Vec::new(),
            locals: Vec::new(),
            places: BTreeMap::new(),
            columns: 0,
            column_starts: vec![0],
            row_indices: Vec::new(),
            block_offsets: BTreeMap::new(),
            symbolic: None,
        };
        for (key, value) in values.iter().filter(|(key, _)| is_free(*key)) {
            let dim = value.dim();
            if locals.contains(&key) {
                structure.places.insert(key, Place::Local(structure.locals.len()));
                structure.locals.push(Local { key, dim, neighbours: BTreeMap::new(), width: 0 });
            } else {
                structure.places.insert(key, Place::Kept(structure.kept.len()));
                structure.kept.push(Kept { key, column: structure.columns, dim });
                structure.columns += dim;
            }
        }
        let below = structure.adjacency(graph);
        structure.fill_pattern(&below);
        if structure.columns > 0 {
            let (order, fill) = (Default::default(), Default::default());
            let symbolic = factorize_symbolic_cholesky(structure.pattern(), Side::Lower, order, fill).ok()?;
            structure.symbolic = Some(symbolic);
        }
        Some(structure)
    }

    /// Non-zeros of the lower triangle of the reduced system.
    pub fn entries(&self) -> usize {
        self.row_indices.len()
    }

    /// Columns of the reduced system.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// The columns of a variable of the reduced system.
    pub fn span(&self, key: Key) -> Option<Range<usize>> {
        match self.places.get(&key) {
            Some(Place::Kept(block)) => {
                let kept = self.kept[*block];
                Some(kept.column..kept.column + kept.dim)
            }
            _ => None,
        }
    }

    /// The index of a latent that is eliminated inside its object.
    pub fn local_index(&self, key: Key) -> Option<usize> {
        match self.places.get(&key) {
            Some(Place::Local(index)) => Some(*index),
            _ => None,
        }
    }

    /// For each column of a latent's coupling block, the column of the reduced system.
    pub fn neighbour_columns(&self, local_index: usize) -> Vec<usize> {
        let neighbours = self.locals[local_index].neighbours.keys();
        neighbours
            .flat_map(|&block| {
                let kept = self.kept[block];
                kept.column..kept.column + kept.dim
            })
            .collect()
    }

    pub(super) fn pattern(&self) -> SymbolicSparseColMatRef<'_, usize> {
        SymbolicSparseColMatRef::new_checked(
            self.columns,
            self.columns,
            &self.column_starts,
            None,
            &self.row_indices,
        )
    }

    /// Where a block (row block, column block) of the lower triangle is in its columns, for [`Structure::entry`]; `None` where it is zero.
    pub(super) fn shift(&self, blocks: (usize, usize)) -> Option<usize> {
        let (row_block, column_block) = blocks;
        if row_block == column_block {
            return Some(0);
        }
        Some(self.kept[column_block].dim + self.block_offsets.get(&blocks)?)
    }

    /// Index, in the compressed columns, of entry (row, column) of a block with a shift; on the diagonal `row >= column`.
    pub(super) fn entry(&self, column_block: usize, shift: usize, row: usize, column: usize) -> usize {
        self.column_starts[self.kept[column_block].column + column] + shift + row - column
    }

    /// For each kept variable, the later kept variables it shares a factor or a latent with.
    fn adjacency(&mut self, graph: &Graph<'_>) -> Vec<BTreeSet<usize>> {
        let mut below = vec![BTreeSet::new(); self.kept.len()];
        let mut connect = |blocks: &[usize]| {
            for &a in blocks {
                below[a].extend(blocks.iter().filter(|&&b| b > a));
            }
        };
        for factor in graph.factors() {
            let mut kept = Vec::new();
            let mut local = None;
            for key in factor.keys() {
                match self.places.get(key) {
                    Some(Place::Kept(block)) => kept.push(*block),
                    Some(Place::Local(index)) => local = Some(*index),
                    None => {}
                }
            }
            match local {
                Some(index) => self.locals[index].neighbours.extend(kept.iter().map(|&block| (block, 0))),
                None => connect(&kept),
            }
        }
        for local in &mut self.locals {
            for (block, offset) in &mut local.neighbours {
                *offset = local.width;
                local.width += self.kept[*block].dim;
            }
            connect(&local.neighbours.keys().copied().collect::<Vec<_>>());
        }
        below
    }

    fn fill_pattern(&mut self, below: &[BTreeSet<usize>]) {
        let dim = |block: &usize| self.kept[*block].dim;
        let entries = |(block, below): (usize, &BTreeSet<usize>)| {
            dim(&block) * (dim(&block) + below.iter().map(dim).sum::<usize>())
        };
        self.row_indices.reserve_exact(below.iter().enumerate().map(entries).sum());
        self.column_starts.reserve_exact(self.columns);
        for (block, rows_below) in below.iter().enumerate() {
            let Kept { column: first, dim, .. } = self.kept[block];
            let mut offset = 0;
            for &row_block in rows_below {
                self.block_offsets.insert((row_block, block), offset);
                offset += self.kept[row_block].dim;
            }
            for column in 0..dim {
                self.row_indices.extend(first + column..first + dim);
                for &row_block in rows_below {
                    let Kept { column: row, dim, .. } = self.kept[row_block];
                    self.row_indices.extend(row..row + dim);
                }
                self.column_starts.push(self.row_indices.len());
            }
        }
    }
}

/// Free latents and offsets that never meet another of either in a factor.
fn local_keys(graph: &Graph<'_>, is_free: &impl Fn(Key) -> bool) -> BTreeSet<Key> {
    let mut locals = BTreeSet::new();
    let mut coupled = BTreeSet::new();
    for factor in graph.factors() {
        let of_object: Vec<Key> = factor
            .keys()
            .iter()
            .copied()
            .filter(|key| matches!(key, Key::Latent(_) | Key::Offset(_)) && is_free(*key))
            .collect();
        if of_object.len() > 1 {
            coupled.extend(of_object.iter().copied());
        }
        locals.extend(of_object);
    }
    &locals - &coupled
}

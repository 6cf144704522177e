//! Joint covariances of a few variables, from the fronts between them and the root alone.

use super::front::spans;
use super::tree::Tree;
use nalgebra::DMatrix;
use std::collections::BTreeMap;

/// The covariance of some variables of a factorised tree, one behind the other, `[n x n]`; `None` where one of them is not in it.
///
/// With `H = L L^T` it is `Y^T Y` of `Y = L^-1 E`, where `E` selects the variables: each column of `Y` is zero off its variable's path to the root.
pub(super) fn joint_covariance(tree: &Tree, variables: &[usize]) -> Option<DMatrix<f64>> {
    let own = spans(variables.iter().map(|&variable| tree.dim(variable)));
    let columns = own.last().map_or(0, |span| span.end);
    let mut paths = Vec::with_capacity(variables.len());
    // Depth from the root, by node: children before parents.
    let mut depths: BTreeMap<usize, usize> = BTreeMap::new();
    for &variable in variables {
        let mut path = Vec::new();
        let mut at = tree.node_of(variable)?;
        while let Some(node) = tree.node(at) {
            path.push(at);
            at = node.parent;
            if at == usize::MAX {
                break;
            }
        }
        for (depth, &node) in path.iter().rev().enumerate() {
            depths.insert(node, depth);
        }
        paths.push(path);
    }
    let mut nodes: Vec<usize> = depths.keys().copied().collect();
    nodes.sort_by_key(|node| std::cmp::Reverse(depths[node]));
    let mut is_on_path = vec![vec![false; variables.len()]; nodes.len()];
    let position: BTreeMap<usize, usize> = nodes.iter().enumerate().map(|(i, &node)| (node, i)).collect();
    for (i, path) in paths.iter().enumerate() {
        path.iter().for_each(|node| is_on_path[position[node]][i] = true);
    }
    // Right sides by variable, one column of `columns` behind the other.
    let mut right: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for (&variable, span) in variables.iter().zip(&own) {
        let dim = span.len();
        let block = right.entry(variable).or_insert_with(|| vec![0.0; dim * columns]);
        (0..dim).for_each(|i| block[(span.start + i) * dim + i] = 1.0);
    }
    let mut covariance = DMatrix::zeros(columns, columns);
    let (mut panel, mut below) = (Vec::new(), Vec::new());
    for (&index, is_on_path) in nodes.iter().zip(&is_on_path) {
        let front = &tree.node(index)?.front;
        let (f, s) = (front.eliminated(), front.separated());
        let active: Vec<usize> = (own.iter().zip(is_on_path))
            .flat_map(|(span, is_on)| if *is_on { span.clone() } else { 0..0 })
            .collect();
        panel.clear();
        panel.resize(f * active.len(), 0.0);
        below.clear();
        below.resize(s * active.len(), 0.0);
        let inside = spans(front.variables.iter().map(|&variable| tree.dim(variable)));
        for (variable, span) in front.variables.iter().zip(inside) {
            let Some(block) = right.remove(variable) else { continue };
            for (place, &column) in active.iter().enumerate() {
                panel[place * f + span.start..place * f + span.end]
                    .copy_from_slice(&block[column * span.len()..(column + 1) * span.len()]);
            }
        }
        for place in 0..active.len() {
            front.forward(&mut panel[place * f..(place + 1) * f], &mut below[place * s..(place + 1) * s]);
        }
        for (a, &row) in active.iter().enumerate() {
            for (b, &column) in active.iter().enumerate().take(a + 1) {
                let product: f64 = (panel[a * f..(a + 1) * f].iter().zip(&panel[b * f..(b + 1) * f]))
                    .map(|(x, y)| x * y)
                    .sum();
                covariance[(row, column)] += product;
            }
        }
        let outside = spans(front.separator.iter().map(|&variable| tree.dim(variable)));
        for (&variable, span) in front.separator.iter().zip(outside) {
            let dim = span.len();
            let block = right.entry(variable).or_insert_with(|| vec![0.0; dim * columns]);
            for (place, &column) in active.iter().enumerate() {
                let target = &mut block[column * dim..(column + 1) * dim];
                target.iter_mut().zip(&below[place * s..][span.clone()]).for_each(|(t, b)| *t += b);
            }
        }
    }
    covariance.fill_upper_triangle_with_lower_triangle();
    Some(covariance)
}

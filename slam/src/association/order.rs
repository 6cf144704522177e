//! In which order variables are eliminated, and which of them together.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

/// Zeros that a front may hold since variables are eliminated together, as a share of a column.
const ZEROS: f64 = 0.2;

/// Variables eliminated together, and those that they meet later.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Clique {
    pub eliminated: Vec<usize>,
    pub separator: Vec<usize>,
}

/// An order of little fill: by approximate minimum degree (Amestoy, Davis & Duff 1996), those for which `is_last` holds behind all others.
///
/// `meets` lists for each variable the others that it meets, sorted.
pub(super) fn order(meets: &[Vec<usize>], is_last: &[bool]) -> Vec<usize> {
    let first: Vec<usize> = (0..meets.len()).filter(|i| !is_last[*i]).collect();
    let mut place = vec![usize::MAX; meets.len()];
    first.iter().enumerate().for_each(|(p, &i)| place[i] = p);
    let (mut starts, mut rows) = (vec![0], Vec::new());
    for &i in &first {
        rows.extend(meets[i].iter().map(|&j| place[j]).filter(|&p| p != usize::MAX));
        starts.push(rows.len());
    }
    let n = first.len();
    let (mut forward, mut inverse) = (vec![0; n], vec![0; n]);
    let pattern = SymbolicSparseColMatRef::new_checked(n, n, &starts, None, &rows);
    let mut memory = MemBuffer::new(amd::order_scratch::<usize>(n, rows.len()));
    let stack = MemStack::new(&mut memory);
    if amd::order(&mut forward, &mut inverse, pattern, amd::Control::default(), stack).is_err() {
        forward = (0..n).collect();
    }
    let mut order: Vec<usize> = forward.into_iter().map(|p| first[p]).collect();
    order.extend((0..meets.len()).filter(|i| is_last[*i]));
    order
}

/// The fronts of an elimination in an order, each before that in which its separator is eliminated.
pub(super) fn cliques(meets: &[Vec<usize>], order: &[usize], dims: &[usize]) -> Vec<Clique> {
    let n = order.len();
    let mut place = vec![0; n];
    order.iter().enumerate().for_each(|(p, &i)| place[i] = p);
    let mut columns: Vec<Vec<usize>> = vec![Vec::new(); n];
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); n];
    let mut mark = vec![usize::MAX; n];
    for p in 0..n {
        let mut column = Vec::new();
        let mut add = |row: usize| {
            if row > p && mark[row] != p {
                mark[row] = p;
                column.push(row);
            }
        };
        meets[order[p]].iter().for_each(|&j| add(place[j]));
        for child in std::mem::take(&mut children[p]) {
            columns[child].iter().for_each(|&row| add(row));
        }
        column.sort_unstable();
        if let Some(&parent) = column.first() {
            children[parent].push(p);
        }
        columns[p] = column;
    }
    let size = |positions: &[usize]| -> usize { positions.iter().map(|&p| dims[order[p]]).sum() };
    let mut fronts: Vec<(Vec<usize>, Vec<usize>, usize)> = Vec::new();
    let mut front_of = vec![0; n];
    for p in (0..n).rev() {
        let own = dims[order[p]];
        let below = size(&columns[p]);
        let parent = columns[p].first().map(|&first| front_of[first]);
        let merged = parent.filter(|&parent| {
            let whole = fronts[parent].2;
            (whole - below) as f64 <= ZEROS * (whole + own) as f64
        });
        front_of[p] = match merged {
            Some(parent) => {
                fronts[parent].0.push(p);
                fronts[parent].2 += own;
                parent
            }
            None => {
                fronts.push((vec![p], std::mem::take(&mut columns[p]), own + below));
                fronts.len() - 1
            }
        };
    }
    let named = |positions: Vec<usize>| positions.into_iter().map(|p| order[p]).collect();
    let in_order = |(mut eliminated, separator, _): (Vec<usize>, Vec<usize>, usize)| {
        eliminated.reverse();
        Clique { eliminated: named(eliminated), separator: named(separator) }
    };
    fronts.into_iter().rev().map(in_order).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_is_cut_into_fronts_that_hold_its_fill() {
        let n = 70;
        let meets: Vec<Vec<usize>> = (0..n)
            .map(|i| {
                let mut both = vec![(i + 1) % n, (i + n - 1) % n];
                both.sort_unstable();
                both
            })
            .collect();
        let mut is_last = vec![false; n];
        is_last[3] = true;
        let order = order(&meets, &is_last);
        assert_eq!(order.last(), Some(&3));
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..n).collect::<Vec<_>>());
        let cliques = cliques(&meets, &order, &vec![3; n]);
        assert_eq!(cliques.iter().map(|clique| clique.eliminated.len()).sum::<usize>(), n);
        assert!(cliques.iter().all(|clique| clique.separator.len() <= 2), "{cliques:?}");
        assert!(cliques.last().unwrap().separator.is_empty());
    }
}

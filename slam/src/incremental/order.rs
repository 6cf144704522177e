//! The order in which variables are eliminated, and the fronts that follow from it.

use std::collections::BTreeSet;

/// Zeros that a variable's column may get by being merged with the front that its separator is eliminated in, as a share of the column.
const MERGED_ZEROS: f64 = 0.15;

/// Which variables meet: a symmetric relation over `0..n`, as rows of bits.
#[derive(Clone, Debug)]
pub struct Meetings {
    n: usize,
    words: usize,
    bits: Vec<u64>,
}

/// Variables that are eliminated together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Clique {
    /// Those eliminated.
    pub eliminated: Vec<usize>,
    /// Those that they meet and that are eliminated later.
    pub separator: Vec<usize>,
}

impl Meetings {
    /// None, among `n` variables.
    pub fn new(n: usize) -> Self {
        let words = n.div_ceil(64);
        Self { n, words, bits: vec![0; n * words] }
    }

    /// All of these meet each other.
    pub fn connect(&mut self, variables: &[usize]) {
        let mut row = vec![0u64; self.words];
        for &variable in variables {
            row[variable / 64] |= 1 << (variable % 64);
        }
        for &variable in variables {
            let target = &mut self.bits[variable * self.words..][..self.words];
            target.iter_mut().zip(&row).for_each(|(t, r)| *t |= r);
        }
    }

    fn of(&self, variable: usize) -> impl Iterator<Item = usize> {
        let row = &self.bits[variable * self.words..][..self.words];
        row.iter().enumerate().flat_map(|(word, &bits)| {
            std::iter::successors(Some(bits), |bits| Some(bits & bits.wrapping_sub(1)))
                .take_while(|bits| *bits != 0)
                .map(move |bits| 64 * word + bits.trailing_zeros() as usize)
        })
    }

    /// An order of little fill: those of higher `rank` later, and of one rank that which meets fewest others first.
    pub fn order(&self, rank: &[usize]) -> Vec<usize> {
        let mut left = self.clone();
        for variable in 0..self.n {
            left.bits[variable * self.words + variable / 64] &= !(1 << (variable % 64));
        }
        let degree = |left: &Self, variable: usize| -> u32 {
            left.bits[variable * self.words..][..self.words].iter().map(|bits| bits.count_ones()).sum()
        };
        let mut degrees: Vec<u32> = (0..self.n).map(|variable| degree(&left, variable)).collect();
        let mut waiting: BTreeSet<(usize, u32, usize)> =
            (0..self.n).map(|variable| (rank[variable], degrees[variable], variable)).collect();
        let mut order = Vec::with_capacity(self.n);
        while let Some((_, _, first)) = waiting.pop_first() {
            let met: Vec<usize> = left.of(first).collect();
            let mut row = left.bits[first * self.words..][..self.words].to_vec();
            row[first / 64] |= 1 << (first % 64);
            // Those that meet no other than `first` does follow it, and make no fill.
            let is_like_first = |other: &usize| {
                let of_other = &left.bits[other * self.words..][..self.words];
                rank[*other] == rank[first] && of_other.iter().zip(&row).all(|(bits, row)| bits & !row == 0)
            };
            let (followers, met): (Vec<usize>, Vec<usize>) = met.into_iter().partition(is_like_first);
            for &follower in &followers {
                waiting.remove(&(rank[follower], degrees[follower], follower));
            }
            for &gone in [&first].into_iter().chain(&followers) {
                order.push(gone);
                row[gone / 64] &= !(1 << (gone % 64));
            }
            for &other in &met {
                let target = &mut left.bits[other * self.words..][..self.words];
                target.iter_mut().zip(&row).for_each(|(t, r)| *t |= r);
                for &gone in followers.iter().chain([&first, &other]) {
                    target[gone / 64] &= !(1 << (gone % 64));
                }
                let now = degree(&left, other);
                waiting.remove(&(rank[other], degrees[other], other));
                waiting.insert((rank[other], now, other));
                degrees[other] = now;
            }
        }
        order
    }

    /// The fronts of an elimination in an order, each before the one that its separator is eliminated in. `dims` are numbers of a variable.
    pub fn cliques(&self, order: &[usize], dims: &[usize]) -> Vec<Clique> {
        let mut place = vec![0; self.n];
        for (position, &variable) in order.iter().enumerate() {
            place[variable] = position;
        }
        let mut filled = Meetings::new(self.n);
        for (position, &variable) in order.iter().enumerate() {
            let row = &mut filled.bits[position * filled.words..][..filled.words];
            for other in self.of(variable).map(|other| place[other]).filter(|&other| other > position) {
                row[other / 64] |= 1 << (other % 64);
            }
        }
        let mut separators: Vec<Vec<usize>> = Vec::with_capacity(self.n);
        for position in 0..self.n {
            let separator: Vec<usize> = filled.of(position).collect();
            if let [parent, rest @ ..] = separator.as_slice() {
                let row = &mut filled.bits[parent * filled.words..][..filled.words];
                for other in rest {
                    row[other / 64] |= 1 << (other % 64);
                }
            }
            separators.push(separator);
        }
        let size = |positions: &[usize]| -> usize { positions.iter().map(|&p| dims[order[p]]).sum() };
        let mut fronts: Vec<(Vec<usize>, Vec<usize>)> = Vec::new();
        let mut front_of = vec![usize::MAX; self.n];
        for position in (0..self.n).rev() {
            let separator = std::mem::take(&mut separators[position]);
            let own = dims[order[position]];
            let parent = separator.first().map(|&first| front_of[first]);
            let merged = parent.filter(|&parent| {
                let whole = size(&fronts[parent].0) + size(&fronts[parent].1) + own;
                let zeros = whole - own - size(&separator);
                zeros as f64 <= MERGED_ZEROS * whole as f64
            });
            front_of[position] = match merged {
                Some(parent) => {
                    fronts[parent].0.push(position);
                    parent
                }
                None => {
                    fronts.push((vec![position], separator));
                    fronts.len() - 1
                }
            };
        }
        let named = |positions: &[usize]| positions.iter().map(|&position| order[position]).collect();
        let mut cliques = Vec::with_capacity(fronts.len());
        for (eliminated, separator) in fronts.iter().rev() {
            let mut eliminated = eliminated.clone();
            eliminated.reverse();
            cliques.push(Clique { eliminated: named(&eliminated), separator: named(separator) });
        }
        cliques
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_that_closes_is_cut_into_fronts_that_hold_its_fill() {
        let n = 70;
        let mut ring = Meetings::new(n);
        for i in 0..n {
            ring.connect(&[i, (i + 1) % n]);
        }
        let mut rank = vec![0; n];
        rank[3] = 1;
        let order = ring.order(&rank);
        assert_eq!(order.last(), Some(&3));
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..n).collect::<Vec<_>>());
        let cliques = ring.cliques(&order, &vec![6; n]);
        assert_eq!(cliques.iter().map(|clique| clique.eliminated.len()).sum::<usize>(), n);
        assert!(cliques.iter().all(|clique| clique.separator.len() <= 2), "{cliques:?}");
        assert!(cliques.last().unwrap().separator.is_empty());
    }

    #[test]
    fn what_all_meet_is_one_front() {
        let mut all = Meetings::new(5);
        all.connect(&[0, 1, 2, 3, 4]);
        let order = all.order(&[0, 0, 2, 1, 0]);
        assert_eq!(order[3..], [3, 2]);
        let cliques = all.cliques(&order, &[6; 5]);
        assert_eq!(cliques, [Clique { eliminated: order, separator: vec![] }]);
    }
}

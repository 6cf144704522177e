//! Which pixels of a batch lie on one facet.

use super::canvas::NO_FACET;
use std::ops::Range;

/// Pixels of a row that are shaded together.
pub(super) const BATCH: usize = 32;

/// Consecutive pixels of a batch on one facet.
pub(super) struct Run {
    pub columns: Range<usize>,
    pub facet: u32,
}

/// The runs of a batch's pixels, in order.
#[derive(Clone, Copy)]
pub(super) struct Runs<'a> {
    nearest: &'a [u32],
    /// Bit `i` where a run begins at the pixel `i`, after the first.
    breaks: u32,
}

impl<'a> Runs<'a> {
    #[inline(always)]
    pub fn of(nearest: &'a [u32]) -> Self {
        let mut padded = [NO_FACET; BATCH + 1];
        padded[1..=nearest.len()].copy_from_slice(nearest);
        let mut breaks = 0;
        for i in 1..BATCH {
            breaks |= u32::from(padded[i + 1] != padded[i]) << i;
        }
        Self { nearest, breaks }
    }

    /// Whether nothing is drawn on any pixel.
    #[inline(always)]
    pub fn all_empty(&self) -> bool {
        self.breaks == 0 && self.nearest[0] == NO_FACET
    }

    /// Them, from the left.
    #[inline(always)]
    pub fn iter(&self) -> impl Iterator<Item = Run> + use<'a> {
        let Self { nearest, mut breaks } = *self;
        let mut start = 0;
        std::iter::from_fn(
            #[inline(always)]
            move || {
                let facet = *nearest.get(start)?;
                let end = nearest.len().min(breaks.trailing_zeros() as usize);
                breaks &= breaks.wrapping_sub(1);
                let columns = start..end;
                start = end;
                Some(Run { columns, facet })
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_of_equal_facets_and_cover_the_batch() {
        let batches = [
            vec![7; BATCH],
            vec![NO_FACET; BATCH],
            (0..BATCH as u32).collect(),
            vec![NO_FACET, 3, 3, NO_FACET],
            vec![1, 1, NO_FACET, NO_FACET, 1],
            vec![4],
        ];
        for nearest in batches {
            let found: Vec<Vec<u32>> =
                Runs::of(&nearest).iter().map(|run| vec![run.facet; run.columns.len()]).collect();
            let expected: Vec<&[u32]> = nearest.chunk_by(PartialEq::eq).collect();
            assert_eq!(found, expected);
            assert_eq!(Runs::of(&nearest).all_empty(), nearest.iter().all(|&facet| facet == NO_FACET));
        }
    }
}

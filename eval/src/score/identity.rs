//! Identity F1 (Ristani et al., ECCV-W 2016): objects and what is told for them, matched one to one.

use pathfinding::kuhn_munkres::kuhn_munkres;
use pathfinding::matrix::Matrix;
use std::collections::BTreeSet;

/// `2 IDTP / (shown + told)` of detections: `IDTP` is how many are of matched pairs under the matching of true objects and told ones for which that is most.
/// `None` where none shows an object and none is told one.
pub fn identity_f1(shown: &[Option<usize>], told: &[Option<usize>]) -> Option<f64> {
    let names = |of: &[Option<usize>]| of.iter().flatten().copied().collect::<BTreeSet<_>>();
    let (rows, columns): (Vec<usize>, Vec<usize>) =
        (names(shown).into_iter().collect(), names(told).into_iter().collect());
    let counted = shown.iter().flatten().count() + told.iter().flatten().count();
    if counted == 0 {
        return None;
    }
    // As many columns as rows at least, and one of each.
    let mut both = Matrix::new(rows.len().max(1), columns.len().max(rows.len()).max(1), 0_i64);
    for (shown, told) in shown.iter().zip(told) {
        if let (Some(shown), Some(told)) = (shown, told)
            && let (Ok(row), Ok(column)) = (rows.binary_search(shown), columns.binary_search(told))
        {
            both[(row, column)] += 1;
        }
    }
    let (matched, _) = kuhn_munkres(&both);
    Some(2.0 * matched as f64 / counted as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn objects(labels: &[i32]) -> Vec<Option<usize>> {
        labels.iter().map(|label| usize::try_from(*label).ok()).collect()
    }

    #[test]
    fn names_say_nothing_and_splits_count_once() {
        let shown = objects(&[0, 0, 0, 0, 1, 1]);
        assert_eq!(identity_f1(&shown, &objects(&[7, 7, 7, 7, 3, 3])), Some(1.0));
        // The larger half of the split object is matched, the smaller one is both missed and false.
        assert_relative_eq!(identity_f1(&shown, &objects(&[7, 7, 7, 8, 3, 3])).unwrap(), 10.0 / 12.0);
        assert_relative_eq!(identity_f1(&shown, &objects(&[7, 7, 7, 7, 7, 7])).unwrap(), 8.0 / 12.0);
    }

    #[test]
    fn what_is_told_of_nothing_and_what_is_not_told_counts_against_it() {
        let f1 = identity_f1(&objects(&[0, 0, -1, 1]), &objects(&[5, -1, 6, -1])).unwrap();
        assert_relative_eq!(f1, 2.0 / 5.0);
        assert_eq!(identity_f1(&objects(&[-1]), &objects(&[-1])), None);
        assert_eq!(identity_f1(&objects(&[0]), &objects(&[-1])), Some(0.0));
    }

    #[test]
    fn the_matching_is_the_best_of_all() {
        // Greedy by the largest entry would match 3 + 0.
        let shown = objects(&[0, 0, 0, 0, 0, 1, 1]);
        let told = objects(&[9, 9, 9, 4, 4, 9, 9]);
        assert_relative_eq!(identity_f1(&shown, &told).unwrap(), 8.0 / 14.0);
    }
}

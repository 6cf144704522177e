//! How right it is what views of objects were taken for.

use crate::score::azimuth::SeenSide;
use crate::score::clustering::cluster_scores;

/// The adjusted Rand index of what views were taken for; one that was taken for nothing is of an object of its own. `None` of no view.
pub fn ari(views: &[SeenSide]) -> Option<f64> {
    let truth: Vec<usize> = views.iter().map(|view| view.object).collect();
    let free = 1 + views.iter().filter_map(|view| view.taken_for).max().unwrap_or(0);
    let told: Vec<usize> =
        views.iter().zip(free..).map(|(view, own)| view.taken_for.unwrap_or(own)).collect();
    cluster_scores(&truth, &told).map(|scores| scores.ari)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(views: &[(usize, Option<usize>)]) -> Option<f64> {
        let view = |(step, &(object, taken_for)): (usize, &(usize, Option<usize>))| SeenSide {
            step,
            object,
            taken_for,
        };
        ari(&views.iter().enumerate().map(view).collect::<Vec<_>>())
    }

    #[test]
    fn numbers_say_nothing_and_views_of_nothing_are_each_alone() {
        assert_eq!(of(&[]), None);
        let told =
            |told: [Option<usize>; 4]| of(&[(0, told[0]), (0, told[1]), (1, told[2]), (1, told[3])]).unwrap();
        assert_eq!(told([Some(7), Some(7), Some(2), Some(2)]), 1.0);
        assert_eq!(told([Some(3), Some(3), Some(3), Some(3)]), 0.0);
        let lost = told([Some(7), Some(7), None, None]);
        assert_eq!(lost, told([Some(0), Some(0), Some(1), Some(2)]));
        assert!(lost > 0.0 && lost < 1.0, "{lost}");
        assert!(told([Some(0), Some(1), Some(0), Some(1)]) < 0.0, "worse than by chance");
    }
}

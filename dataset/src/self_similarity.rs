//! How the look of an object changes as it turns about the vertical: its symmetry, measured.
//!
//! ```text
//! D(t) = mean over a of |I(a) - I(a + t)|       I(a): image from the azimuth a, 0 to 1, black around the object
//! contrast = mean over t of D(t)                left over at order n = max over k of D(2 pi k / n) / contrast
//! ```

use crate::{Crop, Symmetry};
use std::f64::consts::TAU;

/// Orders that are looked for.
const ORDERS: [u8; 8] = [2, 3, 4, 5, 6, 8, 10, 12];
/// An object is seen from all round if each multiple of this part of a turn lies between two of its images.
const ALL_ROUND: u8 = 12;
/// An order is one of the object's if no more than this is left over.
const ALIKE: f64 = 0.25;
/// Of less contrast all turns look alike.
const FAINT: f64 = 0.04;
/// Turns between two photographs are rounded to so many parts of a full one: five degrees each.
const PARTS: usize = 72;
/// Fewer photographs tell no symmetry.
const FEWEST: usize = 24;

/// Differences between the looks of an object before and after turns about the vertical.
#[derive(Clone, Debug, PartialEq)]
pub struct SelfSimilarity {
    /// After the index's share of a full turn: of the greatest difference there can be. None where no two images are such a turn apart.
    differences: Vec<Option<f64>>,
}

impl SelfSimilarity {
    /// Of `D(t)`, 0 to 1, after equal parts of a full turn.
    pub fn new(differences: Vec<Option<f64>>) -> Self {
        Self { differences }
    }

    /// Of crops by azimuth, radians, of one light and elevation; none of fewer than 24.
    pub fn of_crops(crops: &[(f64, &Crop)]) -> Option<Self> {
        if crops.len() < FEWEST {
            return None;
        }
        let mut sums = vec![(0.0, 0usize); PARTS];
        for (a, one) in crops {
            for (b, other) in crops {
                let turn = ((b - a).rem_euclid(TAU) / TAU * PARTS as f64).round() as usize % PARTS;
                let (sum, pairs) = &mut sums[turn];
                *sum += difference(one, other);
                *pairs += 1;
            }
        }
        let mean = |(sum, pairs): (f64, usize)| (pairs > 0).then(|| sum / pairs as f64);
        Some(Self::new(sums.into_iter().map(mean).collect()))
    }

    /// Mean difference over all turns, as a share of the greatest there can be.
    pub fn contrast(&self) -> f64 {
        let known: Vec<f64> = self.differences.iter().skip(1).copied().flatten().collect();
        known.iter().sum::<f64>() / known.len().max(1) as f64
    }

    /// Greatest difference after turns of which `order` make a full one, as a share of the contrast; 0 of what looks the same from all
    /// round. None where no images are those turns apart.
    pub fn left_over(&self, order: u8) -> Option<f64> {
        let parts = self.differences.len();
        if parts == 0 || !parts.is_multiple_of(usize::from(order)) {
            return None;
        }
        let mut turns = self.differences.iter().step_by(parts / usize::from(order));
        let greatest = turns.try_fold(0.0, |greatest: f64, turn| Some(greatest.max((*turn)?)))?;
        Some(if greatest > 0.0 { greatest / self.contrast() } else { 0.0 })
    }

    /// The order of the symmetry, where it has one; else that which leaves the least over, of those that are looked for.
    pub fn most_alike(&self) -> u8 {
        if let Symmetry::Cyclic { order } = self.symmetry() {
            return order;
        }
        let left_over = |order: &u8| self.left_over(*order).unwrap_or(f64::INFINITY);
        ORDERS.into_iter().min_by(|a, b| left_over(a).total_cmp(&left_over(b))).unwrap_or(ORDERS[0])
    }

    /// The greatest order that leaves little over.
    pub fn symmetry(&self) -> Symmetry {
        let is_seen_round = self.left_over(ALL_ROUND).is_some();
        if is_seen_round && self.contrast() < FAINT {
            return Symmetry::Revolution;
        }
        let is_alike = |order: &u8| self.left_over(*order).is_some_and(|left| left < ALIKE);
        let greatest = ORDERS.into_iter().rev().find(is_alike);
        greatest.map_or(Symmetry::None, |order| Symmetry::Cyclic { order })
    }
}

/// Mean over the pixels that are not black in both.
fn difference(a: &Crop, b: &Crop) -> f64 {
    let (mut sum, mut pixels) = (0.0, 0usize);
    for (x, y) in a.0.as_chunks::<3>().0.iter().zip(b.0.as_chunks::<3>().0) {
        if *x != [0; 3] || *y != [0; 3] {
            pixels += 1;
            sum += x.iter().zip(y).map(|(x, y)| f64::from(x.abs_diff(*y))).sum::<f64>();
        }
    }
    sum / (3 * 255 * pixels.max(1)) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A crop whose left half is as bright as `look` says at the azimuth, and whose right half is gray.
    fn crop(azimuth: f64, look: fn(f64) -> f64) -> Crop {
        let mut crop = Crop::black();
        for (pixel, rgb) in crop.0.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            *rgb =
                if pixel % 32 < 16 { [(127.0 + 120.0 * look(azimuth)).round() as u8; 3] } else { [100; 3] };
        }
        crop
    }

    fn symmetry(degrees: impl Iterator<Item = usize>, look: fn(f64) -> f64) -> Option<Symmetry> {
        let azimuths: Vec<f64> = degrees.map(|degrees| (degrees as f64).to_radians()).collect();
        let crops: Vec<Crop> = azimuths.iter().map(|&azimuth| crop(azimuth, look)).collect();
        let by_azimuth: Vec<(f64, &Crop)> = azimuths.iter().copied().zip(&crops).collect();
        SelfSimilarity::of_crops(&by_azimuth).map(|similarity| similarity.symmetry())
    }

    #[test]
    fn photographs_tell_the_symmetry_of_a_look() {
        let all = || (0..360).step_by(5);
        assert_eq!(symmetry(all(), |_| 0.3), Some(Symmetry::Revolution));
        assert_eq!(symmetry(all(), f64::cos), Some(Symmetry::None));
        assert_eq!(symmetry(all(), |azimuth| (2.0 * azimuth).cos()), Some(Symmetry::Cyclic { order: 2 }));
        assert_eq!(symmetry(all(), |azimuth| (6.0 * azimuth).cos()), Some(Symmetry::Cyclic { order: 6 }));
    }

    #[test]
    fn photographs_may_be_missing_or_ten_degrees_apart() {
        let twofold = |azimuth: f64| (2.0 * azimuth).cos();
        let some_missing = (0..360).step_by(5).filter(|degrees| degrees % 45 != 0);
        assert_eq!(symmetry(some_missing, twofold), Some(Symmetry::Cyclic { order: 2 }));
        assert_eq!(symmetry((0..360).step_by(10), twofold), Some(Symmetry::Cyclic { order: 2 }));
        assert_eq!(symmetry((0..360).step_by(20), twofold), None);
    }

    #[test]
    fn photographs_of_one_side_tell_no_symmetry() {
        assert_eq!(symmetry(0..60, |azimuth| (2.0 * azimuth).cos()), Some(Symmetry::None));
        assert_eq!(symmetry(0..60, |_| 0.3), Some(Symmetry::None));
        assert_eq!(symmetry((0..24).map(|_| 0), |_| 0.3), Some(Symmetry::None));
    }
}

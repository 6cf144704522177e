//! Crops as other lights and boxes might have given them.

use vantage_dataset::crop::CROP_SIDE;
use vantage_dataset::{Crop, Stream};

/// How far gains of channels differ beside their common one.
const TINT: f64 = 0.2;
/// Pixels by which a crop is moved, at a strength of 1.
const SHIFT: f64 = 4.0;

/// The crop by a gain of `exp(-strength)` to `exp(strength)`, a fifth of that for each channel, and moved by up to `4 strength` pixels each
/// way. What comes into sight repeats the edge.
pub(crate) fn altered(crop: &Crop, strength: f64, stream: &mut Stream) -> Crop {
    let mut within = |reach: f64| stream.uniform(-reach, reach);
    let light = within(strength);
    let gains = [(); 3].map(|()| libm::exp(light + within(TINT * strength)));
    let [down, right] = [(); 2].map(|()| within(SHIFT * strength).round() as isize);
    let mut altered = Crop::black();
    let from = crop.0.as_chunks::<3>().0;
    for (place, pixel) in altered.0.as_chunks_mut::<3>().0.iter_mut().enumerate() {
        let [row, column] = [(place / CROP_SIDE, down), (place % CROP_SIDE, right)]
            .map(|(at, by)| at.saturating_add_signed(by).min(CROP_SIDE - 1));
        let seen = from[row * CROP_SIDE + column];
        *pixel = std::array::from_fn(|channel| (f64::from(seen[channel]) * gains[channel]).round() as u8);
    }
    altered
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_dataset::Seed;

    fn ramp() -> Crop {
        let mut crop = Crop::black();
        for (place, value) in crop.0.iter_mut().enumerate() {
            *value = (place / 3 % CROP_SIDE * 4 + 60) as u8;
        }
        crop
    }

    #[test]
    fn without_strength_nothing_changes_and_the_stream_decides() {
        let at = |strength, seed| altered(&ramp(), strength, &mut Seed(seed).stream("alter", 0));
        assert_eq!(at(0.0, 1), ramp());
        assert_eq!(at(0.5, 1), at(0.5, 1));
        assert_ne!(at(0.5, 1), at(0.5, 2));
    }

    #[test]
    fn gains_and_shifts_reach_as_far_as_they_are_said_to() {
        let mut stream = Seed(3).stream("alter", 0);
        let mut flat = Crop::black();
        flat.0.fill(100);
        let (mut least, mut most) = (u8::MAX, 0);
        for _ in 0..2000 {
            let lit = altered(&flat, 0.5, &mut stream);
            assert!(lit.0.as_chunks::<3>().0.iter().all(|pixel| *pixel == lit.0[..3]), "a shift shows");
            let [red, green] = [lit.0[0], lit.0[1]].map(f64::from);
            assert!((red / green).ln().abs() < 0.23, "{red} and {green}");
            (least, most) = (least.min(lit.0[2]), most.max(lit.0[2]));
        }
        assert!((54..60).contains(&least) && (170..183).contains(&most), "{least} to {most}");

        let mut edge = Crop::black();
        edge.0.as_chunks_mut::<3>().0.iter_mut().step_by(CROP_SIDE).for_each(|pixel| *pixel = [100; 3]);
        let mut columns = [false; CROP_SIDE];
        for _ in 0..500 {
            let moved = altered(&edge, 0.5, &mut stream);
            for (seen, pixel) in columns.iter_mut().zip(&moved.0.as_chunks::<3>().0[..CROP_SIDE]) {
                *seen |= pixel[0] > 0;
            }
        }
        let reached: Vec<usize> = (0..CROP_SIDE).filter(|&column| columns[column]).collect();
        assert_eq!(reached, [0, 1, 2]);
    }
}

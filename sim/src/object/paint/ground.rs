//! Grounds: what covers a surface before anything is written on it.

use super::{Area, Patch, Rgb, mix};
use vantage_dataset::Stream;

/// A kind of two-tone pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ground {
    Plain,
    Fade,
    Bands,
    Pinstripes,
    Diagonals,
    Checks,
    Dots,
    Patches,
}

impl Ground {
    const ALL: [Ground; 8] = [
        Ground::Plain,
        Ground::Fade,
        Ground::Bands,
        Ground::Pinstripes,
        Ground::Diagonals,
        Ground::Checks,
        Ground::Dots,
        Ground::Patches,
    ];

    /// Draws a kind.
    pub fn draw(look: &mut Stream) -> Self {
        Self::ALL[look.below(Self::ALL.len())]
    }

    /// Covers the patch in two tones; `grain` is the size of the pattern in shares of the patch's height.
    pub fn cover(self, patch: &mut Patch<'_>, [base, tone]: [Rgb; 2], grain: f64, look: &mut Stream) {
        patch.fill(base);
        // Whole numbers of repeats close the pattern over the seam of a wrapped patch.
        let rows = libm::round(1.0 / grain).max(1.0);
        let columns = libm::round(patch.aspect() / grain).max(1.0);
        let cell = |p: f64, q: f64| [0.5 * (p + 1.0) * columns, 0.5 * (q + 1.0) * rows];
        let part = |value: f64| value - libm::floor(value);
        let duty = look.uniform(0.3, 0.55);
        match self {
            Ground::Plain => {}
            Ground::Fade => patch.fade(Area::ALL, base, tone),
            Ground::Bands => patch.draw(Area::ALL, |p, q| (part(cell(p, q)[1]) < duty).then_some(tone)),
            Ground::Pinstripes => patch.draw(Area::ALL, |p, q| (part(cell(p, q)[0]) < duty).then_some(tone)),
            Ground::Diagonals => patch.draw(Area::ALL, |p, q| {
                let [s, t] = cell(p, q);
                (part(s + t) < duty).then_some(tone)
            }),
            Ground::Checks => patch.draw(Area::ALL, |p, q| {
                let [s, t] = cell(p, q);
                ((part(0.5 * s) < 0.5) != (part(0.5 * t) < 0.5)).then_some(tone)
            }),
            Ground::Dots => patch.draw(Area::ALL, |p, q| {
                let [s, t] = cell(p, q).map(|value| part(value) - 0.5);
                (s * s + t * t < 0.5 * duty * duty).then_some(tone)
            }),
            Ground::Patches => {
                let noise = Noise::draw(columns as usize, rows as usize, patch.wraps(), look);
                patch.draw(Area::ALL, |p, q| {
                    let [s, t] = cell(p, q);
                    let share = ((noise.at(s, t) - 0.5) * 4.0 + 0.5).clamp(0.0, 1.0);
                    Some(mix(base, tone, share))
                });
            }
        }
    }
}

/// Smooth random values on a lattice of unit cells.
struct Noise {
    columns: usize,
    row_length: usize,
    values: Vec<f64>,
}

impl Noise {
    fn draw(columns: usize, rows: usize, wraps: bool, look: &mut Stream) -> Self {
        let row_length = columns + 1;
        let mut values: Vec<f64> = (0..row_length * (rows + 1)).map(|_| look.unit()).collect();
        if wraps {
            values.chunks_exact_mut(row_length).for_each(|row| row[columns] = row[0]);
        }
        Self { columns, row_length, values }
    }

    fn at(&self, s: f64, t: f64) -> f64 {
        let rows = self.values.len() / self.row_length - 1;
        let column = (libm::floor(s) as usize).min(self.columns - 1);
        let row = (libm::floor(t) as usize).min(rows - 1);
        let smooth = |x: f64| x * x * (3.0 - 2.0 * x);
        let (s, t) = (smooth(s - column as f64), smooth(t - row as f64));
        let corner = row * self.row_length + column;
        let along = |start: usize| self.values[start] + (self.values[start + 1] - self.values[start]) * s;
        let (upper, lower) = (along(corner), along(corner + self.row_length));
        upper + (lower - upper) * t
    }
}

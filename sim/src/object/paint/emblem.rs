//! Logo shapes.

use std::f64::consts::PI;
use vantage_dataset::Stream;

/// A shape inside the square `[-1, 1]^2`, q downwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Emblem {
    Disc,
    Ring,
    Diamond,
    Star,
    Cross,
    Triangle,
    Heart,
    Crescent,
    Bars,
    Arrow,
    Flower,
    House,
}

impl Emblem {
    const ALL: [Emblem; 12] = [
        Emblem::Disc,
        Emblem::Ring,
        Emblem::Diamond,
        Emblem::Star,
        Emblem::Cross,
        Emblem::Triangle,
        Emblem::Heart,
        Emblem::Crescent,
        Emblem::Bars,
        Emblem::Arrow,
        Emblem::Flower,
        Emblem::House,
    ];

    /// Draws a shape.
    pub fn draw(look: &mut Stream) -> Self {
        Self::ALL[look.below(Self::ALL.len())]
    }

    /// Whether the shape covers the point.
    pub fn contains(self, p: f64, q: f64) -> bool {
        let radius = (p * p + q * q).sqrt();
        match self {
            Emblem::Disc => radius <= 0.95,
            Emblem::Ring => (0.5..=0.98).contains(&radius),
            Emblem::Diamond => p.abs() + q.abs() <= 1.0,
            Emblem::Star => {
                let sector = (libm::atan2(p, -q) * 5.0 / (2.0 * PI)).rem_euclid(1.0);
                let from_point = 1.0 - (2.0 * sector - 1.0).abs();
                radius <= 1.0 - 0.6 * from_point
            }
            Emblem::Cross => p.abs().min(q.abs()) <= 0.32 && p.abs().max(q.abs()) <= 0.95,
            Emblem::Triangle => q <= 0.85 && p.abs() <= 0.5 * (q + 1.0),
            Emblem::Heart => {
                let lobe = (p.abs() - 0.45) * (p.abs() - 0.45) + (q + 0.4) * (q + 0.4) <= 0.25;
                lobe || (q > -0.3 && p.abs() <= 0.88 * (0.95 - q) / 1.25)
            }
            Emblem::Crescent => radius <= 0.98 && (p - 0.42) * (p - 0.42) + q * q > 0.5,
            Emblem::Bars => [-0.66, 0.0, 0.66].iter().any(|bar| (q - bar).abs() <= 0.22),
            Emblem::Arrow => (p <= 0.1 && q.abs() <= 0.3) || (p > 0.1 && q.abs() <= 0.95 - p),
            Emblem::Flower => radius <= 0.62 + 0.36 * libm::cos(6.0 * libm::atan2(q, p)) && radius > 0.22,
            Emblem::House => (q <= 0.0 && p.abs() <= q + 1.0) || (q > 0.0 && q <= 0.9 && p.abs() <= 0.7),
        }
    }
}

//! Two passes of the world's origin, and the way round between them.
//!
//! In the frame of the first pass, which has its middle on the x axis and heads along y:
//!
//! ```text
//! pass 1      (d, -p/2) to (d, p/2), and straight on to the gate g = (d, p/2 + corner)
//! way round   at the polar angles atan2(g) - k S / (n + 1), k = 0 .. n + 1, at the radii R f_k; f = 1 at both ends
//! pass 2      pass 1 turned by the angle a, entered by the mirrored gate
//! sweep       S = 2 pi + 2 atan2(g) - a
//! ```
//!
//! R is solved for: the length of the way grows with it.

use super::chain::Chain;
use crate::scene::RevisitSpec;
use nalgebra::{Rotation2, Vector2};
use std::f64::consts::PI;

/// How many of the radii are drawn.
pub const FACTORS: usize = 6;
/// Ends of the range that the factors of radii are drawn from.
pub const FACTOR: [f64; 2] = [0.85, 1.15];
/// Radius of the corners, metres. No gate turns by more than a right angle, so that its arc leaves a pass its length.
const CORNER: f64 = 0.4;
/// Least distance of the way round from a gate, metres.
const OUT: f64 = 0.4;
/// Halvings of the interval that holds the scale: more than a double has bits.
const HALVINGS: u32 = 64;

/// What all seeds have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Revisit {
    spec: RevisitSpec,
    /// Where the first pass is left, frame of the first pass, metres.
    gate: Vector2<f64>,
    /// Angle between neighbouring points of the way round, as seen from the origin, radians.
    step: f64,
}

impl Revisit {
    /// Of a spec that keeps its rules.
    pub fn new(spec: &RevisitSpec) -> Self {
        let gate = Vector2::new(spec.distance, spec.pass / 2.0 + CORNER);
        let sweep = 2.0 * (PI + libm::atan2(gate.y, gate.x)) - spec.angle_deg.to_radians();
        Self { spec: *spec, gate, step: sweep / (FACTORS + 1) as f64 }
    }

    /// The track of one seed, turned about the origin by `turn` radians; `None` where the detour is too short for it.
    pub fn chain(&self, turn: f64, factors: &[f64; FACTORS]) -> Option<Chain> {
        Some(self.at_scale(self.scale(factors)?, turn, factors))
    }

    /// The least detour, metres, with which every seed has a track.
    pub fn least_detour(&self) -> f64 {
        self.detour(self.least_scale(), &[FACTOR[1]; FACTORS])
    }

    /// No seed's track is further from the origin, metres; `None` where the detour is too short.
    pub fn reach(&self) -> Option<f64> {
        Some(FACTOR[1] * self.scale(&[FACTOR[0]; FACTORS])?)
    }

    /// The scale R, metres, at which the detour is as long as it should be.
    fn scale(&self, factors: &[f64; FACTORS]) -> Option<f64> {
        let is_short = |scale: f64| self.detour(scale, factors) < self.spec.detour;
        let mut low = self.least_scale();
        if self.detour(low, factors) > self.spec.detour {
            return None;
        }
        let mut high = 2.0 * low;
        while is_short(high) {
            high *= 2.0;
        }
        for _ in 0..HALVINGS {
            let middle = (low + high) / 2.0;
            if is_short(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(high)
    }

    /// At this scale the way round is beyond the gates, and nowhere nearer to the origin than the passes are.
    fn least_scale(&self) -> f64 {
        let nearest = FACTOR[0] * libm::cos(self.step / 2.0);
        (self.gate.norm() + OUT).max(self.spec.distance / nearest)
    }

    /// Length between the passes, metres.
    fn detour(&self, scale: f64, factors: &[f64; FACTORS]) -> f64 {
        self.at_scale(scale, 0.0, factors).length() - 2.0 * self.spec.pass
    }

    fn at_scale(&self, scale: f64, turn: f64, factors: &[f64; FACTORS]) -> Chain {
        let first = Rotation2::new(turn);
        let second = Rotation2::new(turn + self.spec.angle_deg.to_radians());
        let end = Vector2::new(self.spec.distance, self.spec.pass / 2.0);
        let mirrored = |point: Vector2<f64>| Vector2::new(point.x, -point.y);
        let out = turn + libm::atan2(self.gate.y, self.gate.x);
        let radii = [1.0].into_iter().chain(*factors).chain([1.0]).map(|factor| scale * factor);
        let round = radii.enumerate().map(|(k, radius)| {
            let angle = out - k as f64 * self.step;
            Vector2::new(libm::cos(angle), libm::sin(angle)) * radius
        });
        let points: Vec<Vector2<f64>> = [first * mirrored(end), first * self.gate]
            .into_iter()
            .chain(round)
            .chain([second * mirrored(self.gate), second * end])
            .collect();
        Chain::rounded(&points, false, CORNER)
    }
}

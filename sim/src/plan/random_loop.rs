//! A loop round the world's origin, by harmonics of its radius.
//!
//! ```text
//! r(phi) = R (1 + A sum_k w_k cos(k phi + psi_k)),   k = 2 .. 4,   sum_k w_k = 1
//! ```
//!
//! The first harmonic is left out: it would only move the loop's middle.

use super::chain::Chain;
use crate::scene::RandomLoopSpec;
use nalgebra::Vector2;
use std::f64::consts::PI;

/// How many harmonics there are.
pub const HARMONICS: usize = 3;
/// The lowest.
const LOWEST: usize = 2;
/// The highest.
const HIGHEST: f64 = (LOWEST + HARMONICS - 1) as f64;
/// Points of the polygon that is rounded to the loop.
const POINTS: u32 = 180;

/// What a seed draws of a loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// How much of the deviation each harmonic has: not negative, their sum positive.
    pub weights: [f64; HARMONICS],
    /// Phases of the harmonics, radians.
    pub phases: [f64; HARMONICS],
    /// Where it begins, as seen from the origin, radians.
    pub start: f64,
    /// Whether it goes round clockwise.
    pub clockwise: bool,
}

/// The loop.
pub fn chain(spec: &RandomLoopSpec, shape: &Shape) -> Chain {
    let turn = if shape.clockwise { -2.0 * PI } else { 2.0 * PI };
    let points: Vec<Vector2<f64>> = (0..POINTS)
        .map(|i| {
            let phi = shape.start + turn * f64::from(i) / f64::from(POINTS);
            Vector2::new(libm::cos(phi), libm::sin(phi)) * radius(spec, shape, phi)
        })
        .collect();
    // Arcs from the middle of a side to the middle of the next.
    Chain::rounded(&points, true, f64::INFINITY)
}

/// No loop is longer, metres.
pub fn longest(spec: &RandomLoopSpec) -> f64 {
    2.0 * PI * spec.radius * (1.0 + spec.amplitude + HIGHEST * spec.amplitude)
}

/// Least and greatest distance of any loop from the origin, metres.
pub fn reach(spec: &RandomLoopSpec) -> [f64; 2] {
    [spec.radius * (1.0 - spec.amplitude), spec.radius * (1.0 + spec.amplitude)]
}

fn radius(spec: &RandomLoopSpec, shape: &Shape, phi: f64) -> f64 {
    let total: f64 = shape.weights.iter().sum();
    let harmonics = shape.weights.iter().zip(&shape.phases).enumerate();
    let deviation: f64 = harmonics
        .map(|(i, (weight, phase))| weight / total * libm::cos((LOWEST + i) as f64 * phi + phase))
        .sum();
    spec.radius * (1.0 + spec.amplitude * deviation)
}

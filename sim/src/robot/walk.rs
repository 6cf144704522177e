//! Random walks that touch nothing.

use crate::error::SimError;
use crate::plan::body;
use crate::plan::chain::Chain;
use crate::plan::ground::Ground;
use crate::scene::path::SHARPEST;
use crate::scene::rule::Interval;
use nalgebra::Vector2;
use std::f64::consts::PI;
use vantage_dataset::Stream;

/// Radius of a walk's corners, metres.
const CORNER: f64 = 0.4;
/// Distance between the places of a leg that are looked at, metres.
const STRIDE: f64 = 0.05;
/// Directions and lengths tried for one leg.
const TRIES: usize = 200;
/// Walks begun before giving up.
const RESTARTS: usize = 50;

/// Draws a walk of straight legs that keeps the robot's body `clearance` metres from everything.
pub fn draw(
    legs: u32,
    leg_length: Interval,
    clearance: f64,
    ground: &Ground,
    stream: &mut Stream,
) -> Result<Chain, SimError> {
    let margin = body::RADIUS + clearance;
    let mut longest = 0;
    for _ in 0..RESTARTS {
        let Some(start) = ground.draw_free(margin, stream) else { break };
        let mut points = vec![start];
        while points.len() <= legs as usize {
            let Some(next) = next_point(&points, leg_length, margin, ground, stream) else { break };
            points.push(next);
        }
        if points.len() <= legs as usize {
            longest = longest.max(points.len() - 1);
            continue;
        }
        let chain = Chain::rounded(&points, false, CORNER);
        let strides = (chain.length() / STRIDE).ceil() as u32;
        let keeps_clear = (0..=strides).all(|i| {
            let along = chain.length() * f64::from(i) / f64::from(strides.max(1));
            ground.clearance(&chain.waypoint(along).position) >= margin
        });
        if keeps_clear {
            return Ok(chain);
        }
    }
    Err(SimError::NoWalk { legs: legs as usize, longest })
}

fn next_point(
    points: &[Vector2<f64>],
    leg_length: Interval,
    margin: f64,
    ground: &Ground,
    stream: &mut Stream,
) -> Option<Vector2<f64>> {
    let from = *points.last()?;
    let before = points.len().checked_sub(2).map(|i| from - points[i]);
    (0..TRIES).find_map(|_| {
        let heading = stream.uniform(-PI, PI);
        let length = stream.uniform(leg_length.low(), leg_length.high());
        let leg = Vector2::new(libm::cos(heading), libm::sin(heading)) * length;
        if before.is_some_and(|before| libm::atan2(before.perp(&leg), before.dot(&leg)).abs() > SHARPEST) {
            return None;
        }
        let strides = (length / STRIDE).ceil() as u32;
        let free = (1..=strides)
            .all(|i| ground.clearance(&(from + leg * (f64::from(i) / f64::from(strides)))) >= margin);
        free.then(|| from + leg)
    })
}

//! A pose graph in the g2o format, solved at once.

use crate::Failure;
use crate::clock::cpu_seconds;
use crate::numbers::pose;
use nalgebra::Matrix6;
use std::path::Path;
use std::time::Instant;
use vantage_slam::Key;
use vantage_slam::factor::{BetweenFactor, PosePrior};
use vantage_slam::graph::Graph;
use vantage_slam::solve::{Limits, solve};
use vantage_slam::variable::{Value, Values};

/// The predicted decrease, as a share of the cost, that ends a solution.
const TOLERANCE: f64 = 1e-10;

/// Prints seconds of the processor and on the wall, the cost at the end, and linearisations.
pub fn run(path: &Path) -> Result<(), Failure> {
    let (mut graph, mut start) = (Graph::default(), Values::default());
    for line in std::fs::read_to_string(path)?.lines() {
        let mut words = line.split_whitespace();
        let kind = words.next();
        let numbers: Vec<f64> = words.map(str::parse).collect::<Result<_, _>>()?;
        let key = |i: usize| Key::Robot(numbers[i] as usize);
        match kind {
            Some("VERTEX_SE3:QUAT") => start.insert(key(0), Value::Pose(pose(&numbers[1..]))),
            Some("EDGE_SE3:QUAT") => {
                let root =
                    sqrt_information(&numbers[9..]).ok_or("an information is not positive definite")?;
                graph.push(BetweenFactor::new(key(0), key(1), pose(&numbers[2..]), root));
            }
            _ => {}
        }
    }
    let first = *start.pose(Key::Robot(0)).ok_or("no pose 0")?;
    graph.push(PosePrior::new(Key::Robot(0), first, Matrix6::identity() * 1e6));
    let (cpu, wall) = (cpu_seconds(), Instant::now());
    let solution = solve(&graph, start, |_| true, Limits { iterations: 100, tolerance: TOLERANCE });
    println!("cpu {}\nwall {}", cpu_seconds() - cpu, wall.elapsed().as_secs_f64());
    println!("cost {}\niterations {}", solution.cost, solution.iterations);
    Ok(())
}

/// From an upper triangle, translation first, to a square root, rotation first.
fn sqrt_information(upper: &[f64]) -> Option<Matrix6<f64>> {
    let mut entries = upper.iter();
    let mut information = Matrix6::zeros();
    for row in 0..6 {
        for column in row..6 {
            let (i, j) = ((row + 3) % 6, (column + 3) % 6);
            information[(i, j)] = *entries.next()?;
            information[(j, i)] = information[(i, j)];
        }
    }
    Some(information.cholesky()?.l().transpose())
}

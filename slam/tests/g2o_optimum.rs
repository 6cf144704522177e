//! Pose graphs with known optima (GTSAM's, in `expected.json`): the same minimum from the same start.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

use nalgebra::{Matrix6, Quaternion, Translation3, UnitQuaternion};
use std::io::Write;
use std::path::{Path, PathBuf};
use vantage_dataset::Pose;
use vantage_slam::factor::{BetweenFactor, PosePrior};
use vantage_slam::graph::Graph;
use vantage_slam::solve::{Limits, solve};
use vantage_slam::variable::{Value, Values};
use vantage_slam::{Key, Outcome};

fn folder() -> Option<PathBuf> {
    let root = std::env::var_os("VANTAGE_SHARED").map(PathBuf::from);
    let root = root.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"));
    let folder = root.join("data/g2o");
    folder.is_dir().then_some(folder)
}

fn pose(numbers: &[f64]) -> Pose {
    let rotation = Quaternion::new(numbers[6], numbers[3], numbers[4], numbers[5]);
    let translation = Translation3::new(numbers[0], numbers[1], numbers[2]);
    Pose::from_parts(translation, UnitQuaternion::new_normalize(rotation))
}

/// The upper triangle of an information matrix, translation first, as a square root, rotation first.
fn sqrt_information(upper: &[f64]) -> Matrix6<f64> {
    let mut entries = upper.iter();
    let mut information = Matrix6::zeros();
    for row in 0..6 {
        for column in row..6 {
            let (i, j) = ((row + 3) % 6, (column + 3) % 6);
            information[(i, j)] = *entries.next().unwrap();
            information[(j, i)] = information[(i, j)];
        }
    }
    information.cholesky().unwrap().l().transpose()
}

fn read(path: &Path) -> (Graph<'static>, Values) {
    let (mut graph, mut values) = (Graph::default(), Values::default());
    for line in std::fs::read_to_string(path).unwrap().lines() {
        let mut words = line.split_whitespace();
        let kind = words.next();
        let numbers: Vec<f64> = words.map(|word| word.parse().unwrap()).collect();
        let key = |i: usize| Key::Robot(numbers[i] as usize);
        match kind {
            Some("VERTEX_SE3:QUAT") => values.insert(key(0), Value::Pose(pose(&numbers[1..]))),
            Some("EDGE_SE3:QUAT") => {
                let information = sqrt_information(&numbers[9..]);
                graph.push(BetweenFactor::new(key(0), key(1), pose(&numbers[2..]), information));
            }
            _ => {}
        }
    }
    (graph, values)
}

#[test]
fn reaches_the_published_optimum() {
    let Some(folder) = folder() else {
        let told = "SKIPPED: no pose graphs; set VANTAGE_SHARED to a folder that holds data/g2o";
        writeln!(std::io::stderr(), "{told}").unwrap();
        return;
    };
    let text = std::fs::read_to_string(folder.join("expected.json")).unwrap();
    let expected: serde_json::Value = serde_json::from_str(&text).unwrap();
    let graphs = expected["graphs"].as_array().unwrap();
    assert!(!graphs.is_empty());
    for entry in graphs {
        let name = entry["file"].as_str().unwrap();
        let number = |field: &str| entry[field].as_f64().unwrap();
        let (mut graph, values) = read(&folder.join(name));
        let initial = graph.cost(&values).unwrap();
        assert!((initial / number("half_chi2_initial") - 1.0).abs() < 1e-6, "{name}: starts at {initial}");
        let first = *values.pose(Key::Robot(0)).unwrap();
        graph.push(PosePrior::new(Key::Robot(0), first, Matrix6::identity() * 1e6));
        let start = std::time::Instant::now();
        let solution = solve(&graph, values, |_| true, Limits { iterations: 100, tolerance: 1e-10 });
        let optimum = number("half_chi2_LM_from_file_init");
        println!(
            "{name}: {:.6} (expected {optimum:.6}), {}, {} iterations, {:?}",
            solution.cost,
            solution.outcome,
            solution.iterations,
            start.elapsed()
        );
        assert_eq!(solution.outcome, Outcome::Converged, "{name}");
        assert!((solution.cost / optimum - 1.0).abs() < 1e-6, "{name}: got {}", solution.cost);
    }
}

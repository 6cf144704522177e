//! Hashes of the source code behind the stages of the cache: a result made by other code is not taken for this one's.

mod source;
mod sources;
mod supplied;

use std::io;
use std::path::Path;
use std::process::Command;

/// Each stage's name, and the folders and files, from the workspace's root, whose code can change its result.
const STAGES: [(&str, &[&str]); 6] = [
    ("SIMULATED", &["dataset/src", "sim/src", "eval/src/pipeline/episodes.rs", "eval/src/pipeline/views.rs"]),
    (
        "TRAINED",
        &[
            "dataset/src",
            "model/src",
            "sim/src",
            "learn/src",
            "eval/src/pipeline/views.rs",
            "eval/src/pipeline/training.rs",
            "eval/src/pipeline/study.rs",
            "eval/src/pipeline/held_out.rs",
            "eval/src/pipeline/variant_views.rs",
        ],
    ),
    (
        "ESTIMATED",
        &[
            "dataset/src",
            "model/src",
            "learn/src",
            "slam/src",
            "eval/src/pipeline/azimuth_sensor.rs",
            "eval/src/pipeline/estimates",
            "eval/src/pipeline/estimates.rs",
            "eval/src/pipeline/true_views.rs",
            "eval/src/result/run.rs",
            "eval/src/scene_file/estimator.rs",
            "eval/src/scene_file/row.rs",
        ],
    ),
    (
        "ASSOCIATED",
        &[
            "dataset/src",
            "model/src",
            "learn/src",
            "slam/src",
            "eval/src/pipeline/associating.rs",
            "eval/src/pipeline/associations.rs",
            "eval/src/pipeline/associator_row.rs",
            "eval/src/result/metric.rs",
            "eval/src/scene_file/associator.rs",
            "eval/src/scene_file/estimator.rs",
            "eval/src/scene_file/row.rs",
            "eval/src/score",
        ],
    ),
    (
        "FOUND",
        &[
            "dataset/src",
            "model/src",
            "learn/src",
            "slam/src",
            "eval/src/pipeline/associating.rs",
            "eval/src/pipeline/associator_row.rs",
            "eval/src/pipeline/found.rs",
            "eval/src/scene_file/associator.rs",
            "eval/src/scene_file/estimator.rs",
            "eval/src/score/association.rs",
        ],
    ),
    (
        "SCORED",
        &[
            "dataset/src",
            "model/src",
            "learn/src",
            "eval/src/pipeline/held_out.rs",
            "eval/src/pipeline/known_views.rs",
            "eval/src/pipeline/unseen.rs",
            "eval/src/result/distribution.rs",
            "eval/src/result/metric.rs",
            "eval/src/scene_file/row_name.rs",
            "eval/src/result/statistics.rs",
            "eval/src/score",
        ],
    ),
];

/// What decides how all of it is built.
const SETTINGS: [&str; 8] = [
    "Cargo.lock",
    "Cargo.toml",
    "dataset/Cargo.toml",
    "model/Cargo.toml",
    "sim/Cargo.toml",
    "learn/Cargo.toml",
    "slam/Cargo.toml",
    "eval/Cargo.toml",
];

fn main() -> io::Result<()> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let compiler = Command::new(rustc).arg("-vV").output()?.stdout;
    for (stage, sources) in STAGES {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&compiler);
        for place in sources.iter().chain(&SETTINGS) {
            let path = Path::new("..").join(place);
            println!("cargo::rerun-if-changed={}", path.display());
            source::add(&mut hasher, &path)?;
        }
        println!("cargo::rustc-env=VANTAGE_CODE_{stage}={}", hasher.finalize().to_hex());
    }
    let root = Path::new("..");
    for folder in sources::FOLDERS {
        println!("cargo::rerun-if-changed={}", root.join(folder).display());
    }
    println!("cargo::rustc-env=VANTAGE_SOURCES={}", sources::hash(root)?);
    let out = std::env::var_os("OUT_DIR").ok_or_else(|| io::Error::other("cargo sets OUT_DIR"))?;
    supplied::write(&Path::new(&out).join("supplied.rs"))
}

//! What a program is built without unless a feature asks for it.

use crate::exit::{Ends, Exit};
use thiserror::Error;

/// Something was asked of a program that was built without it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum LeftOut {
    /// `bench train`, `bench study`, `--train`, and scenes that name no model.
    #[error("{}", remedy("training", "train"))]
    Training,
    /// `--gpu`.
    #[error("{}", remedy("GPUs", "gpu"))]
    Gpu,
    /// `--rerun`.
    #[error("{}", remedy("Rerun", "rerun"))]
    Rerun,
    /// Parquet, and BigBIRD with its HDF5 files.
    #[error("{}", remedy("Parquet and HDF5", "formats"))]
    Formats,
}

impl Ends for LeftOut {
    fn exit(&self) -> Exit {
        Exit::MissingCapability
    }
}

fn remedy(what: &str, feature: &str) -> String {
    format!(
        "this program was built without {what}: use `cargo run --release --features {feature} --bin bench --`, \
         or `cargo install --path eval --locked --features {feature}`"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_names_a_feature_of_the_package() {
        let package = include_str!("../Cargo.toml");
        for part in [LeftOut::Training, LeftOut::Gpu, LeftOut::Rerun, LeftOut::Formats] {
            let said = part.to_string();
            let (_, feature) = said.rsplit_once("--features ").unwrap();
            assert!(package.contains(&format!("\n{} = [", feature.trim_end_matches('`'))), "{said}");
        }
    }
}

//! Our scores against those of others: evo for trajectories, scikit-learn for clusters, BenchBot for maps of objects.
//!
//! The published values are found in `$VANTAGE_SHARED`, or in `../shared` beside the workspace; without them these
//! tests say that they were skipped.

mod clustering;
mod object_maps;
mod trajectory;

use std::io::Write;
use std::path::PathBuf;

/// The path of a file of test data, or `None`, said on standard error, which the test harness does not swallow.
fn test_data(relative: &str) -> Option<PathBuf> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared");
    let root = std::env::var_os("VANTAGE_SHARED").map_or_else(|| PathBuf::from(beside), PathBuf::from);
    let path = root.join("data").join(relative);
    if path.exists() {
        return Some(path);
    }
    let _ = writeln!(std::io::stderr(), "SKIPPED: no test data at {}; set VANTAGE_SHARED", path.display());
    None
}

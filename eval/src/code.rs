//! The source code behind each stage, by its hash with that of the manifests, `Cargo.lock` and the compiler: part of every key of the cache, so that a
//! change of code is never answered with what older code made. Comments, documentation and tests do not count.

/// What simulates and renders.
pub const SIMULATED: &str = env!("VANTAGE_CODE_SIMULATED");
/// What simulates, renders and trains.
#[cfg(feature = "train")]
pub const TRAINED: &str = env!("VANTAGE_CODE_TRAINED");
/// What runs models and estimates.
pub const ESTIMATED: &str = env!("VANTAGE_CODE_ESTIMATED");
/// What runs models and scores them.
pub const SCORED: &str = env!("VANTAGE_CODE_SCORED");
/// What tells who is who, and scores that.
pub const ASSOCIATED: &str = env!("VANTAGE_CODE_ASSOCIATED");
/// What tells who is who to rows that no episode tells it.
pub const FOUND: &str = env!("VANTAGE_CODE_FOUND");

#[path = "../build/sources.rs"]
mod sources;

/// Whether a checkout of this repository holds the sources that this program was built from.
pub fn is_of(root: &std::path::Path) -> bool {
    sources::hash(root).is_ok_and(|hash| hash == env!("VANTAGE_SOURCES"))
}

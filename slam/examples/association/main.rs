//! Association on cases of others with known truth: see `benches/association.sh`.
//!
//! ```text
//! association victoria FILE SEED           MH-iSAM2's Victoria Park: 412 detections with two candidates
//! association city FILE TRUTH SEED [LINES] City10000: odometry of two modes, every loop true or false; the first LINES lines
//! association mu FILE SEEDS                Mu's simulation at its noise of odometry and at three times that
//! association generated SEEDS              worlds like it: what settings are chosen on
//! ```
//!
//! Candidates are shuffled by the seed. Numbers are printed one a line, after a name. Times are of the processor.

mod clock;
mod mh;
mod objects;
mod scores;

use mimalloc::MiMalloc;
use std::path::Path;
use vantage_dataset::Seed;

/// As in `bench`.
#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

/// What went wrong.
type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["victoria", file, seed] => mh::victoria(Path::new(file), Seed(seed.parse()?)),
        ["city", file, truth, seed] => {
            mh::city(Path::new(file), Path::new(truth), Seed(seed.parse()?), usize::MAX)
        }
        ["city", file, truth, seed, lines] => {
            mh::city(Path::new(file), Path::new(truth), Seed(seed.parse()?), lines.parse()?)
        }
        ["mu", file, seeds] => objects::mu(Path::new(file), seeds.parse()?),
        ["generated", seeds] => objects::generated(seeds.parse()?),
        _ => Err("usage: association victoria FILE SEED | association city FILE TRUTH SEED [LINES] | association mu FILE SEEDS | \
                  association generated SEEDS".into()),
    }
}

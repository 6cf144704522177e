//! Association on cases of others with known truth: see `benches/association.sh`.
//!
//! ```text
//! association victoria FILE SEED            Victoria Park of MH-iSAM2: 412 detections with two candidates
//! association city FILE TRUTH SEED [LINES]  City10000: odometry of two modes, every loop true or false; the first LINES lines
//! association detachable FILE TRUTH SEED [LINES]  the same, of loops those alone that the file says may be false
//! association shuffled FILE SEED LINES      the first LINES lines as shuffled, for others
//! association mu FILE SEEDS                 Mu's simulation at its noise of odometry and at three times that
//! association generated FIRST SEEDS         worlds like it, a new one for each seed; settings are chosen on those from 1000
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

const USAGE: &str = "usage: association victoria FILE SEED | city FILE TRUTH SEED [LINES] | \
                     detachable FILE TRUTH SEED [LINES] | shuffled FILE SEED LINES | mu FILE SEEDS | \
                     generated FIRST SEEDS";

/// What went wrong.
type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["victoria", file, seed] => mh::victoria(Path::new(file), Seed(seed.parse()?)),
        [case @ ("city" | "detachable"), file, truth, seed, ref lines @ ..] if lines.len() < 2 => {
            let lines = lines.first().map_or(Ok(usize::MAX), |lines| lines.parse())?;
            mh::city(Path::new(file), Path::new(truth), Seed(seed.parse()?), lines, case == "city")
        }
        ["shuffled", file, seed, lines] => mh::shuffled(Path::new(file), Seed(seed.parse()?), lines.parse()?),
        ["mu", file, seeds] => objects::mu(Path::new(file), seeds.parse()?),
        ["generated", first, seeds] => {
            let (first, seeds): (u64, u64) = (first.parse()?, seeds.parse()?);
            objects::generated(first..first.saturating_add(seeds))
        }
        _ => Err(USAGE.into()),
    }
}

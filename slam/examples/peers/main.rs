//! Our side of a comparison with another library's back-end: see `benches/peers.sh`.
//!
//! ```text
//! peers ring LATENT GRAPH           writes a graph that grows step by step, with latents of so many numbers
//! peers smooth GRAPH THRESHOLD TIMES MAXIMUM  takes it in step by step, relinearising beyond a threshold; writes seconds of each step, and
//!                                   all values at the end
//! peers batch POSE_GRAPH            solves a pose graph in the g2o format
//! peers landmarks GRAPH MARGINALS   writes a graph of poses and landmarks, and the marginals at its maximum
//! ```
//!
//! Files are of little-endian doubles. Numbers are printed one a line, after a name.

mod batch;
mod clock;
mod landmarks;
mod numbers;
mod ring;
mod smooth;
mod view;

use mimalloc::MiMalloc;
use std::path::Path;

/// As in `bench`.
#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

/// What went wrong.
type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["ring", latent, graph] => ring::write(latent.parse()?, Path::new(graph)),
        ["smooth", graph, threshold, times, maximum] => {
            smooth::run(Path::new(graph), threshold.parse()?, Path::new(times), Path::new(maximum))
        }
        ["batch", graph] => batch::run(Path::new(graph)),
        ["landmarks", graph, marginals] => landmarks::run(Path::new(graph), Path::new(marginals)),
        _ => Err(
            "usage: peers ring LATENT GRAPH | peers smooth GRAPH THRESHOLD TIMES MAXIMUM | peers batch POSE_GRAPH | \
                  peers landmarks GRAPH MARGINALS"
                .into(),
        ),
    }
}

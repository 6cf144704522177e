//! Options for how much is said.

use crate::progress::Loudness;
use clap::Args;

/// How much is said on standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Args)]
pub struct LoudnessArgs {
    /// Says nothing of progress.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Says all there is: why each run failed, how long each stage took.
    #[arg(short, long, global = true)]
    pub verbose: bool,
}

impl From<LoudnessArgs> for Loudness {
    fn from(args: LoudnessArgs) -> Self {
        match (args.quiet, args.verbose) {
            (true, _) => Self::Quiet,
            (_, true) => Self::Verbose,
            _ => Self::Usual,
        }
    }
}

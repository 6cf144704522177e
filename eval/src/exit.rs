//! How `bench` ends.

use crate::error::BenchError;
use std::io::ErrorKind;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;

/// Exit codes, which scripts may rely on. Wrong arguments also end with 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// All was done; for `check`, nothing moved.
    Success = 0,
    /// A scene, argument or baseline that cannot be used: the message says what to change.
    BadInput = 2,
    /// Something the machine lacks, such as a Vulkan driver for `--renderer wgpu`.
    MissingCapability = 3,
    /// Nothing was evaluated: no episode, no detection, no number.
    NothingEvaluated = 4,
    /// Stored data (a cache entry, a model, a results file) is not what was written.
    StoredDataInvalid = 5,
    /// The output or cache folder, or standard output, cannot be written.
    CannotWrite = 6,
    /// `check`: an accuracy moved out of its tolerance.
    Regression = 10,
    /// A bug in this program.
    Bug = 70,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        ExitCode::from(exit as u8)
    }
}

/// What follows the message of a bug or a panic.
const REPORT_A_BUG: &str =
    "This is a bug in bench. Please report it with the lines above, the command and the scene file.";

/// Runs a command to its end, whatever that is: the exit code, and what to say on standard error. A panic, which has
/// said where it happened, is a bug like any other.
pub fn end(run: impl FnOnce() -> Result<Exit, BenchError>) -> (Exit, Option<String>) {
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(exit)) => (exit, None),
        Ok(Err(error)) if error.exit() == Exit::Bug => {
            (Exit::Bug, Some(format!("error: {error}\n{REPORT_A_BUG}")))
        }
        // `bench ... | head`: who stopped reading needs not be told.
        Ok(Err(BenchError::Stdout(error))) if error.kind() == ErrorKind::BrokenPipe => {
            (Exit::CannotWrite, None)
        }
        Ok(Err(error)) => (error.exit(), Some(format!("error: {error}"))),
        Err(_) => (Exit::Bug, Some(REPORT_A_BUG.to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gate::GateError;

    #[test]
    fn a_panic_is_a_bug_to_report_and_an_error_keeps_its_code() {
        let (exit, message) = end(|| -> Result<Exit, BenchError> { panic!("on purpose, to see it caught") });
        assert_eq!(exit as u8, 70);
        assert!(message.unwrap().contains("report it"));
        let (exit, message) = end(|| Err(GateError::Nothing.into()));
        assert_eq!((exit, message.unwrap().contains("report it")), (Exit::NothingEvaluated, false));
        assert_eq!(end(|| Ok(Exit::Regression)), (Exit::Regression, None));
        let unread = || std::io::Error::from(ErrorKind::BrokenPipe);
        assert_eq!(end(|| Err(unread().into())), (Exit::CannotWrite, None));
    }
}

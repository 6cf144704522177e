//! How a command ends.

use super::error::BenchError;
use crate::exit::{Ends, Exit};
use std::io::ErrorKind;
use std::panic::{AssertUnwindSafe, catch_unwind};

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
    use crate::result::output_folder::OutputError;
    use crate::result::results_file::ResultsError;
    use crate::result::table::TableError;
    use crate::scene_file::SceneFileError;
    use std::path::PathBuf;
    use vantage_dataset::store::StoreError;

    #[test]
    fn errors_end_with_the_documented_codes() {
        let path = || PathBuf::from("x");
        let io = || std::io::Error::other("full");
        let gate = GateError::Seed { table: "t".into(), seed: 2 };
        let unfinished = StoreError::Unfinished { folder: path() };
        let cases: [(BenchError, u8); 10] = [
            (unfinished.into(), 5),
            (StoreError::Write { path: path(), source: io() }.into(), 6),
            (SceneFileError::TooLarge { path: path() }.into(), 2),
            (ResultsError::Missing { path: path() }.into(), 2),
            (gate.into(), 2),
            (GateError::Nothing.into(), 4),
            (ResultsError::Format { path: path(), found: 9 }.into(), 5),
            (OutputError { path: path(), source: io() }.into(), 6),
            (io().into(), 6),
            (TableError::Reference { table: "t".into(), reference: "r".into() }.into(), 70),
        ];
        for (error, code) in cases {
            assert_eq!(error.exit() as u8, code, "{error}");
        }
    }

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

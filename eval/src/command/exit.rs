//! How `bench` ends, and the exit code of each error.

use super::error::BenchError;
use super::look::error::LookError;
use super::scene::error::RunError;
use super::validation::error::ValidationError;
#[cfg(feature = "rerun")]
use crate::figure::recording::RecordingError;
use crate::gate::GateError;
use crate::pipeline::StageError;
use crate::result::error::SaveError;
use crate::result::results_file::ResultsError;
use std::io::ErrorKind;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;
use vantage_dataset::store::{StoreError, StoreErrorKind};
use vantage_sim::error::SimError;
use vantage_slam::EstimateError;

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
    /// An interrupt, such as Ctrl-C.
    Interrupted = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        ExitCode::from(exit as u8)
    }
}

impl BenchError {
    /// The exit code this error ends with.
    pub fn exit(&self) -> Exit {
        match self {
            Self::Stage(error) => of_stage(error),
            Self::Save(error) => of_save(error),
            Self::Store(error) => of_store(error),
            Self::Sim(error) => of_sim(error),
            Self::Scene(_)
            | Self::Source(_)
            | Self::FullerResult(_)
            | Self::Entry(_)
            | Self::Variant(_)
            | Self::Dataset(_)
            | Self::ImportRefused(_)
            | Self::Look(LookError::NoPicture { .. })
            | Self::Validation(ValidationError::Undriven { .. })
            | Self::NoFolder { .. }
            | Self::NotOurs { .. }
            | Self::Results(ResultsError::Missing { .. })
            | Self::Gate(GateError::Scene { .. } | GateError::Seed { .. }) => Exit::BadInput,
            Self::Render(_) | Self::LeftOut(_) => Exit::MissingCapability,
            Self::Run(
                RunError::NothingSeen { .. } | RunError::NothingAnswered { .. } | RunError::NothingOf { .. },
            )
            | Self::Validation(ValidationError::NothingSeen { .. })
            | Self::Gate(GateError::Nothing) => Exit::NothingEvaluated,
            Self::Import(_) | Self::Refused(_) | Self::Model(_) | Self::Answer(_) | Self::Results(_) => {
                Exit::StoredDataInvalid
            }
            Self::Output(_) | Self::Stdout(_) => Exit::CannotWrite,
            #[cfg(feature = "rerun")]
            Self::Recording(error) => match error {
                RecordingError::Write { .. } => Exit::CannotWrite,
                RecordingError::Sim(error) => of_sim(error),
            },
            Self::Run(RunError::Panicked { .. })
            | Self::Pairs(_)
            | Self::Trajectory(_)
            | Self::Table(_)
            | Self::Json(_)
            | Self::Csv(_)
            | Self::Figure(_) => Exit::Bug,
        }
    }
}

fn of_stage(error: &StageError) -> Exit {
    match error {
        StageError::Store(error) => of_store(error),
        StageError::Sim(error) => of_sim(error),
        #[cfg(feature = "train")]
        StageError::Train(error) => of_training(error),
        StageError::Scene(_)
        | StageError::Variant(_)
        | StageError::Refused(_)
        | StageError::NoViews { .. }
        | StageError::NothingHeldOut { .. } => Exit::BadInput,
        StageError::Render(_) | StageError::LeftOut(_) => Exit::MissingCapability,
        StageError::Model(_)
        | StageError::Answer(_)
        | StageError::StoredAnswers { .. }
        | StageError::NotFinite { .. }
        | StageError::Estimate(EstimateError::Model(_)) => Exit::StoredDataInvalid,
        StageError::Output(_) => Exit::CannotWrite,
        StageError::Estimate(_) | StageError::Pairs(_) | StageError::Table(_) | StageError::Json(_) => {
            Exit::Bug
        }
    }
}

fn of_save(error: &SaveError) -> Exit {
    match error {
        SaveError::Store(error) => of_store(error),
        SaveError::Output(_) => Exit::CannotWrite,
        SaveError::Json(_) => Exit::Bug,
    }
}

fn of_store(error: &StoreError) -> Exit {
    match error.kind() {
        StoreErrorKind::Choice => Exit::BadInput,
        StoreErrorKind::Stored => Exit::StoredDataInvalid,
        StoreErrorKind::Unwritable => Exit::CannotWrite,
        StoreErrorKind::Bug => Exit::Bug,
    }
}

fn of_sim(error: &SimError) -> Exit {
    match error {
        SimError::Render(_) => Exit::MissingCapability,
        SimError::NonFinite { .. } => Exit::Bug,
        _ => Exit::BadInput,
    }
}

#[cfg(feature = "train")]
fn of_training(error: &vantage_learn::TrainError) -> Exit {
    use vantage_learn::TrainError;
    match error {
        TrainError::Write { .. } => Exit::CannotWrite,
        TrainError::NonFiniteLoss { .. } | TrainError::Stopped { .. } => Exit::NothingEvaluated,
        TrainError::Export(_) => Exit::Bug,
        #[cfg(feature = "gpu")]
        TrainError::NoGpu => Exit::MissingCapability,
        _ => Exit::BadInput,
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
    use crate::result::output_folder::OutputError;
    use crate::result::table::TableError;
    use crate::scene_file::SceneFileError;
    use std::path::PathBuf;

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

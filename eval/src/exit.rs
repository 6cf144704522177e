//! Exit codes of `bench`, and what errors of other crates end with; ours say it where they are.

use std::process::ExitCode;
use vantage_dataset::store::{StoreError, StoreErrorKind};
use vantage_formats::ImportError;
use vantage_formats::trajectory::TrajectoryError;
use vantage_learn::ModelError;
use vantage_model::AnswerError;
use vantage_sim::error::SimError;
use vantage_sim::mesh_file::{MeshFault, MeshFileError};
use vantage_sim::render::RenderError;
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

/// An error that a command may end with.
pub trait Ends {
    /// The exit code that says of which kind it is; unless it says otherwise, what was given cannot be used.
    fn exit(&self) -> Exit {
        Exit::BadInput
    }
}

/// Errors that always end with the same code.
macro_rules! always {
    ($($error:ty => $exit:ident;)*) => {
        $(impl Ends for $error {
            fn exit(&self) -> Exit {
                Exit::$exit
            }
        })*
    };
}

always! {
    AnswerError => StoredDataInvalid;
    ImportError => StoredDataInvalid;
    ModelError => StoredDataInvalid;
    RenderError => MissingCapability;
    TrajectoryError => Bug;
    csv::Error => Bug;
    serde_json::Error => Bug;
    // Of standard output: files have errors with their path.
    std::io::Error => CannotWrite;
}

impl Ends for StoreError {
    fn exit(&self) -> Exit {
        match self.kind() {
            StoreErrorKind::Choice => Exit::BadInput,
            StoreErrorKind::Stored => Exit::StoredDataInvalid,
            StoreErrorKind::Unwritable => Exit::CannotWrite,
            StoreErrorKind::Bug => Exit::Bug,
        }
    }
}

impl Ends for MeshFileError {
    fn exit(&self) -> Exit {
        match &self.fault {
            MeshFault::NotKept(error) => error.exit(),
            _ => Exit::BadInput,
        }
    }
}

impl Ends for SimError {
    fn exit(&self) -> Exit {
        match self {
            SimError::Mesh(error) => error.exit(),
            SimError::Render(error) => error.exit(),
            SimError::NonFinite { .. } => Exit::Bug,
            _ => Exit::BadInput,
        }
    }
}

impl Ends for EstimateError {
    fn exit(&self) -> Exit {
        match self {
            EstimateError::Model(error) => error.exit(),
            EstimateError::Bias { .. } => Exit::BadInput,
            _ => Exit::Bug,
        }
    }
}

#[cfg(feature = "train")]
impl Ends for vantage_learn::TrainError {
    fn exit(&self) -> Exit {
        match self {
            Self::Write { .. } => Exit::CannotWrite,
            Self::NonFiniteLoss { .. } | Self::Stopped { .. } => Exit::NothingEvaluated,
            Self::Export(_) => Exit::Bug,
            #[cfg(feature = "gpu")]
            Self::NoGpu => Exit::MissingCapability,
            _ => Exit::BadInput,
        }
    }
}

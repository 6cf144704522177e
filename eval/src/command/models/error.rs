//! Why models are refused.

use crate::exit::{Ends, Exit};
use thiserror::Error;
use vantage_learn::ModelError;

/// Why models are refused, a line each.
#[derive(Debug, Error)]
#[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
pub struct Refused(pub Vec<ModelError>);

impl Ends for Refused {
    fn exit(&self) -> Exit {
        Exit::StoredDataInvalid
    }
}

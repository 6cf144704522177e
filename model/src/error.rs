//! Why a model gave no answer.

/// Why a model gave no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AnswerError {
    /// The network's output is not a finite number. The detection is dropped and counted.
    #[error(
        "{what}: got a number that is not finite or not positive where it must be; check the model's weights"
    )]
    NonFinite {
        /// Which output.
        what: &'static str,
    },
    /// An output or input has the wrong length.
    #[error("{what}: got {got} numbers, expected {expected}; the model does not fit its manifest")]
    Shape {
        /// Which one.
        what: &'static str,
        /// Its length.
        got: usize,
        /// The length it should have.
        expected: usize,
    },
    /// The inference runtime failed.
    #[error("inference failed: {message}")]
    Runtime {
        /// The runtime's message.
        message: String,
    },
}

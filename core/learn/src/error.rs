//! Errors of `learn`.

use hysteron_base::BadInput;

/// Errors of `learn`.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Bad input: a user error.
    #[error(transparent)]
    BadInput(#[from] BadInput),
    /// A file cannot be read or written.
    #[error(transparent)]
    File(hysteron_base::Error),
    /// Training left the finite numbers; the weights are those before the step.
    #[error(
        "training step {step}: the {what} is {value} (hint: a lower learning rate, or clip the gradient)"
    )]
    NotFinite {
        /// Steps done before this one.
        step: u64,
        /// The loss, or the norm of the gradient.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A training was ended before its first epoch was done.
    #[error("interrupted: the training was ended before its first epoch was done, nothing is kept")]
    NothingTrained,
    /// The tensor library or its device refused.
    #[error("tensors: {0}")]
    Tensors(String),
}

impl From<hysteron_base::Error> for Error {
    fn from(error: hysteron_base::Error) -> Self {
        match error {
            hysteron_base::Error::BadInput(bad) => Self::BadInput(bad),
            other => Self::File(other),
        }
    }
}

/// Result of a function in `learn`.
pub type Result<T> = std::result::Result<T, Error>;

//! Errors of `control`.

use hysteron_base::BadInput;

/// Errors of `control`.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A plan is wrong.
    #[error(transparent)]
    BadInput(#[from] BadInput),
    /// A file could not be read or written.
    #[error(transparent)]
    File(#[from] hysteron_base::Error),
    /// A network could not be trained, read or written.
    #[error(transparent)]
    Learn(#[from] hysteron_learn::Error),
    /// A plan commands a stroke beyond its limit.
    #[error(transparent)]
    Stroke(BadInput),
    /// A plan commands a stroke that changes faster than its limit.
    #[error(transparent)]
    StrokeRate(BadInput),
}

/// Result of a function in `control`.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// The bad input behind this error, if that is what it is.
    pub fn bad_input(&self) -> Option<&BadInput> {
        match self {
            Self::BadInput(bad)
            | Self::Stroke(bad)
            | Self::StrokeRate(bad)
            | Self::Learn(
                hysteron_learn::Error::BadInput(bad)
                | hysteron_learn::Error::File(hysteron_base::Error::BadInput(bad)),
            )
            | Self::File(hysteron_base::Error::BadInput(bad)) => Some(bad),
            Self::File(_) | Self::Learn(_) => None,
        }
    }

    /// The same error with the place of its bad input prefixed.
    pub fn within(self, outer: impl std::fmt::Display) -> Self {
        match self {
            Self::BadInput(bad) => Self::BadInput(bad.within(outer)),
            Self::Stroke(bad) => Self::Stroke(bad.within(outer)),
            Self::StrokeRate(bad) => Self::StrokeRate(bad.within(outer)),
            Self::File(_) | Self::Learn(_) => self,
        }
    }
}

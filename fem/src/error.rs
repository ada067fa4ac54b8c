//! Errors from a mesh file to a stiffness factor.

use hysteron_base::BadInput;

/// Errors of `fem`.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Bad input in the mesh, the material or the supports: a user error.
    #[error(transparent)]
    BadInput(#[from] BadInput),
    /// A file could not be read or written.
    #[error(transparent)]
    File(hysteron_base::Error),
    /// The stiffness matrix has no Cholesky factor: some motion costs no energy, or releases it.
    #[error("the stiffness is not positive definite at unknown {unknown} of {n_unknowns} (hint: {hint})")]
    NotPositiveDefinite {
        /// Index of the pivot that failed, in elimination order.
        unknown: usize,
        /// Number of unknowns.
        n_unknowns: usize,
        /// Hint for the user.
        hint: &'static str,
    },
    /// A computed value is not a number.
    #[error("{quantity} of node {node} is not finite")]
    NotFinite {
        /// Name of the quantity, e.g. `position`.
        quantity: &'static str,
        /// Node, numbered as in the mesh file, from 0.
        node: usize,
    },
}

impl Error {
    /// The bad input behind this error, if that is what it is.
    pub fn bad_input(&self) -> Option<&BadInput> {
        match self {
            Self::BadInput(bad) => Some(bad),
            _ => None,
        }
    }
}

/// A missing file is bad input, as everywhere.
impl From<hysteron_base::Error> for Error {
    fn from(error: hysteron_base::Error) -> Self {
        match error {
            hysteron_base::Error::BadInput(bad) => Self::BadInput(bad),
            refused => Self::File(refused),
        }
    }
}

/// Result of a function in `fem`.
pub type Result<T> = std::result::Result<T, Error>;

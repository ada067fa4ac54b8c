//! Errors of the twin.

use hysteron_base::BadInput;

use hysteron_fit::qp::QpStatus;

/// Errors of `twin`.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The scene or the command is wrong.
    #[error(transparent)]
    BadInput(#[from] BadInput),
    /// A file could not be read or written.
    #[error(transparent)]
    File(#[from] hysteron_base::Error),
    /// The body has no equilibrium factor, or a number is not finite.
    #[error(transparent)]
    Fem(#[from] hysteron_fem::Error),
    /// A network could not be trained, read or written.
    #[error(transparent)]
    Learn(#[from] hysteron_learn::Error),
    /// The command cannot be balanced; the state is the last one that could.
    #[error(
        "no equilibrium found beyond {:.1} % of the step: {cause} (relative residual {relative_residual:.1e}; hint: {hint})",
        100.0 * reached
    )]
    NoEquilibrium {
        /// Part of the step that was balanced, 0 to 1.
        reached: f64,
        /// Where the last attempt stopped.
        relative_residual: f64,
        /// Cause that stopped it.
        cause: Cause,
        /// Hint for the user.
        hint: String,
    },
    /// The stroke of a tendon takes more tension than its bounds allow.
    #[error(
        "tendon {tendon} needs more than its largest tension, {largest} N (hint: reduce the stroke, or raise tension_max_n)"
    )]
    Overloaded {
        /// Its name.
        tendon: String,
        /// Its upper bound [N].
        largest: f64,
    },
}

/// Why a step found no equilibrium: what its last attempt ended with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// The stiffness has no factor: the body can move without force.
    NoFactor,
    /// The QP of the tensions was not solved.
    Qp(QpStatus),
    /// The equilibria that the taut tendons' strokes allow are unstable.
    Unstable,
    /// No part of a Newton step comes closer.
    LineSearch,
    /// The residual grows beyond all bounds.
    Diverged,
    /// The iterations are used up.
    IterationLimit,
    /// An element turns inside out on the way, det F <= 0, where no law means anything.
    Inverted {
        /// Its number in the mesh file, from 0.
        element: usize,
    },
}

impl std::fmt::Display for Cause {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::NoFactor => write!(f, "the stiffness has no factor"),
            Self::Qp(status) => write!(f, "the QP of the tensions is {status}"),
            Self::Unstable => write!(f, "the equilibrium is unstable under these strokes"),
            Self::LineSearch => write!(f, "the line search finds no way closer"),
            Self::Diverged => write!(f, "the iteration diverges"),
            Self::IterationLimit => write!(f, "the iteration does not converge"),
            Self::Inverted { element } => write!(f, "element {element} turns inside out"),
        }
    }
}

/// Result of a function in `twin`.
pub type Result<T> = std::result::Result<T, Error>;

impl hysteron_fit::Failure for Error {
    fn is_local(&self) -> bool {
        matches!(self, Self::NoEquilibrium { .. })
    }
}

impl Error {
    /// The bad input behind this error, if that is what it is.
    pub fn bad_input(&self) -> Option<&BadInput> {
        match self {
            Self::BadInput(bad) => Some(bad),
            Self::File(hysteron_base::Error::BadInput(bad)) => Some(bad),
            Self::Fem(error) => error.bad_input(),
            Self::Learn(hysteron_learn::Error::BadInput(bad)) => Some(bad),
            _ => None,
        }
    }
}

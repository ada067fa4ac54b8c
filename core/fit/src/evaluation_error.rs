//! Searches are compiled once, for an error of their own; a caller's error is stored while they run.

use std::sync::Mutex;

use hysteron_base::BadInput;

use crate::Failure;

/// Why a model gave no value.
#[derive(Debug)]
pub(crate) enum EvaluationError {
    /// Our own.
    Bad(BadInput),
    /// The caller's, which is stored.
    Stored { is_local: bool },
}

impl From<BadInput> for EvaluationError {
    fn from(bad: BadInput) -> Self {
        Self::Bad(bad)
    }
}

impl Failure for EvaluationError {
    fn is_local(&self) -> bool {
        matches!(self, Self::Stored { is_local: true })
    }
}

/// A model as a search calls it: its values at parameters, with the error type erased.
pub(crate) type Erased<'a, V> = &'a (dyn Fn(&[f64]) -> Result<V, EvaluationError> + Sync);

/// Runs a search on `model` and gives its result, or the error of `model` that ended it.
pub(crate) fn aside<V, T, E: Failure>(
    model: impl Fn(&[f64]) -> Result<V, E> + Sync,
    search: impl FnOnce(Erased<V>) -> Result<T, EvaluationError>,
) -> Result<T, E> {
    let stored = Mutex::new(None);
    let erased = |at: &[f64]| {
        model(at).map_err(|error| {
            let is_local = error.is_local();
            let mut stored = stored.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            // What ends a search is not replaced by a neighbour that merely has no value.
            if !(is_local && stored.as_ref().is_some_and(|earlier: &E| !earlier.is_local())) {
                *stored = Some(error);
            }
            EvaluationError::Stored { is_local }
        })
    };
    let found = search(&erased);
    let stored = stored.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    found.map_err(|error| match (error, stored) {
        (EvaluationError::Bad(bad), _) => bad.into(),
        (EvaluationError::Stored { .. }, Some(error)) => error,
        (EvaluationError::Stored { .. }, None) => {
            BadInput::new("residuals", "a value or an error", "neither").into()
        }
    })
}

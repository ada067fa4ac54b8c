//! The error of a verb. Its variant decides the exit code of the program, as it would the status of a server.

use hysteron_base::BadInput;

/// The error of a verb.
#[derive(Debug, thiserror::Error)]
pub enum WorkflowError {
    /// The input is to blame: a user error.
    #[error("{0:#}")]
    BadInput(anyhow::Error),
    /// The verb was interrupted.
    #[error("{0:#}")]
    Cancelled(anyhow::Error),
    /// Everything else: a solver without a solution, a disk that is full.
    #[error("{0:#}")]
    Failed(anyhow::Error),
}

impl From<anyhow::Error> for WorkflowError {
    /// An error that already is one of a verb stays what it is.
    fn from(error: anyhow::Error) -> Self {
        let kind = error.chain().find_map(|cause| cause.downcast_ref::<Self>());
        match kind {
            Some(Self::BadInput(_)) => Self::BadInput(error),
            Some(Self::Cancelled(_)) => Self::Cancelled(error),
            Some(Self::Failed(_)) => Self::Failed(error),
            None if error.chain().any(is_cancelled) => Self::Cancelled(error),
            None if error.chain().any(is_bad) => Self::BadInput(error),
            None => Self::Failed(error),
        }
    }
}

impl WorkflowError {
    /// The error of a type of its own that a verb ended with, as the refused recordings of `check`.
    pub fn downcast_ref<T: std::fmt::Display + std::fmt::Debug + Send + Sync + 'static>(&self) -> Option<&T> {
        let (Self::BadInput(error) | Self::Cancelled(error) | Self::Failed(error)) = self;
        error.downcast_ref()
    }

    /// The bad input in it, if the input is to blame: where, what was expected, what was found, and a hint.
    pub fn bad_input(&self) -> Option<&BadInput> {
        let (Self::BadInput(error) | Self::Cancelled(error) | Self::Failed(error)) = self;
        error.chain().find_map(|cause| match cause.downcast_ref::<Self>() {
            Some(inner) => inner.bad_input(),
            None => bad_input(cause),
        })
    }
}

/// A verb was interrupted; the text names the results that are kept.
#[derive(Debug, thiserror::Error)]
#[error("interrupted{0}")]
pub struct Cancelled(String);

impl Cancelled {
    /// Behind "interrupted": what is kept, as in "; nothing is written".
    pub fn new(kept: impl Into<String>) -> Self {
        Self(kept.into())
    }
}

fn is_cancelled(cause: &(dyn std::error::Error + 'static)) -> bool {
    let rig = cause.downcast_ref::<hysteron_rig::Error>();
    cause.is::<Cancelled>() || matches!(rig, Some(hysteron_rig::Error::Interrupted(_)))
}

/// True where the input is to blame.
pub fn is_bad_input(error: &anyhow::Error) -> bool {
    error
        .chain()
        .any(|cause| matches!(cause.downcast_ref(), Some(WorkflowError::BadInput(_))) || is_bad(cause))
}

fn is_bad(cause: &(dyn std::error::Error + 'static)) -> bool {
    bad_input(cause).is_some()
}

/// The bad input that this error is, whichever library found it.
fn bad_input<'a>(cause: &'a (dyn std::error::Error + 'static)) -> Option<&'a BadInput> {
    if let Some(error) = cause.downcast_ref::<hysteron_twin::Error>() {
        return error.bad_input();
    }
    if let Some(error) = cause.downcast_ref::<hysteron_fem::Error>() {
        return error.bad_input();
    }
    if let Some(error) = cause.downcast_ref::<hysteron_control::Error>() {
        return error.bad_input();
    }
    if let Some(error) = cause.downcast_ref::<hysteron_rig::Error>() {
        return error.bad_input();
    }
    if let Some(
        hysteron_learn::Error::BadInput(bad)
        | hysteron_learn::Error::File(hysteron_base::Error::BadInput(bad)),
    ) = cause.downcast_ref()
    {
        return Some(bad);
    }
    if let Some(hysteron_base::Error::BadInput(bad)) = cause.downcast_ref() {
        return Some(bad);
    }
    cause.downcast_ref()
}

#[cfg(test)]
mod tests {
    use anyhow::Context as _;

    use super::*;

    #[test]
    fn bad_input_is_found_through_every_wrapping() {
        let bad = || BadInput::new("place", "this", "that");
        let wrapped = [
            anyhow::Error::new(bad()),
            anyhow::Error::new(hysteron_base::Error::from(bad())),
            anyhow::Error::new(hysteron_fem::Error::from(bad())),
            anyhow::Error::new(hysteron_twin::Error::from(hysteron_fem::Error::from(bad()))),
            anyhow::Error::new(hysteron_rig::Error::from(bad())),
            anyhow::Error::new(hysteron_learn::Error::from(bad())),
            anyhow::Error::new(hysteron_learn::Error::File(hysteron_base::Error::from(bad()))),
            anyhow::Error::new(hysteron_control::Error::from(hysteron_learn::Error::from(bad()))),
            anyhow::Error::new(hysteron_control::Error::from(hysteron_learn::Error::File(bad().into()))),
            Err::<(), _>(bad()).context("while reading").expect_err("an error"),
        ];
        for error in wrapped {
            assert!(is_bad_input(&error), "{error:#}");
            let text = format!("{error:#}");
            let door = WorkflowError::from(error);
            assert!(matches!(door, WorkflowError::BadInput(_)) && door.to_string() == text, "{door:?}");
            assert_eq!(door.bad_input(), Some(&bad()));
            let outside = anyhow::Error::new(door).context("[2/5] identify");
            assert!(is_bad_input(&outside) && matches!(outside.into(), WorkflowError::BadInput(_)));
        }
    }

    #[test]
    fn other_errors_are_failures() {
        let cause = hysteron_twin::Cause::IterationLimit;
        let error = hysteron_twin::Error::NoEquilibrium {
            reached: 0.5,
            relative_residual: 1.0,
            cause,
            hint: String::new(),
        };
        assert!(!is_bad_input(&error.into()));
        assert!(!is_bad_input(&anyhow::anyhow!("disk full")));
        assert!(matches!(anyhow::anyhow!("disk full").into(), WorkflowError::Failed(_)));
    }

    #[test]
    fn an_error_of_a_verb_alone_is_found_behind_its_door() {
        let outside = anyhow::Error::new(BadInput::new("place", "this", "that")).context("while reading");
        let door = WorkflowError::from(outside);
        assert_eq!(door.downcast_ref::<BadInput>().map(|bad| bad.place.as_str()), Some("place"));
        assert!(door.downcast_ref::<Cancelled>().is_none());
    }

    #[test]
    fn an_interrupted_verb_is_cancelled_and_names_the_kept_results() {
        let door = WorkflowError::from(anyhow::Error::new(Cancelled::new("; nothing is written")));
        assert!(matches!(door, WorkflowError::Cancelled(_)), "{door:?}");
        assert_eq!(door.to_string(), "interrupted; nothing is written");
        let rig = anyhow::Error::new(hysteron_rig::Error::Interrupted("the calibration was complete"));
        let door = WorkflowError::from(rig.context("track"));
        assert!(matches!(door, WorkflowError::Cancelled(_)), "{door:?}");
        assert_eq!(door.to_string(), "track: interrupted before the calibration was complete");
    }
}

//! From an error to an exit code.

use hysteron_workflow::WorkflowError;

/// A command that this program had started did not come to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandFailed {
    /// It ended with this exit code, and has reported why.
    Ended(i32),
    /// It was interrupted, as this program was, and has reported it.
    Interrupted,
    /// A signal ended it.
    Killed,
}

impl std::fmt::Display for CommandFailed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Ended(code) => write!(f, "the command failed (exit code {code}); its error is above"),
            Self::Interrupted => write!(f, "interrupted; the same command resumes"),
            Self::Killed => write!(f, "the command was killed"),
        }
    }
}

impl std::error::Error for CommandFailed {}

/// The failed command in an error, also within a `WorkflowError`.
fn failed_command(error: &anyhow::Error) -> Option<&CommandFailed> {
    error.chain().find_map(|cause| {
        cause
            .downcast_ref::<CommandFailed>()
            .or_else(|| cause.downcast_ref::<WorkflowError>()?.downcast_ref())
    })
}

/// 2 where the input is to blame, 1 otherwise.
pub fn exit_code(error: &anyhow::Error) -> u8 {
    match failed_command(error) {
        Some(CommandFailed::Ended(2)) => 2,
        None if hysteron_workflow::is_bad_input(error) => 2,
        _ => 1,
    }
}

/// True where a command that this program had started has printed the error: one line of errors is enough.
pub fn is_reported(error: &anyhow::Error) -> bool {
    failed_command(error).is_some_and(|failed| *failed != CommandFailed::Killed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_that_a_command_reported_is_not_reported_again() {
        let failed = |how: CommandFailed| anyhow::Error::new(how).context("[2/5] identify");
        for (how, code, is_reported_already) in [
            (CommandFailed::Ended(1), 1, true),
            (CommandFailed::Ended(2), 2, true),
            (CommandFailed::Interrupted, 1, true),
            (CommandFailed::Killed, 1, false),
        ] {
            let through_a_door = anyhow::Error::new(WorkflowError::from(failed(how)));
            for error in [failed(how), through_a_door] {
                assert_eq!((exit_code(&error), is_reported(&error)), (code, is_reported_already), "{how:?}");
            }
        }
    }
}

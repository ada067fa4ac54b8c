//! From an error to an exit code.

use hysteron_base::BadInput;

/// A command that this program had started did not come to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandFailed {
    /// It ended with this exit code, and has said why.
    Ended(i32),
    /// It was interrupted, as this program was, and has said so.
    Interrupted,
    /// A signal ended it.
    Killed,
}

impl std::fmt::Display for CommandFailed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Ended(code) => write!(f, "the command failed (exit code {code}) and has said why above"),
            Self::Interrupted => write!(f, "interrupted; the same command goes on from here"),
            Self::Killed => write!(f, "the command was killed"),
        }
    }
}

impl std::error::Error for CommandFailed {}

/// 2 where the input is to blame, 1 otherwise.
pub fn exit_code(error: &anyhow::Error) -> u8 {
    if error.chain().any(is_bad_input) { 2 } else { 1 }
}

/// True where a command that this program had started has printed the error: one line of errors is enough.
pub fn is_told(error: &anyhow::Error) -> bool {
    let failed = error.chain().find_map(|cause| cause.downcast_ref::<CommandFailed>());
    failed.is_some_and(|failed| *failed != CommandFailed::Killed)
}

fn is_bad_input(cause: &(dyn std::error::Error + 'static)) -> bool {
    if let Some(failed) = cause.downcast_ref::<CommandFailed>() {
        return *failed == CommandFailed::Ended(2);
    }
    if let Some(error) = cause.downcast_ref::<hysteron_twin::Error>() {
        return error.bad_input().is_some();
    }
    if let Some(error) = cause.downcast_ref::<hysteron_fem::Error>() {
        return error.bad_input().is_some();
    }
    if let Some(error) = cause.downcast_ref::<hysteron_control::Error>() {
        return error.bad_input().is_some();
    }
    if let Some(error) = cause.downcast_ref::<hysteron_rig::Error>() {
        return error.bad_input().is_some();
    }
    cause.is::<BadInput>()
        || matches!(cause.downcast_ref::<hysteron_base::Error>(), Some(hysteron_base::Error::BadInput(_)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context;

    #[test]
    fn bad_input_is_found_through_every_wrapping() {
        let bad = || BadInput::new("place", "this", "that");
        let wrapped = [
            anyhow::Error::new(bad()),
            anyhow::Error::new(hysteron_base::Error::from(bad())),
            anyhow::Error::new(hysteron_fem::Error::from(bad())),
            anyhow::Error::new(hysteron_twin::Error::from(hysteron_fem::Error::from(bad()))),
            anyhow::Error::new(hysteron_rig::Error::from(bad())),
            Err::<(), _>(bad()).context("while reading").expect_err("an error"),
        ];
        for error in wrapped {
            assert_eq!(exit_code(&error), 2, "{error:#}");
        }
    }

    #[test]
    fn what_a_command_has_told_is_not_told_again() {
        let failed = |how: CommandFailed| anyhow::Error::new(how).context("[2/5] identify");
        for (how, code, is_told_already) in [
            (CommandFailed::Ended(1), 1, true),
            (CommandFailed::Ended(2), 2, true),
            (CommandFailed::Interrupted, 1, true),
            (CommandFailed::Killed, 1, false),
        ] {
            assert_eq!((exit_code(&failed(how)), is_told(&failed(how))), (code, is_told_already), "{how:?}");
        }
    }

    #[test]
    fn other_errors_are_failures() {
        let cause = hysteron_twin::Cause::NotConverged;
        let error = hysteron_twin::Error::NoEquilibrium {
            reached: 0.5,
            relative_residual: 1.0,
            cause,
            hint: String::new(),
        };
        assert_eq!(exit_code(&error.into()), 1);
        assert_eq!(exit_code(&anyhow::anyhow!("disk full")), 1);
    }
}

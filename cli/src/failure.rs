//! From an error to an exit code.

use hysteron_base::BadInput;

/// A command that this program had started failed, and has said why.
#[derive(Debug)]
pub struct CommandFailed(
    /// Its exit code; none if a signal ended it.
    pub Option<i32>,
);

impl std::fmt::Display for CommandFailed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            Some(code) => write!(f, "the command failed (exit code {code}) and has said why above"),
            None => write!(f, "the command was killed"),
        }
    }
}

impl std::error::Error for CommandFailed {}

/// 2 where the input is to blame, 1 otherwise.
pub fn exit_code(error: &anyhow::Error) -> u8 {
    if error.chain().any(is_bad_input) { 2 } else { 1 }
}

fn is_bad_input(cause: &(dyn std::error::Error + 'static)) -> bool {
    if let Some(CommandFailed(code)) = cause.downcast_ref() {
        return *code == Some(2);
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

//! From an error to an exit code.

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
            Self::Ended(code) => write!(f, "the command failed (exit code {code}) and has said why above"),
            Self::Interrupted => write!(f, "interrupted; the same command goes on from here"),
            Self::Killed => write!(f, "the command was killed"),
        }
    }
}

impl std::error::Error for CommandFailed {}

/// 2 where the input is to blame, 1 otherwise.
pub fn exit_code(error: &anyhow::Error) -> u8 {
    let failed = error.chain().find_map(|cause| cause.downcast_ref::<CommandFailed>());
    match failed {
        Some(CommandFailed::Ended(2)) => 2,
        None if hysteron_workflow::is_bad_input(error) => 2,
        _ => 1,
    }
}

/// True where a command that this program had started has printed the error: one line of errors is enough.
pub fn is_told(error: &anyhow::Error) -> bool {
    let failed = error.chain().find_map(|cause| cause.downcast_ref::<CommandFailed>());
    failed.is_some_and(|failed| *failed != CommandFailed::Killed)
}

#[cfg(test)]
mod tests {
    use super::*;

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
}

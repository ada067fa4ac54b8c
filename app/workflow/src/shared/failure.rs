//! Whose fault an error is.

use hysteron_base::BadInput;

/// True where the input is to blame, and whoever gave it can mend it.
pub fn is_bad_input(error: &anyhow::Error) -> bool {
    error.chain().any(is_bad)
}

fn is_bad(cause: &(dyn std::error::Error + 'static)) -> bool {
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
    if let Some(
        hysteron_learn::Error::BadInput(_) | hysteron_learn::Error::File(hysteron_base::Error::BadInput(_)),
    ) = cause.downcast_ref()
    {
        return true;
    }
    cause.is::<BadInput>()
        || matches!(cause.downcast_ref::<hysteron_base::Error>(), Some(hysteron_base::Error::BadInput(_)))
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
    }
}

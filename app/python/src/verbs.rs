//! Verbs of the program, and the program itself.

use std::ffi::OsString;

use hysteron_cli::Invocation;
use hysteron_workflow::tendon::check::Refused;
use hysteron_workflow::{Context, shared::verdict};
use pyo3::prelude::*;

use crate::background;
use crate::errors::exception_of_verb;

/// Runs the program as a terminal would and returns its exit code. `program` are the words that start it again.
#[pyfunction]
pub fn run_program(py: Python<'_>, arguments: Vec<OsString>, program: Vec<OsString>) -> u8 {
    py.detach(|| hysteron_cli::run_program(&Invocation { arguments, program }))
}

/// Runs the verb of these arguments in this process; returns its outcome as JSON.
///
/// `program` are the words that start the program again, `listener` a `pyhysteron._listener.Listener`.
#[pyfunction]
pub fn run_verb(
    py: Python<'_>,
    arguments: Vec<OsString>,
    program: Vec<OsString>,
    listener: &Bound<'_, PyAny>,
) -> PyResult<String> {
    let invocation = Invocation { arguments, program };
    let ended = background::run(py, Some(listener), |progress| {
        hysteron_cli::run_verb(&invocation, |parts| Context {
            progress,
            command: parts.command,
            overwrite: parts.overwrite,
            watchdog: parts.watchdog,
        })
    })?;
    let printed = ended.value(py, |error| {
        let outcome = error.downcast_ref::<Refused>().map(|refused| refused.outcome.json.as_str());
        exception_of_verb(py, &error, outcome)
    })?;
    for line in printed.verdict.iter().flat_map(verdict::lines).chain(printed.lines) {
        listener.call_method1("line", (line,))?;
    }
    Ok(printed.json)
}

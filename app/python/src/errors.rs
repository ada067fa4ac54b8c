//! From an error of a library to a Python exception: the class follows from the variant, the words are those of the program.

use hysteron_base::BadInput;
use hysteron_workflow::WorkflowError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The exception of an error: `pyhysteron.BadInput`, `Cancelled` or `Failed`.
pub fn exception(py: Python<'_>, error: impl Into<anyhow::Error>) -> PyErr {
    let error = error.into();
    match error.downcast() {
        Ok(error) => exception_of_verb(py, &error, None),
        Err(error) => exception_of_verb(py, &WorkflowError::from(error), None),
    }
}

/// The exception of a verb's error, with the outcome that it ended with all the same, as JSON.
pub fn exception_of_verb(py: Python<'_>, error: &WorkflowError, outcome: Option<&str>) -> PyErr {
    made(py, error, outcome)
        .map_or_else(|failure| failure, |exception| PyErr::from_value(exception.into_any()))
}

fn made<'py>(py: Python<'py>, error: &WorkflowError, outcome: Option<&str>) -> PyResult<Bound<'py, PyAny>> {
    let name = match error {
        WorkflowError::BadInput(_) => "BadInput",
        WorkflowError::Cancelled(_) => "Cancelled",
        WorkflowError::Failed(_) => "Failed",
    };
    let class = py.import("pyhysteron._errors")?.getattr(name)?;
    let arguments = PyDict::new(py);
    if let (WorkflowError::BadInput(_), Some(bad)) = (error, error.bad_input()) {
        let BadInput { place, expected, found, hint } = bad;
        for (key, value) in [("place", place), ("expected", expected), ("found", found), ("hint", hint)] {
            arguments.set_item(key, value)?;
        }
    }
    let exception = class.call((error.to_string(),), Some(&arguments))?;
    if let Some(outcome) = outcome {
        exception.setattr("outcome_json", outcome)?;
    }
    Ok(exception)
}

//! The native module of the Python package `pyhysteron`: scenes, twins, recordings and arms as classes, and the verbs of the
//! program in the process of the interpreter.
//!
//! Every class holds one value of another crate and never computes by itself. Long work runs on a thread of its own, so
//! that the interpreter lock is free and Ctrl-C is heard (`background`).

mod arm;
mod arrays;
mod background;
mod errors;
mod log;
mod recording;
mod scene;
mod step_report;
mod twin;
mod verbs;

use pyo3::prelude::*;

/// The native part of `pyhysteron`.
#[pymodule(gil_used = false)]
fn _pyhysteron(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("COMMIT", hysteron_workflow::COMMIT)?;
    module.add_class::<arm::PyArm>()?;
    module.add_class::<recording::PyRecording>()?;
    module.add_class::<scene::PyScene>()?;
    module.add_class::<step_report::PyReachReport>()?;
    module.add_class::<step_report::PyStepReport>()?;
    module.add_class::<twin::PyTwin>()?;
    module.add_class::<twin::PyTwinState>()?;
    module.add_function(wrap_pyfunction!(verbs::run_program, module)?)?;
    module.add_function(wrap_pyfunction!(verbs::run_verb, module)?)
}

//! Reports of one step of a twin.

use hysteron_twin::{ReachReport, StepReport};
use numpy::PyArray1;
use pyo3::prelude::*;

/// Where a step led, with its cost and convergence.
#[pyclass(name = "StepReport", module = "pyhysteron", frozen)]
pub struct PyStepReport {
    pub(crate) tip: [f64; 3],
    pub(crate) tensions: Vec<f64>,
    pub(crate) report: StepReport,
}

#[pymethods]
impl PyStepReport {
    /// Position of the tip (3,) [m], in the frame in which it is recorded.
    #[getter]
    fn tip<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.tip)
    }

    /// Tension of every tendon at its pulled end (n_tendons + n_auxiliary,) [N].
    #[getter]
    fn tensions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.tensions)
    }

    /// Corrections with the lagged factor.
    #[getter]
    fn iterations(&self) -> usize {
        self.report.iterations
    }

    /// Times the lagged factor was replaced.
    #[getter]
    fn refactorisations(&self) -> usize {
        self.report.refactorisations
    }

    /// Newton iterations with the exact tangent; zero in the common case.
    #[getter]
    fn newton_iterations(&self) -> usize {
        self.report.newton_iterations
    }

    /// Parts that the step was divided into; zero in the common case.
    #[getter]
    fn sub_steps(&self) -> usize {
        self.report.sub_steps
    }

    /// Quadratic programs that the active set did not certify.
    #[getter]
    fn clarabel_solves(&self) -> usize {
        self.report.clarabel_solves
    }

    /// Norm of the force residual over that of the applied forces [-].
    #[getter]
    fn relative_residual(&self) -> f64 {
        self.report.relative_residual
    }

    /// Largest stroke error [m].
    #[getter]
    fn stroke_error(&self) -> f64 {
        self.report.stroke_error
    }

    /// Of a chain: how far its largest strain lies beyond those that were validated, over the largest of these [-]; zero
    /// within, and for a mesh.
    #[getter]
    fn outside(&self) -> f64 {
        self.report.outside
    }

    /// True where a chain is bent further than it was validated.
    #[getter]
    fn is_outside(&self) -> bool {
        self.report.outside > 0.0
    }

    fn __repr__(&self) -> String {
        let [x, y, z] = self.tip.map(|c| 1e3 * c);
        format!("<StepReport: tip {x:.3}, {y:.3}, {z:.3} mm, {} iterations>", self.report.iterations)
    }
}

/// How a goal of the tip was met.
#[pyclass(name = "ReachReport", module = "pyhysteron", frozen)]
pub struct PyReachReport {
    pub(crate) reach: ReachReport,
    pub(crate) step: Py<PyStepReport>,
}

#[pymethods]
impl PyReachReport {
    /// Stroke of every tendon (n_tendons + n_auxiliary,) [m]: commanding these gives the same equilibrium.
    #[getter]
    fn strokes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.reach.strokes)
    }

    /// Distance of the tip from the goal [m].
    #[getter]
    fn tip_error(&self) -> f64 {
        self.reach.tip_error
    }

    /// True within the tolerance; otherwise the bounds leave no way closer.
    #[getter]
    fn is_reached(&self) -> bool {
        self.reach.is_reached
    }

    /// Quadratic programs solved, one forward step each.
    #[getter]
    fn rounds(&self) -> usize {
        self.reach.rounds
    }

    /// The forward steps: where the last led, what all cost.
    #[getter]
    fn step(&self, py: Python<'_>) -> Py<PyStepReport> {
        self.step.clone_ref(py)
    }

    fn __repr__(&self) -> String {
        let is_reached = if self.reach.is_reached { "reached" } else { "not reached" };
        format!("<ReachReport: {is_reached}, {:.3} mm from the goal>", 1e3 * self.reach.tip_error)
    }
}

//! Arms: rigid-body dynamics of many states at once.

use std::collections::BTreeMap;
use std::ffi::CString;

use hysteron_arm_dynamics::kernels::{ForwardDynamics, InverseDynamicsKernel, MassMatrix};
use hysteron_arm_dynamics::{Batch, Data, Model, StateKernel, forward_kinematics, frame_pose};
use hysteron_base::BadInput;
use hysteron_workflow::Context;
use hysteron_workflow::arm::RobotOptions;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;

use crate::arrays::{AnyArray, ArrayRows};
use crate::errors::exception;

/// A rigid-body arm: a tree of joints on a fixed base. Never changes.
///
/// States are arrays of one row each (n, n_joints), or a single row (n_joints,); results have the same rows. Many rows are
/// computed on all cores, with the interpreter lock free.
#[pyclass(name = "Arm", module = "pyhysteron", frozen)]
pub struct PyArm {
    model: Model,
}

type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

#[pymethods]
impl PyArm {
    /// Reads a file of URDF, xacro or MJCF, or the built-in robot of that name: "panda", "so101", "scara", …
    ///
    /// `fix_base` holds a robot that floats; `arguments` are those of a xacro file.
    #[staticmethod]
    #[pyo3(signature = (model, *, fix_base=false, arguments=None))]
    fn read(
        py: Python<'_>,
        model: std::path::PathBuf,
        fix_base: bool,
        arguments: Option<BTreeMap<String, String>>,
    ) -> PyResult<Self> {
        let pairs = arguments.unwrap_or_default();
        let arguments = pairs.iter().map(|(name, value)| format!("{name}={value}")).collect();
        let options = RobotOptions { fix_base, arguments };
        let text = model.to_string_lossy();
        let model = py
            .detach(|| options.model_of_any_mass(&text, &Context::silent("pyhysteron")))
            .map_err(|error| exception(py, error))?;
        for warning in &model.notes().warnings {
            let text = CString::new(warning.to_string()).unwrap_or_default();
            PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1)?;
        }
        Ok(Self { model })
    }

    /// Name of the robot.
    #[getter]
    fn name(&self) -> &str {
        self.model.name()
    }

    /// Number of joints that move.
    #[getter]
    fn n_joints(&self) -> usize {
        self.model.n_joints()
    }

    /// Names of the joints, in the order of coordinates.
    #[getter]
    fn joint_names(&self) -> Vec<&str> {
        self.model.joints().iter().map(|joint| joint.name.as_str()).collect()
    }

    /// Names of the frames, for `frame_pose`.
    #[getter]
    fn frame_names(&self) -> Vec<&str> {
        self.model.frames().iter().map(|frame| frame.name.as_str()).collect()
    }

    /// Joint torques τ that a motion takes (n, n_joints) [N m], or [N] of sliding joints: recursive Newton-Euler.
    ///
    /// `q` (n, n_joints) [rad] or [m], `qd` [rad/s], `qdd` [rad/s²].
    fn rnea<'py>(
        &self,
        py: Python<'py>,
        q: AnyArray<'py>,
        qd: AnyArray<'py>,
        qdd: AnyArray<'py>,
    ) -> PyResult<Array<'py>> {
        self.run(py, &InverseDynamicsKernel, &[("q", q), ("qd", qd), ("qdd", qdd)], &[])
    }

    /// Joint accelerations q̈ under torques (n, n_joints) [rad/s²]: articulated bodies.
    ///
    /// `q` (n, n_joints) [rad] or [m], `qd` [rad/s], `tau` [N m].
    fn forward_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: AnyArray<'py>,
        qd: AnyArray<'py>,
        tau: AnyArray<'py>,
    ) -> PyResult<Array<'py>> {
        self.run(py, &ForwardDynamics, &[("q", q), ("qd", qd), ("tau", tau)], &[])
    }

    /// Mass matrix M (n, n_joints, n_joints) [kg m²]: composite bodies.
    ///
    /// `q` (n, n_joints) [rad] or [m].
    fn mass_matrix<'py>(&self, py: Python<'py>, q: AnyArray<'py>) -> PyResult<Array<'py>> {
        self.run(py, &MassMatrix, &[("q", q)], &[self.model.n_joints()])
    }

    /// Position (n, 3) [m] and rotation (n, 3, 3) [-] of a frame in the base.
    ///
    /// `q` (n, n_joints) [rad] or [m]; `frame` is the last one by default.
    #[pyo3(signature = (q, frame=None))]
    fn frame_pose<'py>(
        &self,
        py: Python<'py>,
        q: AnyArray<'py>,
        frame: Option<&str>,
    ) -> PyResult<(Array<'py>, Array<'py>)> {
        let model = &self.model;
        let frame = match frame {
            Some(name) => model.frame(name).map_err(|bad| exception(py, bad))?,
            None => model.frames().len() - 1,
        };
        let rows = ArrayRows::of(q.as_array(), model.n_joints(), "q").map_err(|bad| exception(py, bad))?;
        let (positions, rotations) = py.detach(|| {
            let mut data = Data::new(model, 0.0);
            let (mut positions, mut rotations) = (Vec::new(), Vec::new());
            for q in rows.values.chunks(model.n_joints()) {
                forward_kinematics(model, &mut data, q);
                let pose = frame_pose(model, &data, frame);
                positions.extend(pose.position);
                rotations.extend(pose.rotation.as_flattened());
            }
            (positions, rotations)
        });
        Ok((shaped(py, positions, rows.n_rows, &[3])?, shaped(py, rotations, rows.n_rows, &[3, 3])?))
    }

    fn __repr__(&self) -> String {
        format!("<Arm {:?}: {} joints>", self.model.name(), self.model.n_joints())
    }
}

impl PyArm {
    /// Runs a kernel over rows; a row of the result has `n_joints` numbers, and `further` dimensions behind.
    fn run<'py>(
        &self,
        py: Python<'py>,
        kernel: &impl StateKernel,
        inputs: &[(&str, AnyArray<'py>)],
        further: &[usize],
    ) -> PyResult<Array<'py>> {
        let n_joints = self.model.n_joints();
        let rows: Result<Vec<ArrayRows>, BadInput> =
            inputs.iter().map(|(name, array)| ArrayRows::of(array.as_array(), n_joints, name)).collect();
        let rows = rows.and_then(|rows| same_rows(rows, inputs)).map_err(|bad| exception(py, bad))?;
        let n_rows = rows[0].n_rows;
        let sizes: Vec<usize> = std::iter::once(n_joints).chain(further.iter().copied()).collect();
        let out = py.detach(|| {
            let inputs: Vec<&[f64]> = rows.iter().map(|rows| &rows.values[..]).collect();
            let mut out = vec![0.0; rows[0].len() * sizes.iter().product::<usize>()];
            Batch::new(&self.model).run(kernel, rows[0].len(), &inputs, &mut [&mut out]);
            out
        });
        shaped(py, out, n_rows, &sizes)
    }
}

/// Accepts inputs of the same number of rows.
fn same_rows(rows: Vec<ArrayRows>, inputs: &[(&str, AnyArray<'_>)]) -> Result<Vec<ArrayRows>, BadInput> {
    let text = |n_rows: Option<usize>| n_rows.map_or("one row".to_owned(), |n| format!("{n} rows"));
    match rows.iter().position(|own| own.n_rows != rows[0].n_rows) {
        Some(k) => {
            let expected = format!("{}, as {} has", text(rows[0].n_rows), inputs[0].0);
            Err(BadInput::new(inputs[k].0, expected, text(rows[k].n_rows)))
        }
        None => Ok(rows),
    }
}

/// An array over `values`: rows, where there are any, and `sizes` behind.
fn shaped<'py>(
    py: Python<'py>,
    values: Vec<f64>,
    n_rows: Option<usize>,
    sizes: &[usize],
) -> PyResult<Array<'py>> {
    let shape: Vec<usize> = n_rows.into_iter().chain(sizes.iter().copied()).collect();
    PyArray1::from_vec(py, values).reshape(shape)
}

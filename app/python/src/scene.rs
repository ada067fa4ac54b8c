//! Scenes: the robot as a file describes it.

use std::path::PathBuf;

use hysteron_base::{PrescribedQuantity, Scene};
use hysteron_twin::auxiliary_tendons;
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::errors::exception;

/// A robot as its scene file describes it: mesh, clamp, material, tendons, tip. Never changes.
#[pyclass(name = "Scene", module = "pyhysteron", frozen)]
pub struct PyScene {
    pub(crate) scene: Scene,
    pub(crate) path: PathBuf,
}

#[pymethods]
impl PyScene {
    /// Reads a scene file (.toml) with its mesh.
    ///
    /// `reduced` is a chain by `hysteron reduce`, which moves the robot in place of the finite elements; by default that
    /// of the scene, if it names one.
    #[staticmethod]
    #[pyo3(signature = (path, *, reduced=None))]
    fn read(py: Python<'_>, path: PathBuf, reduced: Option<PathBuf>) -> PyResult<Self> {
        match py.detach(|| Scene::read_with(&path, reduced)) {
            Ok(scene) => Ok(Self { scene, path }),
            Err(error) => Err(exception(py, error)),
        }
    }

    /// The robot that comes with the package: a tube of TPU, 80 mm long, with four tendons.
    #[classmethod]
    fn embedded(class: &Bound<'_, PyType>) -> PyResult<Self> {
        let py = class.py();
        let package: PathBuf = py.import("pyhysteron")?.getattr("__file__")?.extract()?;
        Self::read(py, package.with_file_name("robots").join("tpu80/scene.toml"), None)
    }

    /// Name of the robot.
    #[getter]
    fn name(&self) -> &str {
        &self.scene.name
    }

    /// The file that it was read from.
    #[getter]
    fn path(&self) -> PathBuf {
        self.path.clone()
    }

    /// Seed of every random stream.
    #[getter]
    fn seed(&self) -> u64 {
        self.scene.seed
    }

    /// SHA-256 of all that decides where the tip goes, 64 hexadecimal digits.
    #[getter]
    fn hash(&self) -> &str {
        &self.scene.hash
    }

    /// File of the mesh.
    #[getter]
    fn mesh_path(&self) -> PathBuf {
        self.scene.mesh_path.clone()
    }

    /// File of the chain that moves in place of the mesh, if any.
    #[getter]
    fn reduced_path(&self) -> Option<PathBuf> {
        self.scene.reduced_path.clone()
    }

    /// Number of primary tendons.
    #[getter]
    fn n_tendons(&self) -> usize {
        self.scene.tendons.len()
    }

    /// Names of the primary tendons, in the order of strokes.
    #[getter]
    fn tendon_names(&self) -> Vec<&str> {
        self.scene.tendons.iter().map(|tendon| tendon.name.as_str()).collect()
    }

    /// Drive of each primary tendon: "stroke", "tension" or "free".
    #[getter]
    fn drives(&self) -> Vec<&'static str> {
        let drive = |drive: PrescribedQuantity| match drive {
            PrescribedQuantity::Stroke => "stroke",
            PrescribedQuantity::Tension => "tension",
            PrescribedQuantity::Free => "free",
        };
        self.scene.tendons.iter().map(|tendon| drive(tendon.drive)).collect()
    }

    /// Smallest and largest stroke of each primary tendon [m].
    #[getter]
    fn stroke_bounds(&self) -> Vec<(f64, f64)> {
        self.scene.tendons.iter().map(|tendon| (tendon.stroke.min, tendon.stroke.max)).collect()
    }

    /// Number of auxiliary tendons of CoReAct.
    #[getter]
    fn n_auxiliary(&self) -> usize {
        self.scene.auxiliary.as_ref().map_or(0, |layout| auxiliary_tendons(layout).len())
    }

    /// Young's modulus of the body [Pa].
    #[getter]
    fn youngs_modulus(&self) -> f64 {
        self.scene.material.youngs_modulus
    }

    /// Poisson's ratio of the body [-].
    #[getter]
    fn poisson_ratio(&self) -> f64 {
        self.scene.material.poisson_ratio
    }

    /// Acceleration of gravity, x, y, z [m/s²].
    #[getter]
    fn gravity(&self) -> [f64; 3] {
        self.scene.gravity
    }

    fn __repr__(&self) -> String {
        let n_auxiliary = self.n_auxiliary();
        let auxiliary =
            if n_auxiliary > 0 { format!(", {n_auxiliary} auxiliary ones") } else { String::new() };
        format!("<Scene {:?}: {} tendons{auxiliary}>", self.scene.name, self.n_tendons())
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("pyhysteron._html")?.call_method1("scene", (slf,))
    }
}

//! Twins: a robot that is moved step by step, or along a whole recording.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use hysteron_base::{BadInput, Channel, Metadata, PrescribedQuantity, Recording, Scene};
use hysteron_twin::command::Goals;
use hysteron_twin::{Error, Stepper, Target, Twin, TwinState};
use hysteron_workflow::tendon::simulate;
use hysteron_workflow::{Context, WorkflowError};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use crate::arrays::{AnyArray, ArrayRowValues, ArrayRows};
use crate::background;
use crate::errors::{exception, exception_of_verb};
use crate::recording::PyRecording;
use crate::scene::PyScene;
use crate::step_report::{PyReachReport, PyStepReport};

/// A robot that is moved from equilibrium to equilibrium by its tendons.
///
/// `Twin(scene)` begins at rest: undeformed, without loads. Every method keeps the interpreter lock free while it computes; two
/// threads that use one twin take turns.
#[pyclass(name = "Twin", module = "pyhysteron", frozen)]
pub struct PyTwin {
    scene: Scene,
    twin: Twin,
    motion: Mutex<TwinMotion>,
}

/// All that changes.
struct TwinMotion {
    stepper: Stepper,
    targets: Vec<Target>,
}

/// An equilibrium of a twin: shape, tensions, memory of friction and backlash.
#[pyclass(name = "TwinState", module = "pyhysteron", frozen)]
pub struct PyTwinState {
    state: TwinState,
}

#[pymethods]
impl PyTwin {
    /// The twin of a scene, at rest.
    ///
    /// `reduced` is a chain by `hysteron reduce`, which moves the robot in place of the finite elements; by default that
    /// of the scene, if it names one.
    #[new]
    #[pyo3(signature = (scene, reduced=None))]
    fn new(py: Python<'_>, scene: &Bound<'_, PyScene>, reduced: Option<PathBuf>) -> PyResult<Self> {
        let read = scene.get();
        let made = py.detach(|| -> anyhow::Result<Self> {
            let scene = match reduced {
                Some(_) => Scene::read_with(&read.path, reduced)?,
                None => read.scene.clone(),
            };
            let twin = Twin::from_scene(&scene)?;
            let targets = twin.tendons.iter().map(|tendon| tendon.resting_target()).collect();
            let motion = Mutex::new(TwinMotion { stepper: Stepper::new(&twin), targets });
            Ok(Self { scene, twin, motion })
        });
        made.map_err(|error| exception(py, error))
    }

    /// Number of primary tendons.
    #[getter]
    fn n_tendons(&self) -> usize {
        self.twin.n_primary
    }

    /// Number of auxiliary tendons of CoReAct.
    #[getter]
    fn n_auxiliary(&self) -> usize {
        self.twin.tendons.len() - self.twin.n_primary
    }

    /// Names of all tendons, primary ones first.
    #[getter]
    fn tendon_names(&self) -> Vec<&str> {
        self.twin.tendons.iter().map(|tendon| tendon.name.as_str()).collect()
    }

    /// Moves on to the equilibrium under `strokes`.
    ///
    /// `strokes` (n_tendons,) [m]: one for each primary tendon, positive pulls; of a tendon that the scene drives by tension its
    /// tension [N]. `auxiliary` (n_auxiliary,) [m]: strokes of the auxiliary tendons, which rest without. Where there is no
    /// equilibrium the twin stays at the last one on the way.
    #[pyo3(signature = (strokes, auxiliary=None))]
    fn step(
        &self,
        py: Python<'_>,
        strokes: ArrayRowValues,
        auxiliary: Option<ArrayRowValues>,
    ) -> PyResult<PyStepReport> {
        py.detach(|| self.step_to(&strokes.0, auxiliary.as_ref().map(|row| &row.0[..])))
            .map_err(|error| exception(py, error))
    }

    /// Goes back to rest: undeformed, without loads and without memory of friction.
    fn reset(&self, py: Python<'_>) -> PyResult<()> {
        py.detach(|| self.motion().stepper.restore(&self.twin, &self.twin.rest()))
            .map_err(|error| exception(py, error))
    }

    /// Moves the tip to `target` (3,) [m] and finds the strokes that this takes.
    ///
    /// `tolerance` is the distance that counts as reached [m]. A target out of reach is no error: see
    /// `ReachReport.is_reached`.
    #[pyo3(signature = (target, *, tolerance=1e-4))]
    fn reach(&self, py: Python<'_>, target: ArrayRowValues, tolerance: f64) -> PyResult<PyReachReport> {
        let (reach, step) =
            py.detach(|| self.reach_to(&target.0, tolerance)).map_err(|error| exception(py, error))?;
        Ok(PyReachReport { reach, step: Py::new(py, step)? })
    }

    /// Follows whole arrays of strokes, without the interpreter in between, and returns the recording.
    ///
    /// `strokes` (n_samples, n_tendons) [m], `rate_hz` samples a second; or a `Recording` with strokes, whose times it takes.
    /// `residual` is a checkpoint by `hysteron fit-residual`; its network drives the auxiliary tendons, and the twin
    /// must be at rest. The rows are those that `simulate` writes. The twin begins where it is and ends at the last sample;
    /// where a sample has no equilibrium, or Ctrl-C ends it, it stays where it was. `progress` draws a bar (tqdm).
    #[pyo3(signature = (strokes, *, rate_hz=100.0, residual=None, progress=false))]
    fn rollout(
        &self,
        py: Python<'_>,
        strokes: &Bound<'_, PyAny>,
        rate_hz: f64,
        residual: Option<PathBuf>,
        progress: bool,
    ) -> PyResult<PyRecording> {
        let made;
        let commanded = match strokes.cast::<PyRecording>() {
            Ok(recording) => &recording.get().recording,
            Err(_) => {
                let array: AnyArray = strokes.extract()?;
                made = self.commanded(&array, rate_hz).map_err(|bad| exception(py, bad))?;
                &made
            }
        };
        let listener = match progress {
            true => Some(py.import("pyhysteron._listener")?.call_method1("Listener", (false, true))?),
            false => None,
        };
        let ended = background::run(py, listener.as_ref(), |progress| {
            let context = Context { progress, ..Context::silent("pyhysteron Twin.rollout") };
            self.follow(commanded, residual.as_deref(), &context)
        })?;
        Ok(PyRecording { recording: ended.value(py, |error| exception_of_verb(py, &error, None))? })
    }

    /// Position of the tip (3,) [m].
    #[getter]
    fn tip<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let tip = py.detach(|| self.twin.tip_of(self.motion().stepper.state()));
        PyArray1::from_slice(py, &tip)
    }

    /// Rotation of the tip since rest, a quaternion w, x, y, z (4,) [-].
    #[getter]
    fn tip_orientation<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let turn = py.detach(|| self.twin.tip_rotation_of(self.motion().stepper.state()));
        PyArray1::from_slice(py, &[turn.w, turn.i, turn.j, turn.k])
    }

    /// Tension of every tendon at its pulled end (n_tendons + n_auxiliary,) [N].
    #[getter]
    fn tensions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let n = self.twin.tendons.len();
        let tensions = py.detach(|| self.motion().stepper.state().tensions[..n].to_vec());
        PyArray1::from_vec(py, tensions)
    }

    /// The stroke that a servo shows for every tendon (n_tendons + n_auxiliary,) [m].
    #[getter]
    fn strokes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let strokes = py.detach(|| self.motion().stepper.commands(&self.twin));
        PyArray1::from_vec(py, strokes)
    }

    /// Positions of the nodes of the mesh (n_nodes, 3) [m], in the order of the mesh file.
    #[getter]
    fn nodes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let nodes = py.detach(|| {
            let motion = self.motion();
            let nodes = self.twin.nodes_of(motion.stepper.state());
            self.twin.body.in_file_order(&nodes)
        });
        let n = nodes.len();
        PyArray1::from_vec(py, nodes.into_flattened()).reshape([n, 3])
    }

    /// The present equilibrium, for `restore`.
    fn state(&self, py: Python<'_>) -> PyTwinState {
        PyTwinState { state: py.detach(|| self.motion().stepper.state().clone()) }
    }

    /// Goes to an equilibrium of this robot, where the next step begins.
    fn restore(&self, py: Python<'_>, state: &Bound<'_, PyTwinState>) -> PyResult<()> {
        let state = &state.get().state;
        py.detach(|| self.motion().stepper.restore(&self.twin, state)).map_err(|error| exception(py, error))
    }

    /// Writes the present equilibrium to a file, as `simulate` does with `save_state`.
    fn save_state(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let command = "pyhysteron Twin.save_state";
        py.detach(|| self.motion().stepper.state().write(&path, &self.twin, &self.scene.hash, command))
            .map_err(|error| exception(py, error))
    }

    /// Goes to the equilibrium of a file of the same scene, as `simulate` does with `from_`.
    fn load_state(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| {
            let state = TwinState::read(&path, &self.twin, &self.scene.hash)?;
            self.motion().stepper.restore(&self.twin, &state)
        })
        .map_err(|error| exception(py, error))
    }

    fn __repr__(&self) -> String {
        let body = match &self.twin.chain {
            Some(_) => "a chain of sections".to_owned(),
            None => format!("{} nodes", self.twin.body.n_nodes()),
        };
        format!("<Twin of {:?}: {body}, {} tendons>", self.scene.name, self.twin.tendons.len())
    }
}

impl PyTwin {
    /// Taken by threads that do not hold the interpreter lock.
    fn motion(&self) -> MutexGuard<'_, TwinMotion> {
        self.motion.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn step_to(&self, strokes: &[f64], auxiliary: Option<&[f64]>) -> Result<PyStepReport, Error> {
        let twin = &self.twin;
        let motion = &mut *self.motion();
        self.set_targets(&mut motion.targets, strokes, auxiliary)?;
        let report = motion.stepper.step(twin, &motion.targets)?;
        let state = motion.stepper.state();
        let is_by_stroke = |j: usize| matches!(motion.targets[j], Target::Stroke(_));
        if let Some(error) = twin.overloaded(state, is_by_stroke) {
            return Err(error);
        }
        let tensions = state.tensions[..twin.tendons.len()].to_vec();
        Ok(PyStepReport { tip: twin.tip_of(state), tensions, report })
    }

    /// The targets of a step, each within the bounds of its tendon.
    fn set_targets(
        &self,
        targets: &mut Vec<Target>,
        strokes: &[f64],
        auxiliary: Option<&[f64]>,
    ) -> Result<(), BadInput> {
        let (primary, others) = self.twin.tendons.split_at(self.twin.n_primary);
        check_count("strokes", primary.len(), strokes)?;
        targets.clear();
        for (tendon, &value) in primary.iter().zip(strokes) {
            targets.push(match tendon.drive {
                PrescribedQuantity::Stroke => {
                    tendon.check_stroke(value, || format!("stroke of tendon {}", tendon.name))?;
                    Target::Stroke(value)
                }
                PrescribedQuantity::Tension => Target::Tension(value),
                PrescribedQuantity::Free => Target::Free,
            });
        }
        match auxiliary {
            Some(values) => {
                check_count("auxiliary", others.len(), values)?;
                targets.extend(values.iter().map(|stroke| Target::Stroke(*stroke)));
            }
            None => targets.extend(others.iter().map(|tendon| tendon.resting_target())),
        }
        Ok(())
    }

    fn reach_to(
        &self,
        target: &[f64],
        tolerance: f64,
    ) -> Result<(hysteron_twin::ReachReport, PyStepReport), Error> {
        check_count("target", 3, target)?;
        if !(tolerance.is_finite() && tolerance > 0.0) {
            return Err(BadInput::new("tolerance", "a length above 0 [m]", tolerance.to_string()).into());
        }
        let tip = ["x", "y", "z"].into_iter().zip(target);
        let tip = tip.map(|(axis, c)| Channel::new(format!("tip_{axis}_m"), vec![*c])).collect();
        let goals = Recording::new(vec![0.0], tip, Vec::new(), Metadata::default())
            .map_err(|bad| BadInput { place: "target".to_owned(), ..bad })?;
        let goal = Goals::new(&goals, Path::new("target"), tolerance)?.tip_goal(0);
        let auxiliary = self.twin.tendons[self.twin.n_primary..].iter().map(|tendon| tendon.resting_target());
        let targets: Vec<Target> =
            std::iter::repeat_n(Target::Free, self.twin.n_primary).chain(auxiliary).collect();
        let stepper = &mut self.motion().stepper;
        let reach = stepper.reach(&self.twin, &goal, &targets)?;
        let state = stepper.state();
        let tensions = state.tensions[..self.twin.tendons.len()].to_vec();
        let step = PyStepReport { tip: self.twin.tip_of(state), tensions, report: reach.step };
        Ok((reach, step))
    }

    /// The rows of an array as a recording of strokes.
    fn commanded(&self, array: &AnyArray<'_>, rate_hz: f64) -> Result<Recording, BadInput> {
        let n = self.twin.n_primary;
        if let Some(tendon) =
            self.twin.tendons[..n].iter().find(|tendon| tendon.drive != PrescribedQuantity::Stroke)
        {
            let found = format!("another drive of tendon {}", tendon.name);
            return Err(BadInput::new("strokes", "a scene that drives all tendons by stroke", found)
                .hint("pass a Recording with the channels that the scene needs"));
        }
        if !(rate_hz.is_finite() && rate_hz > 0.0) {
            return Err(BadInput::new("rate_hz", "a number above 0", rate_hz.to_string()));
        }
        let rows = ArrayRows::of(array.as_array(), n, "strokes")?;
        let time = (0..rows.len()).map(|row| row as f64 / rate_hz).collect();
        let column = |k: usize| rows.values.iter().skip(k).step_by(n).copied().collect();
        let channels = (0..n).map(|k| Channel::new(format!("stroke_{}_m", k + 1), column(k))).collect();
        Recording::new(time, channels, Vec::new(), Metadata::default()).map_err(|bad| bad.within("strokes"))
    }

    fn follow(
        &self,
        strokes: &Recording,
        residual: Option<&Path>,
        context: &Context,
    ) -> Result<Recording, WorkflowError> {
        let mut motion = self.motion();
        let start = motion.stepper.state().clone();
        if residual.is_some() && start != self.twin.rest() {
            let bad = BadInput::new("residual", "a twin at rest", "one that has moved")
                .hint("the memory of the network is no part of a state; call reset() first");
            return Err(anyhow::Error::new(bad).into());
        }
        let robot = (&self.scene, &self.twin);
        let (recording, last) = simulate::rollout(robot, strokes, &start, residual, context)?;
        motion.stepper.restore(&self.twin, &last).map_err(anyhow::Error::new)?;
        Ok(recording)
    }
}

fn check_count(name: &str, expected: usize, found: &[f64]) -> Result<(), BadInput> {
    match found.len() == expected {
        true => Ok(()),
        false => Err(BadInput::new(name, format!("{expected} numbers"), found.len().to_string())),
    }
}

//! A trained model: its file, its torques sample by sample.

use std::path::Path;

use hysteron_base::BadInput;
use hysteron_learn::{Result, read_parameters, read_parameters_kind, write_parameters};
use serde::{Deserialize, Serialize};

use super::network::Evaluator;
use super::{ArmSamples, Decomposition, NetworkShape, decompose};
use hysteron_arm_dynamics::JointKind;

/// A trained model of inverse dynamics.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnedDynamics {
    /// Everything but the parameters.
    pub shape: NetworkShape,
    /// In the layout of the shape.
    pub parameters: Vec<f64>,
}

/// All but the parameters, as a file has it.
#[derive(Serialize)]
struct Header<'a, D> {
    shape: &'a NetworkShape,
    /// Of the program that trained the model.
    details: &'a D,
}

/// Fields of [`Header`] that a reader needs.
#[derive(Deserialize)]
struct ShapeHeader {
    shape: NetworkShape,
}

impl LearnedDynamics {
    /// Kind of file, as such files state it.
    pub const KIND: &str = "inverse-dynamics";

    /// True for a file of this kind.
    pub fn is_file(path: &Path) -> bool {
        path.extension().is_some_and(|ending| ending == "safetensors")
            && read_parameters_kind(path).is_ok_and(|kind| kind == Self::KIND)
    }

    /// Writes the model's file; `details` are further metadata: data, seed, errors.
    ///
    /// # Errors
    /// If the file system refuses.
    pub fn write(&self, path: &Path, details: &impl Serialize) -> Result<()> {
        write_parameters(path, Self::KIND, &Header { shape: &self.shape, details }, &self.parameters)
    }

    /// Reads a file by [`LearnedDynamics::write`].
    ///
    /// # Errors
    /// `BadInput` naming the file and what is wrong with it.
    pub fn read(path: &Path) -> Result<Self> {
        let (ShapeHeader { shape }, parameters) = read_parameters(path, Self::KIND)?;
        let within = |bad: BadInput| bad.within(path.display());
        shape.check().map_err(within)?;
        if shape.n_parameters() != parameters.len() {
            let expected = format!("{} of this shape", shape.n_parameters());
            return Err(within(BadInput::new("parameters", expected, parameters.len().to_string())).into());
        }
        Ok(Self { shape, parameters })
    }

    /// Torques of samples, and what they are spent on.
    ///
    /// # Errors
    /// `BadInput` where the samples have another number of joints, or others that slide, or no momenta where the model needs them.
    pub fn decompose(&self, samples: &ArmSamples) -> std::result::Result<Decomposition, BadInput> {
        let n = self.shape.n_joints();
        if samples.n_joints != n {
            return Err(BadInput::new(
                "recording",
                format!("{n} joints, as the model has"),
                samples.n_joints.to_string(),
            ));
        }
        let is_prismatic = |j: &usize| samples.kinds[*j] == JointKind::Prismatic;
        if let Some(j) = (0..n).find(|j| is_prismatic(j) != self.shape.lengths[*j].is_some()) {
            let [expected, found] = if is_prismatic(&j) { ["rad", "m"] } else { ["m", "rad"] };
            let of = |unit: &str| format!("q_{}_{unit}", j + 1);
            return Err(BadInput::new("recording", format!("{}, as the model has", of(expected)), of(found)));
        }
        if self.shape.variant.is_hamiltonian() && samples.momenta[0].is_empty() {
            return Err(BadInput::new("recording", "momenta, which this model takes for velocities", "none"));
        }
        Ok(decompose(&self.shape, &self.parameters, samples))
    }

    /// For torques one sample at a time.
    pub fn stream(&self) -> TorqueStream {
        let parameters: Vec<f32> = self.parameters.iter().map(|p| *p as f32).collect();
        TorqueStream { evaluator: Evaluator::prepared(&self.shape, &parameters), parameters }
    }
}

/// Torques one sample at a time, in single precision; feed-forward of a controller, or the model of an observer.
pub struct TorqueStream {
    evaluator: Evaluator<f32>,
    parameters: Vec<f32>,
}

impl TorqueStream {
    /// Writes the torques of (q, q̇, q̈) to `tau`; of a Hamiltonian those of (q, p, ṗ).
    pub fn torque(&mut self, motion: [&[f64]; 3], tau: &mut [f64]) {
        self.evaluator.evaluate(&self.parameters, motion, 0..1);
        tau.iter_mut().zip(&self.evaluator.outputs).for_each(|(to, from)| *to = f64::from(*from));
    }
}

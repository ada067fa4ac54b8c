//! `NeuralActuator`: a trained network with all that is needed to use it, and its file.

use std::path::Path;

use hysteron_base::BadInput;
use hysteron_learn::{
    Result, TrainableModel as _, Transformer, TransformerShape, read_parameters, write_parameters,
};
use serde::{Deserialize, Serialize};

use super::current::CurrentModel;
use super::details::ActuatorDetails;
use super::features::{FeatureLayout, InputScale};
use super::loss::Heads;
use super::sensing::{Sensing, SensingHeader};
use super::simulation::{ArmSimulation, SimulationOptions};
use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::servo_force::observed_arm;

/// A trained actuator of one arm.
#[derive(Debug, Clone)]
pub struct NeuralActuator {
    /// The network.
    pub network: Transformer<f32>,
    /// Inputs that it takes from a sample.
    pub features: FeatureLayout,
    /// How its inputs are scaled.
    pub scale: InputScale,
    /// The simulation that its torques are for.
    pub simulation: SimulationOptions,
    /// Names of the arm's joints.
    pub joints: Vec<String>,
    /// Currents of the drives, for pure simulation.
    pub currents: CurrentModel,
    /// Force, contact and condition by a network of their own; none where the network in the loop estimates them, as published.
    pub sensing: Option<Sensing>,
    /// A longer force is a contact [N].
    pub contact: f64,
    /// Its training, and the baselines that were fitted with it.
    pub details: ActuatorDetails,
}

/// All but the parameters, as the file has it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ActuatorHeader {
    shape: TransformerShape,
    features: FeatureLayout,
    scale: InputScale,
    simulation: SimulationOptions,
    joints: Vec<String>,
    currents: CurrentModel,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sensing: Option<SensingHeader>,
    contact: f64,
    details: ActuatorDetails,
}

impl NeuralActuator {
    /// Kind of file, as such files state it.
    pub const KIND: &'static str = "neural-actuator";

    /// Writes the actuator's file.
    ///
    /// # Errors
    /// If the file system refuses.
    pub fn write(&self, path: &Path) -> Result<()> {
        let header = ActuatorHeader {
            shape: self.network.shape().clone(),
            features: self.features,
            scale: self.scale.clone(),
            simulation: self.simulation.clone(),
            joints: self.joints.clone(),
            currents: self.currents.clone(),
            sensing: self.sensing.as_ref().map(SensingHeader::of),
            contact: self.contact,
            details: self.details.clone(),
        };
        let networks = std::iter::once(&self.network).chain(self.sensing.iter().map(|own| &own.network));
        let parameters: Vec<f64> =
            networks.flat_map(|one| one.parameters().iter().flatten()).map(|v| f64::from(*v)).collect();
        write_parameters(path, Self::KIND, &header, &parameters)
    }

    /// Reads a file by [`Self::write`].
    ///
    /// # Errors
    /// `BadInput` naming the file and what is wrong with it.
    pub fn read(path: &Path) -> Result<Self> {
        let (header, parameters) = read_parameters(path, Self::KIND)?;
        Ok(Self::from_parts(header, &parameters).map_err(|bad| bad.within(path.display()))?)
    }

    fn from_parts(header: ActuatorHeader, parameters: &[f64]) -> std::result::Result<Self, BadInput> {
        let ActuatorHeader {
            shape,
            features,
            scale,
            simulation,
            joints,
            currents,
            sensing,
            contact,
            details,
        } = header;
        simulation.check(&features).map_err(|bad| bad.within("simulation"))?;
        if let Some(sensing) = &sensing {
            sensing.check(&features).map_err(|bad| bad.within("sensing"))?;
        }
        shape.check()?;
        let fits = shape.inputs == features.len()
            && shape.heads == Heads::sizes(&features)
            && scale.is_for(features.len())
            && joints.len() == features.joints
            && contact >= 0.0
            && contact.is_finite()
            && currents.coefficients.iter().flatten().all(|coefficient| coefficient.is_finite())
            && currents.coefficients.len() == features.motors();
        if !fits {
            return Err(BadInput::new("shape", "sizes that belong together", "others"));
        }
        let own = shape.n_parameters();
        let expected = own + sensing.as_ref().map_or(0, |sensing| sensing.shape.n_parameters());
        if parameters.len() != expected {
            return Err(BadInput::new("parameters", expected.to_string(), parameters.len().to_string()));
        }
        let network = filled(&shape, &parameters[..own])?;
        let sensing = sensing
            .map(|sensing| filled(&sensing.shape, &parameters[own..]).map(|network| sensing.with(network)))
            .transpose()?;
        Ok(Self { network, features, scale, simulation, joints, currents, sensing, contact, details })
    }

    /// The arm as the observer of force knows it.
    ///
    /// # Errors
    /// `BadInput` where `model` is another arm.
    pub fn observed_arm(&self, model: &Model) -> std::result::Result<Model, BadInput> {
        self.check_arm(model)?;
        observed_arm(model, self.features.joints)
    }

    /// The simulation with the bodies of `model`.
    ///
    /// # Errors
    /// `BadInput` where `model` is another arm: its joints have other names.
    pub fn simulation(&self, model: &Model) -> std::result::Result<ArmSimulation, BadInput> {
        self.check_arm(model)?;
        ArmSimulation::new(model, &self.features, &self.simulation)
    }

    fn check_arm(&self, model: &Model) -> std::result::Result<(), BadInput> {
        let found: Vec<&str> =
            model.joints().iter().take(self.joints.len()).map(|joint| joint.name.as_str()).collect();
        if found != self.joints {
            return Err(BadInput::new(
                "robot",
                format!("joints {}", self.joints.join(", ")),
                found.join(", "),
            )
            .hint("the actuator was trained on another arm"));
        }
        Ok(())
    }
}

/// A network of this shape with these parameters, one after the other.
fn filled(shape: &TransformerShape, parameters: &[f64]) -> std::result::Result<Transformer<f32>, BadInput> {
    let mut network = Transformer::<f32>::new(shape, 0)?;
    let mut rest = parameters;
    for values in network.parameters_mut() {
        let (own, after) = rest.split_at(values.len());
        values.iter_mut().zip(own).for_each(|(to, from)| *to = *from as f32);
        rest = after;
    }
    Ok(network)
}

//! The residual network of a twin, read and ready to be rolled out.

use std::path::Path;

use hysteron_base::{BadInput, Scene, file};
use hysteron_twin::coreact::AuxiliaryLimits;
use hysteron_twin::residual::{CorrectedRollout, ResidualModel};
use hysteron_twin::{PhysicsTwin, Plant, Twin};

/// A network and the tendons that it drives.
pub struct Network {
    /// SHA-256 of its checkpoint.
    pub hash: String,
    model: ResidualModel,
    auxiliary: AuxiliaryLimits,
}

impl Network {
    /// Reads a checkpoint for the robot of `scene`, which must be the one that it was trained with.
    pub fn read(path: &Path, scene: &Scene, twin: &Twin) -> anyhow::Result<Self> {
        let hash = file::sha256_of(path)?;
        let model = ResidualModel::read(path)?;
        let auxiliary = AuxiliaryLimits::new(twin)?;
        model
            .check(twin.n_primary, auxiliary.len(), model.step_s)
            .map_err(|bad| bad.within(path.display()))?;
        if model.scene_hash != scene.hash {
            let expected = format!("{}, of {} and its mesh", scene.hash, scene.name);
            return Err(BadInput::new(
                format!("{}: scene_sha256", path.display()),
                expected,
                model.scene_hash,
            )
            .hint("name the scene that it was trained with, or identify and train again with this one")
            .into());
        }
        Ok(Self { hash, model, auxiliary })
    }

    /// The model.
    pub fn model(&self) -> &ResidualModel {
        &self.model
    }

    /// The tendons that it drives.
    pub fn auxiliary(&self) -> &AuxiliaryLimits {
        &self.auxiliary
    }

    /// Number of auxiliary tendons.
    pub fn n_aux(&self) -> usize {
        self.auxiliary.len()
    }

    /// A closed loop at rest, for samples `step` [s] apart.
    pub fn rollout<'a>(&'a self, twin: &'a Twin, step: f64) -> Result<CorrectedRollout<'a>, BadInput> {
        CorrectedRollout::new(twin, &self.auxiliary, &self.model, step)
    }
}

/// Model of the robot, at rest: its twin with the network, or without a network the uncorrected twin.
pub fn plant<'a>(
    network: Option<&'a Network>,
    twin: &'a Twin,
    step: f64,
) -> Result<Box<dyn Plant + 'a>, BadInput> {
    Ok(match network {
        Some(network) => Box::new(network.rollout(twin, step)?),
        None => Box::new(PhysicsTwin::new(twin)),
    })
}

//! Motions of an arm as an identification of its bodies takes them.

use std::path::{Path, PathBuf};

use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::ArmRecording;
use hysteron_arm_estimation::identify::{JointMotion, JointTerm};
use hysteron_base::BadInput;

use super::recordings::read;
use crate::Context;
use crate::arm::RobotOptions;
use crate::shared::identification::positive;

/// Order of the low pass of motions.
const ORDER: usize = 4;

/// Parameters of every joint in addition to those of its body.
pub(super) const TERMS: [JointTerm; 5] =
    [JointTerm::Armature, JointTerm::Coulomb, JointTerm::Viscous, JointTerm::Offset, JointTerm::Spring];

/// How motions of an arm are read.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct MotionOptions {
    /// Highest frequency of the motion; above it, signals count as noise
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "HZ", default_value_t = 8.0, allow_negative_numbers = true)
    )]
    pub cutoff: f64,
    /// Torque for a current in every joint, where the recordings have currents
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "N_M_PER_A,...", value_delimiter = ',', allow_negative_numbers = true)
    )]
    pub torque_constants: Vec<f64>,
    /// Speed within which Coulomb friction changes its sign
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "RAD_S", default_value_t = 0.05, allow_negative_numbers = true)
    )]
    pub width: f64,
    /// Joint of the robot without channels in the recordings, at zero or at a coordinate
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME[=Q]"))]
    pub lock: Vec<String>,
}

/// Motions of one arm, one after the other.
pub(super) fn joined(motions: &[JointMotion]) -> Result<JointMotion, BadInput> {
    let Some((first, rest)) = motions.split_first() else {
        return Err(BadInput::new("recordings", "one or more", "none"));
    };
    let mut all = first.clone();
    rest.iter().for_each(|motion| all.extend(motion));
    Ok(all)
}

impl MotionOptions {
    /// The robot `name`, with joints locked at zero or at the value of `NAME=Q` [rad or m].
    pub(super) fn model(
        &self,
        name: &str,
        (robot, context): (&RobotOptions, &Context),
    ) -> anyhow::Result<Model> {
        let model = robot.model(name, context)?;
        if self.lock.is_empty() {
            return Ok(model);
        }
        let place = |text: &String| -> Result<(String, f64), BadInput> {
            match text.split_once('=') {
                None => Ok((text.clone(), 0.0)),
                Some((name, q)) => {
                    let bad = || BadInput::new("--lock", "NAME or NAME=COORDINATE", format!("{text:?}"));
                    Ok((name.to_owned(), q.trim().parse().map_err(|_| bad())?))
                }
            }
        };
        let places = self.lock.iter().map(place).collect::<Result<Vec<_>, _>>()?;
        let places: Vec<(&str, f64)> = places.iter().map(|(name, q)| (name.as_str(), *q)).collect();
        Ok(model.with_locked(&places)?)
    }

    pub(super) fn check(&self) -> Result<(), BadInput> {
        positive("--cutoff", self.cutoff).and_then(|()| positive("--width", self.width))
    }

    /// The motion of an arm of `model` in one file.
    pub(super) fn read(&self, path: &Path, model: &Model) -> anyhow::Result<JointMotion> {
        let recording = read(path)?;
        let within = |bad: BadInput| bad.within(path.display());
        let recorded = ArmRecording::of(&recording).map_err(within)?;
        if recorded.joints.len() != model.n_joints() {
            let names: Vec<&str> = model.joints().iter().map(|joint| joint.name.as_str()).collect();
            let expected = format!("{} joints, those of the robot: {}", model.n_joints(), names.join(", "));
            let bad = BadInput::new("recording", expected, format!("{} joints", recorded.joints.len()))
                .hint("--lock NAME leaves a joint of the robot out");
            return Err(within(bad).into());
        }
        let motion = JointMotion::of_recording(&recorded, &self.torque_constants, ORDER, self.cutoff);
        Ok(motion.map_err(within)?)
    }

    /// The motions of several files.
    pub(super) fn read_each(&self, paths: &[PathBuf], model: &Model) -> anyhow::Result<Vec<JointMotion>> {
        paths.iter().map(|path| self.read(path, model)).collect()
    }

    /// The motions of several files, one after the other.
    pub(super) fn read_all(&self, paths: &[PathBuf], model: &Model) -> anyhow::Result<JointMotion> {
        Ok(joined(&self.read_each(paths, model)?)?)
    }
}

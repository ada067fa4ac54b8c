//! Recorded motions of a servo that swings a weight.

use std::path::Path;

use hysteron_actuator::identify::{Pendulum, PendulumRun};
use hysteron_arm_estimation::{ArmRecording, JointQuantityKind, POSITION_GAIN};
use hysteron_base::{BadInput, Recording};

use super::Options;
use crate::arm::identify::recordings::read;
use crate::shared::identification::positive;

/// A recorded motion, and the supply's voltage at its start.
pub(super) struct Run {
    pub run: PendulumRun,
    pub voltage: Option<f64>,
}

/// The motion in a file, with the notes of the options and the recording.
///
/// # Errors
/// Those of reading; `BadInput` for what is missing.
pub(super) fn run_of(path: &Path, options: &Options) -> anyhow::Result<Run> {
    let recording = read(path)?;
    let within = |bad: BadInput| bad.within(path.display());
    Ok(of_recording(&recording, options, path.display().to_string()).map_err(within)?)
}

fn of_recording(recording: &Recording, options: &Options, name: String) -> Result<Run, BadInput> {
    let recorded = ArmRecording::of(recording)?;
    if recorded.joints.len() != 1 {
        return Err(BadInput::new("recording", "one joint", recorded.joints.len().to_string()));
    }
    let need = |quantity| recorded.require(quantity).map(|columns| columns[0].to_vec());
    let noted = |key: &str, option: &str, given: Option<f64>| {
        let noted = recording.meta().extra.get(key).and_then(|text| text.parse::<f64>().ok());
        let value = given.or(noted).ok_or_else(|| {
            BadInput::new(option, "this option, because the recording does not have the value", "nothing")
        })?;
        positive(option, value).map(|()| value)
    };
    let first = |quantity| recorded.require(quantity).ok().and_then(|columns| columns[0].first().copied());
    let torque_on = recording.channel("torque_on_1_ratio").map_or_else(
        || vec![true; recording.n_samples()],
        |flags| flags.iter().map(|flag| *flag >= 0.5).collect(),
    );
    let run = PendulumRun {
        // Messages name the file anyway.
        name: "recording".into(),
        time: recorded.time.to_vec(),
        goal: need(JointQuantityKind::Goal)?,
        position: need(JointQuantityKind::Position)?,
        torque_on,
        temperature: first(JointQuantityKind::Temperature).unwrap_or(ROOM),
        gain: noted(POSITION_GAIN, "--gain", options.gain)?,
        pendulum: Pendulum {
            mass: noted("mass_kg", "--mass-kg", options.mass_kg)?,
            length: noted("length_m", "--length-m", options.length_m)?,
            offset: 0.0,
        },
    };
    Ok(Run { run: PendulumRun { name, ..run.checked()? }, voltage: first(JointQuantityKind::Voltage) })
}

/// Temperature of the servo where the recording has none [°C].
const ROOM: f64 = 25.0;

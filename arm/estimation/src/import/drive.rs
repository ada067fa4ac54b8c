//! Duties and currents that a log leaves out, by what is known of its drives.

use hysteron_actuator::{Bridge, CatalogueDrive};
use hysteron_base::import::POSITION_GAIN;
use hysteron_base::{BadInput, Channel, Metadata, Recording};

use crate::{ArmRecording, JointQuantityKind};
use hysteron_arm_dynamics::JointKind;

type Check<T> = Result<T, BadInput>;

/// Name in the metadata: the drive that computed currents come from.
pub const CURRENTS_BY: &str = "currents_by";

/// The recording with currents of all motors, i = (d V - k_t q̇)/R within the drive's limit, where it has none. d is the recorded duty or,
/// where there is none, that of a position loop with the recorded gain and nothing else. Windings are as warm as the recorded temperature,
/// or as the drive's reference.
///
/// # Errors
/// `BadInput` naming a joint that slides, or the channel that is missing.
pub(super) fn with_currents(recording: Recording, drive: &CatalogueDrive) -> Check<Recording> {
    let recorded = ArmRecording::of(&recording)?;
    if recorded.joints[0].current.is_some() {
        return Ok(recording);
    }
    if let Some(k) = recorded.joints.iter().position(|joint| joint.kind == JointKind::Prismatic) {
        let place = format!("joint {}", k + 1);
        return Err(BadInput::new(place, "a joint that turns, as drives do", "one that slides"));
    }
    let (speed, voltage) =
        (recorded.require(JointQuantityKind::Velocity)?, recorded.require(JointQuantityKind::Voltage)?);
    let temperature = recorded.require(JointQuantityKind::Temperature).ok();
    let (duty, is_computed) = match recorded.require(JointQuantityKind::Pwm) {
        Ok(recorded) => (recorded.into_iter().map(<[f64]>::to_vec).collect(), false),
        Err(missing) => (duties(&recording, &recorded, drive, missing)?, true),
    };
    let mut channels = recording.channels().to_vec();
    for (k, duty) in duty.into_iter().enumerate() {
        let torque_on = recording.channel(&format!("torque_on_{}_ratio", k + 1));
        let current = |row: usize| {
            let is_on = torque_on.is_none_or(|flags| flags[row] > 0.5);
            let bridge = if is_on { Bridge::Driven(duty[row]) } else { Bridge::Open };
            let warm = temperature.as_ref().map_or(drive.drive.winding.reference, |series| series[k][row]);
            drive.drive.current(bridge, voltage[k][row], (speed[k][row], warm))
        };
        let name = |quantity: JointQuantityKind| quantity.channel(JointKind::Revolute, k);
        let currents = (0..recording.n_samples()).map(current).collect();
        channels.push(Channel::new(name(JointQuantityKind::Current), currents));
        if is_computed {
            channels.push(Channel::new(name(JointQuantityKind::Pwm), duty));
        }
    }
    let mut meta = recording.meta().clone();
    meta.extra.insert(CURRENTS_BY.to_owned(), drive.name.clone());
    if is_computed {
        meta.extra.insert("duties_by".to_owned(), format!("{POSITION_GAIN} of {}", drive.name));
    }
    Recording::new(recording.time().to_vec(), channels, recording.gap().to_vec(), meta)
}

/// Gain of the position loops, where the recording has it.
///
/// # Errors
/// `BadInput` for what is no gain.
pub fn position_gain(meta: &Metadata) -> Check<Option<f64>> {
    let Some(text) = meta.extra.get(POSITION_GAIN) else { return Ok(None) };
    match text.parse::<f64>() {
        Ok(gain) if gain > 0.0 && gain.is_finite() => Ok(Some(gain)),
        _ => Err(BadInput::new(POSITION_GAIN, "a finite number above zero", format!("{text:?}"))),
    }
}

/// Duties of a position loop that has the recorded gain alone, joint by joint.
fn duties(
    recording: &Recording,
    recorded: &ArmRecording<'_>,
    drive: &CatalogueDrive,
    missing: BadInput,
) -> Check<Vec<Vec<f64>>> {
    let (gain, goal) = (position_gain(recording.meta())?, recorded.require(JointQuantityKind::Goal));
    let (Some(gain), Ok(goal)) = (gain, goal) else {
        return Err(
            missing.hint("currents are computed from duties, or from goal_1_rad and the log's position gain")
        );
    };
    let position = recorded.require(JointQuantityKind::Position)?;
    let per_radian = drive.drive.position_loop.duty_per_radian(gain);
    let of = |(goal, position): (&[f64], &[f64])| {
        goal.iter().zip(position).map(|(goal, q)| (per_radian * (goal - q)).clamp(-1.0, 1.0)).collect()
    };
    Ok(goal.into_iter().zip(position).map(of).collect())
}

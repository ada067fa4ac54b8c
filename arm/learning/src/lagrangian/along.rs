//! A learned model along a recording: torques for a motion (feed-forward), external torques (momentum observer).

use hysteron_base::{BadInput, Channel, Metadata, Recording};

use super::{LearnedBody, LearnedDynamics};
use hysteron_arm_estimation::observer::{ArmSample, Dynamics, FrictionModel, MomentumObserver, Observer};
use hysteron_arm_estimation::{ArmRecording, JointQuantityKind};

/// These quantities of all joints, column by column.
fn columns<'a, const N: usize>(
    recorded: &ArmRecording<'a>,
    n: usize,
    quantities: [JointQuantityKind; N],
) -> Result<[Vec<&'a [f64]>; N], BadInput> {
    if recorded.joints.len() != n {
        let expected = format!("{n} joints, as the model has");
        return Err(BadInput::new("recording", expected, recorded.joints.len().to_string()));
    }
    let mut found = [(); N].map(|()| Vec::new());
    for (columns, quantity) in found.iter_mut().zip(quantities) {
        *columns = recorded.require(quantity)?;
    }
    Ok(found)
}

impl LearnedDynamics {
    /// Torques of the states of a recording: itself, with `tau_k_n_m` by the model in place of its own.
    ///
    /// # Errors
    /// `BadInput` for states that are not there, or of another arm.
    pub fn torques_along(&self, states: &Recording, meta: Metadata) -> Result<Recording, BadInput> {
        let n = self.shape.n_joints();
        let recorded = ArmRecording::of(states)?;
        let motion = columns(
            &recorded,
            n,
            [JointQuantityKind::Position, JointQuantityKind::Velocity, JointQuantityKind::Acceleration],
        )?;
        let mut stream = self.stream();
        let mut found = vec![Vec::with_capacity(recorded.time.len()); n];
        let (mut rows, mut tau) = (motion.each_ref().map(|_| vec![0.0; n]), vec![0.0; n]);
        for row in 0..recorded.time.len() {
            for (values, columns) in rows.iter_mut().zip(&motion) {
                values.iter_mut().zip(columns).for_each(|(value, column)| *value = column[row]);
            }
            stream.torque([&rows[0], &rows[1], &rows[2]], &mut tau);
            found.iter_mut().zip(&tau).for_each(|(column, tau)| column.push(*tau));
        }
        let name = |joint: usize| JointQuantityKind::Torque.channel(recorded.joints[joint].kind, joint);
        let names: Vec<String> = (0..n).map(name).collect();
        let kept = states.channels().iter().filter(|channel| !names.contains(&channel.name)).cloned();
        let channels =
            kept.chain(names.iter().zip(found).map(|(name, column)| Channel::new(name.clone(), column)));
        Recording::new(states.time().to_vec(), channels.collect(), states.gap().to_vec(), meta)
    }
}

/// External torques `tau_ext_k_n_m` along a recording, by a momentum observer of gain `gain` > 0 [1/s] with learned dynamics; it
/// is reset after every gap.
///
/// # Errors
/// `BadInput` for channels that are not there, or of another arm.
pub fn external_torques_along(
    body: LearnedBody,
    recording: &Recording,
    gain: f64,
    meta: Metadata,
) -> Result<Recording, BadInput> {
    let n = body.n_joints();
    let recorded = ArmRecording::of(recording)?;
    let measured = columns(
        &recorded,
        n,
        [JointQuantityKind::Position, JointQuantityKind::Velocity, JointQuantityKind::Torque],
    )?;
    let mut observer = MomentumObserver::new(body, FrictionModel::none(n), &vec![gain; n]);
    let mut found = vec![Vec::with_capacity(recorded.time.len()); n];
    let (mut now, mut external) = (measured.each_ref().map(|_| vec![0.0; n]), vec![0.0; n]);
    let is_gap = |row: usize| recorded.gap.get(row).copied().unwrap_or(false);
    for row in 0..recorded.time.len() {
        for (values, columns) in now.iter_mut().zip(&measured) {
            values.iter_mut().zip(columns).for_each(|(value, column)| *value = column[row]);
        }
        external.fill(0.0);
        if is_gap(row) {
            observer.reset();
        } else {
            // The first sample sets the state; its period counts for nothing.
            let period = if row == 0 { 1.0 } else { recorded.time[row] - recorded.time[row - 1] };
            let sample = ArmSample { period, position: &now[0], velocity: &now[1], torque: &now[2] };
            observer.update(&sample, &mut external);
        }
        found.iter_mut().zip(&external).for_each(|(column, value)| column.push(*value));
    }
    let name = |joint: usize| {
        JointQuantityKind::Torque.channel(recorded.joints[joint].kind, joint).replacen("tau", "tau_ext", 1)
    };
    let channels = found.into_iter().enumerate().map(|(joint, column)| Channel::new(name(joint), column));
    Recording::new(recorded.time.to_vec(), channels.collect(), recorded.gap.to_vec(), meta)
}

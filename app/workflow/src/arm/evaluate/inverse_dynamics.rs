//! Evaluates a model of inverse dynamics on a recording: errors of the torques, and their parts over time.

use hysteron_arm_estimation::{ArmRecording, JointQuantityKind};
use hysteron_arm_learning::lagrangian::{LearnedDynamics, TorqueScores, samples_of};
use hysteron_base::checks::{CheckContext, Purpose};
use hysteron_base::{BadInput, Channel, Metadata, Recording};

use super::Options;
use super::outcome::DynamicsScores;
use crate::shared::outputs::Outputs;
use crate::shared::recording_checks;
use crate::{Context, arm};

/// Evaluates a model of inverse dynamics on a recording.
///
/// # Errors
/// Bad input; a model that diverges; files that cannot be written.
pub(super) fn evaluate(options: &Options, context: &Context) -> anyhow::Result<DynamicsScores> {
    let [path] = &options.recordings[..] else {
        let found = options.recordings.len().to_string();
        return Err(BadInput::new("recordings", "one, for a model of inverse dynamics", found).into());
    };
    let outputs = Outputs::reading([&options.model, path]);
    let outputs = options.out.iter().fold(outputs, |outputs, out| outputs.recording("--out", out));
    let _lock = outputs.check(context)?;
    let model = LearnedDynamics::read(&options.model)?;
    let recording = crate::shared::memory::recording(path)?;
    let name = recording_checks::name_of(path);
    let findings = recording_checks::of_named(&[(&name, &recording)], &CheckContext::new(Purpose::Score))?;
    let within = |bad: BadInput| bad.within(path.display());
    let samples = samples_of(&recording, options.cutoff).map_err(within)?;
    let parts = model.decompose(&samples).map_err(within)?;
    let n = samples.n_joints;
    if let Some(k) = parts.torque.iter().position(|torque| !torque.is_finite()) {
        let place = format!("{}: sample {}: torque of joint {}", path.display(), k / n + 1, k % n + 1);
        let bad = BadInput::new(place, "a finite number from the model", parts.torque[k].to_string());
        return Err(bad.hint("the model diverges on this recording: is it of the same arm?").into());
    }
    let scores = TorqueScores::of(n, &samples.tau, &parts.torque);
    for j in 0..n {
        context.print(format_args!(
            "joint {}: mean squared error {:.4e}, over the variance {:.4e}",
            j + 1,
            scores.mse[j],
            scores.nmse[j]
        ));
    }
    context.print(format_args!(
        "R² pooled {:.4}, mean of the joints {:.4}",
        scores.pooled_r2,
        scores.mean_r2()
    ));
    if let Some(out) = &options.out {
        let parts = [&parts.torque, &parts.inertial, &parts.coriolis, &parts.gravity, &parts.other];
        let recorded = ArmRecording::of(&recording).map_err(within)?;
        recording_of(&recorded, parts, arm::meta(context, "learned inverse dynamics"))?.write(out)?;
        context.print(format_args!("{} rows: {}", samples.len(), out.display()));
    }
    Ok(DynamicsScores {
        mean_r2: scores.mean_r2(),
        mse_n2_m2: scores.mse,
        nmse: scores.nmse,
        pooled_r2: scores.pooled_r2,
        recording_warnings: findings.into_warnings(),
    })
}

/// The torques and their parts, at the samples that are no gaps.
fn recording_of(
    recorded: &ArmRecording<'_>,
    parts: [&Vec<f64>; 5],
    meta: Metadata,
) -> anyhow::Result<Recording> {
    let n = recorded.joints.len();
    let kept: Vec<bool> = recorded.gap.iter().map(|gap| !gap).collect();
    let time: Vec<f64> =
        recorded.time.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(t, _)| *t).collect();
    let mut channels = Vec::new();
    for (name, values) in ["tau", "inertial", "coriolis", "gravity", "other"].into_iter().zip(parts) {
        for (j, joint) in recorded.joints.iter().enumerate() {
            let torque = JointQuantityKind::Torque.channel(joint.kind, j);
            let column = values.iter().skip(j).step_by(n).copied().collect();
            channels.push(Channel::new(torque.replacen("tau", name, 1), column));
        }
    }
    let gap = vec![false; time.len()];
    Ok(Recording::new(time, channels, gap, meta)?)
}

//! External torques along a recording, by a momentum observer whose dynamics are learned.

use hysteron_arm_learning::lagrangian::{LearnedDynamics, external_torques_along};
use hysteron_base::BadInput;

use super::Options;
use super::outcome::ExternalTorques;
use crate::shared::outputs::Outputs;
use crate::{Context, arm};

/// Estimates along the recording of `options`.
///
/// # Errors
/// Bad input, as where telemetry is to be live; files that cannot be written.
pub(super) fn run(options: &Options, context: &Context) -> anyhow::Result<ExternalTorques> {
    let Some(path) = &options.recording else {
        let expected = "an actuator by hysteron arm fit neural --sensing observer";
        return Err(BadInput::new("--live", expected, "a model by hysteron arm fit delan").into());
    };
    let outputs = Outputs::reading([&options.actuator, path]).recording("--out", &options.out);
    let _lock = outputs.check(context)?;
    let recording = crate::shared::memory::recording(path)?;
    let meta = arm::meta(context, "external torques from learned dynamics");
    if !(options.gain > 0.0 && options.gain.is_finite()) {
        return Err(BadInput::new("--gain", "a number > 0", options.gain.to_string()).into());
    }
    let body = LearnedDynamics::read(&options.actuator)?.body();
    let body = body.map_err(|bad| bad.within(options.actuator.display()))?;
    let found = external_torques_along(body, &recording, options.gain, meta);
    let found = found.map_err(|bad| bad.within(path.display()))?;
    found.write(&options.out)?;
    let rows = found.n_samples();
    let rms: Vec<f64> = found
        .channels()
        .iter()
        .map(|channel| (channel.values.iter().map(|v| v * v).sum::<f64>() / rows as f64).sqrt())
        .collect();
    let spelled: Vec<String> = rms.iter().map(|rms| format!("{rms:.3}")).collect();
    context.print(format_args!(
        "{rows} rows, root mean square of each joint {} N m: {}",
        spelled.join(", "),
        options.out.display()
    ));
    Ok(ExternalTorques { rows, rms_n_m: rms, out: options.out.clone() })
}

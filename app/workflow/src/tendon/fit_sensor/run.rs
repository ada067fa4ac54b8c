//! The fit of a sensor: recordings, the twin along them, the sensor, its file.

use std::path::Path;

use hysteron_base::checks::Purpose;
use hysteron_base::{BadInput, file, json, parallel};
use hysteron_twin::Twin;
use hysteron_twin::sense::{ForceSensor, KnownForce, RecordingObservations, fit_sensor};
use serde::Deserialize;

use super::options::Options;
use super::outcome::Outcome;
use crate::shared::identification::{IdentificationFormat, LOAD_SCALE, ParameterEstimate};
use crate::shared::network::Network;
use crate::shared::outputs::Outputs;
use crate::shared::{inputs, locking, recording_checks};
use crate::tendon::sense::file::SensedRobot;
use crate::tendon::sense::input::SensingInput;
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; a step of the twin that fails; an interruption; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(fit(options, context)?)
}

fn fit(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    options.check()?;
    let stall_torque = options.servos.as_deref().map(load_scale).transpose()?.unwrap_or(options.stall_torque);
    let scene = options.body.scene(&options.scene)?;
    let files = inputs::read(&options.recordings)?;
    let outputs =
        Outputs::reading(files.iter().map(|input| &input.path)).and(&options.residual).and(&options.servos);
    let _lock = outputs.scene(&options.scene, &scene).file("--out", &options.out).check(context)?;
    let twin = Twin::from_scene(&scene)?;
    let findings = recording_checks::of_inputs(&files, &recording_checks::context_of(&twin, Purpose::Fit))?;
    let recordings = files
        .iter()
        .map(|input| SensingInput::new(&twin, &input.recording, &input.path.display().to_string()))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let period = common_period(&recordings)?;
    // From here on the stiffness is factorised.
    let network = options.residual.as_ref().map(|path| Network::read(path, &scene, &twin)).transpose()?;
    locking::warn_before_fit(&scene)?;
    context.listen();
    let bar = context.progress("samples", recordings.iter().map(|input| input.motion.len()).sum(), 0);
    let observe = |input| SensingInput::observe(input, &twin, network.as_ref(), context, bar.as_ref());
    let observed: Vec<RecordingObservations> = parallel::try_map(&recordings, observe)?;
    bar.finish();
    let (free, known) = by_contact(&recordings, observed)?;
    let servo = servo(&recordings, stall_torque);
    if servo.is_none() {
        tracing::warn!("not every recording has ticks and loads: tensions will rest on the twin alone");
    }
    let sensor = fit_sensor(&free, &known, servo, period)?;
    if known.is_empty() {
        tracing::warn!(
            "no recording with a known force: the stiffness of the tip is the twin's times {:.2}, known to {:.0} %; push the \
             tip with known weights and record tip_force_x_n, tip_force_y_n, tip_force_z_n",
            sensor.stiffness_scale,
            100.0 * sensor.tip.response
        );
    }
    let robot =
        SensedRobot { scene: &scene.hash, network: network.as_ref().map(|network| network.hash.as_str()) };
    let outcome = Outcome::new(sensor, &robot, (&files, known.len()), &findings, context);
    file::write_bytes(&options.out, json::to_text(&outcome)?)?;
    print(&outcome.sensor, context);
    context.wrote(&options.out);
    Ok(outcome)
}

/// Observations without a contact, and those of pushes with a known force.
fn by_contact(
    recordings: &[SensingInput],
    observed: Vec<RecordingObservations>,
) -> Result<(Vec<RecordingObservations>, Vec<KnownForce>), BadInput> {
    let (mut free, mut known) = (Vec::new(), Vec::new());
    for (input, observed) in recordings.iter().zip(observed) {
        match &input.truth.force {
            Some(force) if input.truth.is_pushed() => {
                known.push(KnownForce { observed, force: force.clone() })
            }
            _ => free.push(observed),
        }
    }
    if free.is_empty() {
        let found = "pushes in every one";
        return Err(BadInput::new("recordings", "at least one without contact", found));
    }
    Ok((free, known))
}

/// Stall torque of the servos [N m] and mean radius of their pulleys [m], where every recording has ticks and loads.
fn servo(recordings: &[SensingInput], stall_torque: f64) -> Option<(f64, f64)> {
    let radius = recordings.iter().map(|input| input.servos.as_ref().map(|servos| servos.radius));
    let radii: Vec<f64> = radius.collect::<Option<_>>()?;
    Some((stall_torque, radii.iter().sum::<f64>() / radii.len() as f64))
}

/// The part of a file by `identify-servo` that is read.
#[derive(Deserialize)]
struct ServoFile {
    format: IdentificationFormat,
    #[serde(default)]
    servos: Vec<IdentifiedServo>,
}

#[derive(Deserialize)]
struct IdentifiedServo {
    has_tension: bool,
    estimates: Vec<ParameterEstimate>,
}

impl IdentifiedServo {
    /// Torque at full load [N m], where tensions were known.
    fn load_scale(&self) -> Option<f64> {
        let mut estimates = self.estimates.iter();
        estimates.find(|estimate| estimate.name == LOAD_SCALE).filter(|_| self.has_tension).map(|it| it.value)
    }
}

/// Mean load scale [N m] of the servos for which `identify-servo` knew tensions.
fn load_scale(path: &Path) -> anyhow::Result<f64> {
    let wrong = |found: String| {
        BadInput::new(path.display().to_string(), "load_scale_n_m of servos, with tensions known", found)
            .hint("hysteron identify-servo RECORDING --out FILE, of a recording with tension_1_n, ..")
    };
    let read: ServoFile =
        json::from_text(&file::read_text(path)?).map_err(|error| wrong(error.to_string()))?;
    if read.format != IdentificationFormat::Identification {
        return Err(wrong("a file of another kind".into()).into());
    }
    let servos = read.servos;
    let scales: Vec<f64> =
        servos.iter().filter_map(IdentifiedServo::load_scale).filter(|scale| *scale > 0.0).collect();
    if scales.is_empty() {
        return Err(wrong(format!("{} servos without it", servos.len())).into());
    }
    Ok(scales.iter().sum::<f64>() / scales.len() as f64)
}

/// Filters are made for one rate.
fn common_period(recordings: &[SensingInput]) -> Result<f64, BadInput> {
    let first = recordings.first().map_or(0.0, SensingInput::period);
    match recordings.iter().find(|input| (input.period() / first - 1.0).abs() > 0.01) {
        Some(other) => {
            let expected = format!("samples of {first:.4} s, as in {}", recordings[0].name);
            Err(BadInput::new(
                format!("{}: time_s", other.name),
                expected,
                format!("{:.4} s", other.period()),
            ))
        }
        None => Ok(first),
    }
}

fn print(sensor: &ForceSensor, context: &Context) {
    let mm = |values: [f64; 3]| values.map(|value| format!("{:.3}", 1e3 * value)).join(" / ");
    let ForceSensor { tension, tip, .. } = sensor;
    if let Some(servo) = &sensor.servo {
        context.print(format_args!(
            "friction of the servos: Coulomb {:.4} N m, breakaway {:.4} N m, viscous {:.4} N m s/rad",
            servo.coulomb_n_m, servo.breakaway_n_m, servo.viscous_n_m_s_per_rad
        ));
    }
    context.print(format_args!(
        "tensions: {:.3} times the twin's, {:.2} N off",
        tension.force_scale, tension.model_n
    ));
    context.print(format_args!(
        "tip: {:.2} times as stiff as the twin's, known to {:.0} %",
        sensor.stiffness_scale,
        100.0 * tip.response
    ));
    context.print(format_args!(
        "tip without contact off by {} mm, another after {:.1} mm of tendon; offset {} mm; noise {} mm",
        mm(tip.model_m),
        1e3 * tip.length_m,
        mm(tip.offset_m),
        mm(tip.noise_m)
    ));
    let [rest, slow, faster, fast] = tip.thresholds;
    context.print(format_args!(
        "a jump counts as contact from {rest:.1} standard deviations on at rest, {slow:.1} below 1 mm/s, {faster:.1} below 2 mm/s, \
         {fast:.1} above"
    ));
}

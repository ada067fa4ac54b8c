//! The estimates: sensor and recording, the twin along it, the recording of the estimates, page.

use hysteron_base::checks::Purpose;
use hysteron_base::number::shown;
use hysteron_base::{BadInput, Channel, Metadata, Recording};
use hysteron_report::folder::ReportFolder;
use hysteron_twin::Twin;
use hysteron_twin::sense::{
    ForceSensor, RecordingObservations, SensedSample, SensingScores, TendonSensing, TensionScore, score,
};

use super::file::{self, SensedRobot};
use super::input::SensingInput;
use super::options::Options;
use super::outcome::Outcome;
use super::page::{self, EstimateSeries};
use crate::shared::network::Network;
use crate::shared::outputs::Outputs;
use crate::shared::{inputs, paths, recording_checks};
use crate::{COMMIT, Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; a step of the twin that fails; an interruption; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(sense(options, context)?)
}

fn sense(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    paths::check_recording(&options.out)?;
    let scene = options.body.scene(&options.scene)?;
    let files = inputs::read(std::slice::from_ref(&options.recording))?;
    let [read] = &files[..] else {
        return Err(BadInput::new("REC", "one recording", files.len().to_string()).into());
    };
    let outputs =
        Outputs::reading([&read.path, &options.sensor]).and(&options.residual).scene(&options.scene, &scene);
    let outputs = outputs.file("--out", &options.out).report("--figures", options.figures.as_deref());
    let _lock = outputs.check(context)?;
    let twin = Twin::from_scene(&scene)?;
    let findings = recording_checks::of_inputs(&files, &recording_checks::context_of(&twin, Purpose::Score))?;
    let input = SensingInput::new(&twin, &read.recording, &read.path.display().to_string())?;
    // From here on the stiffness is factorised.
    let network = options.residual.as_ref().map(|path| Network::read(path, &scene, &twin)).transpose()?;
    let robot =
        SensedRobot { scene: &scene.hash, network: network.as_ref().map(|network| network.hash.as_str()) };
    let sensor = file::read(&options.sensor, &robot)?;
    check_period(&input, &sensor)?;
    context.listen();
    let bar = context.progress("samples", input.motion.len(), 0);
    let observed = input.observe(&twin, network.as_ref(), context, bar.as_ref())?;
    bar.finish();
    let mut sensing = TendonSensing::new(&sensor, twin.n_primary)?;
    let sensed: Vec<SensedSample> = observed.samples.iter().map(|sample| sensing.step(sample)).collect();
    let meta = Metadata {
        scene_hash: scene.hash.clone(),
        source: format!("forces estimated from {}", read.name),
        commit: COMMIT.to_owned(),
        command: context.command.clone(),
        ..Metadata::default()
    };
    let (time, gap) = (read.recording.time().to_vec(), read.recording.gap().to_vec());
    let recording = Recording::new(time, channels(&sensed, &input, &observed), gap, meta)?;
    recording.write(&options.out)?;
    let scores = score(&input.truth, |i| input.sample(i), &observed, &sensed, &sensor)?;
    print(&scores, context);
    let outcome = Outcome::new(scores, sensor, read, &findings, context);
    if let Some(folder) = &options.figures {
        let shown = EstimateSeries { title: &scene.name, estimates: &recording, measured: &read.recording };
        page::write(&ReportFolder { path: folder, png: options.png }, &outcome, &shown)?;
        context.reported(folder);
    }
    context.wrote(&options.out);
    Ok(outcome)
}

/// Refuses a recording at another rate than that of the sensor.
fn check_period(input: &SensingInput, sensor: &ForceSensor) -> Result<(), BadInput> {
    if (input.period() / sensor.period_s - 1.0).abs() <= 0.01 {
        return Ok(());
    }
    let expected = format!("samples of {} s, as the sensor was fitted with", shown(sensor.period_s));
    let found = format!("{} s", shown(input.period()));
    Err(BadInput::new(format!("{}: time_s", input.name), expected, found).hint("resample the recording"))
}

/// Channels of the output: strokes, tensions and force with their standard errors, contact state, and the tip
/// without a contact.
fn channels(sensed: &[SensedSample], input: &SensingInput, observed: &RecordingObservations) -> Vec<Channel> {
    let n = sensed.first().map_or(0, |sensed| sensed.tensions.len());
    let mut channels = Vec::new();
    let mut add = |name: String, value: &dyn Fn(usize) -> f64| {
        channels.push(Channel::new(name, (0..sensed.len()).map(value).collect()));
    };
    for k in 0..n {
        add(format!("stroke_{}_m", k + 1), &|i| input.motion.strokes_at(i)[k]);
    }
    for k in 0..n {
        add(format!("tension_{}_n", k + 1), &|i| sensed[i].tensions[k].0);
        add(format!("tension_error_{}_n", k + 1), &|i| sensed[i].tensions[k].1);
    }
    for (c, axis) in ["x", "y", "z"].into_iter().enumerate() {
        add(format!("tip_force_{axis}_n"), &|i| sensed[i].tip.force[c]);
        add(format!("tip_force_error_{axis}_n"), &|i| sensed[i].tip.covariance[(c, c)].max(0.0).sqrt());
        add(format!("free_tip_{axis}_m"), &|i| observed.samples[i].free_tip[c]);
    }
    add("contact".into(), &|i| f64::from(u8::from(sensed[i].tip.is_contact)));
    channels
}

fn print(scores: &SensingScores, context: &Context) {
    if !scores.tensions.is_empty() {
        context.print("tension, error over its root mean square      all   moving  at rest");
        for row in &scores.tensions {
            let TensionScore { method, all, moving, resting } = row;
            let percent = [all, moving, resting].map(|share| format!("{:>6.1} %", 100.0 * share)).join(" ");
            context.print(format_args!("  {method:<40} {percent}"));
        }
    }
    if !scores.forces.is_empty() {
        context.print("force on the tip               samples     RMS [mN]  median  within 30 mN or 15 %  direction within 15°");
        for row in &scores.forces {
            context.print(format_args!(
                "  {:<28} {:<8} {:>10.0} {:>8.0} {:>20.0} % {:>20.0} %",
                row.method,
                row.samples,
                1e3 * row.rms_n,
                1e3 * row.median_n,
                100.0 * row.near,
                100.0 * row.aligned
            ));
        }
    }
    if let Some(contacts) = &scores.contacts {
        context.print(format_args!(
            "contacts: {}, within 100 ms found {:.0} %, above 0.15 N {:.0} %; false alarms {:.1} an hour, in {:.0} s without contact",
            contacts.contacts,
            100.0 * contacts.found_at_once,
            100.0 * contacts.strong_found_at_once,
            contacts.false_alarms_per_hour,
            contacts.free_s
        ));
    }
}

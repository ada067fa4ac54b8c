//! `hysteron adapt`: a calibrated twin learns, from a little of what is measured now, how its robot has changed.

use std::path::PathBuf;

use hysteron_base::checks::Purpose;
use hysteron_base::{Scene, json};
use hysteron_twin::residual::{AdaptOptions, Adapted, AdaptedParts, adapt, n_samples};
use hysteron_twin::{Motion, Twin};
use serde::Serialize;
use serde_json::Value;

use crate::shared::error::Cancelled;
use crate::shared::network::Network;
use crate::shared::outputs::Outputs;
use crate::shared::recording_checks::{self, Findings};
use crate::{COMMIT, Context, shared::verdict};
use crate::{shared::inputs, shared::paths};
use hysteron_report::page::write_metrics;
use hysteron_report::verdict::{Criterion, Verdict};

/// Adapt a calibrated twin to what is measured now
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Checkpoint by hysteron fit-residual, or by this verb
    #[cfg_attr(feature = "clap", arg(value_name = "CKPT"))]
    pub checkpoint: PathBuf,
    /// Recordings of the robot, .parquet or .csv, or folders of them; in the order of their names
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Scene file of the robot (scene.toml)
    #[cfg_attr(feature = "clap", arg(long, value_name = "SCENE"))]
    pub scene: PathBuf,
    /// Checkpoint to write, .safetensors
    #[cfg_attr(feature = "clap", arg(long, value_name = "CKPT"))]
    pub out: PathBuf,
    /// Folder for metrics.json [default: OUT without its ending]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Time after which what was seen counts a third
    #[cfg_attr(feature = "clap", arg(long, value_name = "S", default_value_t = AdaptOptions::default().memory_s, value_parser = crate::shared::number::time_s))]
    pub memory_s: f64,
}

/// Carries out the verb.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Value> {
    paths::check_checkpoint(&options.out)?;
    let scene = Scene::read(&options.scene)?;
    let twin = Twin::from_scene(&scene)?;
    let network = Network::read(&options.checkpoint, &scene, &twin)?;
    let inputs = inputs::read(&options.recordings)?;
    let motions = inputs
        .iter()
        .map(|input| Motion::for_identification(&twin, &input.recording, &input.path.display().to_string()))
        .collect::<Result<Vec<_>, _>>()?;
    for motion in &motions {
        network.rollout(&twin, motion.step).map_err(|bad| bad.within(&motion.name))?;
    }
    let outputs = Outputs::reading(inputs.iter().map(|input| &input.path)).and([&options.checkpoint]);
    let folder = paths::beside(&options.out, options.figures.as_deref());
    let outputs = outputs.scene(&options.scene, &scene).file("--out", &options.out);
    let _claim = outputs.report("--figures", Some(&folder)).check(context)?;
    let findings = recording_checks::of_inputs(&inputs, &recording_checks::context_of(&twin, Purpose::Fit))?;
    context.listen();
    let bar = context.progress("samples", n_samples(&twin, &motions), 0);
    let on_sample = || {
        bar.inc(1);
        !context.is_cancelled()
    };
    let settings = AdaptOptions { memory_s: options.memory_s, ..AdaptOptions::default() };
    let adapted = adapt(&twin, network.auxiliary(), network.model(), &motions, &settings, &on_sample)?;
    bar.finish();
    let Some(mut adapted) = adapted else { return Err(Cancelled::new("; nothing is written").into()) };
    let hashes = inputs.iter().map(|input| json!([input.name, input.hash])).collect();
    adapted.model.training["adapted_to"] = hashes;
    adapted.model.training["adapted_kept"] = json!(adapted.kept);
    context.sign(&mut adapted.model.training);
    adapted.model.write(&options.out)?;
    let value = write_metrics(&folder, &Metrics::new(&adapted, &settings, &findings, context))?;
    print(&adapted, context);
    context.wrote(&options.out);
    Ok(value)
}

#[derive(Serialize)]
struct Metrics<'a> {
    format: &'static str,
    version: u32,
    /// Whether the adapted twin can be used.
    verdict: Verdict,
    kept: AdaptedParts,
    /// By what would be kept: the root mean square distance of the tip on all blocks while each was held out.
    held_out: Vec<HeldOut>,
    blocks: Vec<Block<'a>>,
    /// Beyond what the checkpoint had; in the checkpoint only where `kept` says so.
    found: Found<'a>,
    recordings: &'a [hysteron_twin::residual::MotionErrors],
    options: &'a AdaptOptions,
    /// Warnings of the checks of the recordings.
    recording_warnings: &'a Findings,
    command: String,
    commit: &'static str,
}

#[derive(Serialize)]
struct HeldOut {
    kept: AdaptedParts,
    rms_m: f64,
}

#[derive(Serialize)]
struct Block<'a> {
    recording: &'a str,
    time_s: [f64; 2],
}

#[derive(Serialize)]
struct Found<'a> {
    zeros_m: &'a [f64],
    play_m: f64,
    friction_ratio: f64,
    prior_weight: f64,
}

impl<'a> Metrics<'a> {
    fn new(
        adapted: &'a Adapted,
        options: &'a AdaptOptions,
        findings: &'a Findings,
        context: &Context,
    ) -> Self {
        let held_out = adapted.held_out_m.iter().map(|&(kept, rms_m)| HeldOut { kept, rms_m });
        let blocks = adapted.blocks.iter().map(|(name, time)| Block { recording: name, time_s: *time });
        Self {
            format: "hysteron-metrics",
            version: 1,
            verdict: judged(adapted),
            kept: adapted.kept,
            held_out: held_out.collect(),
            blocks: blocks.collect(),
            found: Found {
                zeros_m: &adapted.found.zeros_m,
                play_m: adapted.found.play_m,
                friction_ratio: adapted.found.friction_ratio,
                prior_weight: adapted.prior_weight,
            },
            recordings: &adapted.motions,
            options,
            recording_warnings: findings,
            command: context.command.clone(),
            commit: COMMIT,
        }
    }
}

/// Whether what was kept does better, on blocks that were held out, than the twin as it was.
fn judged(adapted: &Adapted) -> Verdict {
    let held_out = |wanted: AdaptedParts| {
        adapted.held_out_m.iter().find(|(kept, _)| *kept == wanted).map_or(f64::NAN, |(_, rms)| *rms)
    };
    let (before, after) = (held_out(AdaptedParts::Nothing), held_out(adapted.kept));
    let mm = |m: f64| format!("{:.3} mm", 1e3 * m);
    let statement = match adapted.kept {
        AdaptedParts::Nothing => {
            format!(
                "nothing new explains the recordings better than the twin as it was ({}), which stays as it is",
                mm(before)
            )
        }
        kept => format!(
            "on blocks that were held out, the tip is off by {} with {}, {} as it was",
            mm(after),
            words(kept),
            mm(before)
        ),
    };
    let outside = adapted.motions.iter().map(|motion| motion.extrapolating).fold(0.0, f64::max);
    let judged = Verdict::on(format!("the twin of the changed robot is off by {}", mm(after)))
        .because(Criterion::ErrorOverBaseline, verdict::ratio(after, before), statement)
        .because(
            Criterion::OutsideTraining,
            outside,
            format!("up to {:.0} % of a recording is outside the network's training", 100.0 * outside),
        );
    verdict::repeated(judged, adapted.blocks.len(), "block that was held out").verdict()
}

/// Description of the parts that would be kept.
fn words(kept: AdaptedParts) -> &'static str {
    match kept {
        AdaptedParts::Nothing => "nothing new",
        AdaptedParts::Change => "zeros, play and friction",
        AdaptedParts::Correction => "a linear correction",
        AdaptedParts::Both => "zeros, play, friction and a linear correction",
    }
}

/// Prints errors held out, the decision, what was found and errors along the recordings.
fn print(adapted: &Adapted, context: &Context) {
    for (kept, rms) in &adapted.held_out_m {
        context.print(format_args!("held out, with {}: tip {:.3} mm off (rms)", words(*kept), 1e3 * rms));
    }
    context.print(format_args!("kept: {}", words(adapted.kept)));
    let zeros: Vec<String> = adapted.found.zeros_m.iter().map(|zero| format!("{:.2}", 1e3 * zero)).collect();
    context.print(format_args!(
        "found: zeros {} mm, play {:.2} mm more, friction times {:.2}",
        zeros.join(", "),
        1e3 * adapted.found.play_m,
        adapted.found.friction_ratio
    ));
    for motion in &adapted.motions {
        let outside = match motion.extrapolating {
            0.0 => String::new(),
            part => format!("; {:.0} % of it outside the network's training, not learned from", 100.0 * part),
        };
        context.print(format_args!(
            "{}: tip off by {:.3} mm (rms) before, {:.3} mm after{outside}",
            motion.name,
            1e3 * motion.before_m,
            1e3 * motion.after_m
        ));
    }
}

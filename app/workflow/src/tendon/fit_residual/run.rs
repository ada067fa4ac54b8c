//! The training of residual networks: identified recordings, networks, checkpoint, page.

use std::path::{Path, PathBuf};
use std::time::Instant;

use hysteron_base::checks::{CheckContext, Purpose};
use hysteron_base::{BadInput, Recording, rng};
use hysteron_control::split::{MotionKind, deal_folds, draw_validation};
use hysteron_learn::{Epoch, TrainingProgress};
use hysteron_report::folder::ReportFolder;
use hysteron_twin::residual::{
    FittedResidual, PUBLISHED, RecurrentOptions, Sequence, Sessions, fit_recurrent, fit_windowed,
};

use super::options::Options;
use super::outcome::Outcome;
use super::page;
use crate::shared::inputs::{self, Input};
use crate::shared::outputs::Outputs;
use crate::shared::paper_design::DesignName;
use crate::shared::paths;
use crate::shared::recording_checks;
use crate::shared::resume::Unfinished;
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; a training that fails or is interrupted before its first epoch is done; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(train(options, context)?)
}

fn train(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    paths::check_checkpoint(&options.out)?;
    let inputs = inputs::read(&options.recordings)?;
    let scene_hash = common_scene(&inputs)?;
    let outputs = Outputs::reading(inputs.iter().map(|input| &input.path));
    let figures = paths::report_folder(&options.out, options.figures.as_deref());
    let outputs = outputs.file("--out", &options.out).report("--figures", Some(&figures));
    let _lock = outputs.check(context)?;
    let findings = recording_checks::of_inputs(&inputs, &CheckContext::new(Purpose::Fit))?;
    let usable: Vec<&Input> = inputs
        .iter()
        .filter(|input| matches!(inputs::role(input.recording.meta()), "" | "training"))
        .collect();
    let held_out = held_out(options, &usable)?;
    let n_of_all = if is_in_folds(options) { options.members } else { 0 };
    let sequences = usable.iter().map(|input| sequence(input)).collect::<anyhow::Result<Vec<_>>>()?;
    let samples = sequences.iter().map(Sequence::len).sum::<usize>();
    tracing::info!("{} recordings, {samples} samples", sequences.len());
    for (k, held_out) in held_out.iter().enumerate() {
        let names: Vec<&str> = held_out.iter().map(|&k| usable[k].name.as_str()).collect();
        context.print(format_args!("network {} is validated on: {}", k + 1, names.join(", ")));
    }
    context.listen();
    // What a network with feedback has seen of itself is in no file.
    let n_files = if options.feedback { 0 } else { held_out.len() + n_of_all };
    let files = (1..=n_files).map(|k| options.out.with_extension(format!("training-{k}"))).collect();
    let unfinished = Unfinished::new(&options.out, files);
    let display = MemberDisplay::new(context);
    let progress = |number: usize, report: &TrainingProgress| display.show(number, report);
    let sessions = Sessions { files: unfinished.files.clone(), progress: &progress };
    let fitted = fit(options, &sequences, (&held_out, n_of_all), &scene_hash, &display, &sessions);
    display.bar.finish();
    let FittedResidual { mut model, reports, is_finished } = fitted?;
    model.training.provenance = Some(context.provenance());
    model.write(&options.out)?;
    let outcome = Outcome::new(reports, model.training, &findings, context);
    print(&outcome, context);
    page::write(&ReportFolder { path: &figures, png: false }, &outcome)?;
    context.reported(&figures);
    unfinished.end(is_finished, context)?;
    Ok(outcome)
}

/// Prints the errors in validation and the warnings.
fn print(outcome: &Outcome, context: &Context) {
    for (k, report) in outcome.networks.iter().enumerate() {
        let of_method = report.methods.iter().zip(report.together());
        let errors: Vec<String> = of_method.map(|(name, error)| format!("{name} {error:.3} mm")).collect();
        context.print(format_args!("network {} in validation: {}", k + 1, errors.join(", ")));
    }
    if let Some(band) = &outcome.training.tip_band {
        context.print(format_args!(
            "{:.0} % of the tip within {:.3} mm on {} recordings left out (twin alone {:.3} mm)",
            100.0 * band.level,
            band.radius_mm,
            band.recordings,
            band.alone_mm,
        ));
    }
    outcome.warnings.iter().for_each(|warning| tracing::warn!("{warning}"));
}

fn fit(
    options: &Options,
    sequences: &[Sequence],
    (held_out, n_of_all): (&[Vec<usize>], usize),
    scene_hash: &str,
    display: &MemberDisplay,
    sessions: &Sessions<'_>,
) -> hysteron_twin::Result<FittedResidual> {
    let Options { epochs, hidden, seed, .. } = *options;
    match options.design {
        DesignName::Recurrent => {
            let default = RecurrentOptions::default();
            let options = RecurrentOptions {
                learning: default.learning.with([epochs, hidden]),
                feedback: options.feedback,
                seed,
                ..default
            };
            display.bar.set_length(((held_out.len() + n_of_all) * options.learning.epochs) as u64);
            fit_recurrent(sequences, (held_out, n_of_all), scene_hash, &options, sessions)
        }
        DesignName::Paper => {
            let options = options.paper.options(PUBLISHED, [epochs, hidden], seed);
            display.bar.set_length(options.epochs as u64);
            let is_held = |k: &usize| held_out[0].contains(k);
            let (validation, training): (Vec<usize>, Vec<usize>) = (0..sequences.len()).partition(is_held);
            let pick = |indices: Vec<usize>| -> Vec<Sequence> {
                indices.into_iter().map(|k| sequences[k].clone()).collect()
            };
            fit_windowed(&pick(training), &pick(validation), scene_hash, &options, sessions)
        }
    }
}

/// A bar over the epochs of all networks.
struct MemberDisplay<'a> {
    bar: Box<dyn crate::Progress>,
    start: Instant,
    context: &'a Context<'a>,
}

impl<'a> MemberDisplay<'a> {
    fn new(context: &'a Context<'a>) -> Self {
        Self { bar: context.progress("epochs", 0, 0), start: Instant::now(), context }
    }

    /// False where the training is to end.
    fn show(&self, member: usize, progress: &TrainingProgress) -> bool {
        if let TrainingProgress::Epoch(Epoch { number, of, training, validation, best }) = progress {
            self.bar.inc(1);
            self.bar.set_message(format!("held out {best:.3} mm"));
            tracing::debug!(
                "network {}, epoch {number}/{of}: {training:.3} mm, validation {validation:.3} mm, best {best:.3} mm; {:.0} s",
                member + 1,
                self.start.elapsed().as_secs_f64(),
            );
        }
        !self.context.is_cancelled()
    }
}

/// The scene that all recordings were identified with.
fn common_scene(inputs: &[Input]) -> Result<String, BadInput> {
    let hash = |input: &Input| input.recording.meta().scene_hash.clone();
    let first = hash(&inputs[0]);
    match inputs.iter().find(|input| hash(input) != first) {
        None if first.is_empty() => {
            let place = format!("{}: scene_hash", inputs[0].path.display());
            Err(BadInput::new(place, "a recording by hysteron identify", "nothing")
                .hint("identify the recordings of the robot first"))
        }
        None => Ok(first),
        Some(other) => Err(BadInput::new(
            format!("{}: scene_hash", other.path.display()),
            format!("{first}, as {}", inputs[0].path.display()),
            hash(other),
        )
        .hint("identify all recordings with one scene")),
    }
}

/// Whether recordings are left out in turn and then all learned from.
fn is_in_folds(options: &Options) -> bool {
    options.design == DesignName::Recurrent && options.held_out.is_empty()
}

/// The recordings that each network is validated on, as indices.
fn held_out(options: &Options, usable: &[&Input]) -> Result<Vec<Vec<usize>>, BadInput> {
    let names: Vec<&str> = usable.iter().map(|input| input.name.as_str()).collect();
    if names.len() < 2 {
        let found = format!("{} for training", names.len());
        return Err(BadInput::new("recordings", "at least two", found)
            .hint("the number of epochs needs a validation trajectory"));
    }
    if let Some(unknown) = options.held_out.iter().find(|name| !names.contains(&name.as_str())) {
        return Err(BadInput::new("--held-out", format!("of {}", names.join(", ")), unknown.clone()));
    }
    let kinds: Vec<String> = usable.iter().map(|input| kind(&input.recording)).collect();
    if is_in_folds(options) {
        let n = options.members.max(2).min(names.len());
        return Ok(deal_folds(&kinds, n, &mut rng(options.seed, "residual/folds")));
    }
    let named = (0..names.len()).filter(|&k| options.held_out.contains(&usable[k].name)).collect();
    Ok(match options.design {
        DesignName::Recurrent => vec![named; options.members],
        DesignName::Paper if !options.held_out.is_empty() => vec![named],
        DesignName::Paper => vec![draw_validation(&kinds, &mut rng(options.seed, "residual/held-out/0"))],
    })
}

/// Kind of the motion: the family of its plan, or without a plan the kind found from its strokes.
fn kind(recording: &Recording) -> String {
    if let Some(family) = recording.meta().extra.get("plan.family") {
        return family.clone();
    }
    let strokes = recording.strokes();
    let rows: Vec<f64> = (0..recording.n_samples()).flat_map(|i| strokes.iter().map(move |s| s[i])).collect();
    MotionKind::of(&rows, strokes.len()).name().to_owned()
}

fn sequence(input: &Input) -> anyhow::Result<Sequence> {
    let sensitivity_of =
        |path: &Path| -> Option<PathBuf> { Some(path.parent()?.join("sensitivity").join(path.file_name()?)) };
    let path = sensitivity_of(&input.path).unwrap_or_default();
    if !path.exists() {
        return Err(BadInput::new(
            path.display().to_string(),
            "the sensitivity that hysteron identify writes next to the recording",
            "nothing",
        )
        .hint("identify the recordings of the robot first")
        .into());
    }
    let sensitivity = Recording::read(&path)?;
    let origin = |recording: &Recording| {
        let keys = ["identify.input_sha256", "identify.options"];
        let extra = keys.map(|key| recording.meta().extra.get(key).cloned());
        (recording.meta().scene_hash.clone(), extra)
    };
    if origin(&sensitivity) != origin(&input.recording) {
        let expected = format!("the strokes that were identified together with {}", input.path.display());
        return Err(BadInput::new(
            path.display().to_string(),
            expected,
            "of another scene, recording or options",
        )
        .hint("run hysteron identify again")
        .into());
    }
    Ok(Sequence::new(&input.path.display().to_string(), &input.recording, &sensitivity)?)
}

//! From a path to strokes: by a trained inverse controller, or through the robot's twin.

use std::collections::BTreeMap;
use std::path::Path;

use hysteron_base::{BadInput, Bounds, Channel, Metadata, Recording, Scene, file};
use hysteron_control::inverse::{Axes, InverseModel, TipPosition};
use hysteron_control::path::{PathSpan, is_recording};
use hysteron_control::{StrokeLimits, TargetPath};

use super::answer::{Answer, LimitOverrides, Target};
use super::finder::Finder;
use super::options::Way;
use super::twin_strokes;
use crate::shared::error::Cancelled;
use crate::shared::memory;
use crate::shared::outputs::Outputs;
use crate::shared::run::TIP_BAND;
use crate::{COMMIT, Context};

impl Way {
    /// The files that it reads.
    ///
    /// # Errors
    /// Those of reading target and scene.
    pub fn reads(&self) -> anyhow::Result<Outputs> {
        let outputs = Outputs::reading(&self.checkpoint).target(&self.target)?;
        Ok(match Finder::of(self)?.scene_and_residual() {
            Some((scene, residual)) => outputs.scene(scene, &Scene::read(scene)?).and(residual),
            None => outputs,
        })
    }

    /// Strokes for the path, and the other recorded channels.
    ///
    /// # Errors
    /// Bad input; an interruption; a path that the twin cannot follow.
    pub fn strokes(&self, overrides: &LimitOverrides, context: &Context) -> anyhow::Result<Recording> {
        let target = self.goal()?;
        self.strokes_led(&target, &target.path, overrides, context)
    }

    /// The path that the tip shall follow.
    ///
    /// # Errors
    /// Those of reading it.
    pub fn goal(&self) -> anyhow::Result<Target> {
        read_target(&self.target)
    }

    /// Strokes that lead the tip along `led`, so that it follows the path of `goal`; the recording has that one.
    ///
    /// # Errors
    /// As [`Way::strokes`].
    pub fn strokes_led(
        &self,
        goal: &Target,
        led: &[TipPosition],
        overrides: &LimitOverrides,
        context: &Context,
    ) -> anyhow::Result<Recording> {
        let target = Target { path: led.to_vec(), ..goal.clone() };
        context.listen();
        let n = target.path.len();
        let bar = context.progress("samples", n, 0);
        let mut progress = |done: usize| {
            bar.set_position(done as u64);
            !context.is_cancelled()
        };
        let finder = Finder::of(self)?;
        if let (None, Some((scene, _))) = (&self.scene, finder.scene_and_residual()) {
            tracing::info!("the twin of {} finds the strokes, as the checkpoint has it", scene.display());
        }
        let answer = match &finder {
            Finder::Twin(twin) => twin_strokes::strokes(twin, overrides, &target, &mut progress)?,
            Finder::Network(model) => by_network(self, model, overrides, &target, &mut progress)?,
        };
        bar.finish();
        let n_done = answer.limited.len().saturating_sub(answer.approach);
        if n_done < n {
            return Err(Cancelled::new(format!(" after {n_done} of {n} samples; nothing is written")).into());
        }
        let part = |flags: &[f64]| {
            let path = &flags[answer.approach..answer.approach + n];
            100.0 * path.iter().sum::<f64>() / n as f64
        };
        let n_return = n_done - n;
        tracing::info!(
            "{n} samples: {:.1} % with a stroke reduced by a limit; {:.2} s of approach before, {:.2} s of return after",
            part(&answer.limited),
            answer.approach as f64 * target.step,
            n_return as f64 * target.step,
        );
        let extrapolating = part(&answer.extrapolating);
        if extrapolating > 0.0 {
            tracing::warn!("{extrapolating:.1} % of the path is outside the training range");
        }
        recording((self, &finder), goal, answer, context)
    }
}

/// By an inverse controller.
fn by_network(
    way: &Way,
    model: &InverseModel,
    overrides: &LimitOverrides,
    target: &Target,
    progress: &mut dyn FnMut(usize) -> bool,
) -> anyhow::Result<Answer> {
    model.check_step(target.step).map_err(|bad| bad.within(&way.target))?;
    if (model.axes(), target.axes) == (Axes::Spatial, Axes::Planar) {
        let bad = BadInput::new(&way.target, "a recording with tip_z_m", "a path in the plane");
        return Err(bad.hint("the network was trained with --spatial").into());
    }
    let limits = limits(model, overrides);
    let commands = model.command(&target.path, limits, progress)?;
    let n = commands.steps.len();
    let n_tendons = commands.strokes.len() / n.max(1);
    let stroke = |k: usize| (0..n).map(|i| commands.strokes[i * n_tendons + k]).collect();
    let answer = Answer {
        approach: 0,
        strokes: (0..n_tendons).map(stroke).collect(),
        twin: None,
        limited: commands.steps.iter().map(|step| f64::from(u8::from(step.is_limited))).collect(),
        extrapolating: commands.steps.iter().map(|step| f64::from(u8::from(step.is_extrapolating))).collect(),
        tip_band: Vec::new(),
    };
    Ok(if n < target.path.len() { answer } else { answer.with_approach(limits.stroke_rate, target.step) })
}

/// Reads the path that the tip shall follow: a target, or a recording with `tip_x_m` and `tip_y_m`, and perhaps
/// `tip_z_m`, at a fixed rate.
fn read_target(named: &str) -> anyhow::Result<Target> {
    let path = Path::new(named);
    let recording =
        if is_recording(path)? { memory::recording(path)? } else { TargetPath::open(named)?.recording()? };
    let within = |bad: BadInput| bad.within(named);
    let [x, y] = ["tip_x_m", "tip_y_m"].map(|name| recording.require(name).map_err(within));
    let (x, y) = (x?, y?);
    let rate = recording
        .rate_hz()
        .ok_or_else(|| within(BadInput::new("time_s", "a fixed rate", "uneven steps").hint("resample it")))?;
    let z = recording.channel("tip_z_m");
    let axes = if z.is_some() { Axes::Spatial } else { Axes::Planar };
    let path = (0..x.len()).map(|i| [x[i], y[i], z.map_or(0.0, |z| z[i])]).collect();
    Ok(Target { time: recording.time().to_vec(), step: rate.recip(), path, axes })
}

/// Limits of the training, unless overridden.
fn limits(model: &InverseModel, overrides: &LimitOverrides) -> StrokeLimits {
    let StrokeLimits { stroke: Bounds { min, max }, stroke_rate } = model.limits;
    let [lowest, highest] = overrides.stroke;
    StrokeLimits {
        stroke: Bounds { min: lowest.unwrap_or(min), max: highest.unwrap_or(max) },
        stroke_rate: overrides.rate.unwrap_or(stroke_rate),
    }
}

fn recording(
    (way, finder): (&Way, &Finder),
    target: &Target,
    answer: Answer,
    context: &Context,
) -> anyhow::Result<Recording> {
    let n = answer.limited.len();
    let n_limited = answer.limited.iter().filter(|flag| **flag > 0.0).count();
    let strokes = answer.strokes.into_iter().enumerate();
    let mut channels: Vec<Channel> =
        strokes.map(|(k, values)| Channel::new(format!("stroke_{}_m", k + 1), values)).collect();
    // Before and after the path its goal is its first and last point.
    let (approach, last) = (answer.approach, target.path.len() - 1);
    let at = |i: usize| i.saturating_sub(approach).min(last);
    for (c, axis) in target.axes.names().iter().enumerate() {
        channels
            .push(Channel::new(format!("target_{axis}_m"), (0..n).map(|i| target.path[at(i)][c]).collect()));
    }
    let axes =
        answer.twin.into_iter().flat_map(|tip| ["twin_x_m", "twin_y_m", "twin_z_m"].into_iter().zip(tip));
    channels.extend(axes.map(|(name, values)| Channel::new(name, values)));
    channels.push(Channel::new("extrapolating", answer.extrapolating));
    channels.push(Channel::new("limited", answer.limited));
    if !answer.tip_band.is_empty() {
        channels.push(Channel::new(TIP_BAND, answer.tip_band));
    }
    let mut extra = BTreeMap::from([("limited_samples".to_owned(), n_limited.to_string())]);
    if let Some(path) = &way.checkpoint {
        extra.insert("checkpoint_sha256".to_owned(), file::sha256_of(path)?);
    }
    if let Some((scene, _)) = finder.scene_and_residual() {
        extra.insert("scene_sha256".to_owned(), Scene::read(scene)?.hash);
    }
    let span =
        PathSpan { begins: approach as f64 * target.step, ends: (approach + last) as f64 * target.step };
    span.write(&mut extra);
    let by = way.checkpoint.as_ref().or(way.scene.as_ref());
    let meta = Metadata {
        commit: COMMIT.to_owned(),
        source: by.map_or_else(String::new, |by| format!("strokes by {} for {}", by.display(), way.target)),
        command: context.command.clone(),
        extra,
        ..Metadata::default()
    };
    let start = target.time[0] - span.begins;
    let time = (0..n).map(|i| start + i as f64 * target.step).collect();
    Ok(Recording::new(time, channels, Vec::new(), meta)?)
}

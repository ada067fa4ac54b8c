//! The twin as a judge of strokes: where they and the recorded ones bring its tip, which a robot with friction and slack does
//! not show in the strokes themselves.
//!
//! Where a tendon hangs loose or a joint sticks, a stroke can be off by half a millimetre without any effect. So the twin moves
//! twice, by the strokes of a controller and by those that were recorded, and the distance of its tips counts. Errors that it
//! makes either way cancel.

use hysteron_base::{Channel, Metadata, Recording, parallel};
use hysteron_control::inverse::{Axes, Demonstration, Folds, InverseModel, TipPosition};
use hysteron_twin::Twin;
use hysteron_twin::synthetic::{RecordedStrokes, SyntheticOutcome, synthesise};

use super::options::Options;
use crate::shared::error::Cancelled;
use crate::shared::network::{Network, plant};
use crate::{Context, Progress};

/// A twin, with its residual network or without, that has followed the recorded strokes.
pub(super) struct Judge {
    twin: Twin,
    network: Option<Network>,
    /// Hash of its scene.
    pub(super) scene_hash: String,
    /// Coordinates of the tips.
    pub(super) axes: Axes,
    /// Where they brought the tip, of each demonstration (n_samples) [m]; none where it could not follow.
    recorded: Vec<FollowedStrokes>,
}

/// A demonstration, and where its strokes bring the twin.
struct FollowedStrokes {
    name: String,
    tips: Option<Vec<TipPosition>>,
}

/// Squared distances of the samples of a recording that were measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SquaredDistances {
    /// Their sum [m²].
    sum: f64,
    /// Their number.
    count: f64,
}

impl Judge {
    /// The twin of the scene that was named, after it has followed the strokes of all recordings of `folds`, which get their
    /// Jacobians by it, so that a network learns what its strokes do to the tip. None where no scene was named.
    ///
    /// # Errors
    /// A scene or a checkpoint that cannot be read, or that do not belong together; recordings of another robot.
    pub(super) fn of(
        options: &Options,
        folds: &mut Folds,
        context: &Context,
    ) -> anyhow::Result<Option<Self>> {
        let Some(path) = &options.scene else { return Ok(None) };
        let scene = options.body.scene(path)?;
        let twin = Twin::from_scene(&scene)?;
        let network =
            options.residual.as_deref().map(|path| Network::read(path, &scene, &twin)).transpose()?;
        let axes = folds.all()[0].axes;
        let mut judge = Self { twin, network, scene_hash: scene.hash, axes, recorded: Vec::new() };
        judge.recorded = judge.follow(folds.all_mut(), context)?;
        Ok(Some(judge))
    }

    fn follow(&self, all: &mut [Demonstration], context: &Context) -> anyhow::Result<Vec<FollowedStrokes>> {
        let is_new = |one: &Demonstration| one.jacobian.is_empty();
        let strokes = all.iter().map(|one| is_new(one).then(|| one.strokes.clone())).collect::<Vec<_>>();
        let found = self.moved(all, &strokes, context)?;
        let kept = all.iter_mut().zip(found).map(|(one, moved)| {
            // Synthetic data are the twin's own.
            let own = (!is_new(one)).then(|| one.tip.clone());
            let tips = moved.map(|moved| {
                one.jacobian = moved.jacobian;
                moved.tip
            });
            FollowedStrokes { name: one.name.clone(), tips: tips.or(own) }
        });
        Ok(kept.collect())
    }

    fn recorded(&self, one: &Demonstration) -> Option<&[TipPosition]> {
        self.recorded.iter().find(|followed| followed.name == one.name)?.tips.as_deref()
    }

    /// Distance of the tip that the recorded strokes bring the twin to from the one that was measured, root mean square over
    /// some demonstrations [mm]: the error of the robot where the twin leads its own tip along the path. None where it cannot follow.
    /// Its residual networks may have learned from these recordings, so that the error is at least theirs in their own validation.
    pub(super) fn own_error_mm<'a>(
        &self,
        validation: impl Iterator<Item = &'a Demonstration>,
    ) -> Option<f64> {
        let of = validation.map(|one| Some(SquaredDistances::of(one, self.recorded(one)?, &one.tip)));
        let (here, _) = SquaredDistances::root_mean_mm(&of.collect::<Option<Vec<_>>>()?);
        let residual =
            self.network.as_ref().and_then(|network| network.model().training.validation_error_mm());
        Some(residual.map_or(here, |residual| here.max(residual)))
    }

    /// Distances of the tips that a controller's strokes and the recorded ones bring the twin to, by demonstration. None where
    /// the twin cannot follow.
    ///
    /// # Errors
    /// Those of the model; an interruption.
    pub(super) fn tip_errors(
        &self,
        model: &InverseModel,
        validation: &[Demonstration],
        context: &Context,
    ) -> anyhow::Result<Vec<Option<SquaredDistances>>> {
        let command = |one: &Demonstration| -> anyhow::Result<Option<Vec<f64>>> {
            Ok(Some(model.command(&one.tip, model.limits, &mut |_| true)?.strokes))
        };
        let strokes = validation.iter().map(command).collect::<anyhow::Result<Vec<_>>>()?;
        let found = self.moved(validation, &strokes, context)?;
        let errors = found.iter().zip(validation);
        Ok(errors
            .map(|(moved, one)| Some(SquaredDistances::of(one, &moved.as_ref()?.tip, self.recorded(one)?)))
            .collect())
    }

    /// The demonstrations that the twin gives with these strokes; none where there are none, or it cannot follow.
    fn moved(
        &self,
        all: &[Demonstration],
        strokes: &[Option<Vec<f64>>],
        context: &Context,
    ) -> anyhow::Result<Vec<Option<Demonstration>>> {
        let jobs: Vec<(&Demonstration, &[f64])> =
            all.iter().zip(strokes).filter_map(|(one, strokes)| Some((one, strokes.as_deref()?))).collect();
        let bar = context.progress("samples by the twin", jobs.iter().map(|(one, _)| one.len()).sum(), 0);
        let mut found =
            parallel::try_map(&jobs, |(one, strokes)| self.rolled_out(one, strokes, &*bar, context))?
                .into_iter();
        bar.finish();
        Ok(strokes.iter().map(|strokes| strokes.as_ref().and_then(|_| found.next().flatten())).collect())
    }

    /// The demonstration that the twin gives with these strokes; none where it cannot follow them.
    fn rolled_out(
        &self,
        one: &Demonstration,
        strokes: &[f64],
        bar: &dyn Progress,
        context: &Context,
    ) -> anyhow::Result<Option<Demonstration>> {
        let n = one.n_tendons;
        let time = (0..strokes.len() / n).map(|i| i as f64 * one.step).collect();
        let series = |k: usize| strokes.iter().skip(k).step_by(n).copied().collect();
        let channels = (0..n).map(|k| Channel::new(format!("stroke_{}_m", k + 1), series(k))).collect();
        let commands = Recording::new(time, channels, Vec::new(), Metadata::default())?;
        let mut plant = plant(self.network.as_ref(), &self.twin, one.step)?;
        let mut go_on = || {
            bar.inc(1);
            !context.is_cancelled()
        };
        let mut drive = RecordedStrokes::new(&self.twin, &commands)?;
        match synthesise(&self.twin, &mut *plant, &mut drive, Metadata::default(), &mut go_on)? {
            SyntheticOutcome::Made(moved) => {
                Ok(Some(Demonstration::new(&one.name, &one.hash, &moved, one.axes)?))
            }
            SyntheticOutcome::Dropped(sample, why) => {
                tracing::warn!("{}: the twin cannot follow at sample {sample}: {why}", one.name);
                Ok(None)
            }
            SyntheticOutcome::Ended => Err(Cancelled::new(String::new()).into()),
        }
    }
}

impl SquaredDistances {
    fn of(one: &Demonstration, tips: &[TipPosition], goals: &[TipPosition]) -> Self {
        let samples = tips.iter().zip(goals).zip(&one.gap).filter(|(_, gap)| !**gap);
        let (sum, count) = samples.fold((0.0, 0.0), |(sum, count), ((tip, goal), _)| {
            let square = (0..one.axes.len()).map(|c| (tip[c] - goal[c]).powi(2)).sum::<f64>();
            (sum + square, count + 1.0)
        });
        Self { sum, count }
    }

    /// Root of the mean over all samples, and its standard error from the differences between recordings, of which one says
    /// nothing of it [mm].
    pub(super) fn root_mean_mm(all: &[Self]) -> (f64, Option<f64>) {
        let count = all.iter().map(|one| one.count).sum::<f64>().max(1.0);
        let mean = all.iter().map(|one| one.sum).sum::<f64>() / count;
        let n = all.len() as f64;
        // Of a ratio of sums: each recording's part of the sum beyond that which its length gives it.
        let off = |one: &Self| (n / count * (one.sum - mean * one.count)).powi(2);
        let variance = all.iter().map(off).sum::<f64>() / (n * (n - 1.0));
        let root = mean.sqrt();
        let standard = (all.len() > 1 && root > 0.0).then(|| 1e3 * 0.5 * variance.sqrt() / root);
        (1e3 * root, standard)
    }
}

//! Identification and rollout on the scenes of the virtual rig's robot: 4 tendons and 36 virtual ones.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use hysteron_base::{Channel, Metadata, Recording, Scene};
use hysteron_twin::coreact::{Auxiliary, AuxiliaryPolicy, Goal, Identifier, IdentifyOptions, identify};
use hysteron_twin::residual::{RecurrentOptions, ResidualModel, Rollout, Sequence, Sessions, fit_recurrent};
use hysteron_twin::{Motion, Plant, Twin, Uncorrected};

use crate::measure::percentile;
use crate::rig::{Circling, PERIOD};
use crate::scenes::N_PRIMARY;
use crate::table::{Goal as Target, Row};

/// Samples before those that are measured: the circle's attack.
const N_WARM: usize = 300;
/// Networks whose mean is rolled out, as `fit-residual` trains them.
const N_NETWORKS: usize = 3;

/// A twin, and the virtual rig's circle for it.
#[derive(Debug)]
pub struct Circle {
    twin: Twin,
    auxiliary: Auxiliary,
    motion: Motion,
}

impl Circle {
    /// With `n` samples to measure. `file` is a scene of `meshes/tpu80`.
    ///
    /// # Errors
    /// The scene or the rig's preset is bad.
    pub fn new(file: &str, n: usize) -> Result<Self> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../meshes/tpu80");
        let twin = Twin::from_scene(&Scene::read(folder.join(file))?)?;
        let auxiliary = Auxiliary::new(&twin)?;
        let motion = Motion::for_identification(&twin, &recorded(N_WARM + n)?, file)?;
        Ok(Self { twin, auxiliary, motion })
    }

    /// Samples that are identified in a second, and the median of what is left between twin and rig [m].
    ///
    /// # Errors
    /// A step fails.
    pub fn identified(&self) -> Result<(f64, f64)> {
        let mut identifier = Identifier::new(&self.twin, &self.auxiliary, IdentifyOptions::default());
        let mut left = Vec::new();
        let rate = self.rate(|k, strokes| {
            let goal = Goal { position: self.motion.tips[k], orientation: None };
            left.push(AuxiliaryPolicy::step(&mut identifier, strokes, Some(&goal), PERIOD)?.distance);
            Ok(())
        })?;
        Ok((rate, percentile(&left[N_WARM..], 0.5)))
    }

    /// Steps in a second of the twin without auxiliary tendons.
    ///
    /// # Errors
    /// A step fails.
    pub fn bare(&self) -> Result<f64> {
        let mut uncorrected = Uncorrected::new(&self.twin);
        self.rate(|_, strokes| Ok(uncorrected.step(strokes).map(drop)?))
    }

    /// Steps in a second of the twin with a network.
    ///
    /// # Errors
    /// A step fails.
    pub fn rolled_out(&self, model: &ResidualModel) -> Result<f64> {
        let mut rollout = Rollout::new(&self.twin, &self.auxiliary, model, PERIOD)?;
        self.rate(|_, strokes| Ok(Plant::step(&mut rollout, strokes).map(drop)?))
    }

    /// A network of the usual size that has seen this circle a few times.
    ///
    /// # Errors
    /// A step or the training fails.
    pub fn network(&self) -> Result<ResidualModel> {
        let mut identifier = Identifier::new(&self.twin, &self.auxiliary, IdentifyOptions::default());
        let found = identify(&self.twin, &mut identifier, &self.motion, Metadata::default(), &mut || true)?
            .context("ended")?;
        let sequence = Sequence::new("circle", &found.recording, &found.sensitivities)?;
        let held_out: Vec<Vec<usize>> = (0..N_NETWORKS).map(|k| vec![k]).collect();
        let mut options = RecurrentOptions::default();
        options.learning.epochs = 3;
        let sessions = Sessions { files: Vec::new(), progress: &|_, _| true };
        Ok(fit_recurrent(&vec![sequence; N_NETWORKS], &held_out, "benchmark", &options, &sessions)?.model)
    }

    /// Samples in a second, those before the measured ones apart.
    fn rate(&self, mut step: impl FnMut(usize, &[f64]) -> Result<()>) -> Result<f64> {
        let n = self.motion.len();
        (0..N_WARM).try_for_each(|k| step(k, self.motion.strokes_at(k)))?;
        let start = Instant::now();
        (N_WARM..n).try_for_each(|k| step(k, self.motion.strokes_at(k)))?;
        Ok((n - N_WARM) as f64 / start.elapsed().as_secs_f64())
    }
}

/// Strokes and tip of the virtual rig on its circle.
fn recorded(n: usize) -> Result<Recording> {
    let mut circling = Circling::new()?;
    let mut columns = vec![Vec::new(); N_PRIMARY + 3];
    for _ in 0..n {
        circling.cycle();
        let strokes = (0..N_PRIMARY).map(|k| circling.world.stroke(k));
        for (column, value) in columns.iter_mut().zip(strokes.chain(circling.world.tip().position)) {
            column.push(value);
        }
    }
    let names = (1..=N_PRIMARY).map(|k| format!("stroke_{k}_m"));
    let names = names.chain(["x", "y", "z"].map(|axis| format!("tip_{axis}_m")));
    let channels = names.zip(columns).map(|(name, values)| Channel::new(name, values)).collect();
    let time = (0..n).map(|k| k as f64 * PERIOD).collect();
    Ok(Recording::new(time, channels, Vec::new(), Metadata::default())?)
}

/// Speeds of identification and rollout on one core, with friction and without, `n` samples each.
///
/// # Errors
/// A step fails.
pub fn rows(repetitions: usize, n: usize) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (file, what) in
        [("scene-typical-friction.toml", "20 friction points"), ("scene-typical.toml", "no friction")]
    {
        let circle = Circle::new(file, n)?;
        let model = circle.network()?;
        let (mut identified, mut rolled_out, mut uncorrected, mut left) = (0.0f64, 0.0f64, 0.0f64, 0.0);
        for _ in 0..repetitions {
            let rate;
            (rate, left) = circle.identified()?;
            identified = identified.max(rate);
            uncorrected = uncorrected.max(circle.bare()?);
            rolled_out = rolled_out.max(circle.rolled_out(&model)?);
        }
        let alone = "the same twin without auxiliary tendons";
        let row = |name: &str, rate: f64, least: f64| {
            Row::new(format!("4 + 36 tendons, {what}: {name}"), rate, "samples/s")
                .against(uncorrected, alone)
                .goal(Target::AtLeast(least))
        };
        rows.push(row("identification", identified, 400.0));
        rows.push(row("rollout with network", rolled_out, 1000.0));
        rows.push(
            Row::new(format!("4 + 36 tendons, {what}: median left by identification"), 1e3 * left, "mm")
                .goal(Target::AtMost(0.05)),
        );
    }
    Ok(rows)
}

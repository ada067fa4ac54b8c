//! Identification and rollout on the scenes of the virtual rig's robot: 4 tendons and 36 virtual ones.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use hysteron_base::{Channel, Metadata, Recording, Scene};
use hysteron_twin::chain::Chain;
use hysteron_twin::coreact::{
    AuxiliaryLimits, AuxiliaryPolicy, Identifier, IdentifyOptions, TipMeasurement, identify,
};
use hysteron_twin::residual::{
    CorrectedRollout, RecurrentOptions, ResidualModel, Sequence, Sessions, fit_recurrent,
};
use hysteron_twin::sense::{
    ForceSensor, SenseSample, ServoLoad, TendonSensing, TensionErrors, TipForceErrors, TwinObserver,
};
use hysteron_twin::{PhysicsTwin, Plant, RobotMotion, Twin};

use crate::measure::percentile;
use crate::rig::{AMPLITUDE, Circling, PERIOD};
use crate::table::{FigureTarget as Target, TableRow};
use hysteron_studies::tendon::scenes::N_PRIMARY;

/// Scenes that are measured, and how they differ.
const SCENES: [(&str, &str); 2] =
    [("scene-typical-friction.toml", "20 friction points"), ("scene-typical.toml", "no friction")];
/// Samples before those that are measured: the circle's attack.
const N_WARM: usize = 300;
/// Networks whose mean is rolled out, as `fit-residual` trains them.
const N_NETWORKS: usize = 3;

/// Radius of the pulleys [m].
const RADIUS: f64 = 0.01;
/// Numbers as a sensor of the virtual rig `typical` has them: how long a sample takes does not depend on them.
const SENSOR: ForceSensor = ForceSensor {
    period_s: PERIOD,
    servo: Some(ServoLoad {
        stall_torque_n_m: 1.4,
        radius_m: RADIUS,
        coulomb_n_m: 0.04,
        breakaway_n_m: 0.06,
        stribeck_velocity_rad_s: 0.1,
        viscous_n_m_s_per_rad: 0.2,
    }),
    tension: TensionErrors { force_scale: 1.2, walk_sqrt_n: 0.9, model_n: 1.8, load_n: 1.0 },
    stiffness_scale: 1.9,
    tip: TipForceErrors {
        noise_m: [4e-5; 3],
        model_m: [3e-4; 3],
        offset_m: [2e-4; 3],
        length_m: 3e-3,
        walk_along_sqrt_m: 8e-3,
        walk_across_sqrt_m: 5e-3,
        creep_m_per_sqrt_s: [6e-5; 3],
        response: 0.15,
        thresholds: [7.0; 4],
    },
};

/// A twin, and the virtual rig's circle for it.
#[derive(Debug)]
pub struct Circle {
    twin: Twin,
    auxiliary: AuxiliaryLimits,
    motion: RobotMotion,
}

impl Circle {
    /// With `n` samples to measure. `file` is a scene of `meshes/tpu80`.
    ///
    /// # Errors
    /// The scene or the rig's preset is bad.
    pub fn new(file: &str, n: usize) -> Result<Self> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../meshes/tpu80");
        let twin = Twin::from_scene(&Scene::read(folder.join(file))?)?;
        let auxiliary = AuxiliaryLimits::new(&twin)?;
        let motion = RobotMotion::for_identification(&twin, &recorded(AMPLITUDE, N_WARM + n)?, file)?;
        Ok(Self { twin, auxiliary, motion })
    }

    /// The same circle for the same twin, moved by a chain of sections.
    ///
    /// # Errors
    /// A body without sections.
    pub fn reduced(&self) -> Result<Self> {
        let twin = self.twin.clone().with_chain(Chain::new(&self.twin)?);
        let auxiliary = AuxiliaryLimits::new(&twin)?;
        Ok(Self { twin, auxiliary, motion: self.motion.clone() })
    }

    /// Samples that are identified in a second, and the median of what is left between twin and rig [m].
    ///
    /// # Errors
    /// A step fails.
    pub fn identified(&self) -> Result<(f64, f64)> {
        let mut identifier = Identifier::new(&self.twin, &self.auxiliary, IdentifyOptions::default());
        let mut left = Vec::new();
        let rate = self.rate(|k, strokes| {
            let goal = TipMeasurement { position: self.motion.tips[k], orientation: None };
            left.push(AuxiliaryPolicy::step(&mut identifier, strokes, Some(&goal), PERIOD)?.distance);
            Ok(())
        })?;
        Ok((rate, percentile(&left[N_WARM..], 0.5)))
    }

    /// Steps in a second of the twin without auxiliary tendons.
    ///
    /// # Errors
    /// A step fails.
    pub fn uncorrected(&self) -> Result<f64> {
        let mut uncorrected = PhysicsTwin::new(&self.twin);
        self.rate(|_, strokes| Ok(uncorrected.step(strokes).map(drop)?))
    }

    /// Steps in a second of the twin with a network.
    ///
    /// # Errors
    /// A step fails.
    pub fn rolled_out(&self, model: &ResidualModel) -> Result<f64> {
        let mut rollout = CorrectedRollout::new(&self.twin, &self.auxiliary, model, PERIOD)?;
        self.rate(|_, strokes| Ok(Plant::step(&mut rollout, strokes).map(drop)?))
    }

    /// Times of the samples of a rollout with a network [s].
    ///
    /// # Errors
    /// A step fails.
    pub fn rollout_times(&self, model: &ResidualModel) -> Result<Vec<f64>> {
        let mut rollout = CorrectedRollout::new(&self.twin, &self.auxiliary, model, PERIOD)?;
        self.times(|k| Ok(Plant::step(&mut rollout, self.motion.strokes_at(k)).map(drop)?))
    }

    /// The same with estimates of the tensions and of the force on the tip.
    ///
    /// # Errors
    /// A step fails.
    pub fn sensing_times(&self, model: &ResidualModel) -> Result<Vec<f64>> {
        let rollout = Box::new(CorrectedRollout::new(&self.twin, &self.auxiliary, model, PERIOD)?);
        let mut observer = TwinObserver::new(&self.twin, rollout, self.motion.strokes_at(0), PERIOD)?;
        let mut sensing = TendonSensing::new(&SENSOR, self.twin.n_primary)?;
        self.times(|k| {
            let strokes = self.motion.strokes_at(k);
            let angles: Vec<f64> = strokes.iter().map(|stroke| stroke / RADIUS).collect();
            let loads = vec![0.1; strokes.len()];
            let sample = SenseSample {
                strokes,
                angles: Some(&angles),
                loads: Some(&loads),
                tip: Some(self.motion.tips[k]),
            };
            Ok(sensing.sense(&mut observer, &sample).map(drop)?)
        })
    }

    /// Time of each sample [s], those before the measured ones apart.
    fn times(&self, mut step: impl FnMut(usize) -> Result<()>) -> Result<Vec<f64>> {
        (0..N_WARM).try_for_each(&mut step)?;
        let timed = |k: usize| {
            let start = Instant::now();
            step(k)?;
            Ok(start.elapsed().as_secs_f64())
        };
        (N_WARM..self.motion.len()).map(timed).collect()
    }

    /// A network of the usual size that has been trained on this circle for a few epochs.
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
        Ok(fit_recurrent(&vec![sequence; N_NETWORKS], (&held_out, 0), "benchmark", &options, &sessions)?
            .model)
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

/// Speeds of identification and rollout by chains of sections on one core, beside their finite elements in the same turns.
///
/// # Errors
/// A step fails.
pub fn rows_of_chains(repetitions: usize, n: usize) -> Result<Vec<TableRow>> {
    let mut rows = Vec::new();
    for (file, what) in SCENES {
        let mesh = Circle::new(file, n)?;
        let chain = mesh.reduced()?;
        let model = chain.network()?;
        let (mut identified, mut rolled_out, mut left) = ([0.0f64; 2], [0.0f64; 2], 0.0);
        for _ in 0..repetitions {
            for (k, circle) in [&mesh, &chain].into_iter().enumerate() {
                let rate;
                (rate, left) = circle.identified()?;
                identified[k] = identified[k].max(rate);
                rolled_out[k] = rolled_out[k].max(circle.rolled_out(&model)?);
            }
        }
        for (name, [of_mesh, of_chain]) in
            [("identification", identified), ("rollout with network", rolled_out)]
        {
            rows.push(
                TableRow::new(format!("chain, 4 + 36 tendons, {what}: {name}"), of_chain, "samples/s")
                    .against(of_mesh, "the finite elements, in between")
                    .goal(Target::AtLeast(4000.0)),
            );
        }
        rows.push(
            TableRow::new(
                format!("chain, 4 + 36 tendons, {what}: median left by identification"),
                1e3 * left,
                "mm",
            )
            .goal(Target::AtMost(0.05)),
        );
    }
    Ok(rows)
}

/// Strokes and tip of the virtual rig on its circle, with strokes of this amplitude [m].
///
/// # Errors
/// The rig's preset is bad.
pub fn recorded(amplitude: f64, n: usize) -> Result<Recording> {
    let mut circling = Circling::new()?;
    circling.amplitude = amplitude;
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
pub fn rows(repetitions: usize, n: usize) -> Result<Vec<TableRow>> {
    let mut rows = Vec::new();
    for (file, what) in SCENES {
        let circle = Circle::new(file, n)?;
        let model = circle.network()?;
        let (mut identified, mut rolled_out, mut uncorrected, mut left) = (0.0f64, 0.0f64, 0.0f64, 0.0);
        let (mut rollout_times, mut sensing_times) = (Vec::new(), Vec::new());
        for _ in 0..repetitions {
            let rate;
            (rate, left) = circle.identified()?;
            identified = identified.max(rate);
            uncorrected = uncorrected.max(circle.uncorrected()?);
            rolled_out = rolled_out.max(circle.rolled_out(&model)?);
            rollout_times.extend(circle.rollout_times(&model)?);
            sensing_times.extend(circle.sensing_times(&model)?);
        }
        let alone = "the same twin without auxiliary tendons";
        let row = |name: &str, rate: f64, least: f64| {
            TableRow::new(format!("4 + 36 tendons, {what}: {name}"), rate, "samples/s")
                .against(uncorrected, alone)
                .goal(Target::AtLeast(least))
        };
        rows.push(row("identification", identified, 400.0));
        rows.push(row("rollout with network", rolled_out, 1000.0));
        let [sensing, rollout] = [&sensing_times, &rollout_times].map(|times| 1e3 * percentile(times, 0.99));
        let name = format!("4 + 36 tendons, {what}: tensions and tip force estimated, 99 % of samples");
        rows.push(
            TableRow::new(name, sensing, "ms")
                .against(rollout, "the rollout alone")
                .goal(Target::AtMost(1e3 * PERIOD)),
        );
        rows.push(
            TableRow::new(format!("4 + 36 tendons, {what}: median left by identification"), 1e3 * left, "mm")
                .goal(Target::AtMost(0.05)),
        );
    }
    Ok(rows)
}

//! Synthetic data (CoReAct paper, section IV-C a): what a twin does on strokes that its robot was never given.
//!
//! A rollout counts as a whole or not at all: one that has no equilibrium, that needs a tendon at its largest
//! tension, or whose tip jumps where its strokes do not, is no data.

use hysteron_base::{BadInput, Channel, Metadata, Recording};
use nalgebra::Vector3;

use crate::friction_points::FrictionPoints;
use crate::model::Twin;
use crate::plant::{Plant, PlantStep, relax_to_equilibrium};
use crate::{Error, Result, TwinState};

/// Samples between two Jacobians, which change slowly with the shape; each holds until the next.
const JACOBIAN_EVERY: usize = 10;
/// Largest move of the tip in a sample: factor on its Jacobian's [-], plus a part of the robot's length [-].
const JUMP: [f64; 2] = [4.0, 0.01];

/// Channel of the flag for samples in which a chain was bent further than it was validated.
pub const OUTSIDE_VALIDATION: &str = "outside_validation";

/// Why a rollout is no data.
#[derive(Debug, Clone, PartialEq)]
pub enum Unphysical {
    /// There is no equilibrium.
    NoEquilibrium,
    /// A tendon has reached its largest tension, and its stroke is not held; its name.
    Overloaded(String),
    /// The tip moved by this much in a sample [m], far more than the strokes ask for.
    Jump(f64),
}

impl std::fmt::Display for Unphysical {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoEquilibrium => write!(f, "no equilibrium"),
            Self::Overloaded(tendon) => write!(f, "tendon {tendon} at its largest tension"),
            Self::Jump(by) => write!(f, "a jump of {:.2} mm", 1e3 * by),
        }
    }
}

/// Outcome of a rollout.
#[derive(Debug, Clone)]
pub enum SyntheticOutcome {
    /// Strokes as they came, the tip `tip_x_m`.., tensions `tension_k_n`, ∂tip/∂stroke `tip_x_per_stroke_k_ratio`.. [-]
    /// (see [`crate::Stepper::tip_response`]), `extrapolating`, 1 where a network left its training range, and of a chain
    /// `outside_validation`, 1 where it was bent further than it was validated.
    Made(Recording),
    /// No data, from this sample on.
    Dropped(usize, Unphysical),
    /// Ended by `on_sample`.
    Ended,
}

/// The strokes of a trajectory, sample by sample.
pub trait StrokeSource {
    /// Time of sample `i` [s].
    fn time(&self, i: usize) -> f64;

    /// Strokes (n_primary) [m] of sample `i`, of a robot whose tip the last one has led to `tip` [m]; none before
    /// the first, under whose strokes the robot rests. False where the trajectory has ended.
    fn strokes(&mut self, i: usize, tip: Option<[f64; 3]>, strokes: &mut [f64]) -> bool;
}

/// Strokes that are known beforehand.
pub struct RecordedStrokes<'a> {
    time: &'a [f64],
    strokes: Vec<&'a [f64]>,
}

impl<'a> RecordedStrokes<'a> {
    /// Those of `commands`.
    ///
    /// # Errors
    /// Commands of another robot.
    pub fn new(twin: &Twin, commands: &'a Recording) -> Result<Self> {
        let strokes = commands.strokes();
        if strokes.len() != twin.n_primary {
            let expected = format!("{}, one per tendon of the scene", twin.n_primary);
            return Err(BadInput::new("stroke columns", expected, strokes.len().to_string()).into());
        }
        Ok(Self { time: commands.time(), strokes })
    }
}

impl StrokeSource for RecordedStrokes<'_> {
    fn time(&self, i: usize) -> f64 {
        self.time[i]
    }

    fn strokes(&mut self, i: usize, _: Option<[f64; 3]>, strokes: &mut [f64]) -> bool {
        if i < self.time.len() {
            strokes.iter_mut().zip(&self.strokes).for_each(|(now, series)| *now = series[i]);
        }
        i < self.time.len()
    }
}

/// Lets `plant`, a simulation with `twin` that has just been made, go where `drive` leads it from where it rests
/// under the first strokes. `on_sample` is called after each sample and ends the run where it returns false.
///
/// # Errors
/// A drive without samples; those of [`Plant::step`] but for a missing equilibrium.
pub fn synthesise(
    twin: &Twin,
    plant: &mut dyn Plant,
    drive: &mut dyn StrokeSource,
    meta: Metadata,
    on_sample: &mut dyn FnMut() -> bool,
) -> Result<SyntheticOutcome> {
    let length = twin.cables.longest();
    let mut columns = RolloutColumns::new(twin.n_primary);
    let mut jacobian = [(); 3].map(|()| vec![0.0; twin.n_primary]);
    let mut now = vec![0.0; twin.n_primary];
    if !drive.strokes(0, None, &mut now) {
        return Err(BadInput::new("a trajectory", "at least one sample", "none").into());
    }
    let rest = match relax_to_equilibrium(twin, plant, &now) {
        Ok(rest) => rest,
        Err(Error::NoEquilibrium { .. }) => {
            return Ok(SyntheticOutcome::Dropped(0, Unphysical::NoEquilibrium));
        }
        Err(other) => return Err(other),
    };
    let mut before = (now.clone(), rest.tip);
    for i in 0.. {
        let step = match plant.step(&now) {
            Ok(step) => step,
            Err(Error::NoEquilibrium { .. }) => {
                return Ok(SyntheticOutcome::Dropped(i, Unphysical::NoEquilibrium));
            }
            Err(other) => return Err(other),
        };
        if i % JACOBIAN_EVERY == 0 {
            jacobian = plant
                .tip_response(FrictionPoints::AsTheyAre)
                .map_or(jacobian, |response| response.per_stroke);
        }
        let jumps =
            |jacobian: &[Vec<f64>; 3]| jump((&before.0, &now), (before.1, step.tip), jacobian, length);
        // A Jacobian from before the tendons slid gives their strokes no effect.
        if jumps(&jacobian).is_some() {
            jacobian = plant
                .tip_response(FrictionPoints::AsTheyAre)
                .map_or(jacobian, |response| response.per_stroke);
        }
        if let Some(why) = overloaded(twin, plant.state()).or_else(|| jumps(&jacobian)) {
            return Ok(SyntheticOutcome::Dropped(i, why));
        }
        columns.push(drive.time(i), &now, plant.state(), &jacobian, &step);
        before.0.copy_from_slice(&now);
        before.1 = step.tip;
        if !on_sample() {
            return Ok(SyntheticOutcome::Ended);
        }
        if !drive.strokes(i + 1, Some(step.tip), &mut now) {
            break;
        }
    }
    let (time, mut channels) = columns.into_series();
    channels.retain(|channel| twin.chain.is_some() || channel.name != OUTSIDE_VALIDATION);
    Ok(SyntheticOutcome::Made(Recording::new(time, channels, Vec::new(), meta)?))
}

fn overloaded(twin: &Twin, state: &TwinState) -> Option<Unphysical> {
    let primary = &twin.tendons[..twin.n_primary];
    let found = primary.iter().zip(&state.tensions).find(|(tendon, held)| **held >= tendon.tension.max);
    found.map(|(tendon, _)| Unphysical::Overloaded(tendon.name.clone()))
}

fn jump(
    strokes: (&[f64], &[f64]),
    tips: ([f64; 3], [f64; 3]),
    jacobian: &[Vec<f64>; 3],
    length: f64,
) -> Option<Unphysical> {
    let moved = (Vector3::from(tips.1) - Vector3::from(tips.0)).norm();
    let pulled = strokes.0.iter().zip(strokes.1).enumerate();
    let asked: f64 = pulled
        .map(|(k, (from, to))| (to - from).abs() * Vector3::from_fn(|c, _| jacobian[c][k]).norm())
        .sum();
    (moved > JUMP[0] * asked + JUMP[1] * length).then_some(Unphysical::Jump(moved))
}

/// Columns of a rollout's recording.
struct RolloutColumns {
    time: Vec<f64>,
    strokes: Vec<Vec<f64>>,
    tip: [Vec<f64>; 3],
    tensions: Vec<Vec<f64>>,
    /// By axis, then by tendon.
    jacobian: [Vec<Vec<f64>>; 3],
    extrapolating: Vec<f64>,
    outside_validation: Vec<f64>,
}

impl RolloutColumns {
    fn new(n_tendons: usize) -> Self {
        let of_tendons = || vec![Vec::new(); n_tendons];
        Self {
            time: Vec::new(),
            strokes: of_tendons(),
            tip: [(); 3].map(|()| Vec::new()),
            tensions: of_tendons(),
            jacobian: [(); 3].map(|()| of_tendons()),
            extrapolating: Vec::new(),
            outside_validation: Vec::new(),
        }
    }

    fn push(
        &mut self,
        time: f64,
        strokes: &[f64],
        state: &TwinState,
        jacobian: &[Vec<f64>; 3],
        step: &PlantStep,
    ) {
        let push = |columns: &mut [Vec<f64>], row: &[f64]| {
            columns.iter_mut().zip(row).for_each(|(column, value)| column.push(*value));
        };
        self.time.push(time);
        push(&mut self.strokes, strokes);
        push(&mut self.tip, &step.tip);
        push(&mut self.tensions, &state.tensions);
        self.jacobian.iter_mut().zip(jacobian).for_each(|(columns, row)| push(columns, row));
        self.extrapolating.push(f64::from(u8::from(step.is_extrapolating)));
        self.outside_validation.push(f64::from(u8::from(step.report.outside > 0.0)));
    }

    /// Times and channels.
    fn into_series(self) -> (Vec<f64>, Vec<Channel>) {
        const AXES: [&str; 3] = ["x", "y", "z"];
        let mut channels = Vec::new();
        let mut of_tendons = |columns: Vec<Vec<f64>>, name: &dyn Fn(usize) -> String| {
            let columns = columns.into_iter().enumerate();
            channels.extend(columns.map(|(k, values)| Channel::new(name(k + 1), values)));
        };
        of_tendons(self.strokes, &|k| format!("stroke_{k}_m"));
        of_tendons(self.tip.into(), &|k| format!("tip_{}_m", AXES[k - 1]));
        of_tendons(self.tensions, &|k| format!("tension_{k}_n"));
        for (axis, columns) in AXES.iter().zip(self.jacobian) {
            of_tendons(columns, &|k| format!("tip_{axis}_per_stroke_{k}_ratio"));
        }
        channels.push(Channel::new("extrapolating", self.extrapolating));
        channels.push(Channel::new(OUTSIDE_VALIDATION, self.outside_validation));
        (self.time, channels)
    }
}

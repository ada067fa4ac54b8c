//! Synthetic data (CoReAct paper, section IV-C a): what a twin does on strokes that its robot was never given.
//!
//! A rollout counts as a whole or not at all: one that has no equilibrium, that needs a tendon at its largest tension, or
//! whose tip jumps where its strokes do not, is no data.

use hysteron_base::{BadInput, Channel, Metadata, Recording};
use nalgebra::Vector3;

use crate::model::Twin;
use crate::plant::{Plant, settle};
use crate::{Error, Result, TwinState};

/// Samples between two Jacobians, which change with the shape, slowly; each stands until the next.
const JACOBIAN_EVERY: usize = 10;
/// How much farther a tip may go in a sample than its Jacobian says [-], and how far besides, over the robot's length.
const JUMP: [f64; 2] = [4.0, 0.01];

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

/// What became of a rollout.
#[derive(Debug, Clone)]
pub enum Outcome {
    /// Strokes as they came, the tip `tip_x_m`.., tensions `tension_k_n`, ∂tip/∂stroke `tip_x_per_stroke_k_ratio`.. [-]
    /// (see [`crate::Stepper::tip_per_stroke`]), and `extrapolating`, 1 where a network left its training range.
    Made(Recording),
    /// No data, from this sample on.
    Dropped(usize, Unphysical),
    /// Ended by `on_sample`.
    Ended,
}

/// Lets `plant`, a simulation with `twin` that has just been made, follow the strokes of `commands` from where it rests under the
/// first of them. `on_sample` is called after each sample and ends the run where it returns false.
///
/// # Errors
/// Commands of another robot; those of [`Plant::step`] but for a missing equilibrium.
pub fn synthesise(
    twin: &Twin,
    plant: &mut dyn Plant,
    commands: &Recording,
    meta: Metadata,
    on_sample: &mut dyn FnMut() -> bool,
) -> Result<Outcome> {
    let strokes = commands.strokes();
    if strokes.len() != twin.n_primary {
        let expected = format!("{}, one per tendon of the scene", twin.n_primary);
        return Err(BadInput::new("stroke columns", expected, strokes.len().to_string()).into());
    }
    let length = twin.cables.longest();
    let mut columns = Columns::new(twin.n_primary, commands.n_samples());
    let mut jacobian = [(); 3].map(|()| vec![0.0; twin.n_primary]);
    let mut now: Vec<f64> = strokes.iter().map(|series| series[0]).collect();
    let rest = match settle(twin, plant, &now) {
        Ok(rest) => rest,
        Err(Error::NoEquilibrium { .. }) => return Ok(Outcome::Dropped(0, Unphysical::NoEquilibrium)),
        Err(other) => return Err(other),
    };
    let mut before = (now.clone(), rest.tip);
    for i in 0..commands.n_samples() {
        now.iter_mut().zip(&strokes).for_each(|(now, series)| *now = series[i]);
        let step = match plant.step(&now) {
            Ok(step) => step,
            Err(Error::NoEquilibrium { .. }) => return Ok(Outcome::Dropped(i, Unphysical::NoEquilibrium)),
            Err(other) => return Err(other),
        };
        if i % JACOBIAN_EVERY == 0 {
            jacobian = plant.tip_per_stroke().unwrap_or(jacobian);
        }
        if let Some(why) = overloaded(twin, plant.state())
            .or_else(|| jump((&before.0, &now), (before.1, step.tip), &jacobian, length))
        {
            return Ok(Outcome::Dropped(i, why));
        }
        columns.push(step.tip, &plant.state().tensions, &jacobian, step.is_extrapolating);
        before.0.copy_from_slice(&now);
        before.1 = step.tip;
        if !on_sample() {
            return Ok(Outcome::Ended);
        }
    }
    let strokes = strokes.iter().enumerate();
    let mut channels: Vec<Channel> =
        strokes.map(|(k, series)| Channel::new(format!("stroke_{}_m", k + 1), series.to_vec())).collect();
    channels.extend(columns.into_channels());
    Ok(Outcome::Made(Recording::new(commands.time().to_vec(), channels, Vec::new(), meta)?))
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

/// What a rollout writes beside its strokes.
struct Columns {
    tip: [Vec<f64>; 3],
    tensions: Vec<Vec<f64>>,
    /// By axis, then by tendon.
    jacobian: [Vec<Vec<f64>>; 3],
    extrapolating: Vec<f64>,
}

impl Columns {
    fn new(n_tendons: usize, n: usize) -> Self {
        let series = || Vec::with_capacity(n);
        let of_tendons = || (0..n_tendons).map(|_| series()).collect::<Vec<_>>();
        Self {
            tip: [series(), series(), series()],
            tensions: of_tendons(),
            jacobian: [of_tendons(), of_tendons(), of_tendons()],
            extrapolating: series(),
        }
    }

    fn push(&mut self, tip: [f64; 3], tensions: &[f64], jacobian: &[Vec<f64>; 3], is_extrapolating: bool) {
        for (column, value) in self.tip.iter_mut().zip(tip) {
            column.push(value);
        }
        for (column, value) in self.tensions.iter_mut().zip(tensions) {
            column.push(*value);
        }
        for (columns, row) in self.jacobian.iter_mut().zip(jacobian) {
            columns.iter_mut().zip(row).for_each(|(column, value)| column.push(*value));
        }
        self.extrapolating.push(f64::from(u8::from(is_extrapolating)));
    }

    fn into_channels(self) -> Vec<Channel> {
        const AXES: [&str; 3] = ["x", "y", "z"];
        let mut channels = Vec::new();
        let tip = AXES.iter().zip(self.tip);
        channels.extend(tip.map(|(axis, values)| Channel::new(format!("tip_{axis}_m"), values)));
        let tensions = self.tensions.into_iter().enumerate();
        channels.extend(tensions.map(|(k, values)| Channel::new(format!("tension_{}_n", k + 1), values)));
        for (axis, columns) in AXES.iter().zip(self.jacobian) {
            let columns = columns.into_iter().enumerate();
            channels.extend(
                columns.map(|(k, values)| {
                    Channel::new(format!("tip_{axis}_per_stroke_{}_ratio", k + 1), values)
                }),
            );
        }
        channels.push(Channel::new("extrapolating", self.extrapolating));
        channels
    }
}

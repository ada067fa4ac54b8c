//! Strokes for a path through the twin, with its residual network or without.

use std::path::{Path, PathBuf};

use hysteron_base::Scene;
use hysteron_control::StrokeLimits;
use hysteron_control::plan::TendonMapping;
use hysteron_twin::Twin;
use hysteron_twin::residual::{FollowLimits, FollowStep, PathFollower};

use super::answer::{Answer, LimitOverrides, Target};
use crate::shared::network::{Network, plant};
use crate::shared::plan::angles_of;

/// Largest stroke, where none is given [m], and fastest change [m/s].
const LIMITS: [f64; 2] = [16e-3, 12e-3];

/// Distance from the path's first point at which the approach ends [m]: a tenth of what a good robot misses.
const NEAR: f64 = 1e-4;
/// The approach ends too where a second brings the tip no nearer than this [m].
const MIN_PROGRESS: f64 = 1e-5;
const PATIENCE_S: f64 = 1.0;

/// Which twin is steered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Twins {
    /// That of the scene.
    OfScene,
    /// The same without what is fitted to a robot.
    Nominal,
}

impl Twins {
    /// The scene of the twin.
    fn scene(self, path: &Path) -> anyhow::Result<Scene> {
        let mut scene = Scene::read(path)?;
        if self == Self::Nominal {
            scene.friction = None;
            for tendon in &mut scene.tendons {
                (tendon.zero, tendon.compliance) = (0.0, 0.0);
            }
        }
        Ok(scene)
    }
}

/// A twin to steer.
#[derive(Debug, Clone)]
pub(super) struct SteeredTwin {
    /// Its scene.
    pub scene: PathBuf,
    /// With or without what is fitted to a robot.
    pub twins: Twins,
    /// Its residual network.
    pub residual: Option<PathBuf>,
    /// Limits of the strokes, where a training had some.
    pub limits: Option<StrokeLimits>,
}

/// Steers the twin to where the path begins, along the path and back to no strokes. `progress` ends it where it returns false.
pub(super) fn strokes(
    steered: &SteeredTwin,
    overrides: &LimitOverrides,
    target: &Target,
    progress: &mut dyn FnMut(usize) -> bool,
) -> anyhow::Result<Answer> {
    let scene = steered.twins.scene(&steered.scene)?;
    let twin = Twin::from_scene(&scene)?;
    let network = steered.residual.as_deref().map(|path| Network::read(path, &scene, &twin)).transpose()?;
    let tendons = TendonMapping { angles: angles_of(&scene), release: 1.0, co_contraction: 0.0 };
    let coordinates = |point: [f64; 2], strokes: &mut [f64]| tendons.strokes_into(point, strokes);
    let [stroke, rate] = steered.limits.map_or(LIMITS, |limits| [limits.stroke.max, limits.stroke_rate]);
    let limits =
        FollowLimits { stroke: overrides.stroke[1].unwrap_or(stroke), rate: overrides.rate.unwrap_or(rate) };
    let plant = plant(network.as_ref(), &twin, target.step)?;
    let mut follower = PathFollower::new(&twin, plant, &coordinates, limits, target.step)?;
    let mut answer = Answer {
        approach: 0,
        strokes: vec![Vec::new(); twin.n_primary],
        twin: Some(Default::default()),
        limited: Vec::new(),
        extrapolating: Vec::new(),
        tip_band: Vec::new(),
    };
    answer.approach = approach(&mut follower, twin.tip_of(&twin.rest()), target, &mut answer)?;
    let mut square = 0.0;
    for (i, goal) in target.path.iter().enumerate() {
        let step = follower.step([goal[0], goal[1]])?;
        square += (step.tip[0] - goal[0]).powi(2) + (step.tip[1] - goal[1]).powi(2);
        answer.push(&follower, &step);
        if !progress(i + 1) {
            return Ok(answer);
        }
    }
    tracing::info!(
        "the twin's tip stays within {:.3} mm (rms) of the path",
        1e3 * (square / target.path.len() as f64).sqrt()
    );
    while !follower.is_home() {
        let step = follower.step_home()?;
        answer.push(&follower, &step);
    }
    Ok(answer)
}

/// Steers the tip from `rest` [m] to the first point of the path, until it is there or comes no nearer; gives the samples that it took.
fn approach(
    follower: &mut PathFollower,
    rest: [f64; 3],
    target: &Target,
    answer: &mut Answer,
) -> anyhow::Result<usize> {
    let [x, y, _] = target.path[0];
    let distance = |tip: [f64; 3]| (tip[0] - x).hypot(tip[1] - y);
    let patience = (PATIENCE_S / target.step).ceil().max(1.0) as usize;
    let (mut nearest, mut since, mut n) = (distance(rest), 0, 0);
    while nearest > NEAR && since < patience {
        let step = follower.step([x, y])?;
        answer.push(follower, &step);
        let now = distance(step.tip);
        if now < nearest - MIN_PROGRESS {
            (nearest, since) = (now, 0);
        } else {
            since += 1;
        }
        n += 1;
    }
    Ok(n)
}

impl Answer {
    fn push(&mut self, follower: &PathFollower, step: &FollowStep) {
        self.strokes.iter_mut().zip(follower.strokes()).for_each(|(column, stroke)| column.push(*stroke));
        for (column, value) in self.twin.iter_mut().flatten().zip(step.tip) {
            column.push(value);
        }
        self.limited.push(f64::from(u8::from(step.is_limited)));
        self.extrapolating.push(f64::from(u8::from(step.is_extrapolating)));
        self.tip_band.extend(step.tip_band);
    }
}

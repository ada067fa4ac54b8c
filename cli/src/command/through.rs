//! Strokes for a path through the twin, with its residual network or without.

use std::f64::consts::TAU;
use std::path::Path;

use hysteron_base::Scene;
use hysteron_control::plan::Tendons;
use hysteron_twin::coreact::Auxiliary;
use hysteron_twin::residual::{FollowLimits, FollowStep, Follower, ResidualModel, Rollout};
use hysteron_twin::{Bare, Plant, Twin};

use super::{Answer, Arguments, Target};

/// Largest stroke, where none is given [mm], and fastest change [mm/s].
const LIMITS: [f64; 2] = [16.0, 12.0];

/// Steers the twin along the path and back to no strokes. `progress` ends it where it returns false.
pub fn strokes(
    scene: &Path,
    arguments: &Arguments,
    target: &Target,
    progress: &mut dyn FnMut(usize) -> bool,
) -> anyhow::Result<Answer> {
    let scene = Scene::read(scene)?;
    let twin = Twin::from_scene(&scene)?;
    let model = arguments.checkpoint.as_deref().map(ResidualModel::read).transpose()?;
    let auxiliary = model.as_ref().map(|_| Auxiliary::new(&twin)).transpose()?;
    let plant: Box<dyn Plant> = match model.as_ref().zip(auxiliary.as_ref()) {
        Some((model, auxiliary)) => {
            if model.scene_hash != scene.hash {
                tracing::warn!("the network was trained with another scene than {}", scene.name);
            }
            Box::new(Rollout::new(&twin, auxiliary, model, target.step)?)
        }
        None => Box::new(Bare::new(&twin)),
    };
    let tendons = Tendons { angles: angles(&scene), release: 1.0, co_contraction: 0.0 };
    let coordinates = |point: [f64; 2], strokes: &mut [f64]| {
        for (k, stroke) in strokes.iter_mut().enumerate() {
            *stroke = tendons.stroke(k, point);
        }
    };
    let limits = FollowLimits {
        stroke: 1e-3 * arguments.stroke_max_mm.unwrap_or(LIMITS[0]),
        rate: 1e-3 * arguments.stroke_rate_max_mm_s.unwrap_or(LIMITS[1]),
    };
    let mut follower = Follower::new(&twin, plant, &coordinates, limits, target.step)?;
    let mut answer = Answer {
        strokes: vec![Vec::new(); twin.n_primary],
        twin: Some(Default::default()),
        limited: Vec::new(),
        extrapolating: Vec::new(),
    };
    let mut square = 0.0;
    for (i, goal) in target.path.iter().enumerate() {
        let step = follower.step(*goal)?;
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

impl Answer {
    fn push(&mut self, follower: &Follower, step: &FollowStep) {
        self.strokes.iter_mut().zip(follower.strokes()).for_each(|(column, stroke)| column.push(*stroke));
        for (column, value) in self.twin.iter_mut().flatten().zip(step.tip) {
            column.push(value);
        }
        self.limited.push(f64::from(u8::from(step.is_limited)));
        self.extrapolating.push(f64::from(u8::from(step.is_extrapolating)));
    }
}

/// Where about the body the tendons run [rad], at their beginning.
fn angles(scene: &Scene) -> Vec<f64> {
    let angle = |point: [f64; 3]| point[1].atan2(point[0]).rem_euclid(TAU);
    scene.tendons.iter().map(|tendon| angle(tendon.points[0])).collect()
}

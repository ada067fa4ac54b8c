//! Strokes of a trajectory: its own, or for a way of the tip those that bring the twin's tip along it.

use hysteron_base::{Channel, Recording};
use hysteron_control::plan::Space;
use hysteron_control::{Limits, Trajectory};
use hysteron_twin::residual::{FollowLimits, Follower};
use hysteron_twin::synthetic::{Outcome, Unphysical};
use hysteron_twin::{Error, Plant, Twin};

/// The strokes, or why there are none. `plant`, a simulation with `twin` that has just been made, is steered where that is needed;
/// `on_sample` is then called after each sample and ends it where it returns false.
pub fn strokes<'a>(
    twin: &'a Twin,
    plant: Box<dyn Plant + 'a>,
    trajectory: &Trajectory,
    limits: Limits,
    on_sample: &mut dyn FnMut() -> bool,
) -> anyhow::Result<Result<Recording, Outcome>> {
    if trajectory.space == Space::Tendons {
        return Ok(Ok(trajectory.commands()?));
    }
    let coordinates = |point: [f64; 2], strokes: &mut [f64]| trajectory.tendons.strokes_into(point, strokes);
    let (step, limits) =
        (trajectory.rate_hz.recip(), FollowLimits { stroke: limits.stroke.max, rate: limits.stroke_rate });
    let no_equilibrium = |sample: usize| Outcome::Dropped(sample, Unphysical::NoEquilibrium);
    let mut follower = match Follower::new(twin, plant, &coordinates, limits, step) {
        Ok(follower) => follower,
        Err(Error::NoEquilibrium { .. }) => return Ok(Err(no_equilibrium(0))),
        Err(other) => return Err(other.into()),
    };
    let mut columns = vec![Vec::new(); twin.n_primary];
    let n = trajectory.n_samples();
    for i in 0.. {
        let found = match i < n {
            true => follower.step(trajectory.position_at(trajectory.time(i))),
            false => follower.step_home(),
        };
        match found {
            Ok(_) => {}
            Err(Error::NoEquilibrium { .. }) => return Ok(Err(no_equilibrium(i))),
            Err(other) => return Err(other.into()),
        }
        columns.iter_mut().zip(follower.strokes()).for_each(|(column, stroke)| column.push(*stroke));
        if i < n && !on_sample() {
            return Ok(Err(Outcome::Ended));
        }
        if i + 1 >= n && follower.is_home() {
            break;
        }
    }
    let time = (0..columns[0].len()).map(|i| trajectory.time(i)).collect();
    let channels = columns.into_iter().enumerate();
    let channels = channels.map(|(k, values)| Channel::new(format!("stroke_{}_m", k + 1), values)).collect();
    Ok(Ok(Recording::new(time, channels, Vec::new(), trajectory.metadata())?))
}

//! Trajectories drawn from ranges: many of a kind, from one entry of the plan file.
//!
//! The range of the amplitude is cut into as many parts as there are trajectories, and each draws its own from one
//! part:
//! with any seed, small and large ones are there. Everything else is drawn evenly.

use super::Direction;
use super::schema::{Draw, FamilyName, TrajectoryTable};
use hysteron_base::schema::{FixedArray, count};
use hysteron_base::{BadInput, rng};
use rand::RngExt;

/// How many trajectories the `index`-th draw of a plan has, at most `most`; its ranges are accepted with it.
pub(super) fn check_draw(index: usize, draw: &Draw, most: i64) -> Result<usize, BadInput> {
    let key = |key: &str| format!("draw[{}].{key}", index + 1);
    let n = count(&key("count"), draw.count, most)?;
    let ranges = [
        ("amplitude_mm", Some(draw.amplitude_mm)),
        ("period_s", Some(draw.period_s)),
        ("aspect", draw.aspect),
        ("swings", draw.swings),
    ];
    for (name, range) in ranges {
        if let Some(FixedArray([min, max])) = range {
            // False for NaN too.
            let is_range = min > 0.0 && min <= max && max.is_finite();
            if !is_range {
                let found = format!("[{min:?}, {max:?}]");
                return Err(BadInput::new(key(name), "[smallest, largest], both above 0", found));
            }
        }
    }
    match (draw.orientation_deg, draw.family) {
        (Some(range), FamilyName::Circle) => {
            let found = format!("{:?}", range.0);
            return Err(BadInput::new(key("orientation_deg"), "no such key for a circle", found));
        }
        (Some(FixedArray([min, max])), _) if !(min <= max && min.is_finite() && max.is_finite()) => {
            let found = format!("[{min:?}, {max:?}]");
            return Err(BadInput::new(key("orientation_deg"), "[smallest, largest]", found));
        }
        _ => {}
    }
    Ok(n)
}

/// The `k`-th of the `n` trajectories of a draw, called NAME-1, NAME-2, …. Each has a random stream of its own, by its name.
pub(super) fn one(draw: &Draw, seed: u64, k: usize, n: usize) -> TrajectoryTable {
    let name = format!("{}-{}", draw.name, k + 1);
    let mut stream = rng(seed, &format!("plan/draw/{name}"));
    let mut part = || stream.random_range(0.0..1.0);
    let within = |FixedArray([min, max]): FixedArray<f64, 2>, part: f64| min + part * (max - min);
    let amplitude_mm = within(draw.amplitude_mm, (k as f64 + part()) / n as f64);
    let period_s = within(draw.period_s, part());
    let aspect = draw.aspect.map(|range| within(range, part()));
    let phase_deg = 360.0 * part();
    let orientation_deg = within(draw.orientation_deg.unwrap_or(FixedArray([0.0, 360.0])), part());
    let is_clockwise = part() < 0.5;
    let swings = draw.swings.map(|range| within(range, part()));
    let has_direction = draw.family != FamilyName::Sinusoid;
    let direction = if is_clockwise { Direction::Clockwise } else { Direction::CounterClockwise };
    TrajectoryTable {
        name,
        role: draw.role,
        family: draw.family,
        amplitude_mm,
        frequency_hz: None,
        period_s: Some(period_s),
        phase_deg: Some(phase_deg),
        orientation_deg: (draw.family != FamilyName::Circle).then_some(orientation_deg),
        aspect,
        swings,
        direction: has_direction.then_some(direction),
        attack_s: draw.attack_s,
        sustain_s: draw.sustain_s,
        decay_s: draw.decay_s,
    }
}

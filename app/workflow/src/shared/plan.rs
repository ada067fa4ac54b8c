//! Plans that a person names, and whether they are for this robot.

use std::f64::consts::TAU;
use std::path::Path;

use hysteron_base::{BadInput, Scene, file};
use hysteron_control::{MotionPlan, StrokeLimits};

/// Angles of tendons that differ by less than this are meant to be the same [rad].
const SAME_ANGLE: f64 = 1e-3;

/// A plan and its text, which is written next to the data: the plan that was run, even if the file changes meanwhile.
pub fn read(named: &str) -> anyhow::Result<(MotionPlan, String)> {
    if Path::new(named).extension().is_some() {
        let text = file::read_text(Path::new(named))?;
        return Ok((MotionPlan::from_toml(&text, named)?, text));
    }
    let plan = MotionPlan::named(named)?;
    Ok((plan, MotionPlan::text(named).unwrap_or_default().to_owned()))
}

/// The plan of this name at the largest scale, at most its own, at which its strokes and their rates stay within `limits` (one for
/// each tendon), with its text and that scale. A tendon that was never released is not released by the plan either.
///
/// # Errors
/// `BadInput` where next to nothing is left of it; those of reading.
pub fn within(named: &str, limits: &[StrokeLimits], by: &str) -> anyhow::Result<(MotionPlan, String, f64)> {
    /// Part of the plan's size below which it is another plan.
    const SMALLEST: f64 = 0.02;
    let (plan, text) = read(named)?;
    let release = |limits: &StrokeLimits| -limits.stroke.min / limits.stroke.max;
    let release = limits.iter().map(release).fold(1.0, f64::min).max(0.0);
    let typed = plan.trajectories().first().map_or(release, |one| one.tendons.release);
    let (plan, text) = if release < typed { changed(&text, "release", release)? } else { (plan, text) };
    let scale = plan.largest_scale(limits);
    if scale >= 1.0 {
        return Ok((plan, text, 1.0));
    }
    if scale < SMALLEST {
        let expected = format!("recordings that pull every tendon, for plan {}", plan.name);
        let bad =
            BadInput::new(by, expected, format!("strokes that allow {:.2} % of its size", 100.0 * scale));
        return Err(bad.hint("name a plan with --plan, which is run without changes").into());
    }
    // Digits that a person reads; never above.
    let scale = (1e4 * scale).floor() / 1e4;
    let (plan, text) = changed(&text, "scale", scale)?;
    Ok((plan, text, scale))
}

/// A plan whose text has another value of a number.
fn changed(text: &str, key: &str, value: f64) -> anyhow::Result<(MotionPlan, String)> {
    let mut document: toml_edit::DocumentMut = text.parse()?;
    document[key] = toml_edit::value(value);
    let text = document.to_string();
    Ok((MotionPlan::from_toml(&text, "plan")?, text))
}

/// Where about the body the tendons run [rad], at their beginning.
pub fn angles_of(scene: &Scene) -> Vec<f64> {
    let angle = |point: [f64; 3]| point[1].atan2(point[0]).rem_euclid(TAU);
    scene.tendons.iter().map(|tendon| angle(tendon.points[0])).collect()
}

/// Refuses a plan made for other tendons than those of `robot`, which run at `angles` [rad].
pub fn check_tendons(plan: &MotionPlan, angles: &[f64], robot: &str) -> Result<(), BadInput> {
    let Some(trajectory) = plan.trajectories().first() else { return Ok(()) };
    check_angles(&plan.name, &trajectory.tendons.angles, angles, robot)
}

/// Refuses the tendons of the plan `plan`, at the angles `planned` [rad], as [`check_tendons`] does.
pub fn check_angles(plan: &str, planned: &[f64], angles: &[f64], robot: &str) -> Result<(), BadInput> {
    let place = format!("plan {plan}: tendon_angles_deg");
    if planned.len() != angles.len() {
        let expected = format!("{} tendons, as {robot} has", angles.len());
        return Err(BadInput::new(place, expected, planned.len().to_string()));
    }
    for (k, (planned, angle)) in planned.iter().zip(angles).enumerate() {
        let apart = (planned - angle).sin().hypot((planned - angle).cos() - 1.0);
        if apart > SAME_ANGLE {
            let expected = format!("{:.1}, as tendon {} of {robot}", angle.to_degrees(), k + 1);
            let found = format!("{:.1}", planned.to_degrees());
            return Err(BadInput::new(format!("{place}[{k}]"), expected, found));
        }
    }
    Ok(())
}

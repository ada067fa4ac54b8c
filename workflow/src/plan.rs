//! Plans that a person names, and whether they are for this robot.

use std::f64::consts::TAU;
use std::path::Path;

use hysteron_base::{BadInput, Scene, file};
use hysteron_control::Plan;

/// Angles of tendons that differ by less than this are meant to be the same [rad].
const SAME_ANGLE: f64 = 1e-3;

/// A plan and its text, which goes beside the data: what was carried out, whatever becomes of the file meanwhile.
pub fn read(named: &str) -> anyhow::Result<(Plan, String)> {
    if Path::new(named).extension().is_some() {
        let text = file::read_text(Path::new(named))?;
        return Ok((Plan::from_toml(&text, named)?, text));
    }
    let plan = Plan::named(named)?;
    Ok((plan, Plan::text(named).unwrap_or_default().to_owned()))
}

/// Where about the body the tendons run [rad], at their beginning.
pub fn angles_of(scene: &Scene) -> Vec<f64> {
    let angle = |point: [f64; 3]| point[1].atan2(point[0]).rem_euclid(TAU);
    scene.tendons.iter().map(|tendon| angle(tendon.points[0])).collect()
}

/// Refuses a plan made for other tendons than those of `robot`, which run at `angles` [rad].
pub fn check_tendons(plan: &Plan, angles: &[f64], robot: &str) -> Result<(), BadInput> {
    let Some(trajectory) = plan.trajectories().first() else { return Ok(()) };
    let planned = &trajectory.tendons.angles;
    let place = format!("plan {}: tendon_angles_deg", plan.name);
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

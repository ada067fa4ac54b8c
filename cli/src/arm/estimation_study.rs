//! `hysteron arm study scara`, `wrist` and `identification`: simulated and recorded arms beside what is published.

use std::path::Path;

use hysteron_arm::study::Listener;
use hysteron_arm::study::estimation::{ScaraOptions, scara_study, wrist_study};
use hysteron_arm::study::identification::{IdentificationOptions, identification_study};
use hysteron_workflow::arm;
use hysteron_workflow::{Caller, arm_estimation_figures, identification_study_figures};
use serde_json::Value;

/// Friction, external torques and collisions of the SCARA; one seed, `scale` times four trials and three stretches.
pub fn scara(out: &Path, scale: usize, listener: Listener<'_>, caller: &Caller) -> anyhow::Result<Value> {
    let amount = ScaraOptions { seed: 1, trials: 4 * scale, stretches: 3 * scale };
    match scara_study(&out.join("cells"), amount, listener)? {
        Some(study) if !caller.is_cancelled() => {
            arm_estimation_figures::write_scara(out, &study, &arm::meta(caller, "study of external torques"))
        }
        _ => interrupted(out),
    }
}

/// Interaction torques of the wrist, every cell with seeds 1 to `seeds`.
pub fn wrist(out: &Path, seeds: usize, listener: Listener<'_>, caller: &Caller) -> anyhow::Result<Value> {
    match wrist_study(&out.join("cells"), seeds as u64, listener)? {
        Some(study) if !caller.is_cancelled() => {
            arm_estimation_figures::write_wrist(out, &study, &arm::meta(caller, "study of external torques"))
        }
        _ => interrupted(out),
    }
}

/// Friction and bodies by every method, with seeds 1 to `seeds`; recorded friction where there is `data`.
pub fn identification(
    out: &Path,
    data: Option<&Path>,
    seeds: usize,
    listener: Listener<'_>,
    caller: &Caller,
) -> anyhow::Result<Value> {
    let franka = data.map(|data| data.join("friction-franka"));
    let options = IdentificationOptions { seeds: seeds as u64 };
    match identification_study(&out.join("cells"), franka.as_deref(), options, listener)? {
        Some(study) if !caller.is_cancelled() => {
            identification_study_figures::write(out, &study, &arm::meta(caller, "study of identification"))
        }
        _ => interrupted(out),
    }
}

fn interrupted(out: &Path) -> anyhow::Result<Value> {
    anyhow::bail!(
        "interrupted; what is done stands in {}: the same command goes on",
        out.join("cells").display()
    )
}

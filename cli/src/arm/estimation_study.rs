//! `hysteron arm study scara` and `wrist`: estimated external torques beside what is published.

use std::path::Path;

use hysteron_arm::study::Listener;
use hysteron_arm::study::estimation::{ScaraOptions, scara_study, wrist_study};
use hysteron_workflow::{Caller, arm_estimation_figures};
use serde_json::Value;

/// Friction, external torques and collisions of the SCARA; one seed, `scale` times four trials and three stretches.
pub fn scara(out: &Path, scale: usize, listener: Listener<'_>, caller: &Caller) -> anyhow::Result<Value> {
    let amount = ScaraOptions { seed: 1, trials: 4 * scale, stretches: 3 * scale };
    match scara_study(&out.join("cells"), amount, listener)? {
        Some(study) if !caller.is_cancelled() => {
            arm_estimation_figures::write_scara(out, &study, &super::meta("study of external torques"))
        }
        _ => interrupted(out),
    }
}

/// Interaction torques of the wrist, every cell with seeds 1 to `seeds`.
pub fn wrist(out: &Path, seeds: usize, listener: Listener<'_>, caller: &Caller) -> anyhow::Result<Value> {
    match wrist_study(&out.join("cells"), seeds as u64, listener)? {
        Some(study) if !caller.is_cancelled() => {
            arm_estimation_figures::write_wrist(out, &study, &super::meta("study of external torques"))
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

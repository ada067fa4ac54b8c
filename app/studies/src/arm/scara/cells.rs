//! The study of the SCARA, cell by cell.

use std::path::Path;

use hysteron_base::json;
use hysteron_learn::Result;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::arm::estimation::collisions::{CollisionCell, collision_cell};
use crate::arm::estimation::scara::{Methods, TeachingCell, teaching_cell};
use crate::arm::estimation::scara_friction::{FrictionCell, friction_cell};
use crate::arm::estimation::scara_signals::{SignalCell, signal_cell};
use crate::runner::cells::{Listener, Steps, cell, make_folder};

/// How much is simulated.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct ScaraOptions {
    /// Seed of all draws.
    pub seed: u64,
    /// Trials of 12 s in which the hand leads the arm.
    pub trials: usize,
    /// Stretches of 300 s with collisions.
    pub stretches: usize,
}

/// Everything about the SCARA.
#[derive(Debug, Clone)]
pub struct ScaraStudy {
    /// How much was simulated.
    pub options: ScaraOptions,
    /// Friction of both joints.
    pub friction: [FrictionCell; 2],
    /// Led by the hand.
    pub teaching: TeachingCell,
    /// Collisions.
    pub collisions: CollisionCell,
    /// Signals of the observer.
    pub signals: SignalCell,
}

/// Friction, led by the hand, collisions. `None` where the listener ended it; what is done is found again below `folder`.
///
/// # Errors
/// Cells of another study; files that cannot be written.
pub fn scara_study(
    folder: &Path,
    options: ScaraOptions,
    mut listener: Listener<'_>,
) -> Result<Option<ScaraStudy>> {
    make_folder(folder)?;
    let mut steps = Steps { listener: &mut listener, done: [0, 5] };
    let identity = json!({ "study": "scara", "options": options });
    let mut friction = Vec::new();
    for joint in 0..2 {
        let name = format!("friction-{}", joint + 1);
        if !steps.begin(&name) {
            return Ok(None);
        }
        let row = cell(folder, &name, &identity, || Ok(Some(friction_cell(joint, options.seed)?)))?;
        let Some(row) = row else { return Ok(None) };
        friction.push(row);
    }
    let Ok(friction) = <[FrictionCell; 2]>::try_from(friction) else { return Ok(None) };
    let methods = Methods::new(&friction)?;
    if !steps.begin("teaching") {
        return Ok(None);
    }
    let run = || Ok(Some(teaching_cell(&methods, options.trials, options.seed)?));
    let Some(teaching) = cell(folder, "teaching", &identity, run)? else { return Ok(None) };
    if !steps.begin("collisions") {
        return Ok(None);
    }
    let collide = || Ok(Some(collision_cell(&methods, options.stretches, options.seed)?));
    let Some(collisions) = cell(folder, "collisions", &identity, collide)? else { return Ok(None) };
    if !steps.begin("signals") {
        return Ok(None);
    }
    let show = || Ok(Some(signal_cell(&methods, options.seed)?));
    let Some(signals) = cell(folder, "signals", &identity, show)? else { return Ok(None) };
    Ok(Some(ScaraStudy { options, friction, teaching, collisions, signals }))
}

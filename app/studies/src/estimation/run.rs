//! Both studies, cell by cell.

use std::path::Path;

use hysteron_base::json;
use hysteron_learn::Result;
use serde::{Deserialize, Serialize};

use super::collisions::{CollisionCell, collision_cell};
use super::scara::{Methods, TeachingCell, teaching_cell};
use super::scara_friction::{FrictionCell, friction_cell};
use super::scara_signals::{SignalCell, signal_cell};
use super::simulated_errors::Comparison;
use super::wrist::{Load, WristCell, Wrists, identify_wrist, simulated_errors, wrist_cell};
use super::wrist_sweep::{SweepCell, sweep_cell};
use crate::{Listener, StudyProgress, cell, make_folder};

/// How much is simulated.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct ScaraOptions {
    /// Seed of all draws.
    pub seed: u64,
    /// Trials of 12 s in which the hand leads the arm.
    pub trials: usize,
    /// Stretches of 300 s with collisions.
    pub stretches: usize,
}

/// Everything about the SCARA.
#[derive(Debug, Clone, Serialize)]
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

/// Everything about the wrist.
#[derive(Debug, Clone, Serialize)]
pub struct WristStudy {
    /// Trials: by drift of friction, load, and seed.
    pub cells: Vec<WristCell>,
    /// Noise, wrong model, sensitivity to the mass of the second link.
    pub simulated: [Comparison; 3],
    /// The identification of the first seed.
    pub sweep: SweepCell,
}

/// Changes of friction after identification.
pub const DRIFTS: [f64; 3] = [-0.15, 0.0, 0.15];

/// Reports to `listener`, and goes on as long as it wants.
struct Steps<'a, 'b> {
    listener: &'a mut Listener<'b>,
    done: [usize; 2],
}

impl Steps<'_, '_> {
    fn next(&mut self, cell: &str) -> bool {
        let goes_on = (self.listener)(&StudyProgress { cell, done: self.done, training: None });
        self.done[0] += 1;
        goes_on
    }
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
        if !steps.next(&name) {
            return Ok(None);
        }
        let row = cell(folder, &name, &identity, || Ok(Some(friction_cell(joint, options.seed)?)))?;
        let Some(row) = row else { return Ok(None) };
        friction.push(row);
    }
    let Ok(friction) = <[FrictionCell; 2]>::try_from(friction) else { return Ok(None) };
    let methods = Methods::new(&friction)?;
    if !steps.next("teaching") {
        return Ok(None);
    }
    let teach = || Ok(Some(teaching_cell(&methods, options.trials, options.seed)?));
    let Some(teaching) = cell(folder, "teaching", &identity, teach)? else { return Ok(None) };
    if !steps.next("collisions") {
        return Ok(None);
    }
    let collide = || Ok(Some(collision_cell(&methods, options.stretches, options.seed)?));
    let Some(collisions) = cell(folder, "collisions", &identity, collide)? else { return Ok(None) };
    if !steps.next("signals") {
        return Ok(None);
    }
    let show = || Ok(Some(signal_cell(&methods, options.seed)?));
    let Some(signals) = cell(folder, "signals", &identity, show)? else { return Ok(None) };
    Ok(Some(ScaraStudy { options, friction, teaching, collisions, signals }))
}

/// Every drift, load and seed from 1 to `seeds`, and the paper's simulations. `None` where the listener ended it; what is done is
/// found again below `folder`.
///
/// # Errors
/// Cells of another study; files that cannot be written.
pub fn wrist_study(folder: &Path, seeds: u64, mut listener: Listener<'_>) -> Result<Option<WristStudy>> {
    make_folder(folder)?;
    let wrists = Wrists::new()?;
    let mut steps = Steps { listener: &mut listener, done: [0, 6 * seeds as usize + 2] };
    let mut cells = Vec::new();
    for seed in 1..=seeds {
        let mut known = None;
        for (drift, load) in
            DRIFTS.into_iter().flat_map(|drift| [Load::Payload, Load::ForceSensor].map(|load| (drift, load)))
        {
            let name = format!("{}-{:+.0}-{seed}", load.name(), 100.0 * drift);
            if !steps.next(&name) {
                return Ok(None);
            }
            let identity = json!({ "study": "wrist", "load": load, "drift": drift, "seed": seed });
            let row = cell(folder, &name, &identity, || {
                if known.is_none() {
                    known = Some(identify_wrist(&wrists, seed)?);
                }
                Ok(known.as_ref().map(|known| wrist_cell(&wrists, known, (load, drift, seed))).transpose()?)
            })?;
            let Some(row) = row else { return Ok(None) };
            cells.push(row);
        }
    }
    if !steps.next("simulated") {
        return Ok(None);
    }
    let identity = json!({ "study": "wrist", "simulated": 1 });
    let simulated = cell(folder, "simulated", &identity, || Ok(Some(simulated_errors(&wrists)?)))?;
    let Some(simulated) = simulated else { return Ok(None) };
    if !steps.next("sweep") {
        return Ok(None);
    }
    let identity = json!({ "study": "wrist", "sweep": 1 });
    let sweep = cell(folder, "sweep", &identity, || Ok(Some(sweep_cell(&wrists, 1)?)))?;
    Ok(sweep.map(|sweep| WristStudy { cells, simulated, sweep }))
}

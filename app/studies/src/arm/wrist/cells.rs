//! The study of the wrist, cell by cell.

use std::path::Path;

use hysteron_base::json;
use hysteron_learn::Result;

use crate::arm::estimation::simulated_errors::ErrorComparison;
use crate::arm::estimation::wrist::{Load, WristCell, Wrists, identify_wrist, simulated_errors, wrist_cell};
use crate::arm::estimation::wrist_sweep::{SweepCell, sweep_cell};
use crate::runner::cells::{Listener, Steps, cell, make_folder};

/// Everything about the wrist.
#[derive(Debug, Clone)]
pub struct WristStudy {
    /// Trials: by drift of friction, load, and seed.
    pub cells: Vec<WristCell>,
    /// Noise, wrong model, sensitivity to the mass of the second link.
    pub simulated: [ErrorComparison; 3],
    /// The identification of the first seed.
    pub sweep: SweepCell,
}

/// Changes of friction after identification.
pub const DRIFTS: [f64; 3] = [-0.15, 0.0, 0.15];

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
            if !steps.begin(&name) {
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
    if !steps.begin("simulated") {
        return Ok(None);
    }
    let identity = json!({ "study": "wrist", "simulated": 1 });
    let simulated = cell(folder, "simulated", &identity, || Ok(Some(simulated_errors(&wrists)?)))?;
    let Some(simulated) = simulated else { return Ok(None) };
    if !steps.begin("sweep") {
        return Ok(None);
    }
    let identity = json!({ "study": "wrist", "sweep": 1 });
    let sweep = cell(folder, "sweep", &identity, || Ok(Some(sweep_cell(&wrists, 1)?)))?;
    Ok(sweep.map(|sweep| WristStudy { cells, simulated, sweep }))
}

//! The study of identification, cell by cell: recorded friction of a Franka arm compared with
//! eight published models, friction of the SCARA of Wan et al. (2026), bodies of the wrist of Saadatzi et al.
//! (2019).

use std::path::Path;

use hysteron_base::json;
use hysteron_learn::Result;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::franka::{FrankaCell, franka_cell};
use super::sweep::{SweepCell, sweep_cell};
use crate::arm::estimation::scara_friction::{FrictionCell, friction_cell};
use crate::runner::cells::{Listener, Steps, cell, make_folder};

/// How much is simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct IdentificationOptions {
    /// Noise seeds 1 to this.
    pub seeds: u64,
}

/// Everything.
#[derive(Debug, Clone)]
pub struct IdentificationStudy {
    /// How much was simulated.
    pub options: IdentificationOptions,
    /// Recorded friction, where there is data.
    pub franka: Option<FrankaCell>,
    /// Friction of both joints of the SCARA, seed by seed.
    pub scara: Vec<FrictionCell>,
    /// Bodies of the wrist, seed by seed.
    pub wrist: Vec<SweepCell>,
}

/// The whole study; `franka` is the folder of the recordings. `None` where the listener ended it; what is done is found again below
/// `folder`.
///
/// # Errors
/// Cells of another study; recordings that cannot be read; files that cannot be written.
pub fn identification_study(
    folder: &Path,
    franka: Option<&Path>,
    options: IdentificationOptions,
    mut listener: Listener<'_>,
) -> Result<Option<IdentificationStudy>> {
    make_folder(folder)?;
    let all = 3 * options.seeds as usize + usize::from(franka.is_some());
    let mut steps = Steps { listener: &mut listener, done: [0, all] };
    let mut study = IdentificationStudy { options, franka: None, scara: vec![], wrist: vec![] };
    if let Some(recordings) = franka {
        if !steps.begin("franka") {
            return Ok(None);
        }
        let identity = json!({ "study": "identification", "cell": "franka" });
        study.franka = cell(folder, "franka", &identity, || Ok(Some(franka_cell(recordings)?)))?;
    }
    for seed in 1..=options.seeds {
        let identity = json!({ "study": "identification", "seed": seed });
        for joint in 0..2 {
            let name = format!("scara-{}-{seed}", joint + 1);
            if !steps.begin(&name) {
                return Ok(None);
            }
            study.scara.extend(cell(folder, &name, &identity, || Ok(Some(friction_cell(joint, seed)?)))?);
        }
        let name = format!("wrist-{seed}");
        if !steps.begin(&name) {
            return Ok(None);
        }
        study.wrist.extend(cell(folder, &name, &identity, || Ok(Some(sweep_cell(seed)?)))?);
    }
    Ok(Some(study))
}

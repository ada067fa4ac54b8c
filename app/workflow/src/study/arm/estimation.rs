//! External torques and identification: simulated and recorded arms beside what is published.

use hysteron_studies::Listener;
use hysteron_studies::estimation::{ScaraOptions, scara_study, wrist_study};
use hysteron_studies::identification::{IdentificationOptions, identification_study};
use serde_json::Value;

use super::Options;
use crate::arm::meta;
use crate::{Context, arm_estimation_figures, identification_study_figures};

/// Result of a study; `None` where it was interrupted.
type Found = anyhow::Result<Option<Value>>;

/// Friction, external torques and collisions of the SCARA; one seed, the number of seeds times four trials and three stretches.
pub(super) fn scara(options: &Options, listener: Listener<'_>, context: &Context) -> Found {
    let amount = ScaraOptions { seed: 1, trials: 4 * options.seeds, stretches: 3 * options.seeds };
    match scara_study(&options.out.join("cells"), amount, listener)? {
        Some(study) if !context.is_cancelled() => {
            let meta = meta(context, "study of external torques");
            arm_estimation_figures::write_scara(&options.out, &study, &meta).map(Some)
        }
        _ => Ok(None),
    }
}

/// Interaction torques of the wrist, every cell with as many seeds.
pub(super) fn wrist(options: &Options, listener: Listener<'_>, context: &Context) -> Found {
    match wrist_study(&options.out.join("cells"), options.seeds as u64, listener)? {
        Some(study) if !context.is_cancelled() => {
            let meta = meta(context, "study of external torques");
            arm_estimation_figures::write_wrist(&options.out, &study, &meta).map(Some)
        }
        _ => Ok(None),
    }
}

/// Friction and bodies by every method, with as many seeds; recorded friction where there is data.
pub(super) fn identification(options: &Options, listener: Listener<'_>, context: &Context) -> Found {
    let franka = options.data.as_ref().map(|data| data.join("friction-franka"));
    let amount = IdentificationOptions { seeds: options.seeds as u64 };
    match identification_study(&options.out.join("cells"), franka.as_deref(), amount, listener)? {
        Some(study) if !context.is_cancelled() => {
            let meta = meta(context, "study of identification");
            identification_study_figures::write(&options.out, &study, &meta).map(Some)
        }
        _ => Ok(None),
    }
}

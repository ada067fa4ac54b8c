//! `hysteron arm study scara` and `wrist`: estimated external torques beside what is published.

use std::path::Path;

use hysteron_arm::study::StudyProgress;
use hysteron_arm::study::estimation::{ScaraOptions, scara_study, wrist_study};
use hysteron_workflow::{Caller, Outputs, arm_estimation_figures};
use serde_json::Value;

/// What of the command line they use.
pub struct Options<'a> {
    /// Folder for cells and report.
    pub out: &'a Path,
    /// Noise seeds of the wrist; the SCARA has one.
    pub seeds: u64,
}

/// Friction, external torques and collisions of the SCARA.
pub fn scara(options: &Options, caller: &Caller) -> anyhow::Result<Value> {
    let _claim = Outputs::default().report("--out", Some(options.out)).check(caller)?;
    caller.listen()?;
    let amount = ScaraOptions { seed: 1, trials: 20, stretches: 15 };
    let mut tell = |p: &StudyProgress<'_>| !caller.is_cancelled();
    match scara_study(&options.out.join("cells"), amount, &mut tell)? {
        Some(study) => arm_estimation_figures::write_scara(options.out, &study, &meta()),
        None => interrupted(options.out),
    }
}

/// Interaction torques of the wrist.
pub fn wrist(options: &Options, caller: &Caller) -> anyhow::Result<Value> {
    let _claim = Outputs::default().report("--out", Some(options.out)).check(caller)?;
    caller.listen()?;
    let mut tell = |p: &StudyProgress<'_>| !caller.is_cancelled();
    match wrist_study(&options.out.join("cells"), options.seeds, &mut tell)? {
        Some(study) => arm_estimation_figures::write_wrist(options.out, &study, &meta()),
        None => interrupted(options.out),
    }
}

//! Bodies and friction of the wrist from a swept sine: differential evolution compared with the convex fit.

use hysteron_base::BadInput;
use hysteron_fit::{GlobalMethod, GlobalOptions};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::arm::estimation::wrist::{SWEEP_OPTIONS, Wrists, sweep_wrist};
use hysteron_arm_estimation::identify::{evolve_bodies, identify_bodies};

/// Weight of joint 2 in the sum of squares, as in the paper.
pub const JOINT_2: f64 = 6.0;

/// One method.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SweepRow {
    /// "convex" or "differential-evolution".
    pub method: String,
    /// Root mean square of what is left, joint by joint [N m].
    pub rms_n_m: [f64; 2],
    /// The two together, joint 2 weighed six-fold: what evolution makes least [N m].
    pub weighed_n_m: f64,
    /// Least eigenvalue of the pseudo-inertias of both bodies: above 0 where they can exist.
    pub least_pseudo_inertias: [f64; 2],
    /// Time it took [s].
    pub seconds: f64,
    /// Evaluations of the cost, of evolution.
    pub evaluations: Option<usize>,
}

/// Both methods on one sweep.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SweepCell {
    /// Seed of all draws.
    pub seed: u64,
    /// The methods.
    pub rows: Vec<SweepRow>,
}

/// Sweeps the wrist and identifies it by both methods.
///
/// # Errors
/// None for the sweep here.
pub fn sweep_cell(seed: u64) -> Result<SweepCell, BadInput> {
    let wrists = Wrists::new()?;
    let (_, motion) = sweep_wrist(&wrists, seed)?;
    let begun = std::time::Instant::now();
    let convex = identify_bodies(&wrists.cad, &motion, &SWEEP_OPTIONS)?;
    let seconds = begun.elapsed().as_secs_f64();
    let pair = |x: &[f64]| [x[0], x[1]];
    let weighed = |rms: [f64; 2]| (rms[0].powi(2) + JOINT_2 * rms[1].powi(2)).sqrt();
    let row = |method: &str, rms: &[f64], least: &[f64], seconds: f64, evaluations: Option<usize>| SweepRow {
        method: method.to_owned(),
        rms_n_m: pair(rms),
        weighed_n_m: weighed(pair(rms)),
        least_pseudo_inertias: pair(least),
        seconds,
        evaluations,
    };
    let mut rows = vec![row("convex", &convex.rms, &convex.least_pseudo_inertias(), seconds, None)];
    let begun = std::time::Instant::now();
    let search = GlobalOptions {
        method: GlobalMethod::EVOLUTION,
        members_per_parameter: 10,
        generations: 6000,
        spread: 1e-6,
        seed,
        watch: &|_, _| true,
    };
    let found = evolve_bodies(&wrists.cad, &motion, &SWEEP_OPTIONS, &[1.0, JOINT_2], &search)?;
    let seconds = begun.elapsed().as_secs_f64();
    let least = &found.least_pseudo_inertias;
    rows.push(row("differential-evolution", &found.rms, least, seconds, Some(found.evaluations)));
    Ok(SweepCell { seed, rows })
}

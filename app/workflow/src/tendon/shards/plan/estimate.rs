//! Time and size of a set, estimated from a few of its trajectories.

use std::time::Instant;

use hysteron_base::{Metadata, TrajectoryShard};
use hysteron_control::LazyPlan;
use hysteron_twin::synthetic::SyntheticOutcome;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Context;
use crate::tendon::generate::TrajectorySimulator;

/// Samples by which sets are compared.
const COMPARED: f64 = 1e9;

/// Time and size of a set, from trajectories that were simulated on one core.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CostEstimate {
    /// Trajectories that were simulated.
    pub trajectories: usize,
    /// Their samples.
    pub samples: usize,
    /// Time of one core for a sample [s].
    pub core_s_per_sample: f64,
    /// Size of a sample [byte].
    pub bytes_per_sample: f64,
    /// Time of one core for the set [h].
    pub core_hours: f64,
    /// Size of the set [GB].
    pub gigabytes: f64,
    /// Time of one core for 10⁹ samples [h].
    pub core_hours_per_1e9: f64,
    /// Size of 10⁹ samples [GB].
    pub gigabytes_per_1e9: f64,
}

impl CostEstimate {
    /// Simulates `n` trajectories, spread over the plan, one after the other; `None` where there is none that the twin can follow.
    pub(super) fn measured(
        simulator: &TrajectorySimulator,
        plan: &LazyPlan,
        (n, n_samples): (usize, u64),
        context: &Context,
    ) -> anyhow::Result<Option<Self>> {
        let n = n.min(plan.n_trajectories());
        let start = Instant::now();
        let mut parts = Vec::new();
        for k in (0..n).map(|k| k * (plan.n_trajectories() / n)) {
            let simulated = simulator.run(&plan.trajectory(k)?, &mut || !context.is_cancelled())?;
            if let SyntheticOutcome::Made(recording) = simulated {
                parts.push((k as u64, recording));
            }
        }
        let samples: usize = parts.iter().map(|(_, recording)| recording.n_samples()).sum();
        if samples == 0 {
            return Ok(None);
        }
        let trajectories = parts.len();
        let bytes = TrajectoryShard::new(Metadata::default(), parts)?.to_bytes()?.len();
        let core_s_per_sample = start.elapsed().as_secs_f64() / samples as f64;
        let bytes_per_sample = bytes as f64 / samples as f64;
        let hours = |n: f64| n * core_s_per_sample / 3600.0;
        let gigabytes = |n: f64| 1e-9 * n * bytes_per_sample;
        Ok(Some(Self {
            trajectories,
            samples,
            core_s_per_sample,
            bytes_per_sample,
            core_hours: hours(n_samples as f64),
            gigabytes: gigabytes(n_samples as f64),
            core_hours_per_1e9: hours(COMPARED),
            gigabytes_per_1e9: gigabytes(COMPARED),
        }))
    }

    /// Prints it.
    pub(super) fn print(&self, context: &Context) {
        let (time, unit) = match self.core_hours {
            hours if hours < 1.0 => (60.0 * hours, "core-minutes"),
            hours => (hours, "core-hours"),
        };
        context.print(format_args!(
            "about {time:.1} {unit} and {:.3} GB: {:.0} µs and {:.1} bytes a sample, from {} trajectories",
            self.gigabytes,
            1e6 * self.core_s_per_sample,
            self.bytes_per_sample,
            self.trajectories,
        ));
        context.print(format_args!(
            "at this rate 10⁹ samples take {:.0} core-hours and {:.0} GB",
            self.core_hours_per_1e9, self.gigabytes_per_1e9
        ));
    }
}

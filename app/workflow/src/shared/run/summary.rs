//! The numbers of a run: cost, accuracy, and what the robot did.

use hysteron_base::Recording;
use hysteron_control::score::{AxisScore, PathScore};
use hysteron_twin::command::{CommandStep, Goals};
use hysteron_twin::{RunLocking, Twin};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::band::TipBandSummary;
use super::exact::ExactSummary;

/// Numbers of a run; written as they are into `metrics.json`.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
pub struct RunSummary {
    /// Samples simulated by this run; an earlier one may have done others.
    pub steps: usize,
    /// Time the steps took [s].
    pub wall_s: f64,
    /// QPs solved for strokes, each tried with one or several forward steps; none without goals.
    pub rounds: usize,
    /// Corrections with the stale factor.
    pub iterations: usize,
    /// Times the factor was renewed.
    pub refactorisations: usize,
    /// Iterations of Newton's method, where the stale factor did not serve.
    pub newton_iterations: usize,
    /// Parts into which such steps were divided.
    pub sub_steps: usize,
    /// QPs solved by clarabel.
    pub clarabel_solves: usize,
    /// Largest force residual over applied forces [-].
    pub worst_relative_residual: f64,
    /// Largest error of a prescribed stroke [m].
    pub worst_stroke_error_m: f64,
    /// Part of the samples in which the residual network left its training range, if there was one [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extrapolated: Option<f64>,
    /// Where the robot's own tip is expected, by a network that learned with recordings left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip_band: Option<TipBandSummary>,
    /// Part of the samples in which a chain was bent further than it was validated, if there was one [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outside_validation: Option<f64>,
    /// How far the chain was off where the finite elements made a sample too, if that was requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exact: Option<ExactSummary>,
    /// Samples in the recording.
    pub samples: usize,
    /// Time from the first to the last sample [s].
    pub duration_s: f64,
    /// Smallest and largest coordinates of the tip [m].
    pub tip_min_m: [f64; 3],
    /// See `tip_min_m`.
    pub tip_max_m: [f64; 3],
    /// One entry per primary tendon.
    pub tendons: Vec<TendonSummary>,
    /// How close the tip came to the measured one, if the strokes came with one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub against_measured: Option<PathScore>,
    /// Error by the locking of linear tetrahedra, where they can be compared with ten-node ones.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub locking: Option<RunLocking>,
    /// How the goals were met, if there were any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goals: Option<GoalSummary>,
}

/// How the goals of a run were met.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct GoalSummary {
    /// Distance that counts as reached [m].
    pub tolerance_m: f64,
    /// Goals that the tip did not come so close to.
    pub out_of_reach: usize,
    /// Largest distance of the tip from its goal [m].
    pub largest_distance_m: f64,
    /// Time of the sample in which it was [s].
    pub largest_distance_at_s: f64,
}

/// Numbers of one tendon over a run.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
pub struct TendonSummary {
    /// Name in the scene.
    pub name: String,
    /// Commanded strokes [m].
    pub stroke_min_m: f64,
    /// See `stroke_min_m`.
    pub stroke_max_m: f64,
    /// Largest tension [N].
    pub tension_max_n: f64,
    /// Share of the samples in which it was at its lower tension bound: slack, if that is zero [-].
    pub share_at_lower_bound: f64,
}

impl RunSummary {
    /// Adds what a sample took.
    pub fn add(&mut self, step: &CommandStep) {
        let report = &step.report;
        self.steps += 1;
        self.rounds += step.rounds;
        self.iterations += report.iterations;
        self.refactorisations += report.refactorisations;
        self.newton_iterations += report.newton_iterations;
        self.sub_steps += report.sub_steps;
        self.clarabel_solves += report.clarabel_solves;
        self.worst_relative_residual = self.worst_relative_residual.max(report.relative_residual);
        self.worst_stroke_error_m = self.worst_stroke_error_m.max(report.stroke_error);
    }

    /// Adds what the recording of the run shows.
    pub fn finish(&mut self, twin: &Twin, recording: &Recording, goals: Option<&Goals>) {
        let time = recording.time();
        self.samples = time.len();
        self.duration_s = time[time.len() - 1] - time[0];
        for (c, values) in recording.tip().into_iter().flatten().enumerate() {
            [self.tip_min_m[c], self.tip_max_m[c]] = range(values);
        }
        let tensions = recording.numbered("tension", "n");
        for ((tendon, strokes), tensions) in twin.tendons.iter().zip(recording.strokes()).zip(tensions) {
            let [stroke_min_m, stroke_max_m] = range(strokes);
            let n_at_bound = tensions.iter().filter(|tension| **tension == tendon.tension.min).count();
            self.tendons.push(TendonSummary {
                name: tendon.name.clone(),
                stroke_min_m,
                stroke_max_m,
                tension_max_n: range(tensions)[1],
                share_at_lower_bound: n_at_bound as f64 / time.len() as f64,
            });
        }
        self.goals = goals.zip(recording.tip()).map(|(goals, tip)| {
            let errors = goals.errors(tip);
            let [_, largest_distance_m] = range(&errors);
            let farthest = errors.iter().position(|error| *error == largest_distance_m);
            GoalSummary {
                tolerance_m: goals.tolerance(),
                out_of_reach: errors.iter().filter(|error| **error > goals.tolerance()).count(),
                largest_distance_m,
                largest_distance_at_s: time[farthest.unwrap_or(0)],
            }
        });
    }

    /// Steps per second.
    pub fn rate(&self) -> f64 {
        self.steps as f64 / self.wall_s
    }

    /// Tells the person.
    pub fn log(&self) {
        let per_step = |count: usize| count as f64 / self.steps.max(1) as f64;
        let what = if self.goals.is_some() { "goals" } else { "steps" };
        tracing::info!(
            "{} {what} in {:.2} s: {:.0} {what}/s, {:.1} times real time",
            self.steps,
            self.wall_s,
            self.rate(),
            self.duration_s * self.steps as f64 / self.samples as f64 / self.wall_s,
        );
        tracing::info!(
            "{:.2} iterations per {}, {} refactorisations of the factor, {} Newton iterations in {} sub-steps, {} clarabel solves",
            per_step(self.iterations),
            what.trim_end_matches('s'),
            self.refactorisations,
            self.newton_iterations,
            self.sub_steps,
            self.clarabel_solves,
        );
        tracing::info!(
            "worst relative residual {:.1e}, worst stroke error {:.1e} mm",
            self.worst_relative_residual,
            1e3 * self.worst_stroke_error_m,
        );
        let axis = |c: usize| {
            format!("{} {:.2} to {:.2}", ["x", "y", "z"][c], 1e3 * self.tip_min_m[c], 1e3 * self.tip_max_m[c])
        };
        tracing::info!("tip range {}, {}, {} mm", axis(0), axis(1), axis(2));
        if let Some(score) = &self.against_measured {
            let cells = (0..3).map(|c| format!("{} {}", ["x", "y", "z"][c], axis_score(&score.axes[c])));
            tracing::info!("against the measured tip: {}", cells.collect::<Vec<_>>().join(", "));
        }
        if let Some(band) = &self.tip_band {
            tracing::info!("{}", band.sentence());
        }
        if let Some(part) = self.extrapolated {
            tracing::info!("the network left its training range in {:.1} % of samples", 100.0 * part);
        }
        if let Some(part) = self.outside_validation.filter(|part| *part > 0.0) {
            tracing::warn!(
                "the chain was bent further than it was validated in {:.1} % of samples: make it with a larger --stroke-mm",
                100.0 * part
            );
        }
        if let Some(exact) = &self.exact {
            tracing::info!("{}", exact.line());
        }
        if let Some(goals) = &self.goals {
            goals.log(self.samples, per_step(self.rounds));
        }
    }
}

/// RMSE in millimetres, and NRMSE in percent where there is one.
pub fn axis_score(score: &AxisScore) -> String {
    let share = score.nrmse.map_or(String::new(), |nrmse| format!(" ({:.2} %)", 100.0 * nrmse));
    format!("{:.3} mm{share}", 1e3 * score.rmse_m)
}

impl GoalSummary {
    fn log(&self, n_goals: usize, rounds_per_goal: f64) {
        let Self { tolerance_m, out_of_reach, largest_distance_m, largest_distance_at_s } = self;
        let line = format!(
            "{} of {n_goals} goals reached within {} mm, in {rounds_per_goal:.1} rounds each; largest distance \
             {:.2e} mm at t = {largest_distance_at_s} s",
            n_goals - out_of_reach,
            1e3 * tolerance_m,
            1e3 * largest_distance_m,
        );
        if *out_of_reach == 0 {
            tracing::info!("{line}");
        } else {
            tracing::warn!("{out_of_reach} goals out of reach: {line}");
        }
    }
}

/// Smallest and largest value.
pub fn range(values: &[f64]) -> [f64; 2] {
    values
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(*value), high.max(*value)])
}

//! From a tip goal to strokes: the effector form of the constraint QP (CoReAct paper, eq. 4).
//!
//! At an equilibrium the drift is zero, and the QP in the tension increments λ reads
//! min ½ |δ_e - goal|² + ½ λᵀRλ with δ = W λ, the strokes of stroke-driven tendons held, tensions and
//! strokes of the free ones within their bounds. Its strokes are then commanded to the forward step,
//! which knows slack tendons, friction and large displacements; what the linearisation missed corrects the
//! effector rows of W (Broyden) for the next round.

use hysteron_base::BadInput;

use crate::model::{Target, Twin};
use crate::report::StepReport;
use crate::solver::{TensionResponse, TipMotion, singular};
use crate::stepper::{Stepper, check_targets};
use crate::{Error, Result, TwinState};
use hysteron_fit::qp::{QpStatus, RowQp, solve_rows};

/// Goal of the tip, and its tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TipGoal {
    /// Position [m]; a coordinate that is `None` may be anything.
    pub position: [Option<f64>; 3],
    /// Distance that counts as reached [m].
    pub tolerance: f64,
    /// Weight of the squared tensions, as displacements of their own tendons, against the squared tip
    /// error [-]: chooses among the strokes that reach the goal.
    pub regularisation: f64,
    /// Part of the distance that is left by which one of two rounds in a row must bring the tip closer for another to
    /// follow [-]. With zero a goal out of reach is approached as closely as the bounds allow.
    pub least_gain: f64,
}

/// How a goal was met.
#[derive(Debug, Clone, PartialEq)]
pub struct ReachReport {
    /// Stroke of every tendon [m]: commanding these gives the same equilibrium.
    pub strokes: Vec<f64>,
    /// Distance of the tip from the goal, in the coordinates that it has [m].
    pub tip_error: f64,
    /// True within the tolerance; otherwise the bounds leave no way closer.
    pub is_reached: bool,
    /// QPs solved, one forward step each.
    pub rounds: usize,
    /// The forward steps: what they cost in all, and how well the last converged.
    pub step: StepReport,
}

const MAX_ROUNDS: usize = 40;
/// Stroke change below which nothing more is gained [m].
const NEGLIGIBLE_STROKE: f64 = 1e-9;
/// Longest stroke change of a round, relative to the shortest tendon.
const LONGEST_STROKE: f64 = 0.05;
/// Rounds in a row that bring the tip hardly closer. One may: where a tendon goes slack.
const MAX_SLOW_ROUNDS: usize = 2;
/// Times a round may be halved when it brings the tip no closer.
const MAX_HALVINGS: usize = 6;

impl Stepper {
    /// Goes on to an equilibrium with the tip at `goal`: tendons given as [`Target::Free`] take
    /// with any strokes that this needs; the others keep their targets.
    ///
    /// # Errors
    /// No free tendon; those of [`Stepper::step`]. A goal out of reach is not an error, nor one that friction keeps the
    /// search from: see [`ReachReport::is_reached`].
    pub fn reach(&mut self, twin: &Twin, goal: &TipGoal, targets: &[Target]) -> Result<ReachReport> {
        if !targets.contains(&Target::Free) {
            return Err(BadInput::new("targets", "at least one free tendon", "none")
                .hint("drive = \"free\" lets the inverse problem choose a tendon's stroke")
                .into());
        }
        if let Some(found) = goal.position.iter().flatten().find(|c| !c.is_finite()) {
            return Err(BadInput::new("goal", "finite coordinates", found.to_string()).into());
        }
        check_targets(twin, targets)?;
        let mut commands = self.held_strokes(twin, targets);
        let mut step = self.step(twin, &commands)?;
        let response =
            self.response(twin, TipMotion::Displacement).ok_or_else(|| singular(step.relative_residual))?;
        let mut problem = EffectorQp::new(twin, response);
        let mut error = distance(goal, twin, self.state());
        let (mut rounds, mut slow_rounds) = (0, 0);
        while error > goal.tolerance && rounds < MAX_ROUNDS {
            rounds += 1;
            let Some(increments) = problem.solve(twin, goal, targets, self.state()) else { break };
            let before = (self.state().clone(), error);
            let mut part = 1.0;
            for halving in 0..=MAX_HALVINGS {
                part *= problem.command(twin, targets, &before.0, &increments, part, &mut commands);
                match self.step(twin, &commands) {
                    Ok(report) => step = step.followed_by(&report),
                    Err(Error::NoEquilibrium { .. }) => {}
                    Err(other) => return Err(other),
                }
                error = distance(goal, twin, self.state());
                if error < before.1 || halving == MAX_HALVINGS {
                    break;
                }
                self.restore(twin, &before.0)?;
                part *= 0.5;
            }
            if error >= before.1 {
                self.restore(twin, &before.0)?;
                error = before.1;
                break;
            }
            problem.learn(twin, &increments, &before.0, self.state());
            slow_rounds = if before.1 - error < goal.least_gain * before.1 { slow_rounds + 1 } else { 0 };
            if slow_rounds == MAX_SLOW_ROUNDS
                || problem.longest_stroke(&increments) * part < NEGLIGIBLE_STROKE
            {
                break;
            }
        }
        Ok(ReachReport {
            strokes: twin.commands_of(self.state()),
            tip_error: error,
            is_reached: error <= goal.tolerance,
            rounds,
            step,
        })
    }

    /// The targets with free tendons held where they are.
    fn held_strokes(&self, twin: &Twin, targets: &[Target]) -> Vec<Target> {
        let strokes = twin.commands_of(self.state());
        let held = |(j, target): (usize, &Target)| match target {
            Target::Free => Target::Stroke(strokes[j]),
            other => *other,
        };
        targets.iter().enumerate().map(held).collect()
    }
}

fn distance(goal: &TipGoal, twin: &Twin, state: &TwinState) -> f64 {
    let tip = twin.tip_of(state);
    let squares =
        goal.position.iter().zip(tip).filter_map(|(goal, tip)| Some((goal.as_ref()? - tip).powi(2)));
    squares.sum::<f64>().sqrt()
}

/// W of the tendons and of the tip at some configuration.
struct EffectorQp {
    /// Tendon rows, row-major n × n [m/N].
    delassus: Vec<f64>,
    /// Tip rows, 3 × n [m/N].
    tip_rows: [Vec<f64>; 3],
    /// Length of the body's displacements [m], which makes the QP dimensionless.
    length: f64,
}

impl EffectorQp {
    fn new(twin: &Twin, response: TensionResponse) -> Self {
        Self {
            delassus: response.delassus,
            tip_rows: response.tip,
            length: LONGEST_STROKE * twin.cables.rest_lengths.iter().copied().fold(f64::INFINITY, f64::min),
        }
    }

    fn compliance(&self, j: usize) -> f64 {
        self.delassus[j * (self.tip_rows[0].len() + 1)]
    }

    /// Tension that counts as none: it stretches its tendon by a millionth of the body's displacements.
    fn negligible_tension(&self, j: usize) -> f64 {
        1e-6 * self.length / self.compliance(j)
    }

    fn stroke_change(&self, j: usize, increments: &[f64]) -> f64 {
        let n = increments.len();
        (0..n).map(|k| self.delassus[j * n + k] * increments[k]).sum()
    }

    fn longest_stroke(&self, increments: &[f64]) -> f64 {
        (0..increments.len()).map(|j| self.stroke_change(j, increments).abs()).fold(0.0, f64::max)
    }

    /// Tension increments [N], or `None` where the QP has no solution.
    ///
    /// Unknowns are y_j = λ_j W_jj / length.
    fn solve(&self, twin: &Twin, goal: &TipGoal, targets: &[Target], state: &TwinState) -> Option<Vec<f64>> {
        let n = self.tip_rows[0].len();
        let tip = twin.tip_of(state);
        let strokes = twin.commands_of(state);
        let unit: Vec<f64> = (0..n).map(|j| self.length / self.compliance(j)).collect();
        let row = |w: &[f64]| -> Vec<f64> { (0..n).map(|k| w[k] * unit[k] / self.length).collect() };
        let effector = self.tip_rows.each_ref().map(|w| row(w));
        let mut qp = RowQp {
            hessian: vec![0.0; n * n],
            linear: vec![0.0; n],
            bounds: Vec::new(),
            rows: Vec::new(),
            row_bounds: Vec::new(),
        };
        for i in 0..n {
            for c in 0..3 {
                let Some(position) = goal.position[c] else { continue };
                qp.linear[i] -= effector[c][i] * (position - tip[c]) / self.length;
                for j in 0..n {
                    qp.hessian[i * n + j] += effector[c][i] * effector[c][j];
                }
            }
            // Friction points keep their jump, as if their tendons slipped on: held ones would allow no first move.
            let Some(target) = targets.get(i) else {
                qp.bounds.push([0.0; 2]);
                continue;
            };
            qp.hessian[i * n + i] += goal.regularisation;
            qp.linear[i] += goal.regularisation * state.tensions[i] / unit[i];
            let bounds = twin.tendons[i].tension;
            // On the verge of it counts as slack: else a held stroke would keep its tendon there.
            let slack = state.tensions[i] - bounds.min <= self.negligible_tension(i);
            qp.bounds.push(match target {
                Target::Tension(_) => [0.0; 2],
                Target::Stroke(_) if slack => [0.0; 2],
                _ => [bounds.min, bounds.max].map(|bound| (bound - state.tensions[i]) / unit[i]),
            });
            let held = match target {
                Target::Stroke(_) if !slack => [0.0; 2],
                Target::Free => {
                    let bounds = twin.tendons[i].stroke;
                    [bounds.min, bounds.max].map(|bound| (bound - strokes[i]) / self.length)
                }
                _ => continue,
            };
            qp.rows.push(row(&self.delassus[i * n..(i + 1) * n]));
            qp.row_bounds.push(held);
        }
        let (y, status) = solve_rows(&qp);
        (status == QpStatus::Solved).then(|| (0..n).map(|j| y[j] * unit[j]).collect())
    }

    /// Writes the commands of a round: `part` of the increments, less where a stroke would move too far.
    /// Returns the factor by which it was shortened.
    fn command(
        &self,
        twin: &Twin,
        targets: &[Target],
        state: &TwinState,
        increments: &[f64],
        part: f64,
        commands: &mut [Target],
    ) -> f64 {
        let strokes = twin.commands_of(state);
        let shortened = (self.length / (part * self.longest_stroke(increments))).min(1.0);
        for j in 0..targets.len() {
            if targets[j] == Target::Free {
                let bounds = twin.tendons[j].tension;
                let tension = state.tensions[j] + part * shortened * increments[j];
                commands[j] = if tension - bounds.min <= self.negligible_tension(j) {
                    Target::Tension(bounds.min)
                } else {
                    let stroke = strokes[j] + part * shortened * self.stroke_change(j, increments);
                    Target::Stroke(twin.tendons[j].stroke.clamp(stroke))
                };
            }
        }
        shortened
    }

    /// Broyden's update of the tip rows: they must reproduce the move just made.
    fn learn(&mut self, twin: &Twin, increments: &[f64], before: &TwinState, after: &TwinState) {
        let n = increments.len();
        let made: Vec<f64> = (0..n).map(|j| after.tensions[j] - before.tensions[j]).collect();
        let weight = |j: usize| self.compliance(j).powi(2);
        let size: f64 = (0..n).map(|j| weight(j) * made[j] * made[j]).sum();
        if size == 0.0 {
            return;
        }
        let weights: Vec<f64> = (0..n).map(weight).collect();
        let (from, to) = (twin.tip_of(before), twin.tip_of(after));
        for c in 0..3 {
            let expected: f64 = (0..n).map(|j| self.tip_rows[c][j] * made[j]).sum();
            let missed = to[c] - from[c] - expected;
            for j in 0..n {
                self.tip_rows[c][j] += missed * weights[j] * made[j] / size;
            }
        }
    }
}

//! Statuses of a tendon's guides where the simple active set cycles: nested policy iteration.
//!
//! With g⁺, g⁻ the residuals of guide j from sliding towards the pulley and from sliding back, the guides'
//! law is max(g⁺, min(g⁻, c (u_j(before) - u_j))) = 0. Every choice in it (which side of max and min, which
//! segment is taut) gives linear equations whose matrix is an M-matrix, once slack segments keep a trace of
//! stiffness: parts of the tendon between two slack segments would float otherwise. So the inner iteration
//! over the choices of the minimum and the outer one over those of the maximum are both monotone and end
//! (Howard's algorithm, twice).

use crate::policy::GuideChoices;
use crate::tendon::{Guide, ROUNDING, TendonModel, TendonTrial};

/// Stiffness of a slack segment over that of a taut one, in here only.
const TRACE: f64 = 1e-9;
/// Choices tried at most, inner and outer; a handful is usual.
const MAX_ROUNDS: usize = 60;

impl TendonModel {
    /// Finds statuses, slips and tensions; scratch of the linear solver is overwritten.
    pub(crate) fn solve_by_policies(&self, lengths: &[f64], trial: &mut TendonTrial) {
        let m = self.n_segments();
        trial.policy[1..m].fill(GuideChoices { is_stuck: true, ..GuideChoices::default() });
        for j in 1..m {
            trial.slips[j] = self.slips[j];
        }
        for _ in 0..MAX_ROUNDS {
            for _ in 0..MAX_ROUNDS {
                self.solve_policies(lengths, trial);
                if !self.improve(lengths, trial, Player::Minimum) {
                    break;
                }
            }
            if !self.improve(lengths, trial, Player::Maximum) {
                break;
            }
        }
        for j in 1..m {
            let policy = trial.policy[j];
            trial.guides[j] = match (policy.is_pulling, policy.is_stuck) {
                (true, _) => Guide::Pulls,
                (_, true) => Guide::Sticks,
                _ => Guide::Releases,
            };
        }
        for i in 0..m {
            let stretch = self.stretch(lengths, &trial.slips, i);
            trial.is_taut[i] = stretch > 0.0;
            trial.tensions[i] = self.stiffness[i] * stretch.max(0.0);
        }
    }

    /// Stiffnesses of the segments before and after guide j as its policy has them [N/m].
    fn sides(&self, policy: GuideChoices, j: usize) -> (f64, f64) {
        let k = |is_taut: bool, i: usize| self.stiffness[i] * if is_taut { 1.0 + TRACE } else { TRACE };
        (k(policy.is_left_taut, j - 1), k(policy.is_right_taut, j))
    }

    fn solve_policies(&self, lengths: &[f64], trial: &mut TendonTrial) {
        let m = self.n_segments();
        let c = |i: usize| lengths[i] - self.spec.rest_lengths[i];
        for j in 1..m {
            let policy = trial.policy[j];
            let (left, right, constant) = if !policy.is_pulling && policy.is_stuck {
                (0.0, 0.0, self.slips[j])
            } else {
                let guide = if policy.is_pulling { Guide::Pulls } else { Guide::Releases };
                let (a, b, f) = self.demand(guide, trial.factors[j]);
                let (k1, k2) = self.sides(policy, j);
                (a * k1, b * k2, a * k1 * c(j - 1) - b * k2 * c(j) - f)
            };
            let previous = if j == 1 { trial.slips[0] } else { trial.right[j - 1] };
            if left + right > 0.0 {
                trial.pivot[j] = right + left * trial.defect[j - 1];
                trial.defect[j] = left * trial.defect[j - 1] / trial.pivot[j];
            } else {
                (trial.pivot[j], trial.defect[j]) = (1.0, 1.0);
            }
            trial.upper[j] = right / trial.pivot[j];
            trial.right[j] = (constant + left * previous) / trial.pivot[j];
        }
        for j in (1..m).rev() {
            trial.slips[j] = trial.right[j] + trial.upper[j] * trial.slips[j + 1];
        }
    }

    /// Updates the choice of one player at the present slips; returns whether any choice changed by more than rounding.
    fn improve(&self, lengths: &[f64], trial: &mut TendonTrial, player: Player) -> bool {
        let m = self.n_segments();
        let mut has_changed = false;
        for j in 1..m {
            let policy = trial.policy[j];
            let (s1, s2) =
                (self.stretch(lengths, &trial.slips, j - 1), self.stretch(lengths, &trial.slips, j));
            let (k1, k2) = (self.stiffness[j - 1], self.stiffness[j]);
            let tension = |k: f64, s: f64, is_taut: bool| k * (TRACE * s + if is_taut { s } else { 0.0 });
            let back = (k1 + k2) * (self.slips[j] - trial.slips[j]);
            let miss = |policy: GuideChoices| {
                let demanded = |guide| {
                    let (a, b, f) = self.demand(guide, trial.factors[j]);
                    a * tension(k1, s1, policy.is_left_taut) - b * tension(k2, s2, policy.is_right_taut) - f
                };
                match (policy.is_pulling, policy.is_stuck) {
                    (true, _) => demanded(Guide::Pulls),
                    (_, true) => back,
                    _ => demanded(Guide::Releases),
                }
            };
            let next = match player {
                Player::Minimum => {
                    let taut = GuideChoices { is_right_taut: s2 > 0.0, ..policy };
                    let (stuck, free) =
                        (GuideChoices { is_stuck: true, ..taut }, GuideChoices { is_stuck: false, ..taut });
                    if miss(free) < miss(stuck) { free } else { stuck }
                }
                Player::Maximum => {
                    let taut = GuideChoices { is_left_taut: s1 > 0.0, is_right_taut: s2 > 0.0, ..policy };
                    let pulling = GuideChoices { is_pulling: true, ..taut };
                    // The minimum answers to each choice.
                    let free = GuideChoices { is_pulling: false, is_stuck: false, ..taut };
                    let stuck = GuideChoices { is_stuck: true, ..free };
                    let other = if miss(free) < miss(stuck) { free } else { stuck };
                    if miss(pulling) > miss(other) { pulling } else { other }
                }
            };
            let room = 10.0 * ROUNDING * (k1 * lengths[j - 1] + k2 * lengths[j]);
            // Choices that make no difference here are free to follow.
            has_changed |= (miss(next) - miss(policy)).abs() > room;
            trial.policy[j] = next;
        }
        has_changed
    }
}

/// Who chooses.
#[derive(Clone, Copy)]
enum Player {
    Minimum,
    Maximum,
}

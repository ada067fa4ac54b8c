//! Who sticks and who slides in one step: speeds that minimise ½ wᵀA w − bᵀw + Σ d_i |w_i|, exactly zero where friction holds.
//!
//! A couples the rotor of each joint with its link, and the links with each other; it is positive definite, so there is one answer.
//! Statuses of the step before are tried first: with them the speeds are those of a linear system, and friction decides whether they
//! were right. Where they cycle, coordinate descent with its soft threshold finds them, which always converges.

use super::chain::N_JOINTS;

/// Rotors, then links.
pub const N_SPEEDS: usize = 2 * N_JOINTS;

/// One step's balance.
#[derive(Debug, Clone, Copy)]
pub struct StictionProblem {
    /// Diagonal of A of the rotors [N m s].
    pub rotors: [f64; N_JOINTS],
    /// −A between rotor and link of each joint [N m s].
    pub coupling: [f64; N_JOINTS],
    /// A of the links [N m s].
    pub links: [[f64; N_JOINTS]; N_JOINTS],
    /// b [N m].
    pub push: [f64; N_SPEEDS],
    /// d: dry friction [N m].
    pub dry: [f64; N_SPEEDS],
}

/// Friction state of each speed: 0 where it sticks, else the sign of the motion.
pub type Statuses = [f64; N_SPEEDS];

/// Changes of statuses before coordinate descent is asked.
const MAX_CHANGES: usize = 8;
/// Sweeps of coordinate descent in the first and in the last attempt.
const SWEEPS: [usize; 3] = [20, 200, 2000];

impl StictionProblem {
    /// The speeds; `statuses` are a first guess, and then those found.
    pub fn solve(&self, statuses: &mut Statuses) -> [f64; N_SPEEDS] {
        for _ in 0..MAX_CHANGES {
            let speeds = self.sliding(statuses);
            let found = self.found(statuses, &speeds);
            if found == *statuses {
                return speeds;
            }
            *statuses = found;
        }
        let mut speeds = [0.0; N_SPEEDS];
        for sweeps in SWEEPS {
            (0..sweeps).for_each(|_| self.sweep(&mut speeds));
            *statuses = speeds.map(|w| if w == 0.0 { 0.0 } else { w.signum() });
            let exact = self.sliding(statuses);
            if self.found(statuses, &exact) == *statuses {
                return exact;
            }
        }
        speeds
    }

    /// Speeds for given statuses.
    fn sliding(&self, statuses: &Statuses) -> [f64; N_SPEEDS] {
        let slid = |i: usize| self.push[i] - statuses[i] * self.dry[i];
        let mut matrix = self.links;
        let mut right = [0.0; N_JOINTS];
        for k in 0..N_JOINTS {
            right[k] = slid(N_JOINTS + k);
            if statuses[k] != 0.0 {
                let share = self.coupling[k] / self.rotors[k];
                matrix[k][k] -= share * self.coupling[k];
                right[k] += share * slid(k);
            }
        }
        let sticks: [bool; N_JOINTS] = std::array::from_fn(|k| statuses[N_JOINTS + k] == 0.0);
        let links = solve_positive(matrix, right, &sticks);
        std::array::from_fn(|i| match i.checked_sub(N_JOINTS) {
            Some(k) => links[k],
            None if statuses[i] == 0.0 => 0.0,
            None => (slid(i) + self.coupling[i] * links[i]) / self.rotors[i],
        })
    }

    /// Friction torque required at coordinate `i` for zero speed there, the other speeds fixed [N m].
    fn held(&self, i: usize, speeds: &[f64; N_SPEEDS]) -> f64 {
        match i.checked_sub(N_JOINTS) {
            None => self.push[i] + self.coupling[i] * speeds[N_JOINTS + i],
            Some(k) => {
                let others =
                    (0..N_JOINTS).filter(|j| *j != k).map(|j| self.links[k][j] * speeds[N_JOINTS + j]);
                self.push[i] + self.coupling[k] * speeds[k] - others.sum::<f64>()
            }
        }
    }

    /// Torque of friction against the motion of coordinate `i` [N m].
    pub fn friction(&self, i: usize, speeds: &[f64; N_SPEEDS]) -> f64 {
        if speeds[i] == 0.0 {
            self.held(i, speeds).clamp(-self.dry[i], self.dry[i])
        } else {
            self.dry[i].copysign(speeds[i])
        }
    }

    /// The statuses that speeds, solved for `statuses`, ask for.
    fn found(&self, statuses: &Statuses, speeds: &[f64; N_SPEEDS]) -> Statuses {
        std::array::from_fn(|i| {
            if statuses[i] == 0.0 {
                let held = self.held(i, speeds);
                if held.abs() <= self.dry[i] { 0.0 } else { held.signum() }
            } else if speeds[i] * statuses[i] > 0.0 {
                statuses[i]
            } else {
                0.0
            }
        })
    }

    fn sweep(&self, speeds: &mut [f64; N_SPEEDS]) {
        for i in 0..N_SPEEDS {
            let held = self.held(i, speeds);
            let diagonal = match i.checked_sub(N_JOINTS) {
                None => self.rotors[i],
                Some(k) => self.links[k][k],
            };
            let beyond = (held.abs() - self.dry[i]).max(0.0);
            speeds[i] = if beyond == 0.0 { 0.0 } else { beyond.copysign(held) / diagonal };
        }
    }
}

/// Solves a positive definite system by L D Lᵀ; unknowns that are `zero` are left out.
fn solve_positive(
    mut a: [[f64; N_JOINTS]; N_JOINTS],
    mut b: [f64; N_JOINTS],
    zero: &[bool; N_JOINTS],
) -> [f64; N_JOINTS] {
    for k in (0..N_JOINTS).filter(|k| zero[*k]) {
        b[k] = 0.0;
        for j in 0..N_JOINTS {
            (a[k][j], a[j][k]) = (0.0, 0.0);
        }
        a[k][k] = 1.0;
    }
    for k in 0..N_JOINTS {
        for i in k + 1..N_JOINTS {
            let share = a[i][k] / a[k][k];
            for j in k + 1..=i {
                a[i][j] -= share * a[j][k];
            }
            b[i] -= share * b[k];
        }
    }
    for k in (0..N_JOINTS).rev() {
        for i in k + 1..N_JOINTS {
            b[k] -= a[i][k] * b[i];
        }
        b[k] /= a[k][k];
    }
    b
}

//! Velocities with dry friction and stops: which joints slide, stick or stop.
//!
//! Minimises ½ vᵀ A v − pᵀ v + Σ f_i |v_i| within bounds that hold zero. A few sweeps of coordinate descent with a soft threshold guess the
//! active set; a primal active-set method goes on from there, which mostly confirms it, and ends for any A that is positive definite.
//!
//! # Reference
//! Nocedal, Wright (2006), Numerical Optimization, section 16.5.

use crate::dense;

/// Sweeps of coordinate descent, which find the active set of a well-conditioned problem.
const SWEEPS: usize = 8;
/// Changes of the active set for each joint, after which it is taken as it is; a few are usual.
const MAX_CHANGES: usize = 20;
/// Rounding of a sum of some tens of terms, relative to their sizes.
const ROUNDING: f64 = 1e-13;

/// Contact state of a joint: slip, stick or end stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ContactState {
    /// Slides this way, or moves without friction: 1, −1.
    Slides(f64),
    /// Stands still.
    Sticks,
    /// Reaches the lower (0) or upper (1) end of its range.
    Stops(usize),
}

/// One problem at a time, with scratch that is allocated once.
#[derive(Debug, Clone)]
pub(crate) struct BoxQp {
    /// A (n × n, row by row).
    pub mass: Vec<f64>,
    /// p.
    pub pull: Vec<f64>,
    /// f, not negative.
    pub dry: Vec<f64>,
    /// Velocities between which the joints stay, zero among them.
    pub bounds: Vec<[f64; 2]>,
    /// Velocities: a guess, then the solution.
    pub speeds: Vec<f64>,
    /// The active set of the solution.
    pub contacts: Vec<ContactState>,
    rows: Vec<usize>,
    part: Vec<f64>,
    side: Vec<f64>,
}

impl BoxQp {
    /// For `n` joints.
    pub fn new(n: usize) -> Self {
        Self {
            mass: vec![0.0; n * n],
            pull: vec![0.0; n],
            dry: vec![0.0; n],
            bounds: vec![[0.0; 2]; n],
            speeds: vec![0.0; n],
            contacts: vec![ContactState::Sticks; n],
            rows: Vec::with_capacity(n),
            part: Vec::with_capacity(n * n),
            side: Vec::with_capacity(n),
        }
    }

    /// Fills in the solution, which depends on the problem and the guess alone.
    pub fn solve(&mut self) {
        if self.dry.iter().all(|dry| *dry == 0.0) {
            self.contacts.fill(ContactState::Slides(1.0));
            self.solve_sliding();
            if self.is_consistent() {
                return self.take_sliding();
            }
        }
        for sweep in 0..SWEEPS {
            if self.sweep() && sweep > 0 {
                break;
            }
        }
        self.descend();
    }

    /// Changes the active set one joint at a time from the velocities at hand: the cost falls with every change, until no joint that
    /// is at rest is loaded beyond its friction.
    fn descend(&mut self) {
        let n = self.pull.len();
        for _ in 0..MAX_CHANGES * n {
            self.solve_sliding();
            if self.block() {
                continue;
            }
            self.take_sliding();
            if !self.release() {
                return;
            }
        }
    }

    /// Moves towards the solution of the sliding joints until one of them stops; returns whether one does.
    fn block(&mut self) -> bool {
        let mut first = (1.0, None);
        for (&i, x) in self.rows.iter().zip(&self.side) {
            let (v, [mut low, mut high]) = (self.speeds[i], self.bounds[i]);
            if let (ContactState::Slides(sign), true) = (self.contacts[i], self.dry[i] > 0.0) {
                (low, high) = if sign > 0.0 { (0.0, high) } else { (low, 0.0) };
            }
            let end = if *x < low { low } else { high };
            if *x < low || *x > high {
                let part = ((end - v) / (x - v)).max(0.0);
                if part < first.0 {
                    first = (part, Some((i, end)));
                }
            }
        }
        let (part, Some((at, end))) = first else { return false };
        for (&i, x) in self.rows.iter().zip(&self.side) {
            self.speeds[i] += part * (x - self.speeds[i]);
        }
        self.speeds[at] = end;
        self.contacts[at] = match end {
            0.0 => ContactState::Sticks,
            end => ContactState::Stops(usize::from(end > 0.0)),
        };
        true
    }

    /// Lets the joint slide that is pulled hardest beyond what holds it; whether there is one.
    fn release(&mut self) -> bool {
        let n = self.pull.len();
        let mut hardest = (0.0, None);
        for i in 0..n {
            let row = &self.mass[n * i..n * (i + 1)];
            let (mut force, mut size) = (self.pull[i], self.pull[i].abs());
            for (a, v) in row.iter().zip(&self.speeds) {
                force -= a * v;
                size += (a * v).abs();
            }
            let (excess, sign) = match self.contacts[i] {
                ContactState::Slides(_) => continue,
                ContactState::Sticks => (force.abs() - self.dry[i], force.signum()),
                ContactState::Stops(end) => {
                    let outwards = if end == 1 { 1.0 } else { -1.0 };
                    (self.dry[i] - outwards * force, outwards)
                }
            };
            // At rest at the end of its range, a joint is free inwards only.
            let is_free =
                self.contacts[i] != ContactState::Sticks || self.bounds[i][usize::from(sign > 0.0)] != 0.0;
            if is_free && excess > ROUNDING * size && excess / row[i].sqrt() > hardest.0 {
                hardest = (excess / row[i].sqrt(), Some((i, sign)));
            }
        }
        let (_, Some((i, sign))) = hardest else { return false };
        self.contacts[i] = ContactState::Slides(sign);
        true
    }

    /// Minimises over one velocity after the other; whether every contact stays as it was.
    fn sweep(&mut self) -> bool {
        let n = self.pull.len();
        let mut is_same = true;
        for i in 0..n {
            let row = &self.mass[n * i..n * (i + 1)];
            let v = self.speeds[i];
            let others: f64 = row.iter().zip(&self.speeds).map(|(a, v)| a * v).sum::<f64>() - row[i] * v;
            let (pull, dry, [low, high]) = (self.pull[i] - others, self.dry[i], self.bounds[i]);
            let sliding = if pull.abs() <= dry { 0.0 } else { (pull - dry * pull.signum()) / row[i] };
            self.speeds[i] = sliding.clamp(low, high);
            let contact = match self.speeds[i] {
                0.0 => ContactState::Sticks,
                v if v == sliding || v.is_nan() => ContactState::Slides(v.signum()),
                v => ContactState::Stops(usize::from(v > 0.0)),
            };
            is_same &= contact == self.contacts[i];
            self.contacts[i] = contact;
        }
        is_same
    }

    /// Solves for the joints that slide, exactly, with the others at rest: joints into `rows`, velocities into `side`.
    fn solve_sliding(&mut self) {
        let n = self.pull.len();
        self.rows.clear();
        self.part.clear();
        self.side.clear();
        for i in 0..n {
            let ContactState::Slides(sign) = self.contacts[i] else { continue };
            let mut side = self.pull[i] - sign * self.dry[i];
            for j in 0..n {
                match self.contacts[j] {
                    ContactState::Slides(_) => self.part.push(self.mass[n * i + j]),
                    ContactState::Sticks => {}
                    ContactState::Stops(end) => side -= self.mass[n * i + j] * self.bounds[j][end],
                }
            }
            self.rows.push(i);
            self.side.push(side);
        }
        if !self.rows.is_empty() {
            dense::factor(self.rows.len(), &mut self.part);
            dense::solve_columns(self.rows.len(), &self.part, &mut self.side);
        }
    }

    /// Whether what sliding does so in the direction assumed and within its bounds.
    fn is_consistent(&self) -> bool {
        self.rows.iter().zip(&self.side).all(|(&i, x)| {
            (self.dry[i] == 0.0 || self.contacts[i] == ContactState::Slides(x.signum()))
                && (self.bounds[i][0]..=self.bounds[i][1]).contains(x)
        })
    }

    fn take_sliding(&mut self) {
        for (&i, x) in self.rows.iter().zip(&self.side) {
            self.speeds[i] = *x;
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;

    /// A problem of `n` joints whose matrix has eigenvalues over four decades, as arms of seven joints have.
    fn drawn(n: usize, seed: u64) -> BoxQp {
        let mut random = hysteron_base::rng(seed, "box-qp");
        let mut draw = |most: f64| random.random_range(-most..most);
        let mut qp = BoxQp::new(n);
        let factor: Vec<f64> = (0..n * n).map(|_| draw(1.0)).collect();
        let scale: Vec<f64> = (0..n).map(|k| 10_f64.powf(-2.0 * k as f64 / n as f64)).collect();
        for i in 0..n {
            for j in 0..n {
                let sum: f64 = (0..n).map(|k| factor[n * i + k] * factor[n * j + k]).sum();
                qp.mass[n * i + j] = scale[i] * scale[j] * (sum + if i == j { 0.1 } else { 0.0 });
            }
            qp.pull[i] = scale[i] * draw(1.0);
            qp.dry[i] = scale[i] * draw(0.3).max(0.0);
            qp.bounds[i] = [-draw(3.0).abs(), draw(3.0).abs()];
            qp.speeds[i] = draw(1.0);
        }
        qp
    }

    #[test]
    fn the_solution_is_the_minimum() {
        let mut found = [0; 3];
        for seed in 0..2000 {
            let n = 1 + (seed % 8) as usize;
            let mut qp = drawn(n, seed);
            qp.solve();
            for i in 0..n {
                let row = &qp.mass[n * i..n * (i + 1)];
                let force: f64 = qp.pull[i] - row.iter().zip(&qp.speeds).map(|(a, v)| a * v).sum::<f64>();
                let size: f64 =
                    qp.pull[i].abs() + row.iter().zip(&qp.speeds).map(|(a, v)| (a * v).abs()).sum::<f64>();
                // Rounding of the solution, through a matrix of condition 1e6 at most.
                let tolerance = 1e-9 * size.max(1e-3);
                let ([low, high], v, dry) = (qp.bounds[i], qp.speeds[i], qp.dry[i]);
                assert!((low..=high).contains(&v), "{seed}: {v} within {low} to {high}");
                let right = match qp.contacts[i] {
                    ContactState::Slides(sign) => {
                        (force - sign * dry).abs() <= tolerance && (dry == 0.0 || sign * v >= 0.0)
                    }
                    ContactState::Sticks => v == 0.0 && force.abs() <= dry + tolerance,
                    ContactState::Stops(end) => {
                        let outwards = if end == 1 { 1.0 } else { -1.0 };
                        v == [low, high][end] && outwards * force >= dry - tolerance
                    }
                };
                assert!(right, "{seed}: joint {i}: {:?}, {force} against {dry}", qp.contacts[i]);
                let kind = match qp.contacts[i] {
                    ContactState::Slides(_) => 0,
                    ContactState::Sticks => 1,
                    ContactState::Stops(_) => 2,
                };
                found[kind] += 1;
            }
        }
        assert!(found.iter().all(|n| *n > 500), "{found:?}");
    }
}

//! Motion with dry friction and joint limits.
//!
//! The velocity after a substep minimises ½ (v − v_free)ᵀ A (v − v_free) + h Σ f_i |v_i| within the velocities that keep
//! every joint in its range, A = M + hD: the friction of a joint is f_i against its motion, or whatever up to f_i keeps it at rest. In
//! impulses this is the box QP |p_i| ≤ h f_i on A⁻¹. Where a joint sticks its velocity is exactly zero.

use crate::crba::fill_mass_matrix;
use crate::rnea::bias_torque;
use crate::{Data, ExternalForce, Model, dense};

/// Sweeps after which the best velocities found so far are taken.
const MOST_SWEEPS: usize = 200;

/// Whether joints stop at the ends of their ranges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stops {
    /// A joint that reaches the end of its range stops there without rebound.
    Rigid,
    /// Joints move through.
    None,
}

/// Advances the state of an arm by a fixed time, with friction and stops.
#[derive(Debug, Clone)]
pub struct Simulator<'m> {
    model: &'m Model,
    data: Data<f64>,
    /// Length of a substep [s].
    period: f64,
    substeps: usize,
    stops: Stops,
    mass: Vec<f64>,
    factor: Vec<f64>,
    free: Vec<f64>,
    /// A v_free.
    pull: Vec<f64>,
    bounds: Vec<[f64; 2]>,
    states: Vec<Contact>,
    rows: Vec<usize>,
    part: Vec<f64>,
    side: Vec<f64>,
}

/// What holds a joint's velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Contact {
    /// Slides this way, or moves without friction: 1, −1.
    Slides(f64),
    /// Stands at this velocity: stuck, or at a stop.
    Stands(f64),
}

impl<'m> Simulator<'m> {
    /// Steps of `period` [s], each in `substeps` equal parts.
    pub fn new(model: &'m Model, period: f64, substeps: usize, stops: Stops) -> Self {
        assert!(period > 0.0 && substeps > 0, "{substeps} substeps of {period} s");
        let (n, h) = (model.n_joints(), period / substeps as f64);
        let mut data = Data::new(model, 0.0);
        for (armature, joint) in data.armature.iter_mut().zip(&model.joints) {
            *armature += h * joint.drive.damping;
        }
        Self {
            model,
            data,
            period: h,
            substeps,
            stops,
            mass: vec![0.0; n * n],
            factor: vec![0.0; n * n],
            free: vec![0.0; n],
            pull: vec![0.0; n],
            bounds: vec![[0.0; 2]; n],
            states: vec![Contact::Slides(1.0); n],
            rows: Vec::with_capacity(n),
            part: Vec::with_capacity(n * n),
            side: Vec::with_capacity(n),
        }
    }

    /// Advances `q`, `dq` by one period under constant torques and external forces.
    pub fn step(&mut self, [q, dq]: [&mut [f64]; 2], tau: &[f64], external: &[ExternalForce<f64>]) {
        for _ in 0..self.substeps {
            self.find_free(q, dq, tau, external);
            self.find_bounds(q);
            self.project(dq);
            for (q, dq) in q.iter_mut().zip(&*dq) {
                *q += self.period * dq;
            }
            self.settle(q, dq);
        }
    }

    /// Velocities without friction and stops.
    fn find_free(&mut self, q: &[f64], dq: &[f64], tau: &[f64], external: &[ExternalForce<f64>]) {
        let (n, h) = (q.len(), self.period);
        bias_torque(self.model, &mut self.data, [q, dq], external, &mut self.free);
        fill_mass_matrix(self.model, &mut self.data, &mut self.mass);
        self.factor.copy_from_slice(&self.mass);
        dense::factor(n, &mut self.factor);
        for i in 0..n {
            self.free[i] = h * (tau[i] - self.free[i] - self.model.joints[i].drive.damping * dq[i]);
        }
        // A v_free = A v + h (…).
        for i in 0..n {
            let row = &self.mass[n * i..n * (i + 1)];
            self.pull[i] = self.free[i] + row.iter().zip(dq).map(|(a, v)| a * v).sum::<f64>();
        }
        self.free.copy_from_slice(&self.pull);
        dense::solve_columns(n, &self.factor, &mut self.free);
    }

    /// Velocities that end a substep within the ranges.
    fn find_bounds(&mut self, q: &[f64]) {
        for ((bounds, joint), q) in self.bounds.iter_mut().zip(&self.model.joints).zip(q) {
            *bounds = match (self.stops, joint.drive.range) {
                (Stops::Rigid, Some([low, high])) => {
                    [((low - q) / self.period).min(0.0), ((high - q) / self.period).max(0.0)]
                }
                _ => [f64::NEG_INFINITY, f64::INFINITY],
            };
        }
    }

    /// Puts joints that stop on the ends of their ranges, free of rounding.
    fn settle(&self, q: &mut [f64], dq: &mut [f64]) {
        for (i, contact) in self.states.iter().enumerate() {
            let Some([low, high]) = self.model.joints[i].drive.range else { continue };
            if let Contact::Stands(v) = contact
                && *v != 0.0
            {
                q[i] = if *v < 0.0 { low } else { high };
                dq[i] = 0.0;
            }
        }
    }

    /// The velocities with friction and stops, from those without.
    fn project(&mut self, v: &mut [f64]) {
        let n = v.len();
        let (model, period) = (self.model, self.period);
        let dry = |i: usize| period * model.joints[i].drive.dry_friction;
        let free =
            (0..n).all(|i| dry(i) == 0.0 && (self.bounds[i][0]..=self.bounds[i][1]).contains(&self.free[i]));
        if free {
            v.copy_from_slice(&self.free);
            self.states.fill(Contact::Slides(1.0));
            return;
        }
        for _ in 0..MOST_SWEEPS {
            let mut is_same = true;
            for i in 0..n {
                let row = &self.mass[n * i..n * (i + 1)];
                let others: f64 = row.iter().zip(&*v).map(|(a, v)| a * v).sum::<f64>() - row[i] * v[i];
                let pull = self.pull[i] - others;
                let slides =
                    if pull.abs() <= dry(i) { 0.0 } else { (pull - dry(i) * pull.signum()) / row[i] };
                v[i] = slides.clamp(self.bounds[i][0], self.bounds[i][1]);
                let slides = v[i] == slides && v[i] != 0.0;
                let contact = if slides { Contact::Slides(v[i].signum()) } else { Contact::Stands(v[i]) };
                is_same &= contact == self.states[i];
                self.states[i] = contact;
            }
            if is_same && self.refine(v) {
                return;
            }
        }
    }

    /// Solves for the joints that slide, exactly, where the others stand; false where that contradicts who slides.
    fn refine(&mut self, v: &mut [f64]) -> bool {
        let n = v.len();
        self.rows.clear();
        self.rows.extend((0..n).filter(|i| matches!(self.states[*i], Contact::Slides(_))));
        self.part.clear();
        self.side.clear();
        for &i in &self.rows {
            let Contact::Slides(sign) = self.states[i] else { continue };
            let mut side = self.pull[i] - sign * self.period * self.model.joints[i].drive.dry_friction;
            for j in 0..n {
                match self.states[j] {
                    Contact::Slides(_) => self.part.push(self.mass[n * i + j]),
                    Contact::Stands(at) => side -= self.mass[n * i + j] * at,
                }
            }
            self.side.push(side);
        }
        if !self.rows.is_empty() {
            dense::factor(self.rows.len(), &mut self.part);
            dense::solve_columns(self.rows.len(), &self.part, &mut self.side);
        }
        let right = self.rows.iter().zip(&self.side).all(|(&i, x)| {
            let friction = self.model.joints[i].drive.dry_friction;
            (friction == 0.0 || self.states[i] == Contact::Slides(x.signum()))
                && (self.bounds[i][0]..=self.bounds[i][1]).contains(x)
        });
        if right {
            for (&i, x) in self.rows.iter().zip(&self.side) {
                v[i] = *x;
            }
        }
        right
    }
}

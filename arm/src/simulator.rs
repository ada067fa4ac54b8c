//! Motion with dry friction and joint limits.
//!
//! The velocity after a substep minimises ½ (v − v_free)ᵀ A (v − v_free) + h Σ f_i |v_i| within the velocities that keep
//! every joint in its range, A = M + hD: the friction of a joint is f_i against its motion, or whatever up to f_i keeps it at rest. In
//! impulses this is the box QP |p_i| ≤ h f_i on A⁻¹. Where a joint sticks its velocity is exactly zero.
//!
//! A joint that follows another moves with it exactly: q = G u + o with one row of G for each joint. Everything above is then said
//! of u, with Gᵀ A G, Gᵀ A v_free and the frictions and ranges of all joints that u moves.

use crate::crba::fill_mass_matrix;
use crate::rnea::bias_torque;
use crate::{Data, ExternalForce, Joint, Model, dense};

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
    /// Of every joint: which independent one leads it, by its place among them, with ratio and offset.
    leaders: Vec<(usize, f64, f64)>,
    /// The joints that follow none.
    independent: Vec<usize>,
    /// Dry friction and range of every independent joint, with those of its followers.
    dry: Vec<f64>,
    ranges: Vec<Option<[f64; 2]>>,
    /// A of all joints, and A v_free.
    whole: Vec<f64>,
    whole_pull: Vec<f64>,
    /// From here on of the independent joints: A,
    mass: Vec<f64>,
    factor: Vec<f64>,
    free: Vec<f64>,
    /// A v_free,
    pull: Vec<f64>,
    /// and velocities.
    speeds: Vec<f64>,
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
        let independent: Vec<usize> = (0..n).filter(|i| model.joints[*i].follows.is_none()).collect();
        let place = |joint: usize| independent.iter().position(|i| *i == joint).unwrap_or(0);
        let leader = |(i, joint): (usize, &Joint)| match joint.follows {
            Some(follower) => (place(follower.joint), follower.ratio, follower.offset),
            None => (place(i), 1.0, 0.0),
        };
        let leaders: Vec<_> = model.joints.iter().enumerate().map(leader).collect();
        let m = independent.len();
        let (mut dry, mut ranges) = (vec![0.0; m], vec![None; m]);
        for (joint, &(u, ratio, offset)) in model.joints.iter().zip(&leaders) {
            dry[u] += f64::abs(ratio) * joint.drive.dry_friction;
            ranges[u] = common_range(ranges[u], joint.drive.range, (ratio, offset));
        }
        Self {
            model,
            data,
            period: h,
            substeps,
            stops,
            leaders,
            independent,
            dry,
            ranges,
            whole: vec![0.0; n * n],
            whole_pull: vec![0.0; n],
            mass: vec![0.0; m * m],
            factor: vec![0.0; m * m],
            free: vec![0.0; m],
            pull: vec![0.0; m],
            speeds: vec![0.0; m],
            bounds: vec![[0.0; 2]; m],
            states: vec![Contact::Slides(1.0); m],
            rows: Vec::with_capacity(m),
            part: Vec::with_capacity(m * m),
            side: Vec::with_capacity(m),
        }
    }

    /// Advances `q`, `dq` by one period under constant torques and external forces. Joints that follow others are put where these
    /// lead them.
    pub fn step(&mut self, [q, dq]: [&mut [f64]; 2], tau: &[f64], external: &[ExternalForce<f64>]) {
        for _ in 0..self.substeps {
            self.follow(q, dq);
            self.find_free(q, dq, tau, external);
            self.find_bounds(q);
            for (speed, joint) in self.speeds.iter_mut().zip(&self.independent) {
                *speed = dq[*joint];
            }
            self.project();
            for (speed, joint) in self.speeds.iter().zip(&self.independent) {
                dq[*joint] = *speed;
                q[*joint] += self.period * speed;
            }
            self.settle(q, dq);
            self.follow(q, dq);
        }
    }

    /// Puts the joints that follow where their leaders want them.
    fn follow(&self, q: &mut [f64], dq: &mut [f64]) {
        for (i, &(u, ratio, offset)) in self.leaders.iter().enumerate() {
            let leader = self.independent[u];
            if leader != i {
                (q[i], dq[i]) = (ratio * q[leader] + offset, ratio * dq[leader]);
            }
        }
    }

    /// Velocities without friction and stops.
    fn find_free(&mut self, q: &[f64], dq: &[f64], tau: &[f64], external: &[ExternalForce<f64>]) {
        let (n, m, h) = (q.len(), self.independent.len(), self.period);
        bias_torque(self.model, &mut self.data, [q, dq], external, &mut self.whole_pull);
        fill_mass_matrix(self.model, &mut self.data, &mut self.whole);
        // A v_free = A v + h (…).
        for i in 0..n {
            let row = &self.whole[n * i..n * (i + 1)];
            let force = tau[i] - self.whole_pull[i] - self.model.joints[i].drive.damping * dq[i];
            self.whole_pull[i] = h * force + row.iter().zip(dq).map(|(a, v)| a * v).sum::<f64>();
        }
        self.reduce(n, m);
        self.factor.copy_from_slice(&self.mass);
        dense::factor(m, &mut self.factor);
        self.free.copy_from_slice(&self.pull);
        dense::solve_columns(m, &self.factor, &mut self.free);
    }

    /// Gᵀ A G and Gᵀ A v_free.
    fn reduce(&mut self, n: usize, m: usize) {
        if m == n {
            self.mass.copy_from_slice(&self.whole);
            self.pull.copy_from_slice(&self.whole_pull);
            return;
        }
        self.mass.fill(0.0);
        self.pull.fill(0.0);
        for (i, &(u, ratio, _)) in self.leaders.iter().enumerate() {
            self.pull[u] += ratio * self.whole_pull[i];
            for (j, &(w, other, _)) in self.leaders.iter().enumerate() {
                self.mass[m * u + w] += ratio * other * self.whole[n * i + j];
            }
        }
    }

    /// Velocities that end a substep within the ranges.
    fn find_bounds(&mut self, q: &[f64]) {
        for ((bounds, range), joint) in self.bounds.iter_mut().zip(&self.ranges).zip(&self.independent) {
            let q = q[*joint];
            *bounds = match (self.stops, range) {
                (Stops::Rigid, Some([low, high])) => {
                    [((low - q) / self.period).min(0.0), ((high - q) / self.period).max(0.0)]
                }
                _ => [f64::NEG_INFINITY, f64::INFINITY],
            };
        }
    }

    /// Puts joints that stop on the ends of their ranges, free of rounding.
    fn settle(&self, q: &mut [f64], dq: &mut [f64]) {
        for (u, contact) in self.states.iter().enumerate() {
            let (Some([low, high]), i) = (self.ranges[u], self.independent[u]) else { continue };
            if let Contact::Stands(v) = contact
                && *v != 0.0
            {
                q[i] = if *v < 0.0 { low } else { high };
                dq[i] = 0.0;
            }
        }
    }

    /// The velocities with friction and stops, from those without.
    fn project(&mut self) {
        let (n, period) = (self.independent.len(), self.period);
        let free = (0..n)
            .all(|i| self.dry[i] == 0.0 && (self.bounds[i][0]..=self.bounds[i][1]).contains(&self.free[i]));
        if free {
            self.speeds.copy_from_slice(&self.free);
            self.states.fill(Contact::Slides(1.0));
            return;
        }
        for _ in 0..MOST_SWEEPS {
            let mut is_same = true;
            for i in 0..n {
                let row = &self.mass[n * i..n * (i + 1)];
                let v = self.speeds[i];
                let others: f64 = row.iter().zip(&self.speeds).map(|(a, v)| a * v).sum::<f64>() - row[i] * v;
                let (pull, dry) = (self.pull[i] - others, period * self.dry[i]);
                let slides = if pull.abs() <= dry { 0.0 } else { (pull - dry * pull.signum()) / row[i] };
                let v = slides.clamp(self.bounds[i][0], self.bounds[i][1]);
                let contact =
                    if v == slides && v != 0.0 { Contact::Slides(v.signum()) } else { Contact::Stands(v) };
                self.speeds[i] = v;
                is_same &= contact == self.states[i];
                self.states[i] = contact;
            }
            if is_same && self.refine() {
                return;
            }
        }
    }

    /// Solves for the joints that slide, exactly, where the others stand; false where that contradicts who slides.
    fn refine(&mut self) -> bool {
        let n = self.independent.len();
        self.rows.clear();
        self.rows.extend((0..n).filter(|i| matches!(self.states[*i], Contact::Slides(_))));
        self.part.clear();
        self.side.clear();
        for &i in &self.rows {
            let Contact::Slides(sign) = self.states[i] else { continue };
            let mut side = self.pull[i] - sign * self.period * self.dry[i];
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
            (self.dry[i] == 0.0 || self.states[i] == Contact::Slides(x.signum()))
                && (self.bounds[i][0]..=self.bounds[i][1]).contains(x)
        });
        if right {
            for (&i, x) in self.rows.iter().zip(&self.side) {
                self.speeds[i] = *x;
            }
        }
        right
    }
}

/// Where a joint may be that has one range of its own and another by a follower, q = ratio · u + offset.
fn common_range(
    own: Option<[f64; 2]>,
    followers: Option<[f64; 2]>,
    (ratio, offset): (f64, f64),
) -> Option<[f64; 2]> {
    let Some(range) = followers.filter(|_| ratio != 0.0) else { return own };
    let mut ends = range.map(|end| (end - offset) / ratio);
    if ratio < 0.0 {
        ends.swap(0, 1);
    }
    match own {
        // Ranges without a place in common: that of the leader.
        Some([low, high]) if ends[0].max(low) > ends[1].min(high) => Some([low, high]),
        Some([low, high]) => Some([ends[0].max(low), ends[1].min(high)]),
        None => Some(ends),
    }
}

//! A substep with dry friction, stops and joints that follow others, forwards and backwards.
//!
//! The velocity after a substep minimises ½ (v − v_free)ᵀ A (v − v_free) + h Σ f_i |v_i| within the velocities that keep
//! every joint in its range, A = M + hD: the friction of a joint is f_i against its motion, or up to f_i if that keeps it at rest. In
//! impulses this is the box QP |p_i| ≤ h f_i on A⁻¹. Where a joint sticks its velocity is exactly zero.
//!
//! A joint that follows another moves with it exactly: q = G u + o with one row of G for each joint. Everything above then holds
//! of u, with Gᵀ A G, Gᵀ A v_free and the frictions and ranges of all joints that u moves.
//!
//! Friction may grow with what a gear transmits, f_i = F_i + μ_i |τ_i + b_i|, with b of gravity, Coriolis and outside forces: the difference
//! of what the motor and what the load put on it, as in bam's model m3 (Duclusaud et al. 2024). It is that of the state before the substep.
//!
//! The active set is found in every lane separately; given it, the velocities are the solution of a linear system whose rows of standing
//! joints are those of the identity. Gradients follow from that system with the active set fixed: with μ its solution for the cotangent of
//! the velocities, those of −h μ·(τ(q, q̇, (v − q̇)/h) + …), which is one reverse sweep of inverse dynamics.

use hysteron_base::lanes::LANES;

use crate::adjoint::inverse_dynamics_adjoint;
use crate::box_qp::{BoxQp, ContactState};
use crate::crba::fill_mass_matrix;
use crate::followers::Followers;
use crate::rnea::bias_torque;
use crate::step_gradient::StepGradient;
use crate::{Cotangent, Data, ExternalForce, Model, Scalar, dense, inverse_dynamics};

/// Whether joints stop at the ends of their ranges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndStops {
    /// A joint that reaches the end of its range stops there without rebound.
    Rigid,
    /// Joints move through.
    None,
}

/// Scratch of the substeps of one model.
#[derive(Debug, Clone)]
pub(crate) struct FrictionStep<T> {
    /// Length of a substep [s].
    period: f64,
    stops: EndStops,
    followers: Followers,
    qp: BoxQp,
    /// A of all joints (n × n), and A v_free.
    whole: Vec<T>,
    whole_pull: Vec<T>,
    /// |τ + b| of all joints, and its signs; where friction grows with it.
    through: Vec<T>,
    through_signs: Vec<T>,
    /// From here on of the independent joints: A,
    mass: Vec<T>,
    factor: Vec<T>,
    /// A v_free,
    pull: Vec<T>,
    /// friction of the joint and its followers, as an impulse,
    dry: Vec<T>,
    /// and velocities.
    speeds: Vec<T>,
    /// One where the joint slides, the sign of its motion, one where it stops, and the end at which it does.
    sliding: Vec<T>,
    signs: Vec<T>,
    stopped: Vec<T>,
    ends: Vec<T>,
    /// The problem of every lane, and its active set.
    values: Vec<[f64; LANES]>,
    found: Vec<[[f64; LANES]; 4]>,
}

/// Inputs of a substep: model, workspace, damping, friction, torques and external forces.
pub(crate) struct Substep<'a, T> {
    pub model: &'a Model,
    /// Armatures with h D in them.
    pub data: &'a mut Data<T>,
    pub damping: &'a [T],
    pub dry_friction: &'a [T],
    /// Dry friction per torque through the gear; empty where it does not grow.
    pub load_friction: &'a [T],
    pub tau: &'a [T],
    pub external: &'a [ExternalForce<T>],
}

impl<T: Scalar> FrictionStep<T> {
    /// Substeps of `period` [s] of numbers like `like`.
    pub fn new(model: &Model, period: f64, stops: EndStops, like: T) -> Self {
        let followers = Followers::new(model);
        let (n, m) = (model.n_joints(), followers.independent.len());
        let [row, of_all] = [m, n].map(|n| vec![like.splat(0.0); n]);
        Self {
            period,
            stops,
            qp: BoxQp::new(m),
            followers,
            whole: vec![like.splat(0.0); n * n],
            through: of_all.clone(),
            through_signs: of_all.clone(),
            whole_pull: of_all,
            mass: vec![like.splat(0.0); m * m],
            factor: vec![like.splat(0.0); m * m],
            pull: row.clone(),
            dry: row.clone(),
            speeds: row.clone(),
            sliding: row.clone(),
            signs: row.clone(),
            stopped: row.clone(),
            ends: row,
            values: vec![[0.0; LANES]; m * (m + 4)],
            found: vec![[[0.0; LANES]; 4]; m],
        }
    }

    /// Advances `q`, `dq` by a substep. Joints that follow others are put where these lead them, before and after.
    #[inline(always)]
    pub fn advance(&mut self, mut at: Substep<T>, [q, dq]: [&mut [T]; 2]) {
        self.followers.follow(q, dq);
        self.find_speeds(&mut at, [&*q, &*dq]);
        let one = q[0].splat(1.0);
        for (u, &i) in self.followers.independent.iter().enumerate() {
            let goes = one - self.stopped[u];
            // A joint that stops is exactly at the end of its range.
            let free = self.speeds[u].mul_add(q[i].splat(self.period), q[i]);
            q[i] = self.stopped[u].mul_add(self.ends[u], goes * free);
            dq[i] = goes * self.speeds[u];
        }
        self.followers.follow(q, dq);
    }

    /// Velocities of the independent joints at the end of a substep that starts at `q`, `dq`.
    #[inline(always)]
    fn find_speeds(&mut self, at: &mut Substep<T>, [q, dq]: [&[T]; 2]) {
        let like = at.data.like();
        like.apart(
            #[inline(always)]
            || {
                let (n, m, h) = (q.len(), self.speeds.len(), self.period);
                bias_torque(at.model, at.data, [q, dq], at.external, &mut self.whole_pull);
                fill_mass_matrix(at.model, at.data, &mut self.whole);
                self.dry.iter_mut().for_each(|dry| *dry = dry.splat(0.0));
                for (i, &(u, ratio, _)) in self.followers.leaders.iter().enumerate() {
                    let mut dry = at.dry_friction[i];
                    if let Some(share) = at.load_friction.get(i) {
                        let through = at.tau[i] + self.whole_pull[i];
                        self.through_signs[i] = through.constants(&through.values().map(f64::signum));
                        self.through[i] = self.through_signs[i] * through;
                        dry = share.mul_add(self.through[i], dry);
                    }
                    self.dry[u] = dry.mul_add(dry.splat(h * ratio.abs()), self.dry[u]);
                }
                // A v_free = A v + h (…).
                for i in 0..n {
                    let force = at.tau[i] - self.whole_pull[i] - at.damping[i] * dq[i];
                    self.whole_pull[i] = dot(&self.whole[n * i..n * (i + 1)], dq) + force.scale(h);
                }
                self.followers.reduce([&self.whole, &self.whole_pull], [&mut self.mass, &mut self.pull]);
                for (speed, &i) in self.speeds.iter_mut().zip(&self.followers.independent) {
                    *speed = dq[i];
                }
                self.find_contacts(q);
                // Rows of joints that do not slide set their velocities.
                let one = q[0].splat(1.0);
                for (u, &i) in self.followers.independent.iter().enumerate() {
                    self.speeds[u] = self.stopped[u] * (self.ends[u] - q[i]).scale(1.0 / h);
                }
                for u in 0..m {
                    let row = &self.mass[m * u..m * (u + 1)];
                    let force = self.pull[u] - self.signs[u] * self.dry[u] - dot(row, &self.speeds);
                    self.pull[u] = self.sliding[u].mul_add(force, (one - self.sliding[u]) * self.speeds[u]);
                    for w in 0..m {
                        self.factor[m * u + w] = self.sliding[u] * self.sliding[w] * row[w];
                    }
                    self.factor[m * u + u] = self.factor[m * u + u] + (one - self.sliding[u]);
                }
                dense::factor(m, &mut self.factor);
                self.speeds.copy_from_slice(&self.pull);
                dense::solve_columns(m, &self.factor, &mut self.speeds);
            },
        )
    }

    /// The active set of every lane, from the velocities before the substep.
    #[inline(always)]
    fn find_contacts(&mut self, q: &[T]) {
        let independent = &self.followers.independent;
        let numbers = self.mass.iter().chain(&self.pull).chain(&self.dry).chain(&self.speeds);
        let numbers = numbers.copied().chain(independent.iter().map(|i| q[*i]));
        for (values, number) in self.values.iter_mut().zip(numbers) {
            *values = number.values();
        }
        for lane in 0..T::N_LANES {
            self.find_contacts_of(lane);
        }
        for (u, [sliding, signs, stopped, ends]) in self.found.iter().enumerate() {
            let like = self.speeds[u];
            self.sliding[u] = like.constants(sliding);
            self.signs[u] = like.constants(signs);
            self.stopped[u] = like.constants(stopped);
            self.ends[u] = like.constants(ends);
        }
    }

    /// The active set of a lane, from `values` to `found`.
    fn find_contacts_of(&mut self, lane: usize) {
        let (m, qp) = (self.speeds.len(), &mut self.qp);
        let mut values = self.values.iter().map(|values| values[lane]);
        for part in [&mut qp.mass, &mut qp.pull, &mut qp.dry, &mut qp.speeds] {
            part.iter_mut().zip(&mut values).for_each(|(x, value)| *x = value);
        }
        for ((bounds, range), q) in qp.bounds.iter_mut().zip(&self.followers.ranges).zip(values) {
            *bounds = match (self.stops, range) {
                (EndStops::Rigid, Some([low, high])) => {
                    [((low - q) / self.period).min(0.0), ((high - q) / self.period).max(0.0)]
                }
                _ => [f64::NEG_INFINITY, f64::INFINITY],
            };
        }
        qp.solve();
        for u in 0..m {
            let found = match qp.contacts[u] {
                ContactState::Slides(sign) => [1.0, sign, 0.0, 0.0],
                ContactState::Sticks => [0.0; 4],
                ContactState::Stops(end) => {
                    [0.0, 0.0, 1.0, self.followers.ranges[u].unwrap_or_default()[end]]
                }
            };
            for (values, value) in self.found[u].iter_mut().zip(found) {
                values[lane] = value;
            }
        }
    }

    /// Pulls the gradients `q`, `dq` by the state after a substep back to the state before it, which is `state`; adds the rest to
    /// `gradient`.
    #[inline(always)]
    pub fn back(
        &mut self,
        mut at: Substep<T>,
        state: [&mut [T]; 3],
        [q, dq]: [&mut [T]; 2],
        cotangent: &mut Cotangent<T>,
        gradient: &mut StepGradient<T>,
    ) {
        let (n, h) = (q.len(), self.period);
        let [from, velocity, acceleration] = state;
        self.followers.follow(from, velocity);
        self.find_speeds(&mut at, [&*from, &*velocity]);
        for (i, &(u, ratio, _)) in self.followers.leaders.iter().enumerate() {
            acceleration[i] = (self.speeds[u].scale(ratio) - velocity[i]).scale(1.0 / h);
        }
        self.followers.follow_back(q, dq);
        self.find_multipliers([&mut *q, &mut *dq]);
        // Of all joints, μ; M μ is what it is worth before the substep.
        for (i, &(u, ratio, _)) in self.followers.leaders.iter().enumerate() {
            cotangent.tau[i] = self.pull[u].scale(ratio);
        }
        for i in 0..n {
            dq[i] = dot(&self.whole[n * i..n * (i + 1)], &cotangent.tau);
        }
        for mu in &mut cotangent.tau {
            *mu = mu.scale(h);
        }
        inverse_dynamics(
            at.model,
            at.data,
            [&*from, &*velocity, &*acceleration],
            at.external,
            &mut self.whole_pull,
        );
        inverse_dynamics_adjoint(at.model, at.data, at.external, cotangent);
        gradient.add(at.data, acceleration, cotangent);
        for i in 0..n {
            let (mu, (u, ratio, _)) = (cotangent.tau[i], self.followers.leaders[i]);
            q[i] = q[i] + cotangent.q[i];
            dq[i] = dq[i] + cotangent.dq[i] - at.damping[i] * mu;
            gradient.damping[i] = gradient.damping[i] - mu * (velocity[i] + acceleration[i].scale(h));
            gradient.dry_friction[i] = gradient.dry_friction[i] + self.by_friction(u, ratio);
        }
        if !at.load_friction.is_empty() {
            acceleration.iter_mut().for_each(|a| *a = a.splat(0.0));
            self.load_friction_back(
                at,
                [from, velocity, acceleration],
                [&mut *q, &mut *dq],
                cotangent,
                gradient,
            );
        }
        self.followers.follow_back(q, dq);
    }

    /// Gradient by the friction of a joint that follows `u`, from the multipliers.
    #[inline(always)]
    fn by_friction(&self, u: usize, ratio: f64) -> T {
        (self.signs[u] * self.pull[u]).scale(-self.period * ratio.abs())
    }

    /// Adds what the gradients get through |τ + b|; `still` is the state before the substep, without acceleration.
    #[inline(always)]
    fn load_friction_back(
        &mut self,
        at: Substep<T>,
        still: [&mut [T]; 3],
        [q, dq]: [&mut [T]; 2],
        cotangent: &mut Cotangent<T>,
        gradient: &mut StepGradient<T>,
    ) {
        let [from, velocity, acceleration] = still;
        for (i, &(u, ratio, _)) in self.followers.leaders.iter().enumerate() {
            let by_friction = self.by_friction(u, ratio);
            gradient.load_friction[i] = self.through[i].mul_add(by_friction, gradient.load_friction[i]);
            let by_through = by_friction * at.load_friction[i] * self.through_signs[i];
            gradient.tau[i] = gradient.tau[i] + by_through;
            cotangent.tau[i] = -by_through;
        }
        let state = [&*from, &*velocity, &*acceleration];
        inverse_dynamics(at.model, at.data, state, at.external, &mut self.whole_pull);
        inverse_dynamics_adjoint(at.model, at.data, at.external, cotangent);
        gradient.add_parameters(at.data, acceleration, cotangent);
        for i in 0..q.len() {
            q[i] = q[i] + cotangent.q[i];
            dq[i] = dq[i] + cotangent.dq[i];
        }
    }

    /// From gradients by the independent joints after a substep, μ to `pull` and what does not pass through the velocities to `q`.
    #[inline(always)]
    fn find_multipliers(&mut self, [q, dq]: [&mut [T]; 2]) {
        let m = self.speeds.len();
        let one = q[0].splat(1.0);
        for (u, &i) in self.followers.independent.iter().enumerate() {
            q[i] = (one - self.stopped[u]) * q[i];
            self.pull[u] = self.sliding[u] * q[i].mul_add(q[i].splat(self.period), dq[i]);
        }
        dense::solve_columns(m, &self.factor, &mut self.pull);
        // A joint that stops takes the others with it at the velocity that its way to the stop needs.
        for (u, &i) in self.followers.independent.iter().enumerate() {
            let force = dot(&self.mass[m * u..m * (u + 1)], &self.pull);
            q[i] = (self.stopped[u] * force).mul_add(q[i].splat(1.0 / self.period), q[i]);
        }
    }
}

/// a · b.
#[inline(always)]
fn dot<T: Scalar>(a: &[T], b: &[T]) -> T {
    let start = b[0].splat(0.0);
    a.iter().zip(b).fold(start, |sum, (a, b)| a.mul_add(*b, sum))
}

//! Friction of the joints as an estimator takes it away.

use hysteron_actuator::law::{CoulombViscous, JointFriction, Law, Sliding};

/// Model of friction near standstill, where the law is not one number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LowSpeed {
    /// A line through zero between ∓ this speed, as in Saadatzi et al. (2019) [rad/s].
    Linear(f64),
    /// Below this speed the torque that holds the joint, up to the dry friction there: min(|τ|, f_s) sgn τ of Wan et al. (2026),
    /// eq. 39 [rad/s]. A contact that friction can hold is not felt at rest.
    Stick(f64),
    /// Below this speed what it was when the joint slid last, and every change since of what it holds, up to the dry friction
    /// there [rad/s]. So friction is where a joint stops: an arm at rest that sank under a load still has the estimate of that load.
    /// A joint that has not slid yet is taken to be without contact.
    Absorb(f64),
}

/// A law of friction for each joint.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionModel {
    laws: Vec<(Law, Vec<f64>)>,
    low_speed: LowSpeed,
    /// Of the last sample, joint by joint: friction, and what it would have had to withstand without accelerations [N m].
    last: Vec<Option<[f64; 2]>>,
}

impl FrictionModel {
    /// `laws` with their parameters, joint by joint.
    pub fn new(laws: Vec<(Law, Vec<f64>)>, low_speed: LowSpeed) -> Self {
        for (law, parameters) in &laws {
            let expected = law.parameters().len();
            assert_eq!(parameters.len(), expected, "parameters of {law:?}");
        }
        Self { last: vec![None; laws.len()], laws, low_speed }
    }

    /// None in `n` joints.
    pub fn none(n: usize) -> Self {
        let law = (Law::CoulombViscous(CoulombViscous), vec![0.0, 0.0]);
        Self::new(vec![law; n], LowSpeed::Linear(0.0))
    }

    /// Number of joints.
    pub fn n_joints(&self) -> usize {
        self.laws.len()
    }

    /// Torque of friction against positive motion of `joint` [N m]; `required` is what friction would have to withstand for the
    /// motion that is seen, without any contact [N m]. Of one sample alone: [`LowSpeed::Absorb`] then is [`LowSpeed::Stick`].
    pub fn torque(&self, joint: usize, at: &Sliding, required: f64) -> f64 {
        let (law, p) = &self.laws[joint];
        match self.low_speed {
            LowSpeed::Linear(width) if at.velocity.abs() < width => {
                let edge = Sliding { velocity: width.copysign(at.velocity), ..*at };
                law.torque(p, &edge) * (at.velocity / edge.velocity)
            }
            LowSpeed::Stick(width) | LowSpeed::Absorb(width) if at.velocity.abs() < width => {
                self.stuck(joint, at, required)
            }
            _ => law.torque(p, at),
        }
    }

    /// `applied`, as far as dry friction at rest goes [N m].
    fn stuck(&self, joint: usize, at: &Sliding, applied: f64) -> f64 {
        let (law, p) = &self.laws[joint];
        // Towards `applied`: a law may have other friction in the other direction.
        let dry = law.budget(p, &Sliding { velocity: 1e-12_f64.copysign(applied), ..*at }).dry;
        applied.clamp(-dry, dry)
    }

    /// [`Self::torque`] of one sample after the other. `resting` is `required` as if nothing accelerated: accelerations from
    /// differences are noise that the bounds of friction would rectify [N m].
    pub(super) fn follow(&mut self, joint: usize, at: &Sliding, [required, resting]: [f64; 2]) -> f64 {
        let friction = match (self.low_speed, self.last[joint]) {
            (LowSpeed::Absorb(width), Some([friction, before])) if at.velocity.abs() < width => {
                self.stuck(joint, at, friction + resting - before)
            }
            _ => self.torque(joint, at, required),
        };
        self.last[joint] = Some([friction, resting]);
        friction
    }

    /// Friction that [`Self::follow`] gave for a joint's last sample; zero before the first [N m].
    pub(super) fn last(&self, joint: usize) -> f64 {
        self.last[joint].map_or(0.0, |[friction, _]| friction)
    }

    /// Forgets all samples.
    pub(super) fn reset(&mut self) {
        self.last.fill(None);
    }
}

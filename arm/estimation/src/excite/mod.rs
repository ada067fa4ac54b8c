//! Motions that make parameters visible: optimal exciting trajectories, and moves from rest to rest.

mod design;
mod fourier;
mod information;
mod limits;
mod point_to_point;

pub use design::{Excitation, ExcitationOptions, exciting_trajectory};
pub use fourier::Fourier;
pub use information::Information;
pub use limits::{LimitOptions, MotionLimits};
pub use point_to_point::{MotionLaw, PointToPoint};

use hysteron_base::{BadInput, Channel, Metadata, Recording};

use crate::JointQuantityKind;
use hysteron_arm_dynamics::{Data, Model, inverse_dynamics};

/// A motion of all joints that is known at every time.
pub trait Motion {
    /// Coordinate, speed and acceleration of joint number `joint` at time `t` [s].
    fn at(&self, joint: usize, t: f64) -> [f64; 3];

    /// How long it takes [s].
    fn duration(&self) -> f64;
}

/// The motion as a recording at `rate_hz`, with its accelerations; `meta` is its provenance; the robot and its joints are added.
///
/// # Errors
/// `BadInput` for a rate that gives no or too many rows.
pub fn states_of(
    model: &Model,
    motion: &impl Motion,
    rate_hz: f64,
    mut meta: Metadata,
) -> Result<Recording, BadInput> {
    let n_rows = (motion.duration() * rate_hz).round();
    if !(rate_hz > 0.0 && (1.0..1e7).contains(&n_rows)) {
        let expected = "a rate that gives 2 to 10 million rows";
        return Err(BadInput::new(
            "rate",
            expected,
            format!("{rate_hz} Hz for {} s", hysteron_base::number::shown(motion.duration())),
        ));
    }
    let time: Vec<f64> = (0..=n_rows as usize).map(|k| k as f64 / rate_hz).collect();
    let mut channels = Vec::new();
    for (part, quantity) in
        [JointQuantityKind::Position, JointQuantityKind::Velocity, JointQuantityKind::Acceleration]
            .into_iter()
            .enumerate()
    {
        for (k, joint) in model.joints().iter().enumerate() {
            let values = time.iter().map(|t| motion.at(k, t.min(motion.duration()))[part]).collect();
            channels.push(Channel::new(quantity.channel(joint.kind, k), values));
        }
    }
    model.describe(&mut meta.extra);
    Recording::new(time, channels, Vec::new(), meta)
}

/// The largest torque of each joint over its limit, with damping and dry friction, on `n_samples` times of a motion [-].
pub(crate) fn torque_use(
    model: &Model,
    data: &mut Data<f64>,
    motion: &impl Motion,
    limits: &MotionLimits,
    n_samples: usize,
) -> f64 {
    let n = model.n_joints();
    let [mut q, mut dq, mut ddq, mut tau] = [0; 4].map(|_| vec![0.0; n]);
    let mut most = 0.0_f64;
    for s in 0..n_samples {
        let t = motion.duration() * s as f64 / n_samples as f64;
        for joint in 0..n {
            [q[joint], dq[joint], ddq[joint]] = motion.at(joint, t);
        }
        inverse_dynamics(model, data, [&q, &dq, &ddq], &[], &mut tau);
        for (joint, described) in model.joints().iter().enumerate() {
            let drive = &described.drive;
            let friction = drive.damping * dq[joint] + drive.dry_friction * sign(dq[joint]);
            most = most.max((tau[joint] + friction).abs() / limits.torque[joint]);
        }
    }
    most
}

/// Sign of a speed: zero at rest, where `signum` gives one.
fn sign(speed: f64) -> f64 {
    if speed == 0.0 { 0.0 } else { speed.signum() }
}

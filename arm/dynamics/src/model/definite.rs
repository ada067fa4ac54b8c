//! Whether accelerations follow from torques: the mass matrix at several configurations.
//!
//! A link without mass is nothing unusual between joints whose axes cross: what the next link weighs resists both. Where nothing
//! resists a joint, its acceleration is not determined, and its pivot in the factorisation of M from the tip to the base
//! is zero.

use hysteron_base::{BadInput, rng};
use rand::RngExt as _;

use super::{JointKind, Model};
use crate::spatial::{Inertia, Sym3};
use crate::{Data, mass_matrix};

/// Configurations at which the mass matrix is factorised.
const N_CONFIGURATIONS: usize = 5;
/// Part of what a joint carries, taken about its origin without regard to the axis, that must resist it [-]. A rod of 1 mm and
/// 1 m that turns about itself has 1e-6 of that; rounding leaves some 1e-15.
const MIN_RESISTING: f64 = 1e-11;
/// Coordinates that are drawn where a joint has no range [rad] or [m].
const DRAWN: [f64; 2] = [-1.0, 1.0];

impl Model {
    /// Accepts a robot whose mass matrix is definite.
    ///
    /// # Errors
    /// `BadInput` naming the joint that nothing resists and its link.
    pub(super) fn check_definite(&self, file: &str) -> Result<(), BadInput> {
        let n = self.n_joints();
        let (mut data, mut mass) = (Data::new(self, 0.0), vec![0.0; n * n]);
        let mut draws = rng(1, "arm/definite");
        for _ in 0..N_CONFIGURATIONS {
            let q: Vec<f64> = self
                .joints
                .iter()
                .map(|joint| {
                    let [low, high] = joint.drive.range.filter(|[low, high]| low < high).unwrap_or(DRAWN);
                    // Within a turn or a metre, so that nothing is lost to rounding.
                    let [low, high] = [low, high].map(|end| end.clamp(-3.0, 3.0));
                    low + (high - low) * draws.random::<f64>()
                })
                .collect();
            mass_matrix(self, &mut data, &q, &mut mass);
            if let Some(joint) = self.unresisted(&q, &mut mass) {
                return Err(self.unresisted_error(file, joint));
            }
        }
        Ok(())
    }

    /// The joint farthest from the base whose pivot is zero; `mass` is factorised in place.
    fn unresisted(&self, q: &[f64], mass: &mut [f64]) -> Option<usize> {
        let n = self.n_joints();
        let mut carried: Vec<Inertia<f64>> = self.joints.iter().map(|joint| joint.inertia).collect();
        for k in (0..n).rev() {
            let joint = &self.joints[k];
            let scale = match joint.kind {
                JointKind::Revolute => trace(&carried[k].second),
                JointKind::Prismatic => carried[k].mass,
            };
            let pivot = mass[n * k + k];
            let least = MIN_RESISTING * (scale + joint.drive.armature);
            if pivot.is_nan() || pivot <= least {
                return Some(k);
            }
            for i in 0..k {
                let factor = mass[n * i + k] / pivot;
                for j in 0..=i {
                    mass[n * i + j] -= factor * mass[n * j + k];
                    mass[n * j + i] = mass[n * i + j];
                }
            }
            if let Some(parent) = joint.parent {
                let at = joint.placement.times(&joint.motion(q[k]));
                carried[parent] = carried[parent].plus(&carried[k].placed(&at.rotation, at.position));
            }
        }
        None
    }

    fn unresisted_error(&self, file: &str, joint: usize) -> BadInput {
        let name = &self.joints[joint].name;
        let link = self.frames.iter().find(|frame| frame.joint == Some(joint));
        let link = link.map_or("", |frame| frame.name.as_str());
        let found = match self.joints[joint].inertia.mass == 0.0 {
            true => "no mass on it that resists",
            false => "masses on its axis alone, without inertia about it",
        };
        BadInput::new(
            format!("{file}: link[{link}]"),
            format!("an <inertial> with a mass, because joint \"{name}\" moves this link"),
            found,
        )
        .hint("arm info and the inverse dynamics of arm dynamics need no mass here")
    }
}

fn trace(second: &Sym3<f64>) -> f64 {
    second[0] + second[2] + second[5]
}

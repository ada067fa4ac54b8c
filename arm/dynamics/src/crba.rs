//! Mass matrix by the composite-rigid-body algorithm.
//!
//! # Reference
//! Featherstone (2008), Rigid Body Dynamics Algorithms, section 6.2, in the axes of the base.

use crate::kinematics::place_bodies;
use crate::rnea::place_inertias;
use crate::{Data, Model, Scalar};

/// Mass matrix M(q) (n × n, row by row), armature included.
#[inline(always)]
pub fn mass_matrix<T: Scalar>(model: &Model, data: &mut Data<T>, q: &[T], mass: &mut [T]) {
    place_bodies(model, data, q);
    place_inertias(data);
    fill_mass_matrix(model, data, mass);
}

/// As [`mass_matrix`], with inertias that are placed already; they become those of all that a body carries.
#[inline(always)]
pub(crate) fn fill_mass_matrix<T: Scalar>(model: &Model, data: &mut Data<T>, mass: &mut [T]) {
    data.apart(
        #[inline(always)]
        |data| {
            let n = model.n_joints();
            if let Some(first) = mass.first().copied() {
                mass.fill(first.splat(0.0));
            }
            for i in (0..n).rev() {
                let body = data.bodies[i];
                let wrench = body.inertia.mul(&body.axis);
                mass[n * i + i] = body.axis.dot(&wrench) + data.armature[i];
                let mut next = model.joints[i].parent;
                if let Some(p) = next {
                    data.bodies[p].inertia = data.bodies[p].inertia.plus(&body.inertia);
                }
                while let Some(j) = next {
                    let value = data.bodies[j].axis.dot(&wrench);
                    mass[n * i + j] = value;
                    mass[n * j + i] = value;
                    next = model.joints[j].parent;
                }
            }
        },
    )
}

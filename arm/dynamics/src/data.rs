//! Workspace of the algorithms: results and scratch, allocated once, next to the model.

use crate::model::{Joint, JointLimits, Weightless};
use crate::spatial::{Articulated, Inertia, Mat3, SpatialMotion, Sym3, Vec3, Wrench};
use crate::{Model, Scalar};

/// Scratch of the algorithms for one [`Model`], and the parameters of its bodies as numbers of kind `T`.
///
/// Parameters start as those of the model; each may be changed, for example to other bodies in every lane.
#[derive(Debug, Clone)]
pub struct Data<T> {
    /// Inertia of every body in its joint's frame.
    pub inertias: Vec<Inertia<T>>,
    /// Armature of every joint [kg m²] or [kg].
    pub armature: Vec<T>,
    /// Stiffness and reference of the spring of every joint; empty where no joint has one.
    pub(crate) springs: Vec<[T; 2]>,
    /// Weightless mass and first moment of bodies; empty where all of them weigh what they should.
    pub(crate) lifts: Vec<Lift<T>>,
    pub(crate) bodies: Vec<BodyState<T>>,
    /// Gravity, the other way round: the acceleration of a base at rest.
    pub(crate) base_acceleration: SpatialMotion<T>,
    /// n zeros.
    pub(crate) still: Vec<T>,
    /// n × n, row by row.
    pub(crate) matrix: Vec<T>,
}

/// Mass [kg] and first moment [kg m], in its joint's frame, of what is weightless of a body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lift<T> {
    pub body: usize,
    pub mass: T,
    pub first: Vec3<T>,
}

/// A body, all of it about the origin of the base and in its axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BodyState<T> {
    /// Columns: the axes of the joint's frame.
    pub rotation: Mat3<T>,
    /// Origin of the joint's frame [m].
    pub position: Vec3<T>,
    /// Motion of the body for one unit of the joint's speed.
    pub axis: SpatialMotion<T>,
    pub velocity: SpatialMotion<T>,
    /// Against a base that accelerates upwards: gravity is in it.
    pub acceleration: SpatialMotion<T>,
    pub inertia: Inertia<T>,
    /// Inertia times velocity.
    pub momentum: Wrench<T>,
    /// Force on this body and all that it carries; while an algorithm runs, on the body alone.
    pub wrench: Wrench<T>,
    pub articulated: Articulated<T>,
    /// Articulated inertia times axis.
    pub reaction: Wrench<T>,
    /// 1 / (axis · reaction + armature).
    pub inverse: T,
    /// Second motion and wrench of solvers and sweeps.
    pub motion: SpatialMotion<T>,
    pub load: Wrench<T>,
    /// Rate of the axis, and its second rate in the frame that accelerates with the parent: Ψ̇ and Ψ̈ of `derivatives`.
    pub axis_rate: SpatialMotion<T>,
    pub axis_acceleration: SpatialMotion<T>,
    /// Rate of the second moment.
    pub second_rate: Sym3<T>,
    /// Moments that the adjoint sums.
    pub turned: Vec3<T>,
    pub resisted: Vec3<T>,
}

impl<T: Scalar> Data<T> {
    /// Runs `kernel` as a function of its own ([`Scalar::apart`]).
    #[inline(always)]
    pub(crate) fn apart<R>(&mut self, kernel: impl FnOnce(&mut Self) -> R) -> R {
        self.like().apart(
            #[inline(always)]
            || kernel(self),
        )
    }

    /// A number of the kind that this is for.
    #[inline(always)]
    pub(crate) fn like(&self) -> T {
        self.base_acceleration.linear[0]
    }

    /// Scratch for `model`, of numbers like `like`.
    pub fn new(model: &Model, like: T) -> Self {
        let zero = like.splat(0.0);
        let [x, y, z] = model.gravity.map(|g| like.splat(-g));
        let inertias: Vec<Inertia<T>> = model
            .joints
            .iter()
            .map(|joint| Inertia::from_parameters(joint.inertia.parameters().map(|p| like.splat(p))))
            .collect();
        let bodies = inertias.iter().map(|inertia| BodyState {
            rotation: [[zero; 3]; 3],
            position: [zero; 3],
            axis: SpatialMotion::zero(like),
            velocity: SpatialMotion::zero(like),
            acceleration: SpatialMotion::zero(like),
            inertia: *inertia,
            momentum: Wrench::zero(like),
            wrench: Wrench::zero(like),
            articulated: Articulated::rigid(inertia),
            reaction: Wrench::zero(like),
            inverse: zero,
            motion: SpatialMotion::zero(like),
            load: Wrench::zero(like),
            axis_rate: SpatialMotion::zero(like),
            axis_acceleration: SpatialMotion::zero(like),
            second_rate: [zero; 6],
            turned: [zero; 3],
            resisted: [zero; 3],
        });
        let n = model.n_joints();
        let has_springs = model.joints.iter().any(|joint| joint.drive.stiffness != 0.0);
        let spring = |drive: &JointLimits| [drive.stiffness, drive.spring_reference].map(|x| like.splat(x));
        let lifted =
            model.joints.iter().enumerate().filter(|(_, joint)| joint.weightless != Weightless::default());
        let lift = |(body, joint): (usize, &Joint)| {
            let Weightless { mass, first } = joint.weightless;
            Lift { body, mass: like.splat(mass), first: first.map(|h| like.splat(h)) }
        };
        Self {
            springs: model.joints.iter().filter(|_| has_springs).map(|joint| spring(&joint.drive)).collect(),
            lifts: lifted.map(lift).collect(),
            bodies: bodies.collect(),
            inertias,
            armature: model.joints.iter().map(|joint| like.splat(joint.drive.armature)).collect(),
            base_acceleration: SpatialMotion { angular: [zero; 3], linear: [x, y, z] },
            still: vec![zero; n],
            matrix: vec![zero; n * n],
        }
    }
}

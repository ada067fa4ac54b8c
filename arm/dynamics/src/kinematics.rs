//! Where the bodies are and how they move: forward kinematics and Jacobians.
//!
//! [`forward_kinematics`] first; the others read what it left in [`Data`].

use crate::data::BodyState;
use crate::model::{Joint, JointKind};
use crate::spatial::{Mat3, Pose, SpatialMotion, Vec3, add3, cross, mul3_add, mul3_constant, scale3, splat3};
use crate::{Data, Model, Scalar};

/// Places the body of `joint`, a child of `parent`, at the coordinate `q`.
#[inline(always)]
fn place<T: Scalar>(joint: &Joint, parent: Option<&BodyState<T>>, q: T, body: &mut BodyState<T>) {
    let Pose { rotation, position } = &joint.placement;
    // Fixed part; on the base it is constant.
    let (fixed, position) = match parent {
        Some(p) => {
            (mul3_constant(&p.rotation, rotation), mul3_add(&p.rotation, splat3(q, *position), p.position))
        }
        None => (splat_rows(q, rotation), splat3(q, *position)),
    };
    let z = [fixed[0][2], fixed[1][2], fixed[2][2]];
    match joint.kind {
        JointKind::Revolute => {
            let (sin, cos) = q.sin_cos();
            body.rotation =
                [turned(fixed[0], sin, cos), turned(fixed[1], sin, cos), turned(fixed[2], sin, cos)];
            body.position = position;
            body.axis = SpatialMotion { angular: z, linear: cross(position, z) };
        }
        JointKind::Prismatic => {
            body.rotation = fixed;
            body.position = add3(position, scale3(q, z));
            body.axis = SpatialMotion { angular: [q.splat(0.0); 3], linear: z };
        }
    }
}

/// A row of R R_z.
#[inline(always)]
fn turned<T: Scalar>([x, y, z]: Vec3<T>, sin: T, cos: T) -> Vec3<T> {
    [cos.mul_add(x, sin * y), cos.mul_add(y, -(sin * x)), z]
}

#[inline(always)]
fn splat_rows<T: Scalar>(like: T, m: &Mat3<f64>) -> Mat3<T> {
    [splat3(like, m[0]), splat3(like, m[1]), splat3(like, m[2])]
}

/// Positions of all bodies at `q`.
#[inline(always)]
pub(crate) fn place_bodies<T: Scalar>(model: &Model, data: &mut Data<T>, q: &[T]) {
    data.apart(
        #[inline(always)]
        |data| {
            for (i, joint) in model.joints.iter().enumerate() {
                let (done, rest) = data.bodies.split_at_mut(i);
                place(joint, joint.parent.map(|p| &done[p]), q[i], &mut rest[0]);
            }
        },
    )
}

/// Positions and velocities of all bodies, and their accelerations where joints do not accelerate.
#[inline(always)]
pub(crate) fn move_bodies<T: Scalar>(model: &Model, data: &mut Data<T>, q: &[T], dq: &[T]) {
    data.apart(
        #[inline(always)]
        |data| {
            let base = data.base_acceleration;
            for (i, joint) in model.joints.iter().enumerate() {
                let (done, rest) = data.bodies.split_at_mut(i);
                let (parent, body) = (joint.parent.map(|p| &done[p]), &mut rest[0]);
                place(joint, parent, q[i], body);
                let step = body.axis.scaled(dq[i]);
                match parent {
                    Some(p) => {
                        body.velocity = p.velocity.plus(&step);
                        body.acceleration = p.acceleration.plus(&body.velocity.cross(&step));
                    }
                    None => {
                        body.velocity = step;
                        body.acceleration = base;
                    }
                }
            }
        },
    )
}

/// Adds to the accelerations what joints that accelerate bring.
#[inline(always)]
pub(crate) fn accelerate_bodies<T: Scalar>(model: &Model, data: &mut Data<T>, ddq: &[T]) {
    for (i, joint) in model.joints.iter().enumerate() {
        let (done, rest) = data.bodies.split_at_mut(i);
        let body = &mut rest[0];
        body.motion = body.axis.scaled(ddq[i]);
        if let Some(p) = joint.parent {
            body.motion = body.motion.plus(&done[p].motion);
        }
        body.acceleration = body.acceleration.plus(&body.motion);
    }
}

/// Places all bodies at `q`.
#[inline(always)]
pub fn forward_kinematics<T: Scalar>(model: &Model, data: &mut Data<T>, q: &[T]) {
    place_bodies(model, data, q);
}

/// Pose of a frame in the base.
#[inline(always)]
pub fn frame_pose<T: Scalar>(model: &Model, data: &Data<T>, frame: usize) -> Pose<T> {
    let frame = &model.frames[frame];
    let like = data.like();
    match frame.joint {
        Some(body) => {
            let BodyState { rotation, position, .. } = data.bodies[body];
            Pose { rotation, position }.times(&frame.pose)
        }
        None => Pose {
            rotation: splat_rows(like, &frame.pose.rotation),
            position: splat3(like, frame.pose.position),
        },
    }
}

/// Jacobian of a frame (6 × n, row by row): linear velocity of its origin, then angular velocity, in the axes of the base,
/// for the speeds of the joints.
#[inline(always)]
pub fn frame_jacobian<T: Scalar>(model: &Model, data: &Data<T>, frame: usize, jacobian: &mut [T]) {
    let position = frame_pose(model, data, frame).position;
    fill_columns(model, frame, position[0], jacobian, |joint| {
        let axis = &data.bodies[joint].axis;
        (axis.at(position), axis.angular)
    });
}

/// Writes the column of every joint that moves `frame`, and zeros elsewhere.
#[inline(always)]
fn fill_columns<T: Scalar>(
    model: &Model,
    frame: usize,
    like: T,
    rows: &mut [T],
    column: impl Fn(usize) -> (Vec3<T>, Vec3<T>),
) {
    let n = model.n_joints();
    rows.fill(like.splat(0.0));
    let mut next = model.frames[frame].joint;
    while let Some(joint) = next {
        let (linear, angular) = column(joint);
        for (row, value) in linear.into_iter().chain(angular).enumerate() {
            rows[n * row + joint] = value;
        }
        next = model.joints[joint].parent;
    }
}

/// The arm at `q` as lines from point to point [m]: from joint to joint, and from the joints to the frames that they carry.
pub fn skeleton(model: &Model, data: &mut Data<f64>, q: &[f64]) -> Vec<[[f64; 3]; 2]> {
    forward_kinematics(model, data, q);
    let at = |body: Option<usize>| body.map_or([0.0; 3], |body| data.bodies[body].position);
    let joints = model.joints.iter().enumerate().map(|(k, joint)| [at(joint.parent), at(Some(k))]);
    let frames =
        (0..model.frames.len()).map(|k| [at(model.frames[k].joint), frame_pose(model, data, k).position]);
    joints.chain(frames).filter(|[from, to]| from != to).collect()
}

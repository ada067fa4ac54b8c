//! A robot as its file describes it: links and joints, the same for URDF and MJCF.

use hysteron_base::BadInput;

use crate::spatial::{Inertia, Pose, Vec3};

/// How a joint lets its two links move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Rotation about the axis; coordinates in rad.
    Revolute,
    /// Translation along the axis; coordinates in m.
    Prismatic,
}

/// Coupling of a joint to another: `ratio` times the coordinate of that joint, plus `offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct Mimic {
    /// Name of the other joint.
    pub joint: String,
    /// [-], or [m/rad] and the like where kinds differ.
    pub ratio: f64,
    /// [rad] or [m].
    pub offset: f64,
}

/// Limits and resistances of a joint's motion. Zero where the file has none.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointLimits {
    /// Least and greatest coordinate [rad] or [m]; `None` for a joint that turns for ever.
    pub range: Option<[f64; 2]>,
    /// Greatest speed [rad/s] or [m/s].
    pub speed_limit: Option<f64>,
    /// Greatest torque [N m] or force [N].
    pub effort_limit: Option<f64>,
    /// Inertia of rotor and gear as felt at the joint [kg m²] or [kg].
    pub armature: f64,
    /// Viscous friction [N m s/rad] or [N s/m].
    pub damping: f64,
    /// Dry friction [N m] or [N].
    pub dry_friction: f64,
    /// Of a spring between the two links [N m/rad] or [N/m].
    pub stiffness: f64,
    /// Coordinate at which that spring has no torque [rad] or [m].
    pub spring_reference: f64,
}

pub(super) struct Link {
    pub name: String,
    /// Where it was read, for errors.
    pub place: String,
    /// In the axes of the link, about its origin; `None` where the file has none.
    pub inertia: Option<Inertia<f64>>,
    /// Share of its weight that is compensated without a torque [-].
    pub compensation: f64,
}

pub(super) struct JointDescription {
    pub name: String,
    pub place: String,
    /// `None` for a joint that is fixed.
    pub kind: Option<JointKind>,
    pub parent: usize,
    pub child: usize,
    /// Of the child in the parent, at zero.
    pub origin: Pose<f64>,
    /// Unit vector in the axes of `origin`.
    pub axis: Vec3<f64>,
    pub drive: JointLimits,
    pub mimic: Option<Mimic>,
}

/// A joint of several degrees of freedom that holds a whole robot, and is taken as fixed at coordinate zero.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeJoint {
    /// Name of the joint.
    pub name: String,
    /// Where it was read.
    pub place: String,
    /// Kind of the joint as the file names it: `floating`, `planar`, `free`.
    pub kind: String,
}

pub(super) struct Description {
    pub file: String,
    pub name: String,
    pub links: Vec<Link>,
    pub joints: Vec<JointDescription>,
    /// Points and axes without mass: name, link, pose in the link.
    pub sites: Vec<(String, usize, Pose<f64>)>,
    /// Joints of several degrees of freedom, which are fixed ones in `joints`.
    pub free: Vec<FreeJoint>,
    /// Error in a link, by its number, raised should the link move.
    pub faults: Vec<(usize, BadInput)>,
    pub gravity: Vec3<f64>,
}

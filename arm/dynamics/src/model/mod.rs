//! A robot: bodies on joints, as numbers that never change.
//!
//! Frames are turned when a robot is read, so that every joint moves about or along the z axis of its frame: a joint
//! is then two numbers (cos, sin) and one constant placement. Links that are fixed to each other are one body; each of
//! them stays a frame with its name.

mod build;
mod builtin;
mod definite;
mod description;
mod edit;
mod mjcf;
mod urdf;
mod write;
mod xacro;
mod xml;

use std::collections::BTreeMap;
use std::path::Path;

use hysteron_base::{BadInput, Result, file};

pub use description::{FreeJoint, JointKind, JointLimits};

use crate::spatial::{Inertia, Pose, Vec3, add_scaled3, add3, mul3};

/// Joints that a robot may have.
pub const MAX_JOINTS: usize = 64;

/// Names that an error lists.
const MAX_NAMED: usize = 100;

/// A tree of bodies. Joints are numbered from the base outwards: a parent comes before its children.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    pub(crate) name: String,
    pub(crate) joints: Vec<Joint>,
    pub(crate) frames: Vec<Frame>,
    pub(crate) gravity: Vec3<f64>,
    pub(crate) base: Inertia<f64>,
    pub(crate) notes: Notes,
}

/// Notes of the reader on a robot: joints taken as fixed, and warnings.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Notes {
    /// Joints of several degrees of freedom that were taken as fixed.
    pub welded: Vec<FreeJoint>,
    /// Warnings of what was ignored or looks wrong, a sentence each.
    pub warnings: Vec<String>,
}

/// Mounting of a robot's base.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Base {
    /// As in the file: a robot that floats is refused.
    #[default]
    AsInFile,
    /// The world: joints of several degrees of freedom are taken as fixed.
    Fixed,
}

/// Which mass matrices a robot may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Masses {
    /// Those from which accelerations follow.
    #[default]
    Definite,
    /// Any: enough for kinematics and inverse dynamics.
    Any,
}

/// Values of `$(arg NAME)`.
pub type Arguments = BTreeMap<String, String>;

/// How a robot is read where there is a choice.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReadOptions {
    /// Mounting of its base.
    pub base: Base,
    /// Which mass matrices it may have.
    pub masses: Masses,
    /// Values of the arguments of a file of xacro.
    pub arguments: Arguments,
}

/// A joint and the body that it moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Unique.
    pub name: String,
    /// About or along z.
    pub kind: JointKind,
    /// The joint whose body carries this one; `None` on the base.
    pub parent: Option<usize>,
    /// Of the joint's frame, at zero, in the frame of its parent.
    pub placement: Pose<f64>,
    /// Of the body, in the joint's frame, which moves with it.
    pub inertia: Inertia<f64>,
    /// Limits, friction, rotor.
    pub drive: JointLimits,
    /// The joint that this one follows.
    pub follows: Option<Follower>,
    /// Weightless part of the body.
    pub weightless: Weightless,
}

/// Mass whose weight is carried without torques of the joints, as by buoyancy, in the joint's frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Weightless {
    /// [kg].
    pub mass: f64,
    /// Mass times its centre [kg m].
    pub first: Vec3<f64>,
}

impl Weightless {
    /// A part of the mass of a body.
    pub(crate) fn part(of: &Inertia<f64>, part: f64) -> Self {
        Self { mass: part * of.mass, first: of.first.map(|h| part * h) }
    }

    /// Both together.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self { mass: self.mass + other.mass, first: add3(self.first, other.first) }
    }

    /// The same in a frame in which its own frame is at `pose`.
    pub(crate) fn placed(&self, pose: &Pose<f64>) -> Self {
        let turned = mul3(&pose.rotation, self.first);
        Self { mass: self.mass, first: add_scaled3(turned, self.mass, pose.position) }
    }
}

/// q = ratio · q of `joint` + offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Follower {
    /// The joint that leads.
    pub joint: usize,
    /// [-], or [m/rad] and the like where kinds differ.
    pub ratio: f64,
    /// [rad] or [m].
    pub offset: f64,
}

/// A frame with a name, fixed to a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Unique: that of a link, or of a site.
    pub name: String,
    /// The joint whose body it is fixed to; `None` on the base.
    pub joint: Option<usize>,
    /// In the joint's frame.
    pub pose: Pose<f64>,
}

impl Model {
    /// Reads a file of URDF or MJCF, whichever it is.
    ///
    /// # Errors
    /// `BadInput` naming file, line and element for a model that is no arm; `Io` if the file cannot be read.
    pub fn read(path: &Path) -> Result<Self> {
        Self::read_with(path, &ReadOptions::default())
    }

    /// As [`Self::read`], with choices.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_with(path: &Path, options: &ReadOptions) -> Result<Self> {
        let text = file::read_text(path)?;
        Ok(Self::from_text_with(&text, &xml::file_name(path), path.parent(), options)?)
    }

    /// Takes `text` as MJCF where it begins with `<mujoco>`, else as URDF; `name` is the file in errors.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn from_text(text: &str, name: &str) -> std::result::Result<Self, BadInput> {
        Self::from_text_with(text, name, None, &ReadOptions::default())
    }

    /// As [`Self::from_text`], with choices; files that it includes are looked for from `folder`.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn from_text_with(
        text: &str,
        name: &str,
        folder: Option<&Path>,
        options: &ReadOptions,
    ) -> std::result::Result<Self, BadInput> {
        let model = if xml::root_is(text, "mujoco") {
            mjcf::read(text, name, folder)?
        } else {
            urdf::read(&xacro::expanded(xml::elements(text, name)?, folder, &options.arguments)?)?
        };
        if options.base == Base::AsInFile {
            model.check_held()?;
        }
        if options.masses == Masses::Definite {
            model.check_definite(name)?;
        }
        Ok(model)
    }

    /// Takes `text` as URDF; `name` is the file in errors.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn from_urdf(text: &str, name: &str) -> std::result::Result<Self, BadInput> {
        let model = urdf::read(&xacro::expanded(xml::elements(text, name)?, None, &Arguments::new())?)?;
        model.check_held().and_then(|()| model.check_definite(name)).map(|()| model)
    }

    /// Takes `text` as MJCF; `name` is the file in errors.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn from_mjcf(text: &str, name: &str) -> std::result::Result<Self, BadInput> {
        let model = mjcf::read(text, name, None)?;
        model.check_held().and_then(|()| model.check_definite(name)).map(|()| model)
    }

    /// Table in Markdown of every element and attribute of URDF with its treatment by the reader.
    pub fn urdf_table() -> String {
        urdf::table()
    }

    /// Table in Markdown of every element and attribute of MJCF with its treatment by the reader.
    pub fn mjcf_table() -> String {
        mjcf::table()
    }

    /// Refuses a robot that floats.
    fn check_held(&self) -> std::result::Result<(), BadInput> {
        let Some(first) = self.notes.welded.first() else { return Ok(()) };
        let found = format!("joint \"{}\", which is {}", first.name, first.kind);
        Err(BadInput::new(&first.place, "a base that does not move", found)
            .hint("add --fix-base, which holds the robot where this joint is at zero"))
    }

    /// Name of the robot and of its joints, and what of it is held, for recordings.
    pub fn describe(&self, extra: &mut BTreeMap<String, String>) {
        let names = |names: &mut dyn Iterator<Item = &str>| names.collect::<Vec<_>>().join(", ");
        extra.insert("robot".to_owned(), self.name.clone());
        let joints = names(&mut self.joints.iter().map(|joint| joint.name.as_str()));
        extra.insert("joint_names".to_owned(), joints);
        if !self.notes.welded.is_empty() {
            let held = names(&mut self.notes.welded.iter().map(|joint| joint.name.as_str()));
            extra.insert("held_joints".to_owned(), held);
        }
    }

    /// Notes of the reader on the robot: joints taken as fixed, and warnings.
    pub fn notes(&self) -> &Notes {
        &self.notes
    }

    /// Name of the robot.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The joints that move, parents first.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// Number of joints n.
    pub fn n_joints(&self) -> usize {
        self.joints.len()
    }

    /// Links and sites.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// Gravity in the axes of the base [m/s²].
    pub fn gravity(&self) -> Vec3<f64> {
        self.gravity
    }

    /// Number of the joint called `name`.
    pub fn joint(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }

    /// Number of the frame called `name`.
    ///
    /// # Errors
    /// `BadInput` with the names there are.
    pub fn frame(&self, name: &str) -> std::result::Result<usize, BadInput> {
        self.frames.iter().position(|frame| frame.name == name).ok_or_else(|| {
            let mut names: Vec<&str> =
                self.frames.iter().take(MAX_NAMED).map(|frame| frame.name.as_str()).collect();
            if self.frames.len() > MAX_NAMED {
                names.push("…");
            }
            BadInput::new("frame", format!("one of {}", names.join(", ")), format!("\"{name}\""))
        })
    }

    /// Joint `from`, its parent, and so on to the base.
    #[inline(always)]
    pub(crate) fn way_to_base(&self, from: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(from), |joint| self.joints[*joint].parent)
    }
}

//! `hysteron arm info` and `hysteron arm check`.

use hysteron_arm::{JointKind, Model};
use hysteron_base::BadInput;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Context;

/// Print the joints of a robot: tree, masses, ranges, reach
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// File of URDF or MJCF, or name of a built-in robot
    pub model: String,
    /// How it is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: super::RobotOptions,
}

/// As info; fails where numbers look wrong
///
/// Suspicious are masses and inertias that no body has, and lengths, masses and inertias that look like mm or g.
/// Exit code 2 where something is.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct CheckOptions {
    /// File of URDF or MJCF, or name of a built-in robot
    pub model: String,
    /// How it is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: super::RobotOptions,
}

/// The outcome of `arm info` and of `arm check`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Name of the robot.
    pub robot: String,
    /// Joints that move.
    pub joints: Vec<JointSummary>,
    /// Distance from the base that no point of the robot is beyond [m].
    pub reach_m: f64,
    /// Joints that are held at zero.
    pub held_joints: Vec<String>,
    /// Doubts about the file, as sentences.
    pub warnings: Vec<String>,
}

impl crate::shared::outcome::Outcome for Outcome {}

/// A joint in numbers.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct JointSummary {
    /// Name.
    pub name: String,
    /// Mass of what moves with it and with no later joint [kg].
    pub mass_kg: f64,
    /// Smallest and largest coordinate [rad or m]; none where the file has no limits.
    pub range: Option<[f64; 2]>,
}

impl Outcome {
    fn new(model: &Model) -> Self {
        let joints = model.joints().iter().map(|joint| JointSummary {
            name: joint.name.clone(),
            mass_kg: joint.inertia.mass,
            range: joint.drive.range,
        });
        Self {
            robot: model.name().to_owned(),
            joints: joints.collect(),
            reach_m: model.reach(),
            held_joints: model.notes().welded.iter().map(|joint| joint.name.clone()).collect(),
            warnings: model.notes().warnings.clone(),
        }
    }
}

/// Prints the robot.
///
/// # Errors
/// A robot that cannot be read.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let model = options.robot_options.model_of_any_mass(&options.model, context)?;
    print(&model, context);
    Ok(Outcome::new(&model))
}

/// Prints the robot and what looks wrong in it.
///
/// # Errors
/// A robot that cannot be read, or with numbers that look wrong.
pub fn check(options: &CheckOptions, context: &Context) -> anyhow::Result<Outcome> {
    let model = options.robot_options.model_of_any_mass(&options.model, context)?;
    print(&model, context);
    let suspicions = model.suspicions();
    context.print("");
    match suspicions.first() {
        None => context.print("nothing suspicious"),
        Some(first) => {
            suspicions.iter().for_each(|suspicion| context.print(suspicion));
            let found =
                if suspicions.len() == 1 { first.clone() } else { format!("{} of them", suspicions.len()) };
            return Err(BadInput::new(&options.model, "numbers that a robot can have", found).into());
        }
    }
    Ok(Outcome::new(&model))
}

fn print(model: &Model, context: &Context) {
    let mass: f64 = model.joints().iter().map(|joint| joint.inertia.mass).sum();
    context.print(format_args!("{}: {} joints, {mass:.3} kg that move", model.name(), model.n_joints()));
    context.print("");
    context.print("joint                          moves with                mass [kg]   from            to");
    for joint in model.joints() {
        let parent = joint.parent.map_or("the base", |parent| &model.joints()[parent].name);
        let shown = |q: f64| match joint.kind {
            JointKind::Revolute => format!("{:.1} deg", q.to_degrees()),
            JointKind::Prismatic => format!("{:.1} mm", 1e3 * q),
        };
        let [from, to] =
            joint.drive.range.map_or_else(|| ["any".to_owned(), "any".to_owned()], |range| range.map(shown));
        context.print(format_args!(
            "{:<30} {parent:<25} {:>9.4}   {from:<15} {to}",
            joint.name, joint.inertia.mass
        ));
        if let Some(follower) = joint.follows {
            let leader = &model.joints()[follower.joint].name;
            context.print(format_args!("    follows {leader}: {} q + {}", follower.ratio, follower.offset));
        }
    }
    context.print("");
    context.print(format_args!("reach at most {:.3} m", model.reach()));
    let frames: Vec<&str> = model.frames().iter().map(|frame| frame.name.as_str()).collect();
    context.print(format_args!("frames: {}", frames.join(", ")));
}

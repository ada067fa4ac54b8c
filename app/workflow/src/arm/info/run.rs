//! Prints a robot, and what looks wrong in it.

use hysteron_arm_dynamics::{JointKind, Model};
use hysteron_base::BadInput;

use super::{CheckOptions, Options, Outcome};
use crate::{Context, WorkflowError};

/// Prints the robot.
///
/// # Errors
/// A robot that cannot be read.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    let model = options.robot_options.model_of_any_mass(&options.model, context)?;
    print(&model, context);
    Ok(Outcome::new(&model))
}

/// Prints the robot and what looks wrong in it.
///
/// # Errors
/// A robot that cannot be read, or with numbers that look wrong.
pub fn check(options: &CheckOptions, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(checked(options, context)?)
}

fn checked(options: &CheckOptions, context: &Context) -> anyhow::Result<Outcome> {
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

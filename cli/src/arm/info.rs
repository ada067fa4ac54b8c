//! `hysteron arm info` and `hysteron arm check`.

use hysteron_arm::{JointKind, Model};
use hysteron_base::BadInput;

use crate::terminal::say;

/// Print the joints of a robot: tree, masses, ranges, reach
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// File of URDF or MJCF, or name of a built-in robot
    model: String,
}

/// As info; fails where numbers look wrong
///
/// Suspicious are masses and inertias that no body has, and lengths, masses and inertias that look like mm or g.
/// Exit code 2 where something is.
#[derive(Debug, clap::Args)]
pub struct CheckArguments {
    /// File of URDF or MJCF, or name of a built-in robot
    model: String,
}

/// Prints the robot.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    print(&super::model(&arguments.model)?);
    Ok(())
}

/// Prints the robot and what looks wrong in it.
pub fn check(arguments: &CheckArguments) -> anyhow::Result<()> {
    let model = super::model(&arguments.model)?;
    print(&model);
    let suspicions = model.suspicions();
    say("");
    match suspicions.first() {
        None => say("nothing suspicious"),
        Some(first) => {
            suspicions.iter().for_each(say);
            let found =
                if suspicions.len() == 1 { first.clone() } else { format!("{} of them", suspicions.len()) };
            return Err(BadInput::new(&arguments.model, "numbers that a robot can have", found).into());
        }
    }
    Ok(())
}

fn print(model: &Model) {
    let mass: f64 = model.joints().iter().map(|joint| joint.inertia.mass).sum();
    say(format_args!("{}: {} joints, {mass:.3} kg that move", model.name(), model.n_joints()));
    say("");
    say("joint                          moves with                mass [kg]   from            to");
    for joint in model.joints() {
        let parent = joint.parent.map_or("the base", |parent| &model.joints()[parent].name);
        let shown = |q: f64| match joint.kind {
            JointKind::Revolute => format!("{:.1} deg", q.to_degrees()),
            JointKind::Prismatic => format!("{:.1} mm", 1e3 * q),
        };
        let [from, to] =
            joint.drive.range.map_or_else(|| ["any".to_owned(), "any".to_owned()], |range| range.map(shown));
        say(format_args!("{:<30} {parent:<25} {:>9.4}   {from:<15} {to}", joint.name, joint.inertia.mass));
        if let Some(follower) = joint.follows {
            let leader = &model.joints()[follower.joint].name;
            say(format_args!("    follows {leader}: {} q + {}", follower.ratio, follower.offset));
        }
    }
    say("");
    say(format_args!("reach at most {:.3} m", model.reach()));
    let frames: Vec<&str> = model.frames().iter().map(|frame| frame.name.as_str()).collect();
    say(format_args!("frames: {}", frames.join(", ")));
}

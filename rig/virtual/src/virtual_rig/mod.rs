//! The virtual rig: a robot with physics of its own, its servos and its tracker.
//!
//! Its body is an elastic rod with tendons that rub, stick and go slack; it is not the twin, and shares no code with
//! it.

mod body;
mod bounds;
mod draw;
mod equilibrium;
mod files;
mod linear;
mod loops;
mod population;
mod population_schema;
mod robot;
mod schema;
mod section;
mod sensor;
mod simulated;
#[cfg(test)]
mod tests;
mod world;

pub(crate) use draw::gaussian;
pub use loops::{LoopWidth, loop_width};
pub use population::{Population, PopulationSpread, Ranges};
pub use robot::{BodyParameters, ServoParameters, TendonParameters, TrackerParameters, VirtualRobot};
pub use sensor::TrackedPose;
pub use simulated::{ExternalForceHandle, SimulatedRig};
pub use world::{BalanceCounts, RigEnergy, World};

use hysteron_rig::config::RIG_FILE;

/// The rig file that goes with a virtual robot: its pulleys and which way they wind.
pub fn rig_file(robot: &VirtualRobot) -> String {
    let winds = robot.servos.directions.iter().map(|sign| if *sign < 0.0 { "negative" } else { "positive" });
    let mut parts = RIG_FILE.split("winds = \"positive\"");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for (part, winds) in parts.zip(winds) {
        text.push_str(&format!("winds = \"{winds}\""));
        text.push_str(part);
    }
    let radius = format!("pulley_radius_mm = {:?}", 1e3 * robot.servos.pulley_radius);
    text.replace("pulley_radius_mm = 10.0", &radius)
}

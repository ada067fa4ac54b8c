//! Trials of the virtual arm with an object, and the expert that shows how.

use hysteron_base::rng;
use hysteron_virtual_rig::virtual_arm::{ArmControl, N_JOINTS, N_SERVOS, Reading, VirtualArm, VirtualLeader};
use nalgebra::Vector3;
use rand::RngExt;

use super::score::Task;

/// Virtual arm of the study, and the seed that draws the individual, as `hysteron arm generate` has it by default.
pub(super) const ARM: (&str, u64) = ("open-manipulator-x", 0);
/// Heaviest object [kg].
pub(super) const HEAVIEST: f64 = 0.5;
/// For how long before the end the tip must be near its goal [s].
pub(super) const STAYS: f64 = 2.0;
/// Rate at which the expert's lead follows the error [1/s].
const EXPERT: f64 = 2.5;
/// Furthest that goals lead [rad].
pub(super) const MAX_LEAD: f64 = 0.25;
/// Jaws that hold the object [m].
const HELD: f64 = 0.0225;

/// An object to handle.
pub(super) struct Trial {
    plan: VirtualLeader,
    mass: f64,
    goal: Vector3<f64>,
    name: String,
}

impl Trial {
    pub fn draw(arm: &VirtualArm, task: Task, set: &str, number: usize) -> Self {
        let name = format!("cloning/{task:?}/{set}/{number}");
        let mut stream = rng(ARM.1, &name);
        let mut about = |centre: [f64; 3], by: f64| {
            Vector3::from_fn(|k, _| centre[k] + by * stream.random_range(-1.0..1.0))
        };
        let mut plan = VirtualLeader::steady(&arm.chain);
        let goal = match task {
            Task::Place => {
                let [from, to] = [-0.09, 0.09].map(|y| about([0.20, y, 0.03], 0.02));
                let (to, pitch) = (Vector3::new(to.x, to.y, 0.03), 0.6);
                let above = Vector3::z() * 0.08;
                plan.reaches(0.0, from + above, pitch, HELD);
                plan.reaches(1.8, 0.5 * (from + to) + 1.3 * above, pitch, HELD);
                plan.reaches(1.6, to + above, pitch, HELD);
                plan.reaches(1.4, to, pitch, HELD);
                to
            }
            Task::Stay => {
                let [from, to] = [[0.22, 0.0, 0.06], [0.23, 0.0, 0.19]].map(|centre| about(centre, 0.025));
                plan.reaches(0.0, from, 0.45, HELD);
                plan.reaches(2.4, to, 0.45, HELD);
                to
            }
        };
        plan.stays(STAYS + 1.0);
        let mass = HEAVIEST * stream.random_range(0.0..1.0);
        Self { plan, mass: mass.max(1e-3), goal, name }
    }

    /// Largest distance from the goal in the last seconds [m].
    pub fn run(&self, arm: &VirtualArm, control: &mut ArmControl<'_>) -> f64 {
        let weight = [0.0, 0.0, -self.mass * arm.chain.gravity.norm()];
        let mut control = |reading: &Reading, planned: &[f64; N_SERVOS], _| control(reading, planned, weight);
        let moments = arm.handle((&self.plan, self.mass), (ARM.1, &self.name), &mut control);
        let end = self.plan.end() - STAYS;
        moments.iter().filter(|m| m.time >= end).map(|m| (m.tip - self.goal).norm()).fold(0.0, f64::max)
    }
}

/// Leads the goals until the arm is where it is planned to be.
#[derive(Default)]
pub(super) struct Expert {
    /// Lead of every joint [rad].
    pub lead: [f64; N_JOINTS],
    last: Option<f64>,
}

impl Expert {
    pub fn control(&mut self, reading: &Reading, planned: &[f64; N_SERVOS]) -> [f64; N_SERVOS] {
        let passed = reading.time - self.last.replace(reading.time).unwrap_or(reading.time);
        for (k, lead) in self.lead.iter_mut().enumerate() {
            let error = planned[k] - reading.position[k];
            *lead = (*lead + EXPERT * passed * error).clamp(-MAX_LEAD, MAX_LEAD);
        }
        led(planned, &self.lead)
    }
}

/// Goals with these leads.
pub(super) fn led(planned: &[f64; N_SERVOS], lead: &[f64]) -> [f64; N_SERVOS] {
    let mut goals = *planned;
    goals.iter_mut().zip(lead).for_each(|(goal, lead)| *goal += lead);
    goals
}

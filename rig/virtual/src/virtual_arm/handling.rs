//! An object of unknown mass in the jaws, and a program that moves the arm with it: what a policy is tried on.
//!
//! The object is held from the beginning and never leaves; the arm has its servos, backlash and friction, and is read 60 times a second
//! as in recordings. Its controller has only measured values.

use hysteron_base::rng;
use nalgebra::Vector3;

use super::chain::N_JOINTS;
use super::leader::VirtualLeader;
use super::robot::VirtualArm;
use super::task::Labels;
use super::telemetry::{Reading, TelemetryRecorder};
use super::world::{ArmWorld, N_SERVOS};

/// Side of the object [m].
const WIDTH: f64 = 0.024;
/// Time in which the arm comes to rest at the start with the object in its jaws, before anything counts [s].
const SETTLE: f64 = 1.0;

/// Where the tip of the arm truly was at a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Since the beginning [s].
    pub time: f64,
    /// In the frame of the base [m].
    pub tip: Vector3<f64>,
}

/// Controller of the arm: from a reading, the goals planned for its time [rad] and the true force on the tip,
/// known only in simulation [N], it returns the goals of the servos [rad].
pub type ArmControl<'a> = dyn FnMut(&Reading, &[f64; N_SERVOS], [f64; 3]) -> [f64; N_SERVOS] + 'a;

impl VirtualArm {
    /// Handles `mass` [kg] for as long as `plan` lasts, from where it begins. `control` is asked at every reading.
    ///
    /// All noise comes from `seed` and `name`.
    pub fn handle(
        &self,
        (plan, mass): (&VirtualLeader, f64),
        (seed, name): (u64, &str),
        control: &mut ArmControl<'_>,
    ) -> Vec<Moment> {
        let start = plan.at(0.0);
        let temperatures = self.supply.temperatures(&mut rng(seed, &format!("virtual-arm/{name}/heat")));
        let angles = std::array::from_fn(|k| start[k]);
        let mut world = ArmWorld::new(self, angles, start[N_JOINTS], temperatures).with_payload(mass, WIDTH);
        let mut goals = VirtualLeader::goals(&start, &self.gripper);
        world.goals = goals.map(Some);
        while world.time() < SETTLE {
            world.step();
        }
        let mut recorder = TelemetryRecorder::new(self, Labels::None, seed, name);
        let (origin, mut moments) = (world.time(), Vec::new());
        loop {
            let time = world.time() - origin;
            if recorder.is_due(time) {
                recorder.read(&world, time, &goals);
                moments.push(Moment { time, tip: self.chain.at(&world.q, &world.dq).tip });
                if let Some((reading, force)) = recorder.last() {
                    let planned = VirtualLeader::goals(&plan.at(time), &self.gripper);
                    goals = control(&reading, &planned, force);
                    world.goals = goals.map(Some);
                }
            }
            if time >= plan.end() {
                return moments;
            }
            world.step();
            recorder.watch(&world);
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may stop where it stands
mod tests {
    use super::*;

    fn droop(mass: f64, add: f64) -> f64 {
        let arm = VirtualArm::preset("open-manipulator-x").unwrap();
        let mut plan = VirtualLeader::steady(&arm.chain);
        let goal = Vector3::new(0.22, 0.0, 0.15);
        // It comes from elsewhere: where it never moves, stiction holds any of these weights.
        plan.reaches(0.0, Vector3::new(0.2, 0.05, 0.12), 0.4, 0.02);
        plan.reaches(1.5, goal, 0.3, 0.02);
        plan.stays(1.5);
        let moments = arm.handle((&plan, mass), (1, "droop"), &mut |_, planned, _| {
            let mut goals = *planned;
            goals[1] -= add;
            goals
        });
        assert!((moments.len() as f64 - 3.0 / arm.telemetry.period).abs() < 4.0, "{}", moments.len());
        goal.z - moments.last().unwrap().tip.z
    }

    #[test]
    fn the_arm_droops_by_the_weight_and_goals_that_lead_take_it_back() {
        let (empty, full) = (droop(1e-6, 0.0), droop(0.5, 0.0));
        // Stiffness of the servos: registers over the motor's torque per duty, at the shoulder alone some 1.1 N m more.
        assert!(full - empty > 3e-3, "{empty} {full}");
        let led = droop(0.5, 0.05);
        assert!(led < full - 5e-3, "{full} {led}");
    }

    #[test]
    fn the_same_seed_is_the_same_motion_and_the_force_is_the_weight_at_rest() {
        let arm = VirtualArm::preset("open-manipulator-x").unwrap();
        let mut plan = VirtualLeader::steady(&arm.chain);
        plan.reaches(0.0, Vector3::new(0.2, 0.05, 0.12), 0.4, 0.02);
        plan.stays(2.0);
        let mut last = [0.0; 3];
        let mut run = || {
            arm.handle((&plan, 0.3), (4, "twice"), &mut |_, planned, force| {
                last = force;
                *planned
            })
        };
        assert_eq!(run(), run());
        assert!((last[2] + 0.3 * 9.81).abs() < 0.02 && last[0].abs() < 0.02, "{last:?}");
    }
}

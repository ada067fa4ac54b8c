//! A trajectory: the leader moves, the follower follows, and is recorded.

use hysteron_base::{Metadata, Recording, rng};
use nalgebra::Vector3;

use super::chain::N_JOINTS;
use super::leader::VirtualLeader;
use super::robot::VirtualArm;
use super::task::{ArmTrial, Degraded};
use super::telemetry::TelemetryRecorder;
use super::world::{ArmWorld, N_SERVOS};
use hysteron_rig::Result;

/// Names of the joints in the recordings, as NAD's importer gives them.
const JOINT_NAMES: &str = "joint1, joint2, joint3, joint4, gripper_motor";

impl VirtualArm {
    /// Records a trajectory. Everything that is drawn for it comes from `seed` and `name`; `meta` is its provenance.
    ///
    /// # Errors
    /// `BadInput` if the arm of the file does not keep finite.
    pub fn record(&self, trial: &ArmTrial, seed: u64, name: &str, meta: Metadata) -> Result<Recording> {
        let stream = |what: &str| rng(seed, &format!("virtual-arm/{name}/{what}"));
        let course = trial.course(self, &mut stream("course"));
        let temperatures = self.supply.temperatures(&mut stream("heat"));
        let start = course.leader.at(0.0);
        let angles = std::array::from_fn(|k| start[k]);
        let mut world =
            ArmWorld::new(self, angles, start[N_JOINTS], temperatures).with_faults(&course.faults);
        if let Some(object) = course.object {
            world = world.with_object(object);
        }
        relax_to_equilibrium(&mut world, &VirtualLeader::goals(&start, &self.gripper));
        let mut recorder = TelemetryRecorder::new(self, trial.labels, seed, name);
        let origin = world.time();
        let end = course.leader.end();
        loop {
            let time = world.time() - origin;
            if recorder.is_due(time) {
                // As a recorder with two arms does: read the leader, send the follower there, read the follower.
                let goals = VirtualLeader::goals(&course.leader.at(time), &self.gripper);
                world.goals = goals.map(Some);
                recorder.read(&world, time, &goals);
            }
            if time >= end {
                break;
            }
            world.push = course.push_at(time);
            world.step();
            recorder.watch(&world);
        }
        let meta = self.described(trial, &course.faults, seed, name, meta);
        let hint = "a smaller step_ms, or smaller gains, stiffness and damping";
        Ok(recorder.finish(meta).map_err(|bad| bad.within(format!("arm {}", self.name)).hint(hint))?)
    }

    fn described(
        &self,
        trial: &ArmTrial,
        faults: &[super::JointFault],
        seed: u64,
        name: &str,
        mut meta: Metadata,
    ) -> Metadata {
        meta.source = format!("virtual arm {} in place of NAD: {name}", self.name);
        meta.scene_hash.clone_from(&self.hash);
        meta.seed = Some(seed);
        let mut note = |key: &str, value: String| meta.extra.insert(key.to_owned(), value);
        note("robot", self.name.clone());
        note("joint_names", JOINT_NAMES.to_owned());
        note("trajectory", name.to_owned());
        note("payload_kg", trial.payload.to_string());
        note("condition", if trial.degraded == Degraded::No { "healthy" } else { "degraded" }.to_owned());
        note("truth", "channels truth_* are known to the simulation alone".to_owned());
        if let [fault, ..] = faults {
            note("fault", fault.describe());
        }
        meta
    }
}

/// Lets the arm come to rest where the leader starts.
fn relax_to_equilibrium(world: &mut ArmWorld, goals: &[f64; N_SERVOS]) {
    /// Longer than any arm swings [s].
    const MAX_SWING: f64 = 2.0;
    world.goals = goals.map(Some);
    world.push = Vector3::zeros();
    let until = world.time() + MAX_SWING;
    while world.time() < until {
        world.step();
    }
}

//! The virtual rig in this process, on a clock of its own: as fast as the machine computes.

use super::{TrackedPose, VirtualRobot, World};
use hysteron_actuator::Gains;
use hysteron_rig::bus::model::XL430_W250;
use hysteron_rig::bus::registers::StoredRegisters;
use hysteron_rig::bus::{BusCounts, ServoReport, xl430};
use hysteron_rig::config::RigConfig;
use hysteron_rig::{Event, Hardware, Pose, Result, ServoSample, SlowSample};
use std::sync::{Arc, Mutex, PoisonError};

/// An external force on the tip of a simulated rig while it is recorded. Clones share it.
#[derive(Debug, Clone, Default)]
pub struct ExternalForceHandle(Arc<Mutex<[f64; 3]>>);

impl ExternalForceHandle {
    /// Exerts this force, in the robot's frame [N], from the next cycle on.
    pub fn push(&self, force: [f64; 3]) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = force;
    }

    fn force(&self) -> [f64; 3] {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A simulated rig. The same seed gives the same bytes.
#[derive(Debug, Clone)]
pub struct SimulatedRig {
    world: World,
    rig: RigConfig,
    poses: Vec<TrackedPose>,
    cycles: BusCounts,
    /// Where there is one, tensions and the force on the tip are recorded as they truly are.
    hand: Option<ExternalForceHandle>,
}

impl SimulatedRig {
    /// Switches a virtual robot on.
    pub fn new(robot: &VirtualRobot, rig: &RigConfig, seed: u64) -> Self {
        let world = World::new(robot, seed);
        Self {
            world,
            rig: rig.clone(),
            poses: Vec::with_capacity(64),
            cycles: BusCounts::default(),
            hand: None,
        }
    }

    /// Applies an external force to the tip: tensions at the pulleys and the force on the tip are then instruments of the
    /// rig, without error.
    pub fn give_to(&mut self, hand: ExternalForceHandle) {
        self.hand = Some(hand);
    }

    /// The world, for what no instrument shows.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The same, for scripted mishaps.
    pub fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }
}

impl Hardware for SimulatedRig {
    fn now(&self) -> f64 {
        self.world.time()
    }

    fn wait_until(&mut self, time: f64) {
        if let Some(hand) = &self.hand {
            self.world.set_tip_force(hand.force());
        }
        let left = time - self.world.time();
        if left > 0.0 {
            self.world.advance(left);
        }
    }

    fn is_real_time(&self) -> bool {
        false
    }

    fn n_servos(&self) -> usize {
        self.world.n_servos()
    }

    fn prepare(&mut self) -> Result<Vec<ServoReport>> {
        let [p, i, d] = self.rig.servos.gains;
        let ids = self.rig.ids();
        let reports = ids.iter().enumerate().map(|(k, id)| {
            let command = self.world.command_mut(k);
            command.gains = Gains { p, i, d };
            command.torque_on = false;
            let servo = self.world.servo(k);
            ServoReport {
                id: *id,
                model: XL430_W250.number,
                firmware: 0,
                mode: xl430::mode::EXTENDED_POSITION,
                voltage_v: servo.voltage(),
                temperature_degc: servo.state.winding_temperature,
                hardware_error: 0,
                torque_on: false,
                position: servo.ticks(),
                registers: StoredRegisters::default(),
            }
        });
        Ok(reports.collect())
    }

    fn write_goals(&mut self, goals: &[i32]) -> Result<()> {
        self.cycles.instructions += 1;
        for (k, goal) in goals.iter().enumerate() {
            self.world.command_mut(k).goal = *goal;
        }
        Ok(())
    }

    fn read_servos(&mut self, samples: &mut [Option<ServoSample>]) -> Result<()> {
        self.cycles.answers += samples.len() as u64;
        for (k, sample) in samples.iter_mut().enumerate() {
            let load = (self.world.load(k) / xl430::LOAD_UNIT).round() * xl430::LOAD_UNIT;
            let torque_on = self.world.command_mut(k).torque_on;
            let servo = self.world.servo(k);
            let position = servo.ticks();
            let velocity = servo.state.velocity;
            *sample = Some(ServoSample { position, velocity, load, torque_on, hardware_error: 0 });
        }
        Ok(())
    }

    fn read_slow(&mut self, samples: &mut [Option<SlowSample>]) -> Result<()> {
        for (k, sample) in samples.iter_mut().enumerate() {
            let servo = self.world.servo(k);
            let temperature = servo.state.winding_temperature.floor();
            *sample = Some(SlowSample { voltage: servo.voltage(), temperature });
        }
        Ok(())
    }

    fn enable_torque(&mut self) -> Result<()> {
        for k in 0..self.world.n_servos() {
            let position = self.world.servo(k).ticks();
            let command = self.world.command_mut(k);
            if !command.torque_on {
                (command.goal, command.torque_on) = (position, true);
            }
        }
        Ok(())
    }

    fn disable_torque(&mut self) -> Result<()> {
        (0..self.world.n_servos()).for_each(|k| self.world.command_mut(k).torque_on = false);
        Ok(())
    }

    fn hold(&mut self) -> Result<()> {
        Ok(())
    }

    fn instruments(&self) -> Vec<String> {
        if self.hand.is_none() {
            return Vec::new();
        }
        let tensions = (1..=self.n_servos()).map(|k| format!("true_tension_{k}_n"));
        tensions.chain(["x", "y", "z"].map(|axis| format!("true_tip_force_{axis}_n"))).collect()
    }

    fn read_instruments(&mut self, values: &mut Vec<f64>) {
        if self.hand.is_some() {
            values.extend((0..self.n_servos()).map(|k| self.world.tension(k)));
            values.extend(self.world.tip_force());
        }
    }

    fn take_poses(&mut self, poses: &mut Vec<Pose>) {
        self.poses.clear();
        self.world.take_poses(&mut self.poses);
        poses.extend(self.poses.iter().map(|tracked| tracked.pose));
    }

    fn take_events(&mut self, _events: &mut Vec<Event>) {}

    fn counts(&self) -> BusCounts {
        self.cycles
    }

    fn processor_time(&self) -> Option<f64> {
        None
    }

    fn bus_time(&self) -> (f64, f64) {
        (0.0, 0.0)
    }
}

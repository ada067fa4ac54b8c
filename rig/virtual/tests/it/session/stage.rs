//! A simulated rig on which something happens in the middle of a recording or of a calibration.

use super::probe::simulated;
use hysteron_base::{Metadata, Recording};
use hysteron_rig::bus::{BusCounts, ServoReport};
use hysteron_rig::calibration::RigCalibration;
use hysteron_rig::config::RigConfig;
use hysteron_rig::session::{Outcome, RecordOptions, RigRecorder, RigSession};
use hysteron_rig::{Event, Hardware, Pose, Result, ServoSample, SlowSample};
use hysteron_virtual_rig::virtual_rig::{SimulatedRig, VirtualRobot, World, rig_file};
use std::cell::Cell;
use std::path::Path;
use std::rc::Rc;

/// Reads after which it happens: in the middle of the rows.
pub const MOMENT: usize = 150;

/// Fault to stage.
#[derive(Debug, Clone, Copy)]
pub enum Mishap {
    None,
    ToTheWorld(fn(&mut World)),
    /// This much more heat is read [°C].
    Heat(f64),
    /// Something else is read of the servos.
    Servos(fn(&mut [Option<ServoSample>])),
}

/// A simulated rig and its commands.
pub struct Stage {
    hardware: SimulatedRig,
    mishap: Mishap,
    n_reads: usize,
    /// Whether the servos are under torque, accessible while a session owns this.
    pub torque: Rc<Cell<bool>>,
    /// Goals, each time they are written.
    pub goals: Vec<Vec<i32>>,
    /// Largest load that was read, either way [-].
    pub load_max: f64,
    /// Goals of rest.
    pub rest: Vec<i32>,
}

impl Stage {
    /// A robot with the rig file of `typical` after these replacements.
    pub fn set(robot: &VirtualRobot, replace: &[(&str, &str)], mishap: Mishap) -> (Self, RigConfig) {
        let mut text = rig_file(robot);
        for (from, to) in replace {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        let config = RigConfig::from_toml(&text, Path::new("")).unwrap();
        let hardware = SimulatedRig::new(robot, &config, 1);
        let (torque, goals, rest) = Default::default();
        (Self { hardware, mishap, n_reads: 0, torque, goals, load_max: 0.0, rest }, config)
    }

    /// The calibration of `typical`, for the present positions of the servos; also notes the rest position.
    pub fn calibration(&mut self) -> RigCalibration {
        let positions: Vec<i32> = self.prepare().unwrap().iter().map(|servo| servo.position).collect();
        let calibration = simulated().0.unwrapped(&positions);
        self.rest = calibration.channels.iter().map(|channel| channel.zero).collect();
        calibration
    }

    /// Records these commands on the rig `typical`, with its rig file after these replacements.
    pub fn record(replace: &[(&str, &str)], commands: &Recording, mishap: Mishap) -> (Self, Outcome) {
        let robot = VirtualRobot::preset("typical").unwrap();
        let (mut stage, config) = Self::set(&robot, replace, mishap);
        let calibration = stage.calibration();
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("run.parquet");
        let options = RecordOptions::new(out, Metadata::default());
        let recorder = RigRecorder::begin(&config, &calibration, options).unwrap();
        let session = RigSession::start(&mut stage, &config, &calibration, 100.0).unwrap();
        let outcome = recorder.run(session, commands, &|| false, &mut |_| {}).unwrap();
        let n_rows = Recording::read(&outcome.out).map_or(0, |recording| recording.n_samples());
        assert_eq!(n_rows, outcome.n_rows);
        (stage, outcome)
    }

    /// Whether any servo is.
    pub fn is_under_torque(&mut self) -> bool {
        (0..4).any(|k| self.hardware.world_mut().command_mut(k).torque_on)
    }
}

impl Hardware for Stage {
    fn now(&self) -> f64 {
        self.hardware.now()
    }

    fn wait_until(&mut self, time: f64) {
        self.hardware.wait_until(time);
    }

    fn is_real_time(&self) -> bool {
        self.hardware.is_real_time()
    }

    fn n_servos(&self) -> usize {
        self.hardware.n_servos()
    }

    fn prepare(&mut self) -> Result<Vec<ServoReport>> {
        self.hardware.prepare()
    }

    fn write_goals(&mut self, goals: &[i32]) -> Result<()> {
        self.goals.push(goals.to_vec());
        self.hardware.write_goals(goals)
    }

    fn read_servos(&mut self, samples: &mut [Option<ServoSample>]) -> Result<()> {
        self.n_reads += 1;
        if self.n_reads == MOMENT
            && let Mishap::ToTheWorld(happens) = self.mishap
        {
            happens(self.hardware.world_mut());
        }
        self.hardware.read_servos(samples)?;
        if self.n_reads >= MOMENT
            && let Mishap::Servos(reads) = self.mishap
        {
            reads(samples);
        }
        let loads = samples.iter().flatten().map(|sample| sample.load.abs());
        self.load_max = loads.fold(self.load_max, f64::max);
        Ok(())
    }

    fn read_slow(&mut self, samples: &mut [Option<SlowSample>]) -> Result<()> {
        self.hardware.read_slow(samples)?;
        if let Mishap::Heat(more) = self.mishap
            && self.n_reads > MOMENT
        {
            samples.iter_mut().flatten().for_each(|sample| sample.temperature += more);
        }
        Ok(())
    }

    fn enable_torque(&mut self) -> Result<()> {
        self.torque.set(true);
        self.hardware.enable_torque()
    }

    fn disable_torque(&mut self) -> Result<()> {
        self.torque.set(false);
        self.hardware.disable_torque()
    }

    fn hold(&mut self) -> Result<()> {
        self.hardware.hold()
    }

    fn take_poses(&mut self, poses: &mut Vec<Pose>) {
        self.hardware.take_poses(poses);
    }

    fn take_events(&mut self, events: &mut Vec<Event>) {
        self.hardware.take_events(events);
    }

    fn counts(&self) -> BusCounts {
        self.hardware.counts()
    }

    fn processor_time(&self) -> Option<f64> {
        self.hardware.processor_time()
    }

    fn bus_time(&self) -> (f64, f64) {
        self.hardware.bus_time()
    }
}

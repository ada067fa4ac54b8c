//! Record of the emulator, against which a test or a person can check a driver: counts, faults with their
//! times, and which servos were under torque when.

use hysteron_base::json;
use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use super::faults::{BusFault, FaultKind};
use hysteron_rig::Result;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Name of the log of faults, in the folder of logs.
pub const FAULTS_LOG: &str = "faults.jsonl";
/// Name of the log of torques, in the folder of logs.
pub const TORQUE_LOG: &str = "torque.jsonl";

/// Counts of the traffic on the bus so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct TrafficCounts {
    /// Instructions with a right checksum.
    pub instructions: u64,
    /// Packets with a wrong checksum.
    pub bad_packets: u64,
    /// Answers sent, damaged ones among them.
    pub answers: u64,
    /// Sync reads of which every answer was sent whole.
    pub complete_rounds: u64,
    /// Sync reads of which an answer was missing or damaged.
    pub broken_rounds: u64,
    /// Time that the world did not live through, because the machine was too slow [ms].
    pub slipped_ms: u64,
}

/// When in the life of a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultMoment {
    /// It is armed, or active.
    Began,
    /// It hit a packet.
    Struck,
    /// It is over.
    Ended,
}

/// A line in the log of faults.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaultRecord {
    /// When [s], on the clock of the virtual rig.
    pub time_s: f64,
    /// In what moment of its life.
    pub moment: FaultMoment,
    /// The fault.
    #[serde(flatten)]
    pub fault: BusFault,
}

/// A line in the log of torques: written whenever one changes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TorqueRecord {
    /// When [s], on the clock of the virtual rig.
    pub time_s: f64,
    /// Whether each servo drives its motor (n_servos).
    pub torque_on: Vec<bool>,
}

/// Active faults of the tracker, for the sender of its poses.
#[derive(Debug, Clone, Default)]
pub struct TrackerFaults(Arc<Mutex<Vec<FaultKind>>>);

impl TrackerFaults {
    /// Whether this fault is active now.
    pub fn is_active(&self, kind: FaultKind) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).contains(&kind)
    }

    pub(super) fn set(&self, kinds: Vec<FaultKind>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = kinds;
    }
}

/// All that is remembered.
#[derive(Debug, Default)]
pub(super) struct TrafficRecorder {
    pub counts: TrafficCounts,
    pub faults: Vec<FaultRecord>,
    pub torques: Vec<TorqueRecord>,
    pub tracker: TrackerFaults,
    faults_file: Option<File>,
    torque_file: Option<File>,
}

impl TrafficRecorder {
    /// With new logs in this folder.
    ///
    /// # Errors
    /// `File` if the file system refuses.
    pub fn new(logs: Option<&Path>) -> Result<Self> {
        let mut recorder = Self::default();
        if let Some(folder) = logs {
            let create = |name: &str| {
                let path = folder.join(name);
                File::create(&path).map_err(|source| hysteron_base::Error::io(&path, source))
            };
            recorder.faults_file = Some(create(FAULTS_LOG)?);
            recorder.torque_file = Some(create(TORQUE_LOG)?);
        }
        Ok(recorder)
    }

    /// Notes a moment of a fault.
    pub fn fault(&mut self, time: f64, moment: FaultMoment, fault: &BusFault) {
        let record = FaultRecord { time_s: time, moment, fault: fault.clone() };
        append(&mut self.faults_file, &record);
        self.faults.push(record);
    }

    /// Notes which servos are under torque, if that is news.
    pub fn torque(&mut self, time: f64, torque_on: impl Iterator<Item = bool> + Clone) {
        let last = self.torques.last();
        if last.is_some_and(|last| last.torque_on.iter().copied().eq(torque_on.clone())) {
            return;
        }
        let record = TorqueRecord { time_s: time, torque_on: torque_on.collect() };
        append(&mut self.torque_file, &record);
        self.torques.push(record);
    }
}

/// Appends a line; a log that cannot be written is given up with a warning.
fn append(file: &mut Option<File>, record: &impl Serialize) {
    let Some(open) = file else { return };
    let line = json::to_line(record).map_err(std::io::Error::from);
    if let Err(error) = line.and_then(|line| writeln!(open, "{line}")) {
        tracing::warn!("a log of the emulator ends here: {error}");
        *file = None;
    }
}

//! Training tasks of the cells: networks, sizes, splits.

use hysteron_learn::{BlockKind, TemporalForm};
use serde::{Deserialize, Serialize};

use super::{Sample, Split};
use hysteron_arm_learning::neural::{
    ActuatorOptions, LossWeights, MotorModelKind, Motors, NeuralOptions, SensingOptions,
};

/// How much is trained.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NeuralSize {
    /// Some minutes for everything, to see that it works.
    Quick,
    /// Some minutes a network.
    Full,
}

/// Which cells are done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NeuralScope {
    /// All.
    Whole,
    /// Networks in the loop on the published split, without forces and conditions: the ablation alone.
    Networks,
}

/// A network in the loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NetworkKind {
    /// In tables.
    pub name: &'static str,
    /// In files.
    pub file: &'static str,
    /// How its layers are put together.
    pub block: BlockKind,
    /// Its form in time.
    pub form: TemporalForm,
    /// Context length [samples].
    pub tokens: usize,
    /// Motor model in addition to the network.
    pub prior: MotorModelKind,
}

/// Networks of the ablation, of one size; the first is that of all other cells.
pub const NETWORKS: [NetworkKind; 7] = [
    NetworkKind {
        name: "servo + streaming Transformer",
        file: "servo-streaming",
        block: BlockKind::GatedPreNorm,
        form: TemporalForm::Streaming,
        tokens: ActuatorOptions::TOKENS,
        prior: MotorModelKind::Servo,
    },
    NetworkKind {
        name: "servo + published Transformer",
        file: "servo-window",
        block: BlockKind::GatedPreNorm,
        form: TemporalForm::Window,
        tokens: ActuatorOptions::TOKENS,
        prior: MotorModelKind::Servo,
    },
    NetworkKind {
        name: "servo + residual perceptron of one sample",
        file: "servo-perceptron",
        block: BlockKind::GatedPreNorm,
        form: TemporalForm::Streaming,
        tokens: 1,
        prior: MotorModelKind::Servo,
    },
    NetworkKind {
        name: "servo + GRU",
        file: "servo-gru",
        block: BlockKind::Gru,
        form: TemporalForm::Streaming,
        tokens: ActuatorOptions::TOKENS,
        prior: MotorModelKind::Servo,
    },
    NetworkKind {
        name: "servo + LSTM",
        file: "servo-lstm",
        block: BlockKind::Lstm,
        form: TemporalForm::Streaming,
        tokens: ActuatorOptions::TOKENS,
        prior: MotorModelKind::Servo,
    },
    NetworkKind {
        name: "streaming Transformer alone",
        file: "streaming",
        block: BlockKind::GatedPreNorm,
        form: TemporalForm::Streaming,
        tokens: ActuatorOptions::TOKENS,
        prior: MotorModelKind::None,
    },
    NetworkKind {
        name: "published Transformer alone",
        file: "window",
        block: BlockKind::GatedPreNorm,
        form: TemporalForm::Window,
        tokens: ActuatorOptions::TOKENS,
        prior: MotorModelKind::None,
    },
];

/// Splits next to the published one: name, and the part of a task's name that makes it a test task.
pub const LEFT_OUT: [(&str, &str); 2] = [("without-500g", "500g"), ("without-200g", "200g")];

/// Forces above this are contacts: beyond the noise of the sensor that labels them [N].
const CONTACT: f64 = 0.3;

impl NeuralSize {
    /// Width, layers, updates in the loop, updates of force and condition, horizons.
    fn numbers(self) -> (usize, usize, u64, u64, &'static [usize]) {
        match self {
            Self::Quick => (24, 1, 60, 300, &[32, 64]),
            Self::Full => (64, 2, 1000, 12_000, &[64, 128]),
        }
    }

    /// The actuator of a cell.
    pub(super) fn actuator(self, kind: &NetworkKind, seed: u64, period: f64) -> ActuatorOptions {
        let (width, layers, updates, sensing, horizons) = self.numbers();
        let has_servo = kind.prior == MotorModelKind::Servo;
        let published = NeuralOptions::published(if has_servo { 0 } else { 2 * updates }, updates);
        let part = updates.div_ceil(horizons.len() as u64);
        let labels = |weight: f64| if has_servo { 0.0 } else { weight };
        let loss = LossWeights::PUBLISHED;
        let training = NeuralOptions {
            horizons: horizons.iter().enumerate().map(|(k, h)| (k as u64 * part, *h)).collect(),
            start_noise: if has_servo { 0.02 } else { 0.05 },
            pure: if has_servo { 0.5 } else { 0.0 },
            loss: LossWeights {
                position_bend: if has_servo { LossWeights::SERVO_BEND } else { loss.position_bend },
                force: labels(loss.force),
                gate: labels(loss.gate),
                condition: labels(loss.condition),
                contact: CONTACT,
                ..loss
            },
            learning_rate: (if has_servo { 2e-3 } else { 8e-4 }, (updates / 10).max(1)),
            ema: 1e-2,
            seed,
            ..published
        };
        ActuatorOptions {
            form: kind.form,
            block: kind.block,
            width,
            layers,
            tokens: kind.tokens,
            prior: kind.prior,
            training,
            sensing: has_servo.then(|| SensingOptions::small(sensing, CONTACT, seed)),
            period,
            motors: Motors::default(),
            drive: None,
        }
    }
}

/// Subset of the data with faults that the published set does not have.
pub const FAULTS: &str = "motor_faults";

/// Split protocol of a cell: training and test tasks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Protocol {
    /// Tests of the same tasks.
    Published,
    /// Tasks whose name contains this are not in training, and all of their trajectories are tests.
    LeaveOut(&'static str),
    /// Tests with faults that the published set does not have, in training with all else; or, where a name is
    /// given, tasks with this name are not in training and all are tests.
    Faults(Option<&'static str>),
}

impl Protocol {
    /// Whether a trajectory is for this.
    pub fn uses(self, sample: &Sample, split: Split) -> bool {
        let is_more = sample.task.starts_with(FAULTS);
        match self {
            Self::Faults(Some(text)) if sample.task.contains(text) => is_more && split == Split::Test,
            Self::Faults(left_out) if split == Split::Test => {
                is_more && left_out.is_none() && sample.split == split
            }
            Self::Faults(_) => sample.split == split,
            _ if is_more => false,
            Self::Published => sample.split == split,
            Self::LeaveOut(text) if sample.task.contains(text) => split == Split::Test,
            Self::LeaveOut(_) => split != Split::Test && sample.split == split,
        }
    }
}

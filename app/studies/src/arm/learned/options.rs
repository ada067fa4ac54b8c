//! Options of the studies of learned inverse dynamics, and the trainings that they ask for.

use std::path::PathBuf;

use hysteron_arm_learning::lagrangian::{InputForm, TrainingOptions, Variant};
use hysteron_base::BadInput;
use hysteron_learn::Activation;
use hysteron_workflow::arm::fit::delan::variant;
use hysteron_workflow::shared::number;

use super::real::RealOptions;
use super::simulated::{SimulatedStudy, Units};

/// Models, their networks and their training.
#[derive(Debug, Clone, clap::Args)]
pub struct NetworkOptions {
    /// Models to learn [default: all of them; of recorded arms feed-forward, friction, augmented]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = variant)]
    pub variants: Vec<Variant>,
    /// Seeds of a row; of recorded arms, networks whose mean is taken
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = number::count::<32>)]
    pub seeds: usize,
    /// Units of each of the two hidden layers [default: 64; simulated: 4 with squares, else 16, 24 of a black-box Hamiltonian]
    #[arg(long, value_name = "N", value_parser = number::count::<{ hysteron_learn::MAX_HIDDEN }>)]
    pub hidden: Option<usize>,
    /// Activation between the layers [default: softplus; simulated: tanh]
    #[arg(long, value_enum)]
    pub activation: Option<ActivationName>,
    /// Epochs of Adam at most [default: 300; simulated: 3]
    #[arg(long, value_name = "N", value_parser = number::count::<{ hysteron_learn::MAX_EPOCHS }>)]
    pub epochs: Option<usize>,
    /// Optimiser after Adam, in double precision [default: lbfgs; simulated: levenberg-marquardt]
    #[arg(long, value_enum)]
    pub polish_by: Option<PolishName>,
    /// Steps of it at most; 0 for none [default: 300; simulated: 150]
    #[arg(long, value_name = "N", value_parser = number::up_to::<100_000>)]
    pub polish: Option<u32>,
    /// Step size of Adam at the start [default: 0.005; published: 0.0001]
    #[arg(long, value_name = "RATE", value_parser = number::learning_rate)]
    pub learning_rate: Option<f64>,
    /// Weight of the torque beyond that of a rigid body, in (10)
    #[arg(long, value_name = "LAMBDA", default_value_t = 0.1)]
    pub penalty: f64,
    /// As published: SI units, the plain error, 512 samples a step at a constant rate of 1e-4
    #[arg(long)]
    pub published: bool,
}

/// Learned inverse dynamics of the simulated three-link arm, part by part of its torques (DeLaN, table 5); an hour
#[derive(Debug, Clone, clap::Args)]
pub struct SimulatedOptions {
    /// Folder for cells, report.html and metrics.json
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// The first seed, so that machines can share the study: put their cells into one DIR/cells
    #[arg(long, value_name = "SEED", default_value_t = 0, value_parser = number::up_to::<10_000>)]
    pub first_seed: u32,
    /// Trajectories of the simulated arm to learn from, one table for each
    #[arg(long, value_name = "N,...", value_delimiter = ',', default_value = "200", value_parser = number::count::<2000>)]
    pub trajectories: Vec<usize>,
    /// Inputs are products of the sines and cosines of up to so many joints, with a linear path past the hidden layers; 0 for sines and
    /// cosines alone [default: 0; simulated: 3]
    #[arg(long, value_name = "N", value_parser = number::up_to::<4>)]
    pub products: Option<u32>,
    /// Squares in the kinetic energy beyond one for each joint [default: 0; simulated: 6]
    #[arg(long, value_name = "N", value_parser = number::up_to::<32>)]
    pub squares: Option<u32>,
    /// Models, their networks and their training.
    #[command(flatten)]
    pub network: NetworkOptions,
}

/// Learned inverse dynamics of a simulated arm that writes characters
#[derive(Debug, Clone, clap::Args)]
pub struct CharactersOptions {
    /// Folder of public recordings, with delan-characters/
    #[arg(long, value_name = "DIR")]
    pub data: PathBuf,
    /// As of the three-link arm.
    #[command(flatten)]
    pub simulated: SimulatedOptions,
}

/// Learned inverse dynamics of recorded arms, compared with an identified rigid body and simple models
#[derive(Debug, Clone, clap::Args)]
pub struct RecordedOptions {
    /// Folder of public recordings, with baxter/, kuka-lwr4/, panda-gaz/
    #[arg(long, value_name = "DIR")]
    pub data: PathBuf,
    /// Folder for cells, report.html and metrics.json
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Every so many samples of a recorded arm are used
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = number::count::<1000>)]
    pub stride: usize,
    /// Fourier features of the simple models
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = number::count::<8000>)]
    pub features: usize,
    /// Models, their networks and their training.
    #[command(flatten)]
    pub network: NetworkOptions,
}

/// Activation between the layers of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum ActivationName {
    /// max(0, x)
    Relu,
    /// tanh x
    Tanh,
    /// log(1 + exp x)
    Softplus,
}

/// Second optimiser of a training.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum PolishName {
    /// For any number of parameters
    Lbfgs,
    /// Much smaller loss, for some thousand parameters
    LevenbergMarquardt,
}

/// Options that were not given.
struct Defaults {
    epochs: usize,
    polish: usize,
    polish_by: PolishName,
    activation: Activation,
    products: usize,
    squares: usize,
    /// Units of a hidden layer; none for as many as a variant was found to need.
    units: Option<usize>,
}

/// Of recorded arms, of the arm that writes, and of everything as published.
const GENERAL: Defaults = Defaults {
    epochs: 300,
    polish: 300,
    polish_by: PolishName::Lbfgs,
    activation: Activation::Softplus,
    products: 0,
    squares: 0,
    units: Some(UNITS),
};
/// Of the three-link arm in the project's own form.
const THREE_LINK: Defaults = Defaults {
    epochs: 3,
    polish: 150,
    polish_by: PolishName::LevenbergMarquardt,
    activation: Activation::Tanh,
    products: 3,
    squares: 6,
    units: None,
};
/// Units of a hidden layer, but of simulated arms.
const UNITS: usize = 64;

impl NetworkOptions {
    fn training(&self, defaults: &Defaults) -> Result<TrainingOptions, BadInput> {
        let epochs = self.epochs.unwrap_or(defaults.epochs);
        let mut training = if self.published {
            TrainingOptions::published(epochs)
        } else {
            let polish = self.polish.map_or(defaults.polish, |steps| steps as usize);
            let normalised = TrainingOptions::normalised(epochs);
            let normalised = match self.polish_by.unwrap_or(defaults.polish_by) {
                PolishName::Lbfgs => normalised,
                PolishName::LevenbergMarquardt => normalised.with_levenberg_marquardt(),
            };
            TrainingOptions { polish, learning_rate: 5e-3, ..normalised }
        };
        if let Some(rate) = self.learning_rate {
            if !(rate > 0.0 && rate < 1.0) {
                return Err(BadInput::new("--learning-rate", "above 0 and below 1", rate.to_string()));
            }
            training.learning_rate = rate;
        }
        if !(self.penalty >= 0.0 && self.penalty.is_finite()) {
            return Err(BadInput::new("--penalty", "a number from 0 on", self.penalty.to_string()));
        }
        training.penalty = self.penalty;
        Ok(training)
    }

    fn activation(&self, defaults: &Defaults) -> Activation {
        match self.activation {
            Some(ActivationName::Relu) => Activation::Relu,
            Some(ActivationName::Tanh) => Activation::Tanh,
            Some(ActivationName::Softplus) => Activation::Softplus,
            None => defaults.activation,
        }
    }
}

impl SimulatedOptions {
    /// The study of the three-link arm.
    pub(super) fn three_link(&self) -> Result<SimulatedStudy, BadInput> {
        let defaults = if self.network.published { &GENERAL } else { &THREE_LINK };
        self.study(defaults, vec![1.0, 1.5, 2.0, 2.5])
    }

    /// The study of the arm that writes.
    pub(super) fn characters(&self) -> Result<SimulatedStudy, BadInput> {
        self.study(&GENERAL, vec![1.0])
    }

    fn study(&self, defaults: &Defaults, speeds: Vec<f64>) -> Result<SimulatedStudy, BadInput> {
        let network = &self.network;
        if self.trajectories.iter().any(|n| *n < 2) {
            return Err(BadInput::new("--trajectories", "2 or more, for one validates", "1"));
        }
        let or = |given: Option<u32>, default: usize| given.map_or(default, |n| n as usize);
        Ok(SimulatedStudy {
            variants: if network.variants.is_empty() {
                Variant::ALL.to_vec()
            } else {
                network.variants.clone()
            },
            seeds: network.seeds as u64,
            first_seed: u64::from(self.first_seed),
            trajectories: self.trajectories.clone(),
            speeds,
            hidden: network.hidden.or(defaults.units).map(|units| vec![units; 2]),
            activation: network.activation(defaults),
            inputs: InputForm::of(or(self.products, defaults.products)),
            squares: or(self.squares, defaults.squares),
            units: if network.published { Units::Si } else { Units::Spread },
            training: network.training(defaults)?,
        })
    }
}

impl RecordedOptions {
    /// How the models of a recorded arm are found.
    pub(super) fn models(&self) -> Result<RealOptions, BadInput> {
        let network = &self.network;
        let variants = [Variant::FeedForward, Variant::Friction, Variant::Augmented];
        if let Some(bad) = network.variants.iter().find(|v| v.is_hamiltonian()) {
            return Err(BadInput::new("--variants", "models of velocities", bad.label())
                .hint("no momenta are recorded"));
        }
        Ok(RealOptions {
            variants: if network.variants.is_empty() { variants.to_vec() } else { network.variants.clone() },
            members: network.seeds as u64,
            hidden: vec![network.hidden.unwrap_or(UNITS); 2],
            activation: network.activation(&GENERAL),
            training: network.training(&GENERAL)?,
            features: self.features,
            lengths: vec![2.0, 4.0, 8.0, 16.0],
            stride: self.stride,
        })
    }
}

//! `hysteron arm study`: methods for arms beside what is published and beside simple ones.

pub(crate) mod cloning;
mod estimation;
mod force;
mod learned;
mod neural;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use hysteron_arm_learning::lagrangian::Variant;
use hysteron_base::{BadInput, json};
use hysteron_learn::TrainingProgress;
use hysteron_studies::StudyProgress;
use hysteron_studies::neural::NeuralScope;
use serde_json::Value;

use crate::Context;
use crate::shared::error::Cancelled;
use crate::shared::outputs::Outputs;

/// Compare learned inverse dynamics, or estimated external torques, with what is published
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Subject of the study
    #[cfg_attr(feature = "clap", arg(value_enum))]
    pub set: SetName,
    /// Folder of public recordings, with baxter/, kuka-lwr4/, panda-gaz/ and delan-characters/; for force and neural that of NAD
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR", required_if_eq_any([
        ("set", "baxter-circle"), ("set", "baxter-helical"), ("set", "kuka"), ("set", "panda"), ("set", "recorded"), ("set", "characters")])))]
    pub data: Option<PathBuf>,
    /// Folder for cells, report.html and metrics.json
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub out: PathBuf,
    /// Models to learn [default: all of them; of recorded arms feed-forward, friction, augmented]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = variant))]
    pub variants: Vec<Variant>,
    /// Seeds of a row; of recorded arms, networks whose mean is taken [default: 5]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 5, value_parser = crate::shared::number::count::<32>))]
    pub seeds: usize,
    /// The first of these seeds, so that machines can share a study whose rows have seeds of networks: put their cells into one DIR/cells
    #[cfg_attr(feature = "clap", arg(long, value_name = "SEED", default_value_t = 0, value_parser = crate::shared::number::up_to::<10_000>))]
    pub first_seed: u32,
    /// Trajectories of the simulated arm to learn from, one table for each
    #[cfg_attr(feature = "clap", arg(long, value_name = "N,...", value_delimiter = ',', default_value = "200", value_parser = crate::shared::number::count::<2000>))]
    pub trajectories: Vec<usize>,
    /// Units of each of the two hidden layers [default: 64; simulated: 4 with squares, else 16, 24 of a black-box Hamiltonian]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::count::<{ hysteron_learn::MAX_HIDDEN }>))]
    pub hidden: Option<usize>,
    /// Between the layers [default: softplus; simulated: tanh]
    #[cfg_attr(feature = "clap", arg(long, value_enum))]
    pub activation: Option<ActivationName>,
    /// Of simulated and characters: networks see products of the sines and cosines of up to so many joints, with a linear path past the
    /// hidden layers; 0 for sines and cosines alone [default: 0; simulated: 3]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::up_to::<4>))]
    pub products: Option<u32>,
    /// Of simulated and characters: squares in the kinetic energy beyond one for each joint [default: 0; simulated: 6]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::up_to::<32>))]
    pub squares: Option<u32>,
    /// Epochs of Adam at most [default: 300; simulated: 3]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::count::<{ hysteron_learn::MAX_EPOCHS }>))]
    pub epochs: Option<usize>,
    /// Optimiser after Adam, in double precision [default: lbfgs; simulated: levenberg-marquardt]
    #[cfg_attr(feature = "clap", arg(long, value_enum))]
    pub polish_by: Option<PolishName>,
    /// Steps of it at most; 0 for none [default: 300; simulated: 150]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::up_to::<100_000>))]
    pub polish: Option<u32>,
    /// Step size of Adam at the start [default: 0.005; published: 0.0001]
    #[cfg_attr(feature = "clap", arg(long, value_name = "RATE", value_parser = crate::shared::number::learning_rate))]
    pub learning_rate: Option<f64>,
    /// Weight of the torque that is not a rigid body's, in (10)
    #[cfg_attr(feature = "clap", arg(long, value_name = "LAMBDA", default_value_t = 0.1))]
    pub penalty: f64,
    /// As published: SI units, the plain error, 512 samples a step at a constant rate of 1e-4
    #[cfg_attr(feature = "clap", arg(long))]
    pub published: bool,
    /// Of cloning: actuator by hysteron arm fit neural --sensing observer that estimates the force; without one that row is left out
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub actuator: Option<PathBuf>,
    /// Of neural: one seed of small networks, minutes for all cells
    #[cfg_attr(feature = "clap", arg(long))]
    pub quick: bool,
    /// Every so many samples of a recorded arm are used
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 2, value_parser = crate::shared::number::count::<1000>))]
    pub stride: usize,
    /// Fourier features of the simple models
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 1000, value_parser = crate::shared::number::count::<8000>))]
    pub features: usize,
}

/// Subject of the study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum SetName {
    /// Learned inverse dynamics: the three-link arm
    #[cfg_attr(feature = "clap", value(alias = "delan"))]
    Simulated,
    /// Learned inverse dynamics: an arm that writes
    Characters,
    /// Learned inverse dynamics: Baxter draws circles
    BaxterCircle,
    /// Learned inverse dynamics: Baxter draws helices
    BaxterHelical,
    /// Learned inverse dynamics: KUKA LWR4+
    Kuka,
    /// Learned inverse dynamics: Panda
    Panda,
    /// Learned inverse dynamics: every recorded arm that is below --data, each with its table
    Recorded,
    /// External torques: friction, momentum observers, collisions
    Scara,
    /// External torques: interaction with an exoskeleton
    Wrist,
    /// Friction and bodies by every method of identification
    Identification,
    /// Force at the tip of the virtual arm, by the classical methods
    Force,
    /// Actuators of the virtual arm learned from telemetry (NeuralActuator)
    Neural,
    /// Networks in their loop alone, of equal size: the ablation of the study above
    NeuralNetworks,
    /// Policies that handle an object of unknown mass on the virtual arm, cloned with and without a force
    Cloning,
}

/// Between the layers of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum ActivationName {
    /// max(0, x)
    Relu,
    /// tanh x
    Tanh,
    /// log(1 + exp x)
    Softplus,
}

/// Optimiser of the last digits of a training.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum PolishName {
    /// For any number of parameters
    Lbfgs,
    /// Much deeper, for some thousand parameters
    LevenbergMarquardt,
}

impl Options {
    fn check(&self) -> Result<(), BadInput> {
        use SetName::{Characters, Neural, NeuralNetworks, Simulated};
        if self.first_seed == 0 || [Simulated, Characters, Neural, NeuralNetworks].contains(&self.set) {
            return Ok(());
        }
        let expected = "0, or a set of simulated, characters, neural and neural-networks";
        Err(BadInput::new("--first-seed", expected, self.first_seed.to_string()))
    }
}

/// A model by the name that files have for it.
///
/// # Errors
/// The names there are.
pub fn variant(text: &str) -> Result<Variant, String> {
    json::from_value(&text.into()).map_err(|e| e.to_string())
}

/// Carries out the verb.
///
/// # Errors
/// Bad input; files that cannot be read or written; an interruption.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Value> {
    options.check()?;
    let outputs = Outputs::reading(options.data.iter().flat_map(|data| inputs(options.set, data)))
        .and(&options.actuator);
    let _claim = outputs.report("--out", Some(&options.out)).check(context)?;
    context.listen();
    let mut bar = Bar::new(context);
    let mut listener = |p: &StudyProgress<'_>| bar.show(p);
    let found = match options.set {
        SetName::Scara => estimation::scara(options, &mut listener, context)?,
        SetName::Wrist => estimation::wrist(options, &mut listener, context)?,
        SetName::Identification => estimation::identification(options, &mut listener, context)?,
        SetName::Force => force::run(options, &mut listener, context)?,
        SetName::Cloning => cloning::run(options, context)?,
        SetName::Neural => neural::run(options, NeuralScope::Whole, &mut listener, context)?,
        SetName::NeuralNetworks => neural::run(options, NeuralScope::Networks, &mut listener, context)?,
        _ => learned::run(options, &mut listener, context)?,
    };
    bar.clear();
    let cells = options.out.join("cells");
    let found = found.ok_or_else(|| {
        Cancelled::new(format!("; what is done stands in {}: the same command goes on", cells.display()))
    })?;
    context.reported(&options.out);
    Ok(found)
}

/// Cells that are done sooner were computed by a study before.
const FOUND_WITHIN: Duration = Duration::from_secs(1);

/// Files that a set is read from.
fn inputs(set: SetName, data: &Path) -> Vec<PathBuf> {
    match set {
        SetName::Characters => vec![data.join("delan-characters/characters.csv")],
        SetName::Kuka => ["measurements_1.npz", "measurements_2.npz"]
            .map(|name| data.join("kuka-lwr4").join(name))
            .to_vec(),
        _ => Vec::new(),
    }
}

/// Cells as a bar, with the epoch and error of the training at hand.
struct Bar<'a> {
    bar: Option<Box<dyn crate::Progress>>,
    context: &'a Context<'a>,
    /// Cells done, and since when.
    done: usize,
    since: Instant,
}

impl<'a> Bar<'a> {
    fn new(context: &'a Context<'a>) -> Self {
        Self { bar: None, context, done: 0, since: Instant::now() }
    }

    fn show(&mut self, p: &StudyProgress<'_>) -> bool {
        let [done, of] = p.done;
        if done > self.done {
            let took = self.since.elapsed();
            (self.done, self.since) = (done, Instant::now());
            // What was found says nothing about how long others take: rate and remaining time begin anew.
            if took < FOUND_WITHIN {
                self.clear();
                self.bar = None;
            }
        }
        let bar = self.bar.get_or_insert_with(|| self.context.progress("cells", of, done));
        bar.set_position(done as u64);
        match p.training {
            Some(TrainingProgress::Epoch(epoch)) => {
                bar.set_message(format!(
                    "{}: {}/{}, error {:.2e}",
                    p.cell, epoch.number, epoch.of, epoch.best
                ));
            }
            Some(TrainingProgress::Step { .. }) => {}
            None => bar.set_message(p.cell.to_owned()),
        }
        !self.context.is_cancelled()
    }

    fn clear(&self) {
        self.bar.iter().for_each(|bar| bar.finish());
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;
    use crate::{ProgressSink, Silent};

    /// Where bars began.
    #[derive(Default)]
    struct Begins(Mutex<Vec<[usize; 2]>>);

    impl ProgressSink for Begins {
        fn start(&self, _: &str, length: usize, done: usize) -> Box<dyn crate::Progress> {
            self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push([done, length]);
            Box::new(Silent)
        }

        fn is_cancelled(&self) -> bool {
            false
        }

        fn print(&self, _: &str) {}
    }

    #[test]
    fn cells_that_were_found_do_not_count_for_the_remaining_time() {
        let begins = Begins::default();
        let context = Context { progress: &begins, command: String::new(), overwrite: false, watchdog: None };
        let mut bar = Bar::new(&context);
        for done in 0..3 {
            bar.show(&StudyProgress { cell: "found", done: [done, 9], training: None });
        }
        // One that took longer goes on with the bar.
        bar.since = Instant::now().checked_sub(2 * FOUND_WITHIN).unwrap_or_else(Instant::now);
        bar.show(&StudyProgress { cell: "computed", done: [3, 9], training: None });
        assert_eq!(begins.0.into_inner().unwrap_or_default(), [[0, 9], [1, 9], [2, 9]]);
    }
}

//! `hysteron arm study`: learned inverse dynamics beside what is published and beside simple models.

use std::path::{Path, PathBuf};

use hysteron_arm::Model;
use hysteron_arm::datasets::{BaxterTraining, RealSet, baxter, characters, kuka, panda};
use hysteron_arm::lagrangian::{TrainingOptions, Variant};
use hysteron_arm::study::{
    RealOptions, SimulatedStudy, StudyProgress, Units, characters_study, real_study, simulated_study,
};
use hysteron_base::BadInput;
use hysteron_learn::{Activation, MOST_EPOCHS, MOST_HIDDEN, Progress};
use hysteron_workflow::arm;
use hysteron_workflow::arm_study_figures::{self, Study};
use hysteron_workflow::outputs::Outputs;
use hysteron_workflow::{Caller, number};
use serde_json::Value;

use super::estimation_study;

const HELP: &str = "\
simulated is the three-link arm of table 5, which needs no data; baxter-circle, baxter-helical, kuka and panda read public recordings \
below --data, characters the simulated arm that writes. Simulated sets compare seven learned models, part by part of their torques; \
recorded ones compare learned models, alone and on top of an identified rigid body, with that body, with Fourier features, and with \
both. Everything is chosen on trajectories of the training data.

scara and wrist estimate external torques on simulated arms by every method of two papers and by what these lack. \
--seeds says how much is simulated: noise seeds of the wrist; for the SCARA, 48 s of contact and 15 min of collisions each.

identification finds friction of a recorded Franka joint (with --data, each speed left out), of the SCARA (table 2) and bodies of the \
wrist by every method; --seeds says how many noise seeds.

Cells of the tables are written to DIR/cells as they are done. After Ctrl-C the same command goes on, within a training too.

Examples, from the root of the repository:
  hysteron arm study simulated --variants structured-lagrangian --seeds 1 --trajectories 10 --hidden 16 \\
      --epochs 2 --polish 0 --out out/arm/study
  hysteron arm study baxter-circle --data ../shared/data/arms --out out/arm/circle

Exit codes: 0 done, 1 failed or interrupted, 2 bad input.";

/// Compare learned inverse dynamics, or estimated external torques, with what is published
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// What is studied
    #[arg(value_enum)]
    set: SetName,
    /// Folder of public recordings, with baxter/, kuka-lwr4/, panda-gaz/ and delan-characters/
    #[arg(long, value_name = "DIR", required_if_eq_any([
        ("set", "baxter-circle"), ("set", "baxter-helical"), ("set", "kuka"), ("set", "panda"), ("set", "characters")]))]
    data: Option<PathBuf>,
    /// Folder for cells, report.html and metrics.json
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Models to learn [default: all of them; of recorded arms feed-forward, friction, augmented]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = variant)]
    variants: Vec<Variant>,
    /// Seeds of a row; of recorded arms, networks whose mean is taken [default: 5]
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = number::count::<32>)]
    seeds: usize,
    /// Trajectories of the simulated arm to learn from, one table for each
    #[arg(long, value_name = "N,...", value_delimiter = ',', default_value = "200", value_parser = number::count::<2000>)]
    trajectories: Vec<usize>,
    /// Units of each of the two hidden layers [default: 64]
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = number::count::<MOST_HIDDEN>)]
    hidden: usize,
    /// Between the layers
    #[arg(long, value_enum, default_value_t = ActivationName::Softplus)]
    activation: ActivationName,
    /// Epochs of Adam at most
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = number::count::<MOST_EPOCHS>)]
    epochs: usize,
    /// Steps of L-BFGS at most, in double precision, after Adam; 0 for none
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = number::up_to::<100_000>)]
    polish: u32,
    /// Step size of Adam at the start [default: 0.005; published: 0.0001]
    #[arg(long, value_name = "RATE")]
    learning_rate: Option<f64>,
    /// Weight of the torque that is not a rigid body's, in (10)
    #[arg(long, value_name = "LAMBDA", default_value_t = 0.1)]
    penalty: f64,
    /// As published: SI units, the plain error, 512 samples a step at a constant rate of 1e-4
    #[arg(long)]
    published: bool,
    /// Every so many samples of a recorded arm are used
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = number::count::<1000>)]
    stride: usize,
    /// Fourier features of the simple models
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = number::count::<8000>)]
    features: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum SetName {
    Simulated,
    Characters,
    BaxterCircle,
    BaxterHelical,
    Kuka,
    Panda,
    /// External torques: friction, momentum observers, collisions
    Scara,
    /// External torques: interaction with an exoskeleton
    Wrist,
    /// Friction and bodies by every method of identification
    Identification,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum ActivationName {
    Relu,
    Tanh,
    Softplus,
}

/// A model by the name that files have for it.
pub fn variant(text: &str) -> Result<Variant, String> {
    serde_json::from_value(text.into()).map_err(|e| e.to_string())
}

/// Carries out the verb.
pub fn run(arguments: &Arguments, caller: &Caller) -> anyhow::Result<Value> {
    let outputs = Outputs::reading(arguments.data.iter().flat_map(|data| inputs(arguments.set, data)));
    let _claim = outputs.report("--out", Some(&arguments.out)).check(caller)?;
    caller.listen()?;
    let cells = arguments.out.join("cells");
    let mut bar = Bar { bar: None, caller };
    let mut listener = |p: &StudyProgress<'_>| bar.show(p);
    match arguments.set {
        SetName::Scara => {
            return estimation_study::scara(&arguments.out, arguments.seeds, &mut listener, caller);
        }
        SetName::Wrist => {
            return estimation_study::wrist(&arguments.out, arguments.seeds, &mut listener, caller);
        }
        SetName::Identification => {
            let data = arguments.data.as_deref();
            return estimation_study::identification(
                &arguments.out,
                data,
                arguments.seeds,
                &mut listener,
                caller,
            );
        }
        _ => {}
    }
    let study = match arguments.set {
        SetName::Simulated | SetName::Characters => {
            let study = simulated(arguments)?;
            let rows = if arguments.set == SetName::Simulated {
                simulated_study(&study, &Model::builtin("three-link")?, &cells, &mut listener)?
            } else {
                let file = data(arguments)?.join("delan-characters/characters.csv");
                characters_study(&study, characters(&file)?, &cells, &mut listener)?
            };
            Study::Simulated { study, rows }
        }
        _ => {
            let (set, model) = real_set(arguments.set, data(arguments)?)?;
            let options = real(arguments)?;
            let rows = real_study(&set, &model, &options, &cells, &mut listener)?;
            Study::Real { set: set.name, test_samples: set.test.len(), options, rows }
        }
    };
    bar.clear();
    if caller.is_cancelled() {
        anyhow::bail!("interrupted; what is done stands in {}: the same command goes on", cells.display());
    }
    arm_study_figures::write(&arguments.out, &study, &arm::meta(caller, "study of learned inverse dynamics"))
}

fn data(arguments: &Arguments) -> Result<&Path, BadInput> {
    arguments.data.as_deref().ok_or_else(|| BadInput::new("--data", "a folder of recordings", "nothing"))
}

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

fn training(arguments: &Arguments) -> Result<TrainingOptions, BadInput> {
    let mut options = if arguments.published {
        TrainingOptions::published(arguments.epochs)
    } else {
        let polish = arguments.polish as usize;
        TrainingOptions { polish, learning_rate: 5e-3, ..TrainingOptions::normalised(arguments.epochs) }
    };
    if let Some(rate) = arguments.learning_rate {
        if !(rate > 0.0 && rate < 1.0) {
            return Err(BadInput::new("--learning-rate", "above 0 and below 1", rate.to_string()));
        }
        options.learning_rate = rate;
    }
    if !(arguments.penalty >= 0.0 && arguments.penalty.is_finite()) {
        return Err(BadInput::new("--penalty", "a number from 0 on", arguments.penalty.to_string()));
    }
    options.penalty = arguments.penalty;
    Ok(options)
}

fn activation(name: ActivationName) -> Activation {
    match name {
        ActivationName::Relu => Activation::Relu,
        ActivationName::Tanh => Activation::Tanh,
        ActivationName::Softplus => Activation::Softplus,
    }
}

fn simulated(arguments: &Arguments) -> Result<SimulatedStudy, BadInput> {
    let is_simulated = arguments.set == SetName::Simulated;
    if arguments.trajectories.iter().any(|n| *n < 2) {
        return Err(BadInput::new("--trajectories", "2 or more, for one validates", "1"));
    }
    Ok(SimulatedStudy {
        variants: if arguments.variants.is_empty() {
            Variant::ALL.to_vec()
        } else {
            arguments.variants.clone()
        },
        seeds: arguments.seeds as u64,
        trajectories: arguments.trajectories.clone(),
        speeds: if is_simulated { vec![1.0, 1.5, 2.0, 2.5] } else { vec![1.0] },
        hidden: vec![arguments.hidden; 2],
        activation: activation(arguments.activation),
        units: if arguments.published { Units::Si } else { Units::Spread },
        training: training(arguments)?,
    })
}

fn real(arguments: &Arguments) -> Result<RealOptions, BadInput> {
    let variants = [Variant::FeedForward, Variant::Friction, Variant::Augmented];
    if let Some(bad) = arguments.variants.iter().find(|v| v.is_hamiltonian()) {
        return Err(
            BadInput::new("--variants", "models of velocities", bad.label()).hint("no momenta are recorded")
        );
    }
    Ok(RealOptions {
        variants: if arguments.variants.is_empty() { variants.to_vec() } else { arguments.variants.clone() },
        members: arguments.seeds as u64,
        hidden: vec![arguments.hidden; 2],
        activation: activation(arguments.activation),
        training: training(arguments)?,
        features: arguments.features,
        lengths: vec![2.0, 4.0, 8.0, 16.0],
        stride: arguments.stride,
    })
}

/// A recorded set and the kinematics of its arm.
fn real_set(set: SetName, data: &Path) -> anyhow::Result<(RealSet, Model)> {
    let folder = data.join("baxter");
    let arm =
        || Ok::<_, anyhow::Error>(Model::from_urdf(hysteron_arm::datasets::BAXTER_ARM, "baxter_arm.urdf")?);
    Ok(match set {
        SetName::BaxterHelical => {
            let test = "sin_XYZ_12_5s_T2_5_Tz_5T_r18_ang_vel_torq.csv";
            (baxter(&folder, test, BaxterTraining::Helical)?, arm()?)
        }
        SetName::Kuka => {
            let folder = data.join("kuka-lwr4");
            (kuka(&folder)?, Model::read(&folder.join("kuka_lwr4_identified.urdf"))?)
        }
        SetName::Panda => {
            let fingers = [("panda_finger_joint1", 0.0), ("panda_finger_joint2", 0.0)];
            (panda(&data.join("panda-gaz"))?, Model::builtin("panda")?.with_locked(&fingers)?)
        }
        _ => (baxter(&folder, "circle_XY_T2_r10_ang_vel_torq.csv", BaxterTraining::All)?, arm()?),
    })
}

/// Cells as a bar, with the epoch and error of the training at hand.
struct Bar<'a> {
    bar: Option<Box<dyn hysteron_workflow::Progress>>,
    caller: &'a Caller<'a>,
}

impl Bar<'_> {
    fn show(&mut self, p: &StudyProgress<'_>) -> bool {
        let bar = self.bar.get_or_insert_with(|| self.caller.progress("cells", p.done[1], p.done[0]));
        bar.set_position(p.done[0] as u64);
        match p.training {
            Some(Progress::Epoch(epoch)) => {
                bar.set_message(format!(
                    "{}: {}/{}, error {:.2e}",
                    p.cell, epoch.number, epoch.of, epoch.best
                ));
            }
            Some(Progress::Step { .. }) => {}
            None => bar.set_message(p.cell.to_owned()),
        }
        !self.caller.is_cancelled()
    }

    fn clear(&self) {
        self.bar.iter().for_each(|bar| bar.finish());
    }
}

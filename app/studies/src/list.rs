//! All studies by their names, as a command line has them.

use hysteron_workflow::shared::outcome::{Outcome, Printed};
use hysteron_workflow::{Context, WorkflowError};

use crate::arm::learned::{self, RecordedSet};
use crate::arm::neural::NeuralScope;
use crate::arm::{cloning, force, identification, neural, scara, wrist};
use crate::tendon;

/// Studies of arms
#[derive(Debug, Clone, clap::Subcommand)]
#[allow(missing_docs, reason = "a study without documentation here has that of its options")]
pub enum ArmStudy {
    #[command(alias = "delan", after_help = include_str!("arm/learned/simulated.txt"))]
    Simulated(learned::SimulatedOptions),
    #[command(after_help = include_str!("arm/learned/simulated.txt"))]
    Characters(learned::CharactersOptions),
    /// Learned inverse dynamics of recorded arms: Baxter draws circles; a quarter of an hour
    #[command(after_help = include_str!("arm/learned/recorded.txt"))]
    BaxterCircle(learned::RecordedOptions),
    /// Learned inverse dynamics of recorded arms: Baxter draws helices; a quarter of an hour
    #[command(after_help = include_str!("arm/learned/recorded.txt"))]
    BaxterHelical(learned::RecordedOptions),
    /// Learned inverse dynamics of recorded arms: KUKA LWR4+; a quarter of an hour
    #[command(after_help = include_str!("arm/learned/recorded.txt"))]
    Kuka(learned::RecordedOptions),
    /// Learned inverse dynamics of recorded arms: Panda; a quarter of an hour
    #[command(after_help = include_str!("arm/learned/recorded.txt"))]
    Panda(learned::RecordedOptions),
    /// Learned inverse dynamics of every recorded arm that is below --data, each with its table; an hour
    #[command(after_help = include_str!("arm/learned/recorded.txt"))]
    Recorded(learned::RecordedOptions),
    #[command(after_help = include_str!("arm/scara/help.txt"))]
    Scara(scara::Options),
    #[command(after_help = include_str!("arm/wrist/help.txt"))]
    Wrist(wrist::Options),
    #[command(after_help = include_str!("arm/identification/help.txt"))]
    Identification(identification::Options),
    #[command(after_help = include_str!("arm/force/help.txt"))]
    Force(force::Options),
    /// Actuators learned from telemetry, compared with published tables and simple baselines (NeuralActuator); hours
    #[command(after_help = include_str!("arm/neural/help.txt"))]
    Neural(neural::Options),
    /// Networks in the loop alone, of equal size: the ablation of the study neural (table X); hours
    #[command(after_help = include_str!("arm/neural/help.txt"))]
    NeuralNetworks(neural::Options),
    #[command(after_help = include_str!("arm/cloning/help.txt"))]
    Cloning(cloning::Options),
}

impl ArmStudy {
    /// Runs the study.
    ///
    /// # Errors
    /// Those of the study.
    pub fn run(&self, context: &Context) -> anyhow::Result<Printed> {
        match self {
            Self::Simulated(options) => printed(learned::simulated(options, context)),
            Self::Characters(options) => printed(learned::characters(options, context)),
            Self::BaxterCircle(options) => recorded(RecordedSet::BaxterCircle, options, context),
            Self::BaxterHelical(options) => recorded(RecordedSet::BaxterHelical, options, context),
            Self::Kuka(options) => recorded(RecordedSet::Kuka, options, context),
            Self::Panda(options) => recorded(RecordedSet::Panda, options, context),
            Self::Recorded(options) => recorded(RecordedSet::All, options, context),
            Self::Scara(options) => printed(scara::run(options, context)),
            Self::Wrist(options) => printed(wrist::run(options, context)),
            Self::Identification(options) => printed(identification::run(options, context)),
            Self::Force(options) => printed(force::run(options, context)),
            Self::Neural(options) => printed(neural::run(options, NeuralScope::Whole, context)),
            Self::NeuralNetworks(options) => printed(neural::run(options, NeuralScope::Networks, context)),
            Self::Cloning(options) => printed(cloning::run(options, context)),
        }
    }
}

/// Studies of tendon robots
#[derive(Debug, Clone, clap::Subcommand)]
pub enum TendonStudy {
    /// Tip and tension compared with SOFA on the same mesh; a minute
    #[command(after_help = include_str!("tendon/reference.txt"))]
    Sofa(tendon::Options),
    /// Linear and quadratic tetrahedra, finer and finer; minutes
    #[command(after_help = include_str!("tendon/reference.txt"))]
    Convergence(tendon::Options),
    /// 500 static shapes of a rod compared with SoRoSim; half an hour
    #[command(after_help = include_str!("tendon/data.txt"))]
    Sorosim(tendon::DataOptions),
    /// 14 holds of a recorded silicone tentacle, nominal and fitted parameters, residual tensions; minutes
    #[command(after_help = include_str!("tendon/data.txt"))]
    Tentacle(tendon::DataOptions),
    /// A recorded three-segment robot, tip on patterns that were not fitted, by fourteen methods; minutes
    #[command(after_help = include_str!("tendon/data.txt"))]
    Ftdcr(tendon::DataOptions),
    /// Strokes of two recorded robots from their tips: regressions, a kernel, networks; an hour
    #[command(after_help = include_str!("tendon/data.txt"))]
    Inverse(tendon::DataOptions),
    /// Record, identify, train and roll out on the virtual rig: five twins on test trajectories; hours
    #[command(after_help = include_str!("tendon/chain.txt"))]
    Coreact(tendon::Options),
    /// The twins of coreact on two other presets and ten robots of a population; an hour
    #[command(after_help = include_str!("tendon/chain.txt"))]
    Robots(tendon::Options),
    /// The effect of each part of the chain, on three presets and ten robots of a population; half an hour or more
    #[command(after_help = include_str!("tendon/chain.txt"), alias = "ladder")]
    Ablation(tendon::Options),
    /// The whole chain on robots of a wide population, known from their recordings alone; hours
    #[command(after_help = include_str!("tendon/chain.txt"))]
    Population(tendon::PopulationOptions),
    /// Fewer auxiliary tendons than the paper's 36; half an hour
    #[command(after_help = include_str!("tendon/chain.txt"))]
    Layouts(tendon::Options),
    /// A robot that changes, before and after a minute of new data; half an hour
    #[command(after_help = include_str!("tendon/chain.txt"))]
    Adaptation(tendon::Options),
    /// Tensions and pushes estimated without force sensors on two virtual robots; two hours
    #[command(after_help = include_str!("tendon/chain.txt"))]
    Sensing(tendon::Options),
    /// Ideal paths, open loop on the virtual rig: five methods for strokes; hours
    #[command(after_help = include_str!("tendon/chain.txt"))]
    Edic(tendon::Options),
}

impl TendonStudy {
    /// Runs the study.
    ///
    /// # Errors
    /// Those of the study.
    pub fn run(&self, context: &Context) -> anyhow::Result<Printed> {
        match self {
            Self::Sofa(options) => printed(tendon::sofa::run(options, context)),
            Self::Convergence(options) => printed(tendon::convergence::run(options, context)),
            Self::Sorosim(options) => printed(tendon::sorosim::run(options, context)),
            Self::Tentacle(options) => printed(tendon::tentacle::run(options, context)),
            Self::Ftdcr(options) => printed(tendon::ftdcr::run(options, context)),
            Self::Inverse(options) => printed(tendon::inverse::run(options, context)),
            Self::Coreact(options) => printed(tendon::coreact::run(options, context)),
            Self::Robots(options) => printed(tendon::robots::run(options, context)),
            Self::Ablation(options) => printed(tendon::ablation::run(options, context)),
            Self::Population(options) => printed(tendon::population::run(options, context)),
            Self::Layouts(options) => printed(tendon::layouts::run(options, context)),
            Self::Adaptation(options) => printed(tendon::adaptation::run(options, context)),
            Self::Sensing(options) => printed(tendon::sensing::run(options, context)),
            Self::Edic(options) => printed(tendon::edic::run(options, context)),
        }
    }
}

fn recorded(
    set: RecordedSet,
    options: &learned::RecordedOptions,
    context: &Context,
) -> anyhow::Result<Printed> {
    printed(learned::recorded(set, options, context))
}

/// The outcome of a study as a terminal prints it.
fn printed<T: Outcome>(outcome: Result<T, WorkflowError>) -> anyhow::Result<Printed> {
    Printed::new(&outcome?)
}

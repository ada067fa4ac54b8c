//! `cargo run --profile bench -p hysteron-bench`: the performance targets, or a study by name.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::{Parser, Subcommand, ValueEnum};
use hysteron_bench::growth;
use hysteron_bench::study::{
    adaptation, convergence, coreact, edic, ftdcr, inverse, ladder, layouts, population, rig, robots,
    sensing, sofa, sorosim, tentacle,
};
use hysteron_bench::targets::{self, Effort};

/// Performance targets next to their baselines; studies that compare with other programs and real robots
///
/// Without a study: measures every performance target and writes FOLDER/targets.json. HYSTERON_DATA names the folder of
/// recordings for sorosim, tentacle, ftdcr and inverse [default: ../shared/data].
#[derive(Debug, Parser)]
struct Program {
    #[command(subcommand)]
    verb: Option<Verb>,
    /// Less effort: figures that show that it works
    #[arg(long, global = true)]
    quick: bool,
    /// Folder to write to [default: bench for the targets, out for a study]
    #[arg(long, global = true, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Time every reader on larger and larger files; writes FOLDER/growth/metrics.json, fails where time grows faster than the file
    Growth,
    /// Run a study; writes FOLDER/NAME/metrics.json
    Study {
        /// Which
        name: Name,
        /// How many robots of the population [default: all that are left]
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
        robots: Option<u64>,
        /// The first robot of the population: machines can share it
        #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
        first: u64,
    },
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Name {
    /// Comparison with SOFA's results on the same meshes
    Sofa,
    /// Orders of convergence
    Convergence,
    /// A recorded soft finger compared with SoRoSim
    Sorosim,
    /// A recorded silicone tentacle
    Tentacle,
    /// A recorded three-segment robot
    Ftdcr,
    /// Inverse networks on recorded robots
    Inverse,
    /// Recording from the emulated rig
    Rig,
    /// The calibrated twin on paths that are in no training
    Coreact,
    /// Ablation: the effect of each part of the chain on other robots
    Ladder,
    /// Virtual robots that nobody tuned to
    Robots,
    /// Robots of a wider population, each from its recordings alone
    Population,
    /// Layouts of auxiliary tendons
    Layouts,
    /// Tensions and pushes estimated without force sensors
    Sensing,
    /// Open-loop tracking by the inverse network
    Edic,
    /// Robots that have changed
    Adaptation,
}

fn main() -> Result<()> {
    let Program { verb, quick, out } = Program::parse();
    if let Some(Verb::Growth) = verb {
        return growth::run(&out.unwrap_or_else(|| PathBuf::from("out")).join("growth"), quick);
    }
    let Some(Verb::Study { name, robots, first }) = verb else {
        let effort = if quick { Effort::QUICK } else { Effort::FULL };
        let folder = out.unwrap_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")));
        return targets::run(effort, &folder.join("targets.json"));
    };
    let folder = out.unwrap_or_else(|| PathBuf::from("out"));
    let value = name.to_possible_value();
    study(name, &folder.join(value.as_ref().map_or("", |value| value.get_name())), quick, (first, robots))
}

fn study(name: Name, folder: &Path, quick: bool, members: (u64, Option<u64>)) -> Result<()> {
    match name {
        Name::Sofa => sofa::run(folder),
        Name::Convergence => convergence::run(folder, quick),
        Name::Sorosim => sorosim::run(folder, quick),
        Name::Tentacle => tentacle::run(folder, quick),
        Name::Ftdcr => ftdcr::run(folder, quick),
        Name::Inverse => inverse::run(folder, quick),
        Name::Rig => rig::run(folder, quick),
        Name::Coreact => coreact::run(folder, quick),
        Name::Ladder => ladder::run(folder, quick),
        Name::Robots => robots::run(folder, quick),
        Name::Population => population::run(folder, quick, members),
        Name::Layouts => layouts::run(folder, quick),
        Name::Sensing => sensing::run(folder, quick),
        Name::Edic => edic::run(folder, quick),
        Name::Adaptation => adaptation::run(folder, quick),
    }
}

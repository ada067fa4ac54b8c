//! `cargo run --profile bench -p hysteron-bench`: the performance targets.

use std::path::PathBuf;

use anyhow::Result;
use clap::{Parser, Subcommand};
use hysteron_bench::targets::{self, MeasuringTime};
use hysteron_bench::{emulated, growth};

/// Performance targets next to their baselines
///
/// Without a verb: measures every performance target and writes FOLDER/targets.json. Studies are `hysteron study NAME`.
#[derive(Debug, Parser)]
struct BenchProgram {
    #[command(subcommand)]
    verb: Option<Verb>,
    /// Less effort: figures that show that it works
    #[arg(long, global = true)]
    quick: bool,
    /// Folder to write to [default: bench for the targets, out for a verb]
    #[arg(long, global = true, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, Subcommand)]
enum Verb {
    /// Time every reader on larger and larger files; writes FOLDER/growth/metrics.json, fails where time grows faster than the file
    Growth,
    /// Measure chains of sections beside their finite elements; writes FOLDER/chains.json
    Chains,
    /// Record a minute from the emulated rig, through its ports; writes FOLDER/rig/metrics.json
    Rig,
}

fn main() -> Result<()> {
    let BenchProgram { verb, quick, out } = BenchProgram::parse();
    let folder = |name: &str| out.clone().unwrap_or_else(|| PathBuf::from("out")).join(name);
    let effort = if quick { MeasuringTime::QUICK } else { MeasuringTime::FULL };
    match verb {
        Some(Verb::Growth) => growth::run(&folder("growth"), quick),
        Some(Verb::Rig) => emulated::run(&folder("rig"), quick),
        Some(Verb::Chains) => {
            let folder = out.unwrap_or_else(|| PathBuf::from("out"));
            targets::run_chains(effort, &folder.join("chains.json"))
        }
        None => {
            let folder = out.unwrap_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")));
            targets::run(effort, &folder.join("targets.json"))
        }
    }
}

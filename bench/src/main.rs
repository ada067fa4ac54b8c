//! `cargo run --release -p hysteron-bench`: the performance targets, or a study by name.
#![allow(clippy::print_stdout, clippy::print_stderr)] // usage and tables are what this program is for

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use hysteron_bench::study::{
    adaptation, convergence, coreact, edic, ftdcr, inverse, ladder, layouts, population, rig, robots, sofa,
    sorosim, tentacle,
};
use hysteron_bench::targets::{self, Effort};

const USAGE: &str = "usage: hysteron-bench [--quick] [--out FOLDER]
       hysteron-bench study sofa|convergence|sorosim|tentacle|ftdcr|inverse|rig|coreact|robots|edic|ladder|population|layouts|adaptation [--quick] [--out FOLDER]
       hysteron-bench study population [--robots N]

Without a study: measures every performance target and writes FOLDER/targets.json.
A study compares with another program or a robot, or records from the emulated rig, and writes FOLDER/NAME/metrics.json.
FOLDER is bench/ for the targets and out/ for the studies unless given.
HYSTERON_DATA names the folder of recordings for sorosim, tentacle, ftdcr and inverse (default ../shared/data).";

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<()> {
    let mut words = Vec::new();
    let (mut quick, mut out, mut robots) = (false, None, None);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--quick" => quick = true,
            "--out" => out = arguments.next().map(PathBuf::from),
            "--robots" => {
                robots = Some(arguments.next().context("--robots N")?.parse().context("--robots N")?)
            }
            "--help" | "-h" => {
                println!("{USAGE}");
                return Ok(());
            }
            _ => words.push(argument),
        }
    }
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        [] => {
            let effort = if quick { Effort::QUICK } else { Effort::FULL };
            let folder = out.unwrap_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")));
            targets::run(effort, &folder.join("targets.json"))
        }
        ["study", name] => {
            let folder = out.unwrap_or_else(|| PathBuf::from("out")).join(name);
            match name {
                "sofa" => sofa::run(&folder),
                "convergence" => convergence::run(&folder, quick),
                "sorosim" => sorosim::run(&folder, quick),
                "tentacle" => tentacle::run(&folder, quick),
                "ftdcr" => ftdcr::run(&folder, quick),
                "inverse" => inverse::run(&folder, quick),
                "rig" => rig::run(&folder, quick),
                "coreact" => coreact::run(&folder, quick),
                "ladder" => ladder::run(&folder, quick),
                "robots" => robots::run(&folder, quick),
                "population" => population::run(&folder, quick, robots),
                "layouts" => layouts::run(&folder, quick),
                "edic" => edic::run(&folder, quick),
                "adaptation" => adaptation::run(&folder, quick),
                _ => bail!("no study {name:?}\n{USAGE}"),
            }
        }
        _ => bail!("{USAGE}"),
    }
}

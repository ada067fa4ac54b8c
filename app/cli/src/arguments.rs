//! The command line: verbs, options for all of them, and the help that goes with them.

use std::ffi::OsString;
use std::io::Write;
use std::path::PathBuf;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{ArgAction, Parser, Subcommand};
use hysteron_base::BadInput;
use hysteron_workflow::shared::number;

use crate::invocation::WATCHDOG;
use crate::terminal;

const HELP: &str = "\
Examples, from the root of the repository; where hysteron is not installed, use `cargo run --release --` instead:
  hysteron demo
  hysteron study run app/cli/studies/paper.toml
  hysteron check meshes/tpu80/scene.toml
  hysteron simulate meshes/tpu80/scene.toml \\
      --strokes meshes/tpu80/strokes-circle.csv \\
      --out out/tpu80/tip.parquet --figures out/tpu80
  hysteron reach meshes/tpu80/scene.toml \\
      --goals out/tpu80/tip.parquet \\
      --out out/tpu80/strokes.parquet --figures out/tpu80/reach
  hysteron mesh --length-mm 80 --outer-diameter-mm 12 --bore-diameter-mm 6 \\
      --channels 4 --channel-diameter-mm 1.5 --channel-radius-mm 4.5 \\
      --layers 17 --out out/tube.msh
  hysteron record --rig virtual:typical --plan quick --out out/quick
  hysteron fit-material meshes/tpu80/scene.toml out/quick --role training \\
      --out out/fitted/scene.toml --figures out/fitted
  hysteron target circle:40 --out out/circle40.parquet
  hysteron evaluate --target circle:38 out/circle40.parquet
  hysteron train out/quick --out out/quick/inverse.safetensors
  hysteron command out/quick/inverse.safetensors --target out/quick/ellipse.parquet \\
      --out out/commands/ellipse.parquet
  hysteron generate meshes/tpu80/scene.toml --plan quick --out out/bare
  hysteron track --rig virtual:typical --scene meshes/tpu80/scene.toml --nominal \\
      --target circle:30 --out out/nominal
  hysteron arm info panda
  hysteron rig check
  hysteron rig emulate --dir out/rig --for-s 1

With servos and a tracker, begin with docs/rig.md.

Exit codes: 0 done, 1 failed or interrupted, 2 bad input (nothing is written under the final name).";

/// Digital twin and controller for tendon-driven continuum robots
///
/// A robot is a folder with a mesh (.msh) and a scene (scene.toml): material, clamp, tendons, tip. A rig is a file
/// (rig.toml): servos, tracker, limits. `hysteron help VERB` says what each verb needs and writes. Results go to
/// stdout, everything else to stderr.
#[derive(Debug, Parser)]
#[command(name = "hysteron", version, after_help = HELP)]
pub struct Program {
    #[command(subcommand)]
    pub verb: Verb,
    /// Log details; twice for everything, of libraries too
    #[arg(short, long, global = true, help_heading = "Options of all verbs", action = ArgAction::Count)]
    verbose: u8,
    /// Log only warnings, and show no progress; twice for errors alone
    #[arg(short, long, global = true, help_heading = "Options of all verbs", action = ArgAction::Count)]
    quiet: u8,
    /// Replace results of this program that other arguments have made; an input, a measurement or a file of another
    /// program is never replaced
    #[arg(long, global = true, help_heading = "Options of all verbs")]
    overwrite: bool,
    /// Threads to use [default: all cores]; results do not depend on it
    #[arg(long, global = true, help_heading = "Options of all verbs", value_name = "N", value_parser = number::threads)]
    threads: Option<usize>,
    /// Print the outcome as JSON, and nothing else on stdout
    #[arg(long, global = true, help_heading = "Options of all verbs")]
    json: bool,
}

/// Verbs of the program.
#[derive(Debug, Subcommand)]
pub enum Verb {
    #[command(after_help = include_str!("help/simulate.txt"))]
    Simulate(hysteron_workflow::tendon::simulate::Options),
    #[command(after_help = include_str!("help/reach.txt"))]
    Reach(hysteron_workflow::tendon::reach::Options),
    #[command(after_help = include_str!("help/mesh.txt"))]
    Mesh(hysteron_workflow::tendon::mesh::Options),
    #[command(after_help = include_str!("help/reduce.txt"))]
    Reduce(hysteron_workflow::tendon::reduce::Options),
    #[command(after_help = include_str!("help/check.txt"))]
    Check(hysteron_workflow::tendon::check::Options),
    #[command(after_help = include_str!("help/record.txt"))]
    Record(hysteron_workflow::rig::record::Options),
    #[command(after_help = include_str!("help/import.txt"))]
    Import(hysteron_workflow::import::Options),
    Arm(crate::arm::Arguments),
    #[command(after_help = include_str!("help/fit-material.txt"))]
    FitMaterial(hysteron_workflow::tendon::fit_material::Options),
    #[command(after_help = include_str!("help/identify.txt"))]
    Identify(hysteron_workflow::tendon::identify::Options),
    #[command(after_help = include_str!("help/fit-residual.txt"))]
    FitResidual(hysteron_workflow::tendon::fit_residual::Options),
    #[command(after_help = include_str!("help/adapt.txt"))]
    Adapt(hysteron_workflow::tendon::adapt::Options),
    #[command(after_help = include_str!("help/generate.txt"))]
    Generate(hysteron_workflow::tendon::generate::Options),
    Shards(crate::shards::Arguments),
    #[command(after_help = include_str!("help/target.txt"))]
    Target(hysteron_workflow::tendon::target::Options),
    #[command(after_help = include_str!("help/evaluate.txt"))]
    Evaluate(hysteron_workflow::tendon::evaluate::Options),
    #[command(after_help = include_str!("help/train.txt"))]
    Train(hysteron_workflow::tendon::train::Options),
    #[command(after_help = include_str!("help/command.txt"))]
    Command(hysteron_workflow::tendon::command::Options),
    #[command(after_help = include_str!("help/track.txt"))]
    Track(hysteron_workflow::tendon::track::Options),
    #[command(after_help = include_str!("help/fit-sensor.txt"))]
    FitSensor(hysteron_workflow::tendon::fit_sensor::Options),
    #[command(after_help = include_str!("help/sense.txt"))]
    Sense(hysteron_workflow::tendon::sense::Options),
    #[command(after_help = include_str!("help/identify-servo.txt"))]
    IdentifyServo(hysteron_workflow::rig::identify_servo::Options),
    Rig(crate::rig::Arguments),
    Study(crate::study::Arguments),
    /// As `hysteron study run`
    #[command(hide = true, after_help = include_str!("help/study.txt"))]
    Run(hysteron_studies::chain::Options),
    #[command(after_help = include_str!("help/demo.txt"))]
    Demo(crate::study::demo::Arguments),
    Completions(crate::manual::CompletionArguments),
    Man(crate::manual::ManArguments),
    /// Switch the torque of a rig off when stdin closes (started by `record` and `rig calibrate`)
    #[command(hide = true, name = WATCHDOG)]
    Watchdog {
        /// Rig file
        rig: PathBuf,
    },
}

impl Program {
    /// The arguments as typed; or where they cannot be used, the exit code after the error was reported.
    pub fn typed(arguments: &[OsString]) -> Result<Self, u8> {
        Self::parse_from_words(arguments.iter().cloned()).map_err(|error| match out_of_range(&error) {
            Some(bad) => {
                terminal::report_error(&bad.into());
                2
            }
            None => {
                // Control characters in the typed words are escaped.
                let shown = |word: OsString| OsString::from(terminal::escaped(&word.to_string_lossy()));
                let again = Self::parse_from_words(arguments.iter().cloned().map(shown));
                let error = again.err().unwrap_or(error);
                // Help and version are no errors, and go to stdout.
                let printed = error.print();
                if error.use_stderr() {
                    return u8::try_from(error.exit_code()).unwrap_or(2);
                }
                terminal::keep_first(printed.and_then(|()| std::io::stdout().flush()));
                terminal::exit_code_of_printing()
            }
        })
    }

    /// The arguments of a caller in the same process.
    ///
    /// # Errors
    /// `BadInput` for arguments that cannot be used.
    pub fn of_caller(arguments: &[OsString]) -> Result<Self, anyhow::Error> {
        Self::parse_from_words(arguments.iter().cloned())
            .map_err(|error| out_of_range(&error).unwrap_or_else(|| unusable(&error)).into())
    }

    fn parse_from_words(words: impl Iterator<Item = OsString>) -> Result<Self, clap::Error> {
        Self::try_parse_from(std::iter::once(OsString::from("hysteron")).chain(words))
    }

    /// Whether results of this program that other arguments have made may be replaced too.
    pub fn overwrite(&self) -> bool {
        self.overwrite
    }

    /// Log level: 1 is the default; none if no option sets it.
    pub fn verbosity(&self) -> Option<i8> {
        let of = |count: u8| i8::try_from(count).unwrap_or(i8::MAX);
        let is_typed = self.verbose > 0 || self.quiet > 0;
        is_typed.then(|| 1i8.saturating_add(of(self.verbose)).saturating_sub(of(self.quiet)))
    }

    /// Whether stdout is read by a program.
    pub fn is_json(&self) -> bool {
        self.json
    }

    /// The options of all verbs, for the processes of a study.
    pub fn passed_on(&self) -> Vec<String> {
        let times = |option: &str, count: u8| vec![option.to_owned(); usize::from(count)];
        let threads = self.threads.iter().flat_map(|n| ["--threads".to_owned(), n.to_string()]);
        times("--verbose", self.verbose)
            .into_iter()
            .chain(times("--quiet", self.quiet))
            .chain(threads)
            .collect()
    }

    /// Limits the threads of everything that follows.
    pub fn use_threads(&self) -> anyhow::Result<()> {
        if let Some(threads) = self.threads {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
        }
        Ok(())
    }
}

/// The error of a number's parser, its place the option.
fn out_of_range(error: &clap::Error) -> Option<BadInput> {
    if error.kind() != ErrorKind::ValueValidation {
        return None;
    }
    let bad = std::error::Error::source(error)?.downcast_ref::<BadInput>()?.clone();
    let Some(ContextValue::String(argument)) = error.get(ContextKind::InvalidArg) else { return None };
    let option = argument.split(' ').next().unwrap_or(argument);
    Some(bad.within(option))
}

/// Any other error of the command line: its place is the option, where it names one.
fn unusable(error: &clap::Error) -> BadInput {
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => text.clone(),
        Some(ContextValue::Strings(texts)) => texts.join(" "),
        _ => String::new(),
    };
    let place = match text(ContextKind::InvalidArg) {
        argument if argument.is_empty() => "arguments".to_owned(),
        argument => argument,
    };
    // The first paragraph says what is wrong; usage and advice on --help follow.
    let rendered = error.render().to_string();
    let paragraph = rendered.split("\n\n").next().unwrap_or_default();
    let found = paragraph.strip_prefix("error: ").unwrap_or(paragraph);
    BadInput::new(place, "arguments that can be used", found.split_whitespace().collect::<Vec<_>>().join(" "))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    #[test]
    fn verbs_and_options_do_not_contradict_each_other() {
        use clap::CommandFactory;
        Program::command().debug_assert();
    }

    #[test]
    fn a_number_out_of_range_is_refused_in_the_form_of_all_errors() {
        let typed = "hysteron track a.safetensors --target circle:4 --rig r --out o --repeats 1000000000";
        let error = Program::try_parse_from(typed.split(' ')).unwrap_err();
        let bad = out_of_range(&error).unwrap();
        assert_eq!(bad.to_string(), "--repeats: expected at most 100, got 1000000000");
    }
}

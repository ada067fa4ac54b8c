//! The command line: verbs, options for all of them, and the help that goes with them.

use clap::{ArgAction, Parser, Subcommand};

const HELP: &str = "\
Examples, from the root of the repository; where hysteron is not installed, `cargo run --release --` stands for it:
  hysteron demo
  hysteron run cli/studies/paper.toml
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
  hysteron fit-material meshes/tpu80/scene.toml out/quick/*.parquet --role training \\
      --out out/fitted/scene.toml --figures out/fitted
  hysteron target circle:40 --out out/circle40.parquet
  hysteron evaluate --target circle:38 out/circle40.parquet
  hysteron train out/quick --out out/quick/inverse.safetensors
  hysteron command out/quick/inverse.safetensors --target out/quick/ellipse.parquet \\
      --out out/commands/ellipse.parquet
  hysteron generate meshes/tpu80/scene.toml --plan quick --out out/bare
  hysteron track --rig virtual:typical --scene meshes/tpu80/scene.toml --nominal --target circle:30 --out out/nominal
  hysteron arm info panda
  hysteron rig check
  hysteron rig emulate --dir out/rig --for-s 1

With servos and a tracker, begin with docs/rig.md.

Exit codes: 0 done, 1 failed or interrupted, 2 bad input (nothing is written under the final name).";

/// Digital twin and controller for tendon-driven continuum robots
///
/// A robot is a folder with a mesh (.msh) and a scene (scene.toml): material, clamp, tendons, tip. A rig is a file
/// (rig.toml): servos, tracker, limits. `hysteron help VERB` says what each verb needs and writes. Results go to stdout,
/// everything else to stderr.
#[derive(Debug, Parser)]
#[command(name = "hysteron", version, after_help = HELP)]
pub struct Program {
    #[command(subcommand)]
    pub verb: Verb,
    /// Log more; twice for everything
    #[arg(short, long, global = true, help_heading = "Options of all verbs", action = ArgAction::Count)]
    verbose: u8,
    /// Log only warnings; twice for errors alone
    #[arg(short, long, global = true, help_heading = "Options of all verbs", action = ArgAction::Count)]
    quiet: u8,
    /// Threads to use [default: all cores]; results do not depend on it
    #[arg(long, global = true, help_heading = "Options of all verbs", value_name = "N")]
    threads: Option<std::num::NonZeroUsize>,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Verb {
    Simulate(crate::simulate::Arguments),
    Reach(crate::reach::Arguments),
    Mesh(crate::mesh::Arguments),
    Check(crate::check::Arguments),
    Record(crate::record::Arguments),
    Arm(crate::arm::Arguments),
    FitMaterial(crate::fit_material::Arguments),
    Identify(crate::identify::Arguments),
    FitResidual(crate::fit_residual::Arguments),
    Adapt(crate::adapt::Arguments),
    Generate(crate::generate::Arguments),
    Target(crate::target::Arguments),
    Evaluate(crate::evaluate::Arguments),
    Train(crate::train::Arguments),
    Command(crate::command::Arguments),
    Track(crate::track::Arguments),
    Rig(crate::rig::Arguments),
    Run(crate::study::Arguments),
    Demo(crate::study::demo::Arguments),
    #[command(hide = true)]
    Watchman(crate::watchman::Arguments),
}

impl Program {
    /// 1 unless asked for more or less.
    pub fn verbosity(&self) -> i8 {
        let of = |count: u8| i8::try_from(count).unwrap_or(i8::MAX);
        1i8.saturating_add(of(self.verbose)).saturating_sub(of(self.quiet))
    }

    /// The options of all verbs, for a program that this one starts.
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
            rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build_global()?;
        }
        Ok(())
    }
}

//! The outcome of `reduce`: size of the chain, and how far it is from the finite elements.

use std::path::PathBuf;

use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_twin::chain::{Chain, Spread, Validation};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{COMMIT, Context};

/// The outcome of `reduce`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// The file.
    pub out: PathBuf,
    /// Hash of the scene and its mesh.
    pub scene_sha256: String,
    /// Unknowns of the finite elements.
    pub mesh_unknowns: usize,
    /// Unknowns of the chain.
    pub chain_unknowns: usize,
    /// Sections of the chain.
    pub sections: usize,
    /// Equilibria that were compared.
    pub equilibria: usize,
    /// Targets under which the finite elements had no equilibrium.
    pub without_mesh_equilibrium: usize,
    /// Others under which the chain had none.
    pub without_chain_equilibrium: usize,
    /// Largest stroke of the targets [m].
    pub stroke_m: f64,
    /// Largest tension of auxiliary tendons in the targets [N].
    pub tension_n: f64,
    /// Distance of the tips over the tip's displacement, or over a fortieth of the body's length where it moves less [-].
    pub tip: ReductionError,
    /// Largest error of a tension over the largest tension of the equilibrium, or over a fortieth of the largest of all where
    /// that is more [-].
    pub tensions: ReductionError,
    /// Angle between the rotations of the tip [rad].
    pub turn_rad: ReductionError,
    /// Whether the chain can stand for the finite elements.
    pub verdict: Verdict,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

/// Distribution of an error over the equilibria.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct ReductionError {
    /// Half of the errors are below this.
    pub median: f64,
    /// 99 of 100 are below this.
    pub percentile_99: f64,
    /// Largest error.
    pub largest: f64,
}

impl From<Spread> for ReductionError {
    fn from(spread: Spread) -> Self {
        let Spread { median, percentile_99, largest } = spread;
        Self { median, percentile_99, largest }
    }
}

impl crate::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }

    fn lines(&self) -> Vec<String> {
        let row = |name: &str, scale: f64, error: &ReductionError| {
            let of = |value: f64| format!("{:>10.3}", scale * value);
            format!("{name:<20}{}{}{}", of(error.median), of(error.percentile_99), of(error.largest))
        };
        vec![
            format!("{:<20}{:>10}{:>10}{:>10}", "error", "median", "99 %", "largest"),
            row("tip [%]", 100.0, &self.tip),
            row("tension [%]", 100.0, &self.tensions),
            row("rotation [deg]", 1f64.to_degrees(), &self.turn_rad),
            format!(
                "{} sections, {} unknowns in place of {}; {} equilibria, strokes to {:.2} mm",
                self.sections,
                self.chain_unknowns,
                self.mesh_unknowns,
                self.equilibria,
                1e3 * self.stroke_m
            ),
        ]
    }
}

impl Outcome {
    /// Of a chain that was validated.
    pub(super) fn new(
        out: PathBuf,
        (scene_sha256, mesh_unknowns): (String, usize),
        (chain, validation): (&Chain, &Validation),
        context: &Context,
    ) -> Self {
        Self {
            out,
            scene_sha256,
            mesh_unknowns,
            chain_unknowns: chain.n_unknowns(),
            sections: chain.n_sections(),
            equilibria: validation.count,
            without_mesh_equilibrium: validation.refused[0],
            without_chain_equilibrium: validation.refused[1],
            stroke_m: validation.stroke,
            tension_n: validation.tension,
            tip: validation.tip.into(),
            tensions: validation.tensions.into(),
            turn_rad: validation.turn.into(),
            verdict: assess(validation),
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

/// Whether the chain can stand for the finite elements.
fn assess(validation: &Validation) -> Verdict {
    let percent = |share: f64| format!("{:.2} %", 100.0 * share);
    let (tip, tensions) = (validation.tip, validation.tensions);
    let [unsolved, failed] = validation.refused;
    let solved = validation.count + failed;
    let asked = solved + unsolved;
    Verdict::on(format!(
        "tips and tensions are those of the finite elements within {} and {} in the median",
        percent(tip.median),
        percent(tensions.median)
    ))
    .because(
        Criterion::ErrorOverTarget,
        tip.percentile_99,
        format!(
            "in 99 of 100 equilibria the tip is off by at most {} of its way",
            percent(tip.percentile_99)
        ),
    )
    .because(
        Criterion::ErrorOverTarget,
        tensions.percentile_99,
        format!("in 99 of 100 equilibria tensions are off by at most {}", percent(tensions.percentile_99)),
    )
    .because(
        Criterion::SolverFailures,
        failed as f64 / solved.max(1) as f64,
        format!("{failed} of {solved} equilibria of the finite elements are none of the chain"),
    )
    .because(
        Criterion::Missing,
        unsolved as f64 / asked.max(1) as f64,
        format!("{unsolved} of {asked} targets have no equilibrium of the finite elements"),
    )
    .verdict()
}

//! Chains of condensed sections next to the finite elements that they were made from, on the same drives.

#![allow(clippy::print_stdout)] // this program prints tables

use std::time::Instant;

use anyhow::Result;
use hysteron_twin::chain::Chain;
use hysteron_twin::{Target, Twin};

use crate::drive::N_RAMP;
use crate::measure::{StepCost, percentile, percentile_of_steps};
use crate::table::{FigureTarget, TableRow};

/// Stroke of one tick of a servo [m].
const TICK: f64 = 5e-6;

const MESH: &str = "the finite elements, in between";

/// The twins of the drives: with four tendons, with auxiliary ones too, with friction.
#[derive(Debug, Clone, Copy)]
pub struct DrivenTwins<'a> {
    /// With four tendons.
    pub few: &'a Twin,
    /// With auxiliary tendons too.
    pub many: &'a Twin,
    /// With four tendons and friction.
    pub rubbing: &'a Twin,
}

/// A drive, and the speed that the chain is to have [steps/s].
struct ChainDrive<'a> {
    name: &'a str,
    twin: &'a Twin,
    targets: &'a [Vec<Target>],
    speed: f64,
}

/// The targets with strokes as servos take them, in whole ticks.
fn in_ticks(targets: &[Vec<Target>]) -> Vec<Vec<Target>> {
    let ticked = |target: &Target| match *target {
        Target::Stroke(stroke) => Target::Stroke(TICK * (stroke / TICK).round()),
        other => other,
    };
    targets.iter().map(|targets| targets.iter().map(ticked).collect()).collect()
}

/// Speed and slowest steps on a circle, with all tendons by `strokes` and in ticks; `worst` takes the largest residual [-] and stroke error [m].
///
/// # Errors
/// A body without sections, a step that fails.
pub fn rows(
    repetitions: usize,
    DrivenTwins { few, many, rubbing }: DrivenTwins,
    [circle, strokes]: [&[Vec<Target>]; 2],
    worst: &mut (f64, f64),
) -> Result<Vec<TableRow>> {
    let ticks = in_ticks(circle);
    let drives = [
        ChainDrive { name: "4 tendons", twin: few, targets: circle, speed: 12_000.0 },
        ChainDrive { name: "4 + 36 tendons, all by stroke", twin: many, targets: strokes, speed: 6000.0 },
        ChainDrive { name: "4 tendons, friction", twin: rubbing, targets: circle, speed: 5000.0 },
        ChainDrive { name: "4 tendons, strokes in ticks", twin: few, targets: &ticks, speed: 5000.0 },
    ];
    let mut rows = Vec::new();
    for ChainDrive { name, twin, targets, speed } in drives {
        let start = Instant::now();
        let reduced = twin.clone().with_chain(Chain::new(twin)?);
        let making = start.elapsed().as_secs_f64();
        let (mut chains, mut meshes) = (Vec::new(), Vec::new());
        for repetition in 0..repetitions {
            let run = StepCost::new(&reduced, targets, N_RAMP)?;
            println!("{:2}  chain, {name:33} {:7.0} steps/s", repetition + 1, run.rate());
            *worst = (worst.0.max(run.worst_residual), worst.1.max(run.worst_stroke_error));
            chains.push(run);
            meshes.push(StepCost::new(twin, targets, N_RAMP)?);
        }
        let best = |runs: &[StepCost]| percentile(&runs.iter().map(StepCost::rate).collect::<Vec<_>>(), 1.0);
        let slow = |runs: &[StepCost], part: f64| 1e3 * percentile_of_steps(runs, part);
        rows.push(
            TableRow::new(format!("chain, {name}: speed"), best(&chains), "steps/s")
                .against(best(&meshes), MESH)
                .goal(FigureTarget::AtLeast(speed)),
        );
        for (part, title, limit) in [(0.99, "99 % of steps", 0.3), (1.0, "worst step", 2.0)] {
            rows.push(
                TableRow::new(format!("chain, {name}: {title}"), slow(&chains, part), "ms")
                    .against(slow(&meshes, part), MESH)
                    .goal(FigureTarget::AtMost(limit)),
            );
        }
        rows.push(TableRow::new(format!("chain, {name}: made in"), making, "s"));
    }
    Ok(rows)
}

//! The performance targets: every figure next to its baseline, in one run.
//!
//! Speeds are the best of several repetitions, each from rest, so that other load on the machine costs
//! repetitions and not truth; the median over the repetitions is written next to them. A percentile of steps
//! is one of all steps of all repetitions, delayed ones included. The ramp at the beginning is not measured.
//! The baseline of a speed is one numeric factorisation by faer of the same stiffness, timed in between: the
//! cost of any method that factorises once a step.
#![allow(clippy::print_stdout)] // this program prints tables

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Result, ensure};
use hysteron_base::{file, json};
use hysteron_fem::{FactorKind, FemModel, Order, Stiffness, StiffnessFactor, Tangent};
use hysteron_twin::{Stepper, Target, Twin};

use crate::chain::{self, DrivenTwins};
use crate::coreact;
use crate::drive::{self, N_CIRCLE, N_RAMP};
use crate::fit;
use crate::learn;
use crate::measure::{
    StepCost, machine, peak_memory_mb, percentile, percentile_of_steps, processor_seconds, shortest,
};
use crate::rig;
use crate::table::{FigureTarget, TableRow, print_rows};
use crate::{emulated, repository};
use hysteron_studies::tendon::scenes::{
    N_PRIMARY, N_TENDONS, Setting, sofa_mesh, sofa_scene, tube, tube_scene,
};

/// SOFA on this scene, one linearisation a step and not converged [steps/s]; `tests/reference/sofa`, one core of
/// a 2.6 GHz Xeon with AVX-512.
const SOFA: [(usize, f64); 2] = [(N_PRIMARY, 68.9), (N_TENDONS, 40.4)];
const FAER: &str = "numeric factorisation by faer (f64) of the same stiffness";
const NOISE: f64 = 10e-6;

/// How long to measure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuringTime {
    /// Times every drive is run.
    pub repetitions: usize,
    /// Steps of a drive, the ramp included.
    pub n_steps: usize,
    /// Sides of the tubes whose cost is compared.
    pub divisions: &'static [u32],
    /// Measured steps on each of these.
    pub n_scaling_steps: usize,
    /// Time that is recorded from the emulated rig [s].
    pub recorded: f64,
    /// Samples of the virtual rig's circle that are identified and rolled out.
    pub n_identified: usize,
    /// Samples of each recording that a scene is fitted to.
    pub n_fitted: usize,
    /// Samples of the sequences that a network is trained on.
    pub n_samples: usize,
}

impl MeasuringTime {
    /// A whole circle and more, five times.
    pub const FULL: Self = Self {
        repetitions: 5,
        n_steps: N_RAMP + N_CIRCLE + 429,
        divisions: &[9, 16, 28, 41],
        n_scaling_steps: 100,
        recorded: 10.0,
        n_identified: 1500,
        n_fitted: 14_333,
        n_samples: 200,
    };
    /// Shows that everything runs; the figures mean little.
    pub const QUICK: Self = Self {
        repetitions: 1,
        n_steps: N_RAMP + 150,
        divisions: &[9, 16],
        n_scaling_steps: 30,
        recorded: 5.0,
        n_identified: 100,
        n_fitted: 700,
        n_samples: 20,
    };
}

/// Measures, prints the table and writes it to `path`.
///
/// # Errors
/// A step fails, or the reference cannot be read.
pub fn run(effort: MeasuringTime, path: &Path) -> Result<()> {
    let mesh = sofa_mesh(repository())?;
    let few = sofa_scene(repository(), Setting::TARGETS, &mesh, N_PRIMARY)?;
    let many = sofa_scene(repository(), Setting::TARGETS, &mesh, N_TENDONS)?;
    let rubbing = sofa_scene(repository(), Setting::RUBBING, &mesh, N_PRIMARY)?;
    let n = effort.n_steps;
    let circle = drive::with_tensions(N_PRIMARY, n, 0.0);
    let strokes = drive::with_strokes(&many, n)?;
    let tensions = drive::with_tensions(N_TENDONS, n, 0.5);
    let noisy = |targets, n_noisy| drive::with_noise(targets, n_noisy, NOISE);

    let drives = [
        ("4 tendons", &few, circle.clone(), Some(2500.0)),
        ("4 + 36 tendons, all by stroke", &many, strokes.clone(), Some(2000.0)),
        ("4 + 36 tendons, 36 by tension", &many, tensions.clone(), Some(2000.0)),
        ("4 tendons, noise", &few, noisy(&circle, N_PRIMARY), Some(700.0)),
        ("4 + 36 tendons by stroke, noise on 4", &many, noisy(&strokes, N_PRIMARY), Some(700.0)),
        ("4 + 36 tendons by stroke, noise on 40", &many, noisy(&strokes, N_TENDONS), None),
        ("4 + 36 tendons by tension, noise on 4", &many, noisy(&tensions, N_PRIMARY), Some(700.0)),
        ("4 tendons, 16 friction points", &rubbing, circle.clone(), Some(2000.0)),
    ];
    let mut runs: Vec<Vec<StepCost>> = vec![Vec::new(); drives.len()];
    let mut factorisation = f64::INFINITY;
    for repetition in 0..effort.repetitions {
        for ((name, twin, targets, _), runs) in drives.iter().zip(&mut runs) {
            factorisation = factorisation.min(faer_seconds(&few));
            let run = StepCost::new(twin, targets, N_RAMP)?;
            println!("{:2}  {name:40} {:7.0} steps/s", repetition + 1, run.rate());
            runs.push(run);
        }
    }

    let mut rows = Vec::new();
    let mut details = Vec::new();
    let mut worst = (0.0f64, 0.0f64);
    for ((name, twin, _, target), runs) in drives.iter().zip(&runs) {
        let rates: Vec<f64> = runs.iter().map(StepCost::rate).collect();
        let row = TableRow::new(format!("{name}: speed"), percentile(&rates, 1.0), "steps/s")
            .against(1.0 / factorisation, FAER);
        rows.push(match target {
            Some(rate) => row.goal(FigureTarget::AtLeast(*rate)),
            None => row,
        });
        let row =
            TableRow::new(format!("{name}: 99 % of steps"), 1e3 * percentile_of_steps(runs, 0.99), "ms")
                .against(1e3 * factorisation, FAER);
        rows.push(if target.is_some_and(|rate| rate > 700.0) {
            row.goal(FigureTarget::AtMost(2.0))
        } else {
            row
        });
        for run in runs {
            worst = (worst.0.max(run.worst_residual), worst.1.max(run.worst_stroke_error));
        }
        if let Some(run) = runs.first() {
            let steps = run.seconds.len() as f64;
            details.push(json!({
                "drive": name,
                "n_tendons": twin.tendons.len(),
                "n_friction_points": twin.friction.len(),
                "steps": steps,
                "median_steps_per_s": percentile(&rates, 0.5),
                "iterations_per_step": run.iterations as f64 / steps,
                "steps_per_factorisation": steps / run.refactorisations.max(1) as f64,
                "steps_by_newton": run.newton_steps,
                "qps_by_clarabel": run.clarabel_solves,
            }));
        }
    }
    for ((n_tendons, sofa), row) in SOFA.into_iter().zip([0, 2]) {
        let name = format!("{n_tendons} tendons: speed, SOFA quoted");
        rows.push(TableRow::new(name, rows[row].measured, "steps/s").against(sofa, "SOFA v25.06, quoted"));
    }
    rows.push(TableRow::new("peak memory", peak_memory_mb(), "MB").goal(FigureTarget::AtMost(200.0)));
    let ThreadSpeeds { two, one, by_processor_time } = rollouts(&few, &circle, effort.repetitions)?;
    rows.push(TableRow::new("two threads: rollouts", two, "steps/s").against(one, "one thread, in between"));
    rows.push(TableRow::new("two threads: gain", two / one, "-").goal(FigureTarget::AtLeast(1.8)));
    rows.push(TableRow::new("two threads: gain by processor time", by_processor_time, "-"));
    let twins = DrivenTwins { few: &few, many: &many, rubbing: &rubbing };
    rows.extend(chain::rows(effort.repetitions, twins, [&circle, &strokes], &mut worst)?);
    rows.extend(coreact::rows_of_chains(effort.repetitions, effort.n_identified)?);
    rows.extend(scaling(effort, &mut worst)?);
    rows.extend(rig::rows(effort.repetitions)?);
    rows.extend(emulated::rows(effort.recorded)?);
    rows.extend(coreact::rows(effort.repetitions, effort.n_identified)?);
    rows.extend(fit::rows(effort.n_fitted)?);
    rows.extend(learn::rows(effort.repetitions, effort.n_samples)?);
    rows.extend(worst_errors(worst));
    write(&rows, &details, effort, path)
}

/// Measures the chains of sections alone, prints the table and writes it to `path`.
///
/// # Errors
/// A step fails.
pub fn run_chains(effort: MeasuringTime, path: &Path) -> Result<()> {
    let mesh = sofa_mesh(repository())?;
    let few = sofa_scene(repository(), Setting::TARGETS, &mesh, N_PRIMARY)?;
    let many = sofa_scene(repository(), Setting::TARGETS, &mesh, N_TENDONS)?;
    let rubbing = sofa_scene(repository(), Setting::RUBBING, &mesh, N_PRIMARY)?;
    let circle = drive::with_tensions(N_PRIMARY, effort.n_steps, 0.0);
    let strokes = drive::with_strokes(&many, effort.n_steps)?;
    let twins = DrivenTwins { few: &few, many: &many, rubbing: &rubbing };
    let mut worst = (0.0f64, 0.0f64);
    let mut rows = chain::rows(effort.repetitions, twins, [&circle, &strokes], &mut worst)?;
    rows.extend(coreact::rows_of_chains(effort.repetitions, effort.n_identified)?);
    rows.extend(fit::rows(effort.n_fitted)?);
    rows.extend(worst_errors(worst));
    write(&rows, &[], effort, path)
}

/// Largest relative residual [-] and stroke error [m] of all steps.
fn worst_errors((residual, stroke): (f64, f64)) -> [TableRow; 2] {
    [
        TableRow::new("worst relative residual", residual, "-").goal(FigureTarget::AtMost(1e-6)),
        TableRow::new("worst stroke error", 1e3 * stroke, "mm").goal(FigureTarget::AtMost(1e-6)),
    ]
}

fn write(rows: &[TableRow], details: &[json::Value], effort: MeasuringTime, path: &Path) -> Result<()> {
    println!();
    print_rows(rows);
    let report = json!({
        "format": "hysteron-targets",
        "version": 1,
        "machine": machine(),
        "repetitions": effort.repetitions,
        "steps": effort.n_steps,
        "targets": rows,
        "details": details,
    });
    file::write_bytes(path, json::to_text(&report)?)?;
    println!("\nwritten to {}", path.display());
    Ok(())
}

/// Assembled stiffness of a body at rest, in the pattern of its elements.
pub fn rest_stiffness(body: &FemModel) -> Stiffness {
    let mut stiffness = Stiffness::zeros(Arc::new(body.stiffness_pattern(&[])));
    body.stiffness_into(&body.rest, Tangent::Exact, &mut stiffness);
    stiffness
}

/// Shortest of a few numeric factorisations by faer [s].
fn faer_seconds(twin: &Twin) -> f64 {
    let stiffness = rest_stiffness(&twin.body);
    let mut factor = StiffnessFactor::new(&stiffness.pattern, FactorKind::Supernodal, twin.body.isa);
    // The stiffness of a clamped body at rest is positive definite.
    shortest(5, || assert!(factor.factorize(&stiffness).is_ok(), "the stiffness at rest has no factor"))
}

/// Speed on two threads and on one [steps/s].
struct ThreadSpeeds {
    two: f64,
    one: f64,
    /// Gain with an undisturbed core for each thread, from processor times: what sharing memory and caches
    /// leaves of 2. None where the system does not give it.
    by_processor_time: Option<f64>,
}

/// Rollouts on two threads, with a stepper each, and on one; best of alternations.
fn rollouts(twin: &Twin, targets: &[Vec<Target>], alternations: usize) -> Result<ThreadSpeeds> {
    let rollout = || -> hysteron_twin::Result<()> {
        let mut stepper = Stepper::new(twin);
        targets.iter().try_for_each(|targets| stepper.step(twin, targets).map(drop))
    };
    let (mut two, mut one) = (0.0f64, 0.0f64);
    let mut processor = [Some(0.0); 2];
    for _ in 0..alternations.max(2) {
        let before = processor_seconds();
        let start = Instant::now();
        rollout()?;
        one = one.max(targets.len() as f64 / start.elapsed().as_secs_f64());
        let between = processor_seconds();
        let start = Instant::now();
        std::thread::scope(|scope| {
            let other = scope.spawn(rollout);
            let here = rollout();
            other.join().unwrap_or(Ok(())).and(here)
        })?;
        two = two.max(2.0 * targets.len() as f64 / start.elapsed().as_secs_f64());
        for (sum, [from, to]) in processor.iter_mut().zip([[before, between], [between, processor_seconds()]])
        {
            *sum = sum.zip(from.zip(to)).map(|(sum, (from, to))| sum + to - from);
        }
    }
    let by_processor_time = match processor {
        [Some(one), Some(two)] if two > 0.0 => Some(4.0 * one / two),
        _ => None,
    };
    Ok(ThreadSpeeds { two, one, by_processor_time })
}

/// The circular drive on finer and finer tubes, and the exponent of cost over size.
fn scaling(effort: MeasuringTime, worst: &mut (f64, f64)) -> Result<Vec<TableRow>> {
    // Up to the circle in few steps: only the steps on it are measured.
    let n_ramp = N_RAMP / 10;
    let ramp = (0..n_ramp).map(|k| 10 * k);
    // After a jump of ten steps there is a refactorisation; a few steps settle it.
    let n_settling = 10;
    let on_circle = N_RAMP..N_RAMP + n_settling + effort.n_scaling_steps;
    let targets: Vec<Vec<Target>> =
        ramp.chain(on_circle).map(|k| drive::circle(k).map(Target::Stroke).to_vec()).collect();
    let mut rows = Vec::new();
    let mut points = Vec::new();
    for &divisions in effort.divisions {
        let twin = tube_scene(Setting::TARGETS, &tube(divisions, Order::Linear).mesh()?)?;
        let repetitions = if divisions < 25 { effort.repetitions } else { 1 };
        let mut fastest = f64::INFINITY;
        for _ in 0..repetitions {
            let run = StepCost::new(&twin, &targets, n_ramp + n_settling)?;
            ensure!(run.newton_steps == 0, "{} steps on the circle by Newton's method", run.newton_steps);
            fastest = fastest.min(1e3 / run.rate());
            *worst = (worst.0.max(run.worst_residual), worst.1.max(run.worst_stroke_error));
        }
        let n = twin.body.n_unknowns();
        println!("{n} unknowns: {fastest:.3} ms/step");
        rows.push(
            TableRow::new(format!("step with {n} unknowns"), fastest, "ms")
                .against(1e3 * faer_seconds(&twin), FAER),
        );
        points.push([(n as f64).ln(), fastest.ln()]);
    }
    rows.push(
        TableRow::new("exponent of cost over unknowns", slope(&points), "-").goal(FigureTarget::AtMost(1.3)),
    );
    Ok(rows)
}

/// Slope of the least-squares line through (x, y).
pub fn slope(points: &[[f64; 2]]) -> f64 {
    let n = points.len() as f64;
    let mean = |c: usize| points.iter().map(|p| p[c]).sum::<f64>() / n;
    let (x, y) = (mean(0), mean(1));
    let covariance: f64 = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    covariance / points.iter().map(|p| (p[0] - x).powi(2)).sum::<f64>()
}

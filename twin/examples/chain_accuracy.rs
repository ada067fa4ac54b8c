//! How well a chain of condensed sections follows the finite elements that it was made from, and how fast.
//!
//!     cargo run --release -p hysteron-twin --example chain_accuracy -- meshes/tpu80/scene.toml 20 6 10
//!
//! Equilibria under random strokes of all real tendons within six millimetres, tensions of auxiliary ones within ten newtons, then a circle of five millimetres in steps of
//! 0.02 mm, of both bodies.
#![allow(clippy::print_stdout)]

use std::path::Path;
use std::time::Instant;

use hysteron_base::Scene;
use hysteron_twin::chain::{Chain, ChainStepper};
use hysteron_twin::{Accuracy, Result, Stepper, Target, Twin, nearest_rotation, read_body};
use nalgebra::{Matrix3, Vector3};
use rand::RngExt;

/// Largest stroke [m], and radius and step of the circle [m].
const REACH: f64 = 6e-3;
const RADIUS: f64 = 5e-3;
const STEP: f64 = 2e-5;
/// Largest tension of an auxiliary tendon [N].
const PUSH: f64 = 10.0;
/// Steps from one equilibrium to the next where friction makes the way matter.
const WALK: usize = 60;
/// Steps that are timed.
const TIMED: usize = 1500;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let scene = arguments.next().unwrap_or_else(|| "meshes/tpu80/scene.toml".into());
    let count = arguments.next().and_then(|count| count.parse().ok()).unwrap_or(20);
    let reach = 1e-3 * arguments.next().and_then(|reach| reach.parse().ok()).unwrap_or(1e3 * REACH);
    let push = arguments.next().and_then(|push| push.parse().ok()).unwrap_or(PUSH);
    let timed = arguments.next().and_then(|count| count.parse().ok()).unwrap_or(TIMED);
    let scene = Scene::read(Path::new(&scene))?;
    let (mesh, _) = read_body(&scene)?;
    let mut twin = Twin::new(&scene, &mesh)?;
    twin.accuracy = Accuracy { relative_residual: 1e-6, stroke: 1e-9 };
    let begun = Instant::now();
    let chain = Chain::new(&twin)?;
    println!(
        "{}: {} unknowns; chain of {} sections, {} unknowns, made in {:.1} s; asymmetry {:.1e}",
        scene.name,
        twin.body.n_unknowns(),
        chain.n_sections(),
        chain.n_unknowns(),
        begun.elapsed().as_secs_f64(),
        chain.asymmetry
    );
    let tip: Vec<u32> = mesh.groups.get("tip").cloned().unwrap_or_default();
    let tip: Vec<u32> = tip.iter().map(|&file| twin.body.model_node[file as usize]).collect();
    compare(&twin, &chain, &tip, count, (reach, push))?;
    time(&twin, &chain, timed)
}

/// How a tendon is driven here.
enum Kind {
    /// A real tendon, by stroke.
    Driven,
    /// An auxiliary one, by tension.
    Auxiliary,
    /// One that may push: it models something else, and stays.
    Held,
}

fn kind(twin: &Twin, j: usize) -> Kind {
    if j >= twin.n_primary {
        Kind::Auxiliary
    } else if twin.tendons[j].tension.min < 0.0 {
        Kind::Held
    } else {
        Kind::Driven
    }
}

/// Prints the errors of `count` equilibria.
fn compare(twin: &Twin, chain: &Chain, tip: &[u32], count: usize, (reach, push): (f64, f64)) -> Result<()> {
    let mut rng = hysteron_base::rng(1, "chain/accuracy");
    let (mut fine, mut coarse) = (Stepper::new(twin), ChainStepper::new(twin, chain));
    let rest = Vector3::from(twin.tip_of(&twin.rest()));
    let mut errors = [const { Vec::new() }; 3];
    let mut refused = 0;
    let mut last_targets: Vec<Target> = twin.tendons.iter().map(|tendon| tendon.resting_target()).collect();
    for k in 0..count {
        let targets: Vec<Target> = (0..twin.tendons.len())
            .map(|j| match kind(twin, j) {
                Kind::Driven => Target::Stroke(rng.random_range(-reach..reach)),
                Kind::Auxiliary => Target::Tension(push * rng.random_range(-1.0..1.0)),
                Kind::Held => twin.tendons[j].resting_target(),
            })
            .collect();
        let parts = if twin.friction.is_empty() { 1 } else { WALK };
        let (mut iterations, mut failed) = ([0; 4], false);
        for part in 1..=parts {
            let between = mix(&last_targets, &targets, part as f64 / parts as f64);
            let report = fine.step(twin, &between)?;
            match coarse.step(twin, chain, &between) {
                Ok(chained) => {
                    let counts =
                        [report.iterations, report.newton_iterations, chained.iterations, chained.newton_iterations];
                    iterations.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
                }
                Err(error) => {
                    println!("{k:3}: {error}");
                    failed = true;
                }
            }
        }
        last_targets = targets;
        if failed {
            refused += 1;
            continue;
        }
        let (state, approximate) = (fine.state(), coarse.state());
        let moved = Vector3::from(twin.tip_of(state)) - rest;
        let apart = (Vector3::from(chain.tip_of(approximate)) - rest - moved).norm();
        let strongest = state.tensions.iter().fold(0.0f64, |max, t| max.max(t.abs()));
        let pairs = state.tensions.iter().zip(&approximate.tensions);
        let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let last = approximate.interfaces.last().map_or_else(Matrix3::identity, |end| end.rotation);
        let turned = turn(twin, tip, &state.positions);
        let between = (turned.transpose() * last).trace();
        let turn_error = (0.5 * (between - 1.0)).clamp(-1.0, 1.0).acos().to_degrees();
        let all = [100.0 * apart / moved.norm().max(2e-3), 100.0 * off / strongest.max(3.0), turn_error];
        println!(
            "{k:3}: tip {:6.2} mm, {:6.2} N; errors {:.3} % {:.3} % {:.3} deg; iterations {iterations:?}",
            1e3 * moved.norm(),
            strongest,
            all[0],
            all[1],
            all[2]
        );
        for (errors, error) in errors.iter_mut().zip(all) {
            errors.push(error);
        }
    }
    for (name, errors) in ["tip %", "tension %", "turn deg"].iter().zip(&mut errors) {
        errors.sort_by(f64::total_cmp);
        let at = |part: f64| errors.get(((errors.len() - 1) as f64 * part).round() as usize).copied().unwrap_or(f64::NAN);
        println!("{name}: median {:.3}, 90 % {:.3}, largest {:.3}", at(0.5), at(0.9), at(1.0));
    }
    println!("{refused} of {count} without an equilibrium of the chain");
    Ok(())
}

/// Targets at part `t` of the way.
fn mix(from: &[Target], to: &[Target], t: f64) -> Vec<Target> {
    let between = |(from, to): (&Target, &Target)| match (*from, *to) {
        (Target::Stroke(a), Target::Stroke(b)) => Target::Stroke(a + t * (b - a)),
        (Target::Tension(a), Target::Tension(b)) => Target::Tension(a + t * (b - a)),
        (_, to) => to,
    };
    from.iter().zip(to).map(between).collect()
}

/// Rotation of the tip's nodes since rest.
fn turn(twin: &Twin, tip: &[u32], x: &[[f64; 4]]) -> Matrix3<f64> {
    let arms = |x: &[[f64; 4]]| {
        let points: Vec<Vector3<f64>> =
            tip.iter().map(|&node| Vector3::from_column_slice(&x[node as usize][..3])).collect();
        let center = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
        points.into_iter().map(move |point| point - center).collect::<Vec<_>>()
    };
    let (before, after) = (arms(&twin.body.rest), arms(x));
    nearest_rotation(&before.iter().zip(&after).map(|(p, q)| q * p.transpose()).sum())
}

/// Strokes of the circle's step `k`: the tendons across let as much as others pull.
fn circle(twin: &Twin, k: usize) -> Vec<Target> {
    let ramp = (k as f64 * STEP / RADIUS).min(1.0);
    let angle = (k as f64 * STEP / RADIUS - 1.0).max(0.0);
    let target = |j: usize| {
        match kind(twin, j) {
            Kind::Driven => (),
            Kind::Auxiliary => return Target::Tension(0.0),
            Kind::Held => return twin.tendons[j].resting_target(),
        }
        let phase = std::f64::consts::TAU * j as f64 / twin.n_primary as f64;
        Target::Stroke(ramp * RADIUS * (angle - phase).cos())
    };
    (0..twin.tendons.len()).map(target).collect()
}

/// Prints steps per second of both, after 200 steps.
fn time(twin: &Twin, chain: &Chain, steps: usize) -> Result<()> {
    const WARM: usize = 200;
    let mut coarse = ChainStepper::new(twin, chain);
    let mut counts = [0; 2];
    let mut times = Vec::with_capacity(steps);
    for k in 0..WARM + steps {
        let targets = circle(twin, k);
        let begun = Instant::now();
        let report = coarse.step(twin, chain, &targets)?;
        if k >= WARM {
            times.push(begun.elapsed().as_secs_f64());
            counts = [counts[0] + report.iterations, counts[1] + report.refactorisations];
        }
    }
    print_times("chain", &mut times, counts);
    let mut fine = Stepper::new(twin);
    let (mut counts, mut times) = ([0; 2], Vec::with_capacity(steps));
    for k in 0..WARM + steps {
        let targets = circle(twin, k);
        let begun = Instant::now();
        let report = fine.step(twin, &targets)?;
        if k >= WARM {
            times.push(begun.elapsed().as_secs_f64());
            counts = [counts[0] + report.iterations, counts[1] + report.refactorisations];
        }
    }
    print_times("mesh", &mut times, counts);
    Ok(())
}

fn print_times(name: &str, times: &mut [f64], counts: [usize; 2]) {
    let total: f64 = times.iter().sum();
    times.sort_by(f64::total_cmp);
    let n = times.len() as f64;
    println!(
        "{name}: {:.0} steps/s; median {:.1}, 99 % {:.1}, worst {:.1} us; {:.2} iterations, {:.3} factors a step",
        n / total,
        1e6 * times[times.len() / 2],
        1e6 * times[(0.99 * n) as usize],
        1e6 * times[times.len() - 1],
        counts[0] as f64 / n,
        counts[1] as f64 / n
    );
}

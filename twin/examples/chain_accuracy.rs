//! How well a chain of condensed sections follows the finite elements that it was made from, and how fast.
//!
//!     cargo run --release -p hysteron-twin --example chain_accuracy -- meshes/tpu80/scene.toml 20 6 10 1500
//!
//! Equilibria under random strokes of the real tendons, here 20 within six millimetres, and tensions of auxiliary ones within ten
//! newtons; then a circle of five millimetres in 1500 steps of 0.02 mm, of both bodies.
#![allow(clippy::print_stdout)]

use std::path::Path;
use std::time::Instant;

use hysteron_base::Scene;
use hysteron_twin::chain::{Chain, Equilibrium, ErrorSpread, ValidationOptions};
use hysteron_twin::{Accuracy, Result, Stepper, Target, Twin};

/// Radius and step of the circle [m].
const RADIUS: f64 = 5e-3;
const STEP: f64 = 2e-5;
/// Steps before the clock starts.
const WARM: usize = 200;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number =
        |k: usize, default: f64| arguments.get(k).and_then(|text| text.parse().ok()).unwrap_or(default);
    let scene = arguments.first().map_or("meshes/tpu80/scene.toml", String::as_str);
    let scene = Scene::read(Path::new(scene))?;
    let mut twin = Twin::from_scene(&scene)?.without_chain();
    twin.accuracy = Accuracy { relative_residual: 1e-6, stroke: 1e-9 };
    let begun = Instant::now();
    let mut chain = Chain::new(&twin)?;
    println!(
        "{}: {} unknowns; chain of {} sections, {} unknowns, made in {:.1} s; asymmetry {:.1e}",
        scene.name,
        twin.body.n_unknowns(),
        chain.n_sections(),
        chain.n_unknowns(),
        begun.elapsed().as_secs_f64(),
        chain.asymmetry
    );
    let options = ValidationOptions {
        count: number(1, 20.0) as usize,
        stroke: 1e-3 * number(2, 6.0),
        tension: number(3, 10.0),
        seed: 1,
    };
    chain.validate(&twin, &options, &Equilibrium::all(&twin, &options)?)?;
    if let Some(validation) = &chain.validation {
        let row = |name: &str, unit: f64, spread: &ErrorSpread| {
            let [a, b, c] = [spread.median, spread.percentile_99, spread.largest].map(|error| unit * error);
            println!("{name}: median {a:.3}, 99 % {b:.3}, largest {c:.3}");
        };
        row("tip %", 100.0, &validation.tip);
        row("tension %", 100.0, &validation.tensions);
        row("turn deg", 1f64.to_degrees(), &validation.turn);
        println!(
            "{} compared, {:?} without an equilibrium of the mesh and the chain; strain to {:.3}",
            validation.count, validation.refused, validation.strain
        );
    }
    let steps = number(4, 1500.0) as usize;
    time("chain", &twin.clone().with_chain(chain), steps)?;
    time("mesh", &twin, steps)
}

/// Strokes of the circle's step `k`: the tendons across let as much as others pull.
fn circle(twin: &Twin, k: usize) -> Vec<Target> {
    let ramp = (k as f64 * STEP / RADIUS).min(1.0);
    let angle = (k as f64 * STEP / RADIUS - 1.0).max(0.0);
    let target = |j: usize| {
        let tendon = &twin.tendons[j];
        if j >= twin.n_primary {
            return Target::Tension(tendon.tension.clamp(0.0));
        }
        if tendon.tension.min < 0.0 {
            return tendon.resting_target();
        }
        let phase = std::f64::consts::TAU * j as f64 / twin.n_primary as f64;
        Target::Stroke(ramp * RADIUS * (angle - phase).cos())
    };
    (0..twin.tendons.len()).map(target).collect()
}

/// Prints steps per second.
fn time(name: &str, twin: &Twin, steps: usize) -> Result<()> {
    let mut stepper = Stepper::new(twin);
    let (mut iterations, mut factors) = (0, 0);
    let mut times = Vec::with_capacity(steps);
    for k in 0..WARM + steps {
        let targets = circle(twin, k);
        let begun = Instant::now();
        let report = stepper.step(twin, &targets)?;
        if k >= WARM {
            times.push(1e6 * begun.elapsed().as_secs_f64());
            iterations += report.iterations;
            factors += report.refactorisations;
        }
    }
    let total: f64 = times.iter().sum();
    times.sort_by(f64::total_cmp);
    let n = times.len();
    println!(
        "{name}: {:.0} steps/s; median {:.1}, 99 % {:.1}, worst {:.1} us; {:.2} iterations, {:.3} factors a step",
        1e6 * n as f64 / total,
        times[n / 2],
        times[n * 99 / 100],
        times[n - 1],
        iterations as f64 / n as f64,
        factors as f64 / n as f64
    );
    Ok(())
}

//! Regenerates `meshes/tpu80/strokes-circle.csv`, byte for byte:
//! `cargo run --release -p hysteron --example make_strokes -- meshes/tpu80/strokes-circle.csv`
//!
//! Circles in tendon space, u_k = a(t) cos(φ(t) - k 90°), with a smooth attack, a sustained part and a decay, as
//! a rig of four servos (4096 ticks per turn) with 10 mm pulleys would record them: whole ticks, a little unsteady.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::PathBuf;

use anyhow::Context as _;
use hysteron_base::{file, rng};
use rand::RngExt;

const SEED: u64 = 1;
const RATE_HZ: f64 = 100.0;
const DURATION_S: f64 = 40.0;
const ATTACK_S: f64 = 6.0;
const DECAY_S: f64 = 14.0;
const AMPLITUDE_MM: f64 = 5.0;
const TURNS: f64 = 10.0;
/// Length of tendon per tick.
const TICK_MM: f64 = TAU * 10.0 / 4096.0;

fn main() -> anyhow::Result<()> {
    let path: PathBuf = std::env::args().nth(1).context("name the file to write")?.into();
    let mut noise = rng(SEED, "strokes/circle");
    let mut csv = String::from("# format: hysteron-recording\n# version: 1\n");
    csv.push_str("# seed: 1\n# source: made by app/cli/examples/make_strokes.rs\n");
    csv.push_str("time_s,stroke_1_mm,stroke_2_mm,stroke_3_mm,stroke_4_mm\n");
    for sample in 0..=(DURATION_S * RATE_HZ) as usize {
        let t = sample as f64 / RATE_HZ;
        let phase = TAU * TURNS * t / DURATION_S;
        csv.push_str(&format!("{t:.2}"));
        for k in 0..4 {
            let stroke = AMPLITUDE_MM * envelope(t) * (phase - FRAC_PI_2 * f64::from(k)).cos();
            // The servo settles within half a tick of its commanded position.
            let unsteady: f64 = envelope(t).sqrt() * noise.random_range(-0.5..0.5);
            let ticks = (stroke / TICK_MM + unsteady).round();
            csv.push_str(&format!(",{:.4}", ticks * TICK_MM + 0.0));
        }
        csv.push('\n');
    }
    file::write_bytes(&path, csv)?;
    Ok(())
}

/// Attack, sustain and decay, smooth at their ends.
fn envelope(t: f64) -> f64 {
    let rise = |part: f64| 0.5 - 0.5 * (PI * part.clamp(0.0, 1.0)).cos();
    rise(t / ATTACK_S) * rise((DURATION_S - t) / DECAY_S)
}

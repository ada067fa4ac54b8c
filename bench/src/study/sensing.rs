//! Force estimation without force sensors: tensions and pushes estimated from recordings of virtual robots,
//! whose true forces are known.
//!
//! Each robot is calibrated from recordings of its own, as a user would; the scale of its servos' loads from one whose tensions are known;
//! the sensor is fitted on further ones, and evaluated on others.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result};
use hysteron_base::{file, json, rng};
use rand::RngExt;
use rayon::prelude::*;
use serde_json::Value;

use super::chain::{Chain, FRICTION, scene_path};
use super::write_metrics;

const ROBOTS: [&str; 2] = ["typical", "harsh"];
/// Trajectories of the plan `quick` that are for training.
const TRAINING: [&str; 4] = ["sinusoid", "diagonal", "circle", "square"];
/// Samples per second of all recordings [Hz].
const RATE: f64 = 100.0;
/// Largest stroke [mm]; speeds of moves [mm/s]; holds [s].
const REACH: f64 = 5.5;
const SPEEDS: [f64; 2] = [1.5, 5.0];
const HOLDS: [f64; 2] = [0.2, 2.5];
/// Forces of pushes [N], how long they last and how long there is none [s].
const FORCES: [f64; 2] = [0.05, 0.5];
const LASTS: [f64; 2] = [1.0, 3.0];
const PAUSES: [f64; 2] = [2.0, 4.0];

/// Runs the study; quick: one robot, short recordings.
///
/// # Errors
/// A stage fails.
pub fn run(folder: &Path, quick: bool) -> Result<()> {
    let effort = if quick {
        Effort { seconds: 60.0, epochs: "2", n_free: 2 }
    } else {
        Effort { seconds: 240.0, epochs: "300", n_free: 15 }
    };
    let robots = if quick { &ROBOTS[..1] } else { &ROBOTS[..] };
    let rows = robots.iter().map(|robot| sense(folder, robot, &effort)).collect::<Result<Vec<Value>>>()?;
    write_metrics(folder, "sensing", json!({ "robots": rows }))
}

struct Effort {
    /// Length of each recording [s].
    seconds: f64,
    /// Of the residual network.
    epochs: &'static str,
    /// Recordings without contact that the sensor is fitted on, and as many others to count false alarms in.
    n_free: u64,
}

/// Records, calibrates, fits and evaluates the sensor of one robot.
fn sense(folder: &Path, robot: &str, effort: &Effort) -> Result<Value> {
    let Effort { seconds, epochs, n_free } = *effort;
    let chain = Chain::new(&folder.join(robot))?;
    chain.record(robot, "quick", "quick")?;
    let [twin, residual, servos, sensor] =
        ["twin/scene.toml", "residual.safetensors", "servos.json", "sensor.json"]
            .map(|name| chain.path(name));
    let (twin, residual, servos, sensor) = (twin?, residual?, servos?, sensor?);
    let scene = scene_path(FRICTION.1);
    let training = TRAINING.map(|name| chain.path(&format!("quick/{name}.parquet")));
    let training = training.into_iter().collect::<Result<Vec<String>>>()?;
    let names: Vec<&str> = training.iter().map(String::as_str).collect();
    chain.once(&twin, &[&["fit-material", &scene][..], &names, &["--out", &twin]].concat())?;
    let record = |name: &str, seed: u64, pushed: bool| -> Result<String> {
        let [strokes, force, out] =
            ["strokes", "force", "recorded"].map(|kind| chain.path(&format!("{kind}/{name}")));
        let (strokes, force) = (format!("{}.csv", strokes?), format!("{}.csv", force?));
        let out = format!("{}.parquet", out?);
        let n = write_strokes(&strokes, seed, seconds)?;
        write_pushes(&force, seed, n, pushed)?;
        let (rig, seed) = (format!("virtual:{robot}"), seed.to_string());
        let what = ["record", "--rig", &rig, "--strokes", &strokes, "--tip-force", &force, "--seed", &seed];
        chain.once(&out, &[&what[..], &["--out", &out]].concat())?;
        Ok(out)
    };
    for kind in ["strokes", "force", "recorded", "told"] {
        std::fs::create_dir_all(chain.path(kind)?)?;
    }
    let learned = (1..=4).map(|k| record(&format!("learned-{k}"), k, false)).collect::<Result<Vec<_>>>()?;
    let (known, pushed) = (record("known", 7, true)?, record("pushed", 8, true)?);
    // The one recording whose tensions are used before the end.
    let balance = record("balance", 9, false)?;
    chain.once(&servos, &["identify-servo", &balance, "--out", &servos])?;
    let without = |name: &str, first: u64| {
        (0..n_free).map(|k| record(&format!("{name}-{k}"), first + k, false)).collect::<Result<Vec<_>>>()
    };
    let (free, other) = (without("free", 100)?, without("other", 200)?);
    let identified = chain.path("identified")?;
    let names: Vec<&str> = learned.iter().map(String::as_str).collect();
    chain.hysteron(&[&["identify", &twin][..], &names, &["--out", &identified]].concat())?;
    chain.once(&residual, &["fit-residual", &identified, "--epochs", epochs, "--out", &residual])?;
    let with = ["--residual", &residual];
    let names: Vec<&str> = free.iter().map(String::as_str).collect();
    let with_servos = ["--servos", &servos, "--out", &sensor];
    let fit = [&["fit-sensor", &twin][..], &names, &[&known], &with, &with_servos].concat();
    chain.once(&sensor, &fit)?;
    let tell = |recording: &str, name: &str| -> Result<Value> {
        let (told, figures) =
            (chain.path(&format!("told/{name}.parquet"))?, chain.path(&format!("told/{name}"))?);
        let out = ["--sensor", &sensor, "--out", &told, "--figures", &figures];
        chain.hysteron(&[&["sense", &twin, recording][..], &with, &out].concat())?;
        let text = file::read_text(&Path::new(&figures).join("metrics.json"))?;
        json::from_text(&text).context("the metrics of a sensed recording")
    };
    let metrics = tell(&pushed, "pushed")?;
    let contacts = |(k, recording): (usize, &String)| -> Result<[f64; 2]> {
        let scores = tell(recording, &format!("other-{k}"))?["scores"]["contacts"].clone();
        let [rate, free] = ["false_alarms_per_hour", "free_s"].map(|key| scores[key].as_f64());
        let (rate, free) = rate.zip(free).context("contacts of a recording without any")?;
        Ok([(rate * free / 3600.0).round(), free])
    };
    let told = other.par_iter().enumerate().map(contacts).collect::<Result<Vec<_>>>()?;
    let [alarms, free_s] = [0, 1].map(|c| told.iter().map(|of_one| of_one[c]).sum::<f64>());
    Ok(json!({
        "robot": robot, "scores": metrics["scores"], "sensor": metrics["sensor"],
        "without_contact": { "alarms": alarms, "seconds": free_s },
    }))
}

/// A smooth way from 0 to 1 that starts and ends at rest (minimum jerk).
fn smooth(part: f64) -> f64 {
    part.powi(3) * (10.0 - 15.0 * part + 6.0 * part * part)
}

/// Moves between places within reach, with holds, from rest to rest [mm]; gives the number of samples.
fn write_strokes(path: &str, seed: u64, seconds: f64) -> Result<usize> {
    let mut draw = rng(seed, "sensing/strokes");
    let mut between = |[low, high]: [f64; 2]| draw.random_range(low..high);
    let (mut places, mut now) = (vec![[0.0; 2]; 60], [0.0f64; 2]);
    let mut go = |places: &mut Vec<[f64; 2]>, to: [f64; 2], speed: f64, hold: f64| {
        // The fastest moment of the way is 1.9 times its mean.
        let way = (to[0] - now[0]).hypot(to[1] - now[1]);
        let n = ((way * 1.9 / speed * RATE) as usize).max(20);
        places.extend((1..=n).map(|i| {
            let part = smooth(i as f64 / n as f64);
            [0, 1].map(|c| now[c] + part * (to[c] - now[c]))
        }));
        now = to;
        places.extend(std::iter::repeat_n(now, (hold * RATE) as usize));
    };
    while (places.len() as f64) < (seconds - 4.0) * RATE {
        let (radius, angle) = (REACH * between([0.0, 1.0]).sqrt(), between([0.0, TAU]));
        go(&mut places, [radius * angle.cos(), radius * angle.sin()], between(SPEEDS), between(HOLDS));
    }
    go(&mut places, [0.0; 2], SPEEDS[1], 0.6);
    let mut text = "time_s,stroke_1_mm,stroke_2_mm,stroke_3_mm,stroke_4_mm\n".to_owned();
    for (i, [a, b]) in places.iter().enumerate() {
        writeln!(text, "{},{a},{b},{},{}", i as f64 / RATE, -a, -b)?;
    }
    file::write_bytes(Path::new(path), text)?;
    Ok(places.len())
}

/// Pushes across the axis in any direction, growing within 50 ms; none where nobody pushes.
fn write_pushes(path: &str, seed: u64, n: usize, pushed: bool) -> Result<()> {
    let mut draw = rng(seed, "sensing/pushes");
    let mut between = |[low, high]: [f64; 2]| draw.random_range(low..high);
    let mut forces = vec![[0.0; 2]; n];
    let mut begin = (3.0 * RATE) as usize;
    while pushed && begin + (4.0 * RATE) as usize <= n {
        let (size, angle) = (between(FORCES.map(f64::ln)).exp(), between([0.0, TAU]));
        let lasts = (between(LASTS) * RATE) as usize;
        for (i, force) in forces[begin..begin + lasts].iter_mut().enumerate() {
            let part = ((i + 1) as f64 / (0.05 * RATE)).min(1.0);
            *force = [part * size * angle.cos(), part * size * angle.sin()];
        }
        begin += lasts + (between(PAUSES) * RATE) as usize;
    }
    let mut text = "time_s,tip_force_x_n,tip_force_y_n,tip_force_z_n\n".to_owned();
    for (i, [x, y]) in forces.iter().enumerate() {
        writeln!(text, "{},{x},{y},0", i as f64 / RATE)?;
    }
    Ok(file::write_bytes(Path::new(path), text)?)
}

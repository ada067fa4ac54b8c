//! The run of `study sensing`.

use std::path::Path;

use anyhow::{Context as _, Result};
use hysteron_twin::sense::ContactScore;
use hysteron_workflow::tendon::sense;
use hysteron_workflow::{Context, WorkflowError};
use rayon::prelude::*;

use super::outcome::{SensedRobot, SensingMetrics, WithoutContact};
use super::recordings::{write_pushes, write_strokes};
use crate::tendon::commands::{ChainCommands, FRICTION, read_outcome};
use crate::tendon::{Options, Outcome, session};

const ROBOTS: [&str; 2] = ["typical", "harsh"];
/// Trajectories of the plan `quick` that are for training.
const TRAINING: [&str; 4] = ["sinusoid", "diagonal", "circle", "square"];

/// Runs the study; quick: one robot, short recordings.
///
/// # Errors
/// A command fails, or an interruption.
pub fn run(options: &Options, context: &Context) -> Result<Outcome<SensingMetrics>, WorkflowError> {
    let effort = if options.quick {
        Effort { seconds: 60.0, epochs: "2", n_free: 2 }
    } else {
        Effort { seconds: 240.0, epochs: "300", n_free: 15 }
    };
    let robots = if options.quick { &ROBOTS[..1] } else { &ROBOTS[..] };
    session::run("sensing", &options.out, context, || {
        let one = |robot: &&str| {
            let chain = ChainCommands::new(&options.out.join(robot), &options.repository, context)?;
            evaluate_sensor(&chain, robot, &effort)
        };
        Ok(SensingMetrics { robots: robots.iter().map(one).collect::<Result<_>>()? })
    })
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
fn evaluate_sensor(chain: &ChainCommands<'_>, robot: &str, effort: &Effort) -> Result<SensedRobot> {
    let Effort { seconds, epochs, n_free } = *effort;
    chain.record(robot, "quick", "quick")?;
    let [twin, residual, servos, sensor] =
        ["twin/scene.toml", "residual.safetensors", "servos.json", "sensor.json"]
            .map(|name| chain.path(name));
    let (twin, residual, servos, sensor) = (twin?, residual?, servos?, sensor?);
    let scene = chain.scene_path(FRICTION.1);
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
    chain.command(&[&["identify", &twin][..], &names, &["--out", &identified]].concat())?;
    chain.once(&residual, &["fit-residual", &identified, "--epochs", epochs, "--out", &residual])?;
    let with = ["--residual", &residual];
    let names: Vec<&str> = free.iter().map(String::as_str).collect();
    let with_servos = ["--servos", &servos, "--out", &sensor];
    let fit = [&["fit-sensor", &twin][..], &names, &[&known], &with, &with_servos].concat();
    chain.once(&sensor, &fit)?;
    let sense = |recording: &str, name: &str| -> Result<sense::Outcome> {
        let (estimates, figures) =
            (chain.path(&format!("told/{name}.parquet"))?, chain.path(&format!("told/{name}"))?);
        let out = ["--sensor", &sensor, "--out", &estimates, "--figures", &figures];
        chain.command(&[&["sense", &twin, recording][..], &with, &out].concat())?;
        read_outcome(&Path::new(&figures).join("metrics.json"))
    };
    let metrics = sense(&pushed, "pushed")?;
    let contacts = |(k, recording): (usize, &String)| -> Result<[f64; 2]> {
        let found = sense(recording, &format!("other-{k}"))?.scores.contacts;
        let ContactScore { false_alarms_per_hour, free_s, .. } =
            found.context("contacts of a recording without any")?;
        Ok([(false_alarms_per_hour * free_s / 3600.0).round(), free_s])
    };
    let alarms = other.par_iter().enumerate().map(contacts).collect::<Result<Vec<_>>>()?;
    let [alarms, seconds] = [0, 1].map(|c| alarms.iter().map(|of_one| of_one[c]).sum::<f64>());
    Ok(SensedRobot {
        robot: robot.to_owned(),
        scores: metrics.scores,
        sensor: metrics.sensor,
        without_contact: WithoutContact { alarms, seconds },
    })
}

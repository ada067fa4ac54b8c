//! The drive of an XL330-M288 identified by rollout of a pendulum, compared with the published models m1 to
//! m6 in the same rollouts.
//!
//!     HYSTERON_DATA=../shared/data cargo run --release -p hysteron-actuator --example xl330_pendulum [-- metrics.json]
//!
//! Data and published parameters: Rhoban/bam (Apache-2.0). Errors are means over logs of the mean absolute error of position,
//! open loop over 6 s. No number of a test log is used for a choice: each split is fitted on its own training logs alone.
#![allow(clippy::print_stdout)] // this program prints tables

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use hysteron_actuator::identify::{
    DriveFit, DriveFitOptions, Pendulum, PendulumRun, identify_drive, mean_error,
};
use hysteron_actuator::law::{JointFriction, Law};
use hysteron_actuator::{Drive, Gear, LoopSpec, Motor, Supply, Winding};
use hysteron_base::json;
use hysteron_fuzz::data_folder;
use serde_json::Value;

/// K_P of an XL330 makes one PWM unit per tick from 256 on: measured, load over error of position.
const LOOP: LoopSpec = LoopSpec { gains: [256.0, 65536.0, 16.0], ..LoopSpec::XL430 };
const STEP: f64 = 1e-3;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = data_folder().join("arms/bam");
    if !folder.join("xl330").is_dir() {
        println!("skipped: no recordings in {}", folder.display());
        return Ok(());
    }
    let logs = read_logs(&folder.join("xl330"))?;
    let of = |keep: &dyn Fn(&Log) -> bool| -> Vec<PendulumRun> {
        logs.iter().filter(|log| keep(log)).map(|log| log.run.clone()).collect()
    };
    let low = |log: &Log| log.run.gain == 100.0 || log.run.gain == 400.0;
    let sines = |log: &Log| log.trajectory == "sin_sin";
    let all = of(&|_| true);
    let splits = [
        ("in sample", all.clone(), all.clone()),
        ("gains 100, 400 -> 200, 800", of(&low), of(&|log| !low(log))),
        ("gains 200, 800 -> 100, 400", of(&|log| !low(log)), of(&low)),
        ("sin_sin -> up_and_down", of(&sines), of(&|log| !sines(log))),
    ];
    let mut rows = Vec::new();
    for (name, training, test) in &splits {
        let begun = Instant::now();
        let found = fit(training)?;
        let seconds = begun.elapsed().as_secs_f64();
        let error = |runs| mean_error(&found.drive, found.offset, runs, STEP);
        println!(
            "\n{name}: {:.4} rad on its test logs, {:.4} on those of the fit, {seconds:.1} s",
            error(test),
            error(training)
        );
        let published = (1..=6)
            .map(|m| {
                let (drive, offset) = published(&folder.join(format!("params/xl330/m{m}.json")))?;
                Ok(mean_error(&drive, offset, test, STEP))
            })
            .collect::<Result<Vec<f64>, Box<dyn Error>>>()?;
        println!("  published m1-m6 on the test logs: {published:.4?}");
        for estimate in &found.fit.estimates {
            let width = estimate.standard_error.unwrap_or(f64::NAN);
            println!(
                "  {:34} {:10.5} ± {width:9.2e}  {:?}",
                estimate.name, estimate.value, estimate.identifiability
            );
        }
        rows.push(json!({
            "split": name, "test_rad": error(test), "training_rad": error(training), "seconds": seconds,
            "published_m1_to_m6_rad": published, "condition": found.fit.condition,
            "parameters": found.fit.estimates.iter().map(|e| json!([e.name, e.value, e.standard_error])).collect::<Vec<_>>(),
        }));
    }
    let held_out = rows[1..].iter().filter_map(|row| row["test_rad"].as_f64()).sum::<f64>() / 3.0;
    println!("\nmean of the three held-out splits: {held_out:.4} rad");
    if let Some(path) = std::env::args().nth(1) {
        let metrics = json!({"format": "hysteron-metrics", "version": 1, "study": "xl330_pendulum",
            "metrics": {"splits": rows, "held_out_mean_rad": held_out}});
        hysteron_base::file::write_bytes(Path::new(&path), json::to_text(&metrics)?)?;
    }
    Ok(())
}

/// Where a fit begins: the data sheet of the XL330-M288-T (stall 0.52 N m and 1.47 A, 103 rev/min at 5 V), copper's and a
/// ferrite magnet's temperature coefficients, a winding of some grams of copper, and the registers' current limit.
fn datasheet(law: Law) -> Drive {
    let friction = vec![0.0; law.parameters().len()];
    Drive {
        motor: Motor { current_limit: 1.75, ..Motor::new(0.52 / 1.47, 5.0 / 1.47, 5.0) },
        supply: Supply { voltage: 7.3, resistance: 0.1 },
        winding: Winding {
            heat_capacity: 1.0,
            to_case: 20.0,
            case_heat_capacity: 20.0,
            to_air: 20.0,
            resistance_slope: 0.00393,
            magnet_slope: 0.002,
            reference: 30.0,
            air: 25.0,
        },
        gear: Gear { armature: 0.0018, backlash: 0.0, law, friction },
        position_loop: LOOP,
    }
}

fn fit(runs: &[PendulumRun]) -> Result<DriveFit, Box<dyn Error>> {
    let law = std::env::var("LAW").unwrap_or_else(|_| "m4".into());
    let options = DriveFitOptions {
        quantities: &[
            "torque_constant_n_m_per_a",
            "resistance_ohm",
            "current_limit_a",
            "supply_resistance_ohm",
            "winding_heat_capacity_j_per_k",
            "magnet_slope_per_k",
            "armature_kg_m2",
        ],
        longest_step: STEP,
        huber: 0.03,
        starts: &[0.05, 0.15, 0.3],
        watch: &|_, _| true,
    };
    Ok(identify_drive(&datasheet(Law::named(&law)?), runs, &options)?)
}

struct Log {
    trajectory: String,
    run: PendulumRun,
}

fn read_logs(folder: &Path) -> Result<Vec<Log>, Box<dyn Error>> {
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<Result<_, std::io::Error>>()?;
    paths.sort();
    paths.iter().map(|path| read_log(path)).collect()
}

fn number(value: &Value) -> Result<f64, Box<dyn Error>> {
    value.as_f64().ok_or_else(|| format!("expected a number, got {value}").into())
}

fn read_log(path: &Path) -> Result<Log, Box<dyn Error>> {
    let log: Value = json::from_text(&std::fs::read(path)?)?;
    let entries = log["entries"].as_array().ok_or("no entries")?;
    let column = |key: &str| entries.iter().map(|entry| number(&entry[key])).collect::<Result<Vec<f64>, _>>();
    let run = PendulumRun {
        name: path.display().to_string(),
        time: column("timestamp")?,
        goal: column("goal_position")?,
        position: column("position")?,
        torque_on: entries.iter().map(|entry| entry["torque_enable"] == true).collect(),
        temperature: number(&entries[0]["temp"])?,
        gain: number(&log["kp"])?,
        pendulum: Pendulum { mass: number(&log["mass"])?, length: number(&log["length"])?, offset: 0.0 },
    };
    Ok(Log { trajectory: log["trajectory"].as_str().unwrap_or_default().into(), run: run.checked()? })
}

/// A published model: no current limit, no heat, the nominal 7.4 V.
fn published(path: &Path) -> Result<(Drive, f64), Box<dyn Error>> {
    let p: Value = json::from_text(&std::fs::read(path)?)?;
    let law = Law::named(p["model"].as_str().unwrap_or_default())?;
    let friction = law.parameters().iter().map(|q| number(&p[q.name.as_ref()])).collect::<Result<_, _>>()?;
    let drive = Drive {
        motor: Motor::new(number(&p["kt"])?, number(&p["R"])?, 7.4),
        supply: Supply { voltage: 7.4, resistance: 0.0 },
        winding: Winding::COLD,
        gear: Gear { armature: number(&p["armature"])?, backlash: 0.0, law, friction },
        position_loop: LOOP,
    };
    // Without heat the stated values hold at any temperature.
    let drive = Drive { winding: Winding { resistance_slope: 0.0, ..drive.winding }, ..drive };
    Ok((drive, number(&p["q_offset"])?))
}

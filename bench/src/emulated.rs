//! The whole chain in real time: `hysteron record` on the emulated rig, two processes and two ports between them.
//!
//! The emulator answers at the times of the wire, without return delay. Host and emulator share the machine, so what
//! is measured is no better than with servos of metal. The calibration, two minutes in real time, is made in process.
#![allow(clippy::print_stdout)] // this program prints tables

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use hysteron_base::{Recording, file, json};
use hysteron_rig::calibration::{RigCalibration, calibrate};
use hysteron_rig::config::RigConfig;
use hysteron_rig::{Hardware, LiveRig};
use hysteron_virtual_rig::virtual_rig::{SimulatedRig, VirtualRobot};
use serde_json::Value;

use crate::measure::machine;
use crate::table::{FigureTarget, TableRow, print_rows};

const PRESET: &str = "typical";
const SEED: u64 = 1;
/// How long the emulator may take to its first word.
const PATIENCE: Duration = Duration::from_secs(10);

/// Measures a minute, or a few seconds, and writes `folder/metrics.json`.
///
/// # Errors
/// The program cannot be built, or it fails.
pub fn run(folder: &Path, quick: bool) -> Result<()> {
    let measured = measure(folder, if quick { 5.0 } else { 60.0 })?;
    print_rows(&measured.rows());
    let metrics = json!({
        "format": "hysteron-metrics",
        "version": 1,
        "study": "rig",
        "machine": machine(),
        "metrics": { "targets": measured.rows(), "run": measured.stats },
    });
    Ok(file::write_bytes(&folder.join("metrics.json"), json::to_text(&metrics)?)?)
}

/// Figures of a recording of this many seconds.
///
/// # Errors
/// As [`run`].
pub fn rows(seconds: f64) -> Result<Vec<TableRow>> {
    let folder = tempfile::tempdir()?;
    Ok(measure(folder.path(), seconds)?.rows())
}

/// Statistics in a recording's metadata.
struct Measured {
    n_rows: usize,
    n_filled: usize,
    stats: Value,
}

impl Measured {
    fn stat(&self, name: &str) -> Option<f64> {
        self.stats.get(name)?.as_f64()
    }

    fn rows(&self) -> Vec<TableRow> {
        let percent = |part: Option<f64>| part.map(|part| 100.0 * part);
        let filled = 100.0 * self.n_filled as f64 / self.n_rows as f64;
        let lost = self.stats.pointer("/bus/lost").and_then(Value::as_f64);
        let wire = self.stat("wire_ms");
        let bus = |name: &str, row: &str| {
            let row = TableRow::new(format!("rig: {row}"), self.stat(name), "ms");
            wire.map_or(row.clone(), |wire| row.against(wire, "time of its bytes on the wire at 1 Mbaud"))
        };
        let over_wire = self.stat("bus_median_ms").zip(wire).map(|(bus, wire)| bus / wire);
        vec![
            TableRow::new("rig: cycles within 1 ms of schedule", percent(self.stat("within_1ms")), "%")
                .goal(FigureTarget::AtLeast(99.0)),
            TableRow::new("rig: host's load of a core", self.stat("processor_percent"), "%")
                .goal(FigureTarget::AtMost(10.0)),
            bus("bus_median_ms", "transfers of a cycle, median"),
            TableRow::new("rig: the same over its time on the wire", over_wire, "-")
                .goal(FigureTarget::AtMost(1.3)),
            bus("bus_p99_ms", "transfers of a cycle, 99 %"),
            TableRow::new("rig: reads of a servo lost", lost, "-").goal(FigureTarget::AtMost(0.0)),
            // The tracker of the virtual rig drops one pose in a thousand; a missed cycle would count here, too.
            TableRow::new("rig: rows filled in", filled, "%"),
            TableRow::new("rig: start of cycles late, 99 %", self.stat("late_p99_ms"), "ms"),
            TableRow::new("rig: start of cycles late, worst", self.stat("late_max_ms"), "ms"),
        ]
    }
}

/// Emulates, calibrates, records and reads what was recorded.
fn measure(folder: &Path, seconds: f64) -> Result<Measured> {
    let program = program()?;
    // The port's name is a link with a full path; a recording is never overwritten.
    std::fs::create_dir_all(folder)?;
    let folder = folder.canonicalize()?;
    let (emulated, out) = (folder.join("emulated"), folder.join("run.parquet"));
    for old in ["run.parquet", "run.journal", "run.events.jsonl"] {
        let _ = std::fs::remove_file(folder.join(old));
    }
    let plan = folder.join("plan.toml");
    file::write_bytes(&plan, plan_text(seconds))?;

    let _emulator = Emulator::start(&program, &emulated)?;
    let rig = emulated.join("rig.toml");
    file::write_bytes(&emulated.join("calibration.toml"), calibration(&rig)?.to_toml())?;
    println!("recording {seconds:.0} s at 100 Hz from {}", emulated.join("servos").display());
    let mut record = Command::new(&program);
    record.arg("record").arg("--rig").arg(&rig).arg("--plan").arg(&plan).arg("--out").arg(&out);
    call(record.arg("--figures").arg(folder.join("figures")))?;

    let recording = Recording::read(&out)?;
    let text = recording.meta().extra.get("run.stats").context("a recording without run.stats")?;
    Ok(Measured {
        n_rows: recording.n_samples(),
        n_filled: recording.gap().iter().filter(|gap| **gap).count(),
        stats: json::from_text(text)?,
    })
}

/// The calibration of the emulated rig: that of the same robot in this process, with each zero as far from where its
/// servo is.
fn calibration(rig: &Path) -> Result<RigCalibration> {
    let rig = RigConfig::read(rig)?;
    let robot = VirtualRobot::preset(PRESET)?;
    let mut simulated = SimulatedRig::new(&robot, &rig, SEED);
    let there = simulated.prepare()?;
    let mut calibration = calibrate(&mut simulated, &rig, "in process".into(), &|| false, &mut |_| {})?;
    let here = LiveRig::open(&rig)?.bus().self_check(&rig.servo_bounds())?;
    for ((channel, there), here) in calibration.channels.iter_mut().zip(&there).zip(&here) {
        channel.zero += here.position - there.position;
    }
    Ok(calibration)
}

/// A circle of so many seconds in all.
fn plan_text(seconds: f64) -> String {
    format!(
        "format = \"hysteron-plan\"\nversion = 1\nname = \"bench\"\nseed = 1\nrate_hz = 100\n\
         tendon_angles_deg = [0, 90, 180, 270]\nrelease = 1.0\nrest_before_s = 0\nrest_after_s = 0\n\
         stroke_max_mm = 8\nstroke_rate_max_mm_s = 8\n\
         [[trajectory]]\nname = \"circle\"\nrole = \"training\"\nfamily = \"circle\"\namplitude_mm = 4.5\n\
         frequency_hz = 0.2\nattack_s = 2\nsustain_s = {}\ndecay_s = 2\n",
        (seconds - 4.0).max(0.0)
    )
}

/// The program, built like this one and next to it.
fn program() -> Result<PathBuf> {
    let own = std::env::current_exe()?;
    // Of a test or benchmark: one folder further up.
    let folder = own.ancestors().skip(1).find(|folder| !folder.ends_with("deps")).context("no folder")?;
    let mut build = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    build.args(["build", "--quiet", "--package", "hysteron", "--bin", "hysteron"]);
    if folder.ends_with("release") {
        build.arg("--release");
    }
    build.arg("--target-dir").arg(folder.parent().context("no folder")?);
    call(build.current_dir(env!("CARGO_MANIFEST_DIR")))?;
    Ok(folder.join(format!("hysteron{}", std::env::consts::EXE_SUFFIX)))
}

/// Runs a command in silence; its words are in the error if it fails.
fn call(command: &mut Command) -> Result<()> {
    let output = command.stdin(Stdio::null()).output().with_context(|| format!("{command:?}"))?;
    let words = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "{command:?}: {}\n{words}", output.status);
    Ok(())
}

/// `hysteron rig emulate`, ended when this is dropped.
struct Emulator(Child);

impl Emulator {
    fn start(program: &Path, folder: &Path) -> Result<Self> {
        // Of an earlier run.
        let _ = std::fs::remove_dir_all(folder);
        let tracker = std::net::TcpListener::bind("127.0.0.1:0")?.local_addr()?.port();
        let mut command = Command::new(program);
        command.args([
            "rig",
            "emulate",
            "--return-delay-us",
            "0",
            "--preset",
            PRESET,
            "--seed",
            &SEED.to_string(),
        ]);
        command.args(["--port-tracker", &tracker.to_string(), "--dir"]).arg(folder);
        let child = command.stdin(Stdio::null()).stdout(Stdio::null()).spawn()?;
        let mut emulator = Self(child);
        let start = Instant::now();
        // Written last.
        while !folder.join("rig.toml").exists() {
            let ended = emulator.0.try_wait()?;
            ensure!(ended.is_none() && start.elapsed() < PATIENCE, "the emulator does not come: {ended:?}");
            std::thread::sleep(Duration::from_millis(20));
        }
        Ok(emulator)
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

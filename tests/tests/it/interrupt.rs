//! Ctrl-C and SIGTERM: every verb that works for long ends within two seconds, reports it, and leaves nothing
//! half written.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use hysteron_tests::{Workplace, emulated, names_in, program, root};

/// From the request to the end.
const LIMIT: Duration = Duration::from_secs(2);
/// A verb is asked to stop when it has computed for so long [clock ticks of 10 ms, all threads].
const BEGUN: u64 = 100;
/// Most that a busy machine may take until then.
const PATIENCE: Duration = Duration::from_secs(120);

/// Processor time of a process so far [10 ms].
fn processor_time(process: &Child) -> u64 {
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", process.id())).unwrap_or_default();
    // Behind the name of the program, which is in brackets, from the third field on.
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    [11, 12].map(|k| fields.get(k).and_then(|field| field.parse::<u64>().ok()).unwrap_or(0)).iter().sum()
}

/// Result of `work`, and the largest lateness with which a thread that sleeps for 20 ms woke meanwhile: a
/// measure of how busy the machine is.
fn with_lateness<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let is_over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let sleeper = scope.spawn(|| {
            let (nap, mut latest) = (Duration::from_millis(20), Duration::ZERO);
            while !is_over.load(Ordering::Relaxed) {
                let start = Instant::now();
                std::thread::sleep(nap);
                latest = latest.max(start.elapsed().saturating_sub(nap));
            }
            latest
        });
        let found = work();
        is_over.store(true, Ordering::Relaxed);
        (found, sleeper.join().unwrap())
    })
}

/// Files of a killed program in a folder and those in it.
fn half_written(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for name in names_in(folder) {
        if folder.join(&name).is_dir() {
            found.extend(half_written(&folder.join(&name)));
        } else if name.starts_with('.') && (name.ends_with(".tmp") || name.ends_with(".lock")) {
            found.push(name);
        }
    }
    found
}

/// Starts a verb, asks it to stop once it runs, and returns the time until its end.
#[track_caller]
fn stopped(place: &Path, line: &str, signal: &str) -> Duration {
    let mut command = Command::new(program());
    command.args(line.split_whitespace()).current_dir(place).env_remove("RUST_LOG").stdin(Stdio::null());
    let mut process = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let start = Instant::now();
    while processor_time(&process) < BEGUN {
        assert!(process.try_wait().unwrap().is_none(), "{line}: it has ended before it was asked");
        assert!(start.elapsed() < PATIENCE, "{line}: it does not begin");
        std::thread::sleep(Duration::from_millis(5));
    }
    let ((took, output), late) = with_lateness(|| {
        emulated::signal(&process, signal);
        let asked = Instant::now();
        while process.try_wait().unwrap().is_none() && asked.elapsed() < PATIENCE {
            std::thread::sleep(Duration::from_millis(5));
        }
        let took = asked.elapsed();
        let _ = process.kill();
        (took, process.wait_with_output().unwrap())
    });
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{line}: {errors}");
    let errors: Vec<&str> = errors.lines().filter(|line| line.starts_with("error: ")).collect();
    assert!(errors.len() == 1 && errors[0].contains("interrupted"), "{line}: {errors:?}");
    assert_eq!(half_written(place), [""; 0], "{line}");
    // The program sleeps too before it looks, and is woken as late.
    assert!(took < LIMIT + 2 * late, "{line}: {took:?} after the signal, on a machine {late:?} late");
    took
}

/// The times, one a line, go to this file where it is named.
fn archive(lines: &[String]) {
    if let Some(path) = std::env::var_os("HYSTERON_INTERRUPTED") {
        let mut all = std::fs::read_to_string(&path).unwrap_or_default();
        all.extend(lines.iter().map(|line| format!("{line}\n")));
        std::fs::write(path, all).unwrap();
    }
}

/// All lines, each with either signal by turns.
#[track_caller]
fn all_stopped(place: &Path, lines: &[&str]) {
    let one = |(k, line): (usize, &&str)| {
        let signal = ["INT", "TERM"][k % 2];
        let took = stopped(place, line, signal);
        format!("{:.2},{signal},\"{line}\"", took.as_secs_f64())
    };
    archive(&lines.iter().enumerate().map(one).collect::<Vec<_>>());
}

#[test]
fn verbs_of_tendon_robots_end_when_asked() {
    let place = Workplace::new();
    place.write_circle("long.csv", 60_000);
    let slow: String = (0..60_000)
        .map(|i| f64::from(i) / 100.0)
        .map(|t| (t, (0.1 * t).min(0.1 * (599.99 - t)).min(1.0) * (0.5 * t).sin()))
        .map(|(t, stroke)| format!("{t:.2},{stroke:.4},0,{:.4},0\n", -stroke))
        .collect();
    place.write("slow.csv", format!("time_s,stroke_1_mm,stroke_2_mm,stroke_3_mm,stroke_4_mm\n{slow}"));
    place.write_circle("short.csv", 300);
    place.simulate("short.csv", "rec.csv").succeeded();
    let goals: String = (0..60_000)
        .map(|i| f64::from(i) / 100.0)
        .map(|t| format!("{t:.2},{:.4},{:.4},78\n", 5.0 * t.cos(), 5.0 * t.sin()))
        .collect();
    place.write("goals.csv", format!("time_s,tip_x_mm,tip_y_mm,tip_z_mm\n{goals}"));
    let record =
        ["record", "--rig", "virtual:typical", "--plan", "quick", "--only", "circle", "--out", "data"];
    place.run(&record).succeeded();
    let shards = ["shards", "plan", "scene.toml", "--plan", "roses", "--to", "set", "--measure", "0"];
    place.run(&shards).succeeded();
    all_stopped(
        place.path(),
        &[
            "simulate scene.toml --strokes long.csv --out a.csv",
            "reach scene.toml --goals goals.csv --out b.csv",
            "record --rig virtual:typical --strokes slow.csv --out c.csv",
            "fit-material scene.toml data --every-mm 0.1 --out d.toml",
            "identify scene-coreact.toml data --out e",
            "generate scene.toml --plan roses --out f",
            "shards work set",
            "command --scene scene.toml --target goals.csv --out h.csv",
            "track --rig virtual:typical --scene scene.toml --nominal --target circle:20 --out i --repeats 20",
        ],
    );
}

#[test]
fn learning_of_tendon_robots_ends_when_asked() {
    let place = Workplace::new();
    let record = ["record", "--rig", "virtual:typical", "--plan", "quick", "--out", "data"];
    place.run(&record).succeeded();
    place
        .run(&["identify", "scene-coreact.toml", "data", "--rounds", "1", "--out", "identified"])
        .succeeded();
    let fit = ["fit-residual", "identified", "--out", "r.safetensors", "--epochs", "1", "--members", "1"];
    place.run(&fit).succeeded();
    all_stopped(
        place.path(),
        &[
            "train data --hidden 256 --epochs 1000 --out d.safetensors",
            "fit-residual identified --out a.safetensors --epochs 1000",
            "adapt r.safetensors data --scene scene-coreact.toml --out b.safetensors",
            "fit-sensor scene.toml data --out c.json",
        ],
    );
}

#[test]
fn verbs_of_arms_end_when_asked() {
    let place = tempfile::tempdir().unwrap();
    let run = |line: &str| {
        hysteron_tests::run(place.path(), &line.split_whitespace().collect::<Vec<_>>()).succeeded();
    };
    let torques = root().join("arm/dynamics/tests/data/torques.csv");
    std::fs::copy(torques, place.path().join("torques.csv")).unwrap();
    run("arm simulate three-link --torques torques.csv --start 0.3,-0.4,0.5 --out motion.csv");
    run("arm generate --subsets force_unlabeled --splits train,validation --trajectories 2 --out nad");
    all_stopped(
        place.path(),
        &[
            "arm fit delan motion.csv --epochs 100000 --out a.safetensors",
            "arm fit neural nad --out b.safetensors",
            "arm excite panda --out c.csv --generations 100000",
            "arm generate --out d",
            "study simulated --out e",
            "study scara --out f",
            "study wrist --out g",
            "arm study force --out h",
            "study neural --out i",
        ],
    );
}

//! A recording is interrupted, killed, robbed of its disk, its bus, its tracker: the torque is off, the
//! measured rows can be read, and the same command resumes.

#![cfg(unix)]

use std::collections::VecDeque;
use std::process::{Child, Command, Output};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use hysteron_base::{JournalWriter, Recording, rng};
use hysteron_tests::emulated::{EmulatedRig, signal};
use hysteron_tests::{Outcome, program, run};

/// From the death of a run to the last servo's release: the watchdog process commands all at once, and one that misses it
/// up to three times in each of three transfers of 100 ms; four may [s].
const RELEASE: f64 = 4.0 * 3.0 * 3.0 * 0.1;
/// Processes of a busy machine wait for their turn that long [s].
const SLACK: f64 = 2.0;

/// Waits for a run to end.
fn ended(process: Child) -> Outcome {
    let Output { status, stdout, stderr } = process.wait_with_output().unwrap();
    let text = |bytes| String::from_utf8_lossy(bytes).into_owned();
    Outcome { code: status.code(), stdout: text(&stdout), stderr: text(&stderr) }
}

/// Starts to record to `out.parquet` and waits until rows are in the journal.
fn recording(rig: &EmulatedRig) -> Child {
    let process = rig.record("out.parquet").spawn().unwrap();
    let start = Instant::now();
    // The head has some kilobytes, a row 200 bytes.
    while !std::fs::metadata(rig.file("out.journal")).is_ok_and(|file| file.len() > 10_000) {
        assert!(start.elapsed() < Duration::from_secs(20), "no rows: {}", ended(process).stderr);
        std::thread::sleep(Duration::from_millis(5));
    }
    process
}

/// Asserts that the measured rows are a recording of this name, with its log, and that there is no journal
/// any more.
fn is_kept(rig: &EmulatedRig, name: &str) {
    assert!(Recording::read(rig.file(&format!("{name}.parquet"))).unwrap().n_samples() > 10);
    assert!(!rig.file("out.journal").exists());
    assert!(rig.file(&format!("{name}.events.jsonl")).exists());
    assert_eq!(rig.file("out.parquet").exists(), name == WHOLE);
}

/// A run that came to its end.
const WHOLE: &str = "out";
/// One that did not: the same command can go on.
const PARTIAL: &str = "out.partial-1";

#[test]
fn a_run_to_the_end_lets_go() {
    let rig = EmulatedRig::start("", 0.6);
    let outcome = ended(rig.record("out.parquet").spawn().unwrap()).succeeded();
    rig.wait_for_torque(false);
    assert!(outcome.stdout.contains("circle"), "{}", outcome.stdout);
    is_kept(&rig, WHOLE);
}

#[test]
fn a_run_that_is_asked_to_stop_goes_to_rest_lets_go_and_keeps_its_rows() {
    for name in ["INT", "TERM"] {
        let rig = EmulatedRig::start("", 20.0);
        let process = recording(&rig);
        signal(&process, name);
        let outcome = ended(process);
        assert!(outcome.error(1).contains("interrupted"), "{}", outcome.stderr);
        assert!(!rig.torques().last().unwrap().1, "{name}");
        is_kept(&rig, PARTIAL);
    }
}

#[test]
fn a_run_that_is_asked_twice_ends_at_once_and_its_watchman_lets_go() {
    let rig = EmulatedRig::start("", 20.0);
    let process = recording(&rig);
    signal(&process, "INT");
    std::thread::sleep(Duration::from_millis(100));
    signal(&process, "INT");
    assert_eq!(ended(process).code, Some(1));
    assert!(rig.wait_for_torque(false).as_secs_f64() < RELEASE + SLACK);
    run(rig.path(), &["rig", "recover", "out.journal", "--out", "recovered.parquet"]).succeeded();
    assert!(Recording::read(rig.file("recovered.parquet")).unwrap().n_samples() > 10);
}

/// A rig whose file has `hold`.
fn holding() -> EmulatedRig {
    let rig = EmulatedRig::start("", 20.0);
    rig.replace("at_end = \"release\"", "at_end = \"hold\"");
    rig
}

#[test]
fn a_rig_that_shall_hold_lets_go_after_ctrl_c_and_kill() {
    let rig = holding();
    let process = recording(&rig);
    signal(&process, "INT");
    assert!(ended(process).error(1).contains("interrupted"));
    assert!(!rig.torques().last().unwrap().1);
    is_kept(&rig, PARTIAL);
    let rig = holding();
    let process = recording(&rig);
    signal(&process, "KILL");
    ended(process);
    assert!(rig.wait_for_torque(false).as_secs_f64() < RELEASE + SLACK);
}

#[test]
fn a_calibration_that_is_stopped_or_killed_lets_go_although_the_rig_shall_hold() {
    for name in ["INT", "TERM", "KILL"] {
        let rig = holding();
        let process = rig.calibrate("new.toml").spawn().unwrap();
        rig.wait_for_torque(true);
        std::thread::sleep(Duration::from_millis(300));
        signal(&process, name);
        assert_ne!(ended(process).code, Some(0), "{name}");
        let released = rig.wait_for_torque(false).as_secs_f64();
        assert!(released < RELEASE + SLACK, "{name}: under torque for {released} s");
        assert!(!rig.file("new.toml").exists(), "{name}");
    }
}

#[test]
fn a_disk_that_is_full_ends_the_run_safely_and_what_was_written_opens() {
    // Room for some 140 rows of 200 bytes.
    let rig = EmulatedRig::start("", 20.0);
    let record = rig.record("out.parquet");
    let mut limited = Command::new("bash");
    limited.arg("-c").arg("trap '' XFSZ; ulimit -f 30; exec \"$0\" \"$@\"").arg(program());
    limited.args(record.get_args()).current_dir(rig.path()).env_remove("RUST_LOG");
    let Output { status, stderr, .. } = limited.stdin(std::process::Stdio::null()).output().unwrap();
    let outcome =
        Outcome { code: status.code(), stdout: String::new(), stderr: String::from_utf8(stderr).unwrap() };
    let error = outcome.error(1);
    assert!(error.contains("writing the recording") && error.contains("free space"), "{error}");
    assert!(!rig.torques().last().unwrap().1);
    // The recording may have had no room next to its journal, which then stays.
    let out = if rig.file("out.journal").exists() {
        run(rig.path(), &["rig", "recover", "out.journal", "--out", "recovered.parquet"]).succeeded();
        "recovered.parquet"
    } else {
        "out.partial-1.parquet"
    };
    assert!(!rig.file("out.parquet").exists(), "cut short under the final name");
    let n_rows = Recording::read(rig.file(out)).unwrap().n_samples();
    assert!((100..=150).contains(&n_rows), "{n_rows}");
}

/// A fault in the middle of a long recording; the error must have these parts.
fn broken(fault: &str, parts: &[&str]) {
    let rig = EmulatedRig::start(&format!("[[fault]]\nat_s = 6.0\n{fault}"), 20.0);
    let outcome = ended(rig.record("out.parquet").spawn().unwrap());
    let error = outcome.error(1);
    assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    assert!(!rig.torques().last().unwrap().1);
    is_kept(&rig, PARTIAL);
}

#[test]
fn a_tracker_that_is_unplugged_ends_the_run_and_the_rows_are_kept() {
    broken("kind = \"unplug_tracker\"", &["limit passed", "tracker: no pose"]);
}

#[test]
fn a_bus_that_is_unplugged_ends_the_run_and_the_rows_are_kept() {
    broken("kind = \"unplug_bus\"\nduration_s = 1.0", &["servo bus", "port lost"]);
}

#[test]
fn two_recorders_with_one_name_do_not_harm_each_other() {
    let rig = EmulatedRig::start("", 20.0);
    let first = recording(&rig);
    for out in ["out.parquet", "./out.parquet"] {
        let second = ended(rig.record(out).spawn().unwrap());
        assert!(second.error(2).contains(&format!("process {} is writing", first.id())), "{}", second.stderr);
    }
    signal(&first, "INT");
    assert!(ended(first).error(1).contains("interrupted"));
    is_kept(&rig, PARTIAL);
}

#[test]
fn what_a_run_leaves_that_is_killed_at_its_end_is_cleared_by_the_same_command() {
    let rig = EmulatedRig::start("", 0.6);
    ended(rig.record("out.parquet").spawn().unwrap()).succeeded();
    let whole = std::fs::read(rig.file("out.parquet")).unwrap();
    // As if it had been killed after the recording was whole and before the rest was cleared.
    let recording = Recording::read(rig.file("out.parquet")).unwrap();
    let names: Vec<String> = recording.channels().iter().map(|channel| channel.name.clone()).collect();
    let mut journal = JournalWriter::create(rig.file("out.journal"), &names, recording.meta()).unwrap();
    for (i, time) in recording.time().iter().enumerate() {
        let row: Vec<f64> = recording.channels().iter().map(|channel| channel.values[i]).collect();
        journal.append(*time, &row).unwrap();
    }
    drop(journal);
    std::fs::write(rig.file(".out.parquet.lock"), "4711").unwrap();
    ended(rig.record("out.parquet").spawn().unwrap()).succeeded();
    assert!(!rig.file("out.journal").exists() && !rig.file(".out.parquet.lock").exists());
    assert!(!rig.file("out.crashed-1.parquet").exists());
    // Rows of another run are kept, under another name.
    let mut journal = JournalWriter::create(rig.file("out.journal"), &names[..1], recording.meta()).unwrap();
    (0..20).for_each(|i| journal.append(f64::from(i), &[1.0]).unwrap());
    drop(journal);
    ended(rig.record("out.parquet").spawn().unwrap()).succeeded();
    assert!(!rig.file("out.journal").exists());
    assert_eq!(Recording::read(rig.file("out.crashed-1.parquet")).unwrap().n_samples(), 20);
    assert!(std::fs::read(rig.file("out.parquet")).unwrap() == whole);
}

/// Rows of the plan with 0.6 s of sustain.
const N_ROWS: usize = 220;
/// Most that a kill may cost [s].
const LOST: f64 = 1.0;

/// When an event of the log came [s], on the clock of the run.
fn time_of(log: &str, message: &str) -> Option<f64> {
    let line = log.lines().find(|line| line.contains(&format!("\"message\":\"{message}\"")))?;
    line.strip_prefix("{\"time_s\":")?.split(',').next()?.parse().ok()
}

/// Files that a killed run left.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Left {
    Nothing,
    Rows,
    Recording,
}

/// Kills a run after that time [s], looks at what it left, and runs the same command again.
fn kill(rig: &EmulatedRig, name: &str, after: f64) -> Left {
    let out = format!("{name}.parquet");
    let n_before = rig.torques().len();
    let mut process = rig.record(&out).spawn().unwrap();
    std::thread::sleep(Duration::from_secs_f64(after));
    let was_over = process.try_wait().unwrap().is_some();
    process.kill().unwrap();
    let own_words = ended(process).stderr;
    let released = rig.wait_for_torque(false).as_secs_f64();
    assert!(released < RELEASE + SLACK, "{name}: under torque for {released} s");

    let torques = rig.torques().split_off(n_before);
    let on = torques.iter().find(|torque| torque.1).map(|torque| torque.0);
    let off = torques.last().map_or(0.0, |torque| torque.0);
    let journal = rig.file(&format!("{name}.journal"));
    let is_whole = rig.file(&out).exists();
    let mut n_rows = 0;
    if journal.exists() {
        let recovered = format!("{name}-recovered");
        let outcome = run(
            rig.path(),
            &["rig", "recover", &format!("{name}.journal"), "--out", &format!("{recovered}.parquet")],
        );
        if outcome.code == Some(0) {
            n_rows = Recording::read(rig.file(&format!("{recovered}.parquet"))).unwrap().n_samples();
            let log = std::fs::read_to_string(rig.file(&format!("{recovered}.events.jsonl"))).unwrap();
            let begun = time_of(&log, "recording").unwrap() - time_of(&log, "torque on").unwrap();
            let measured = (off - released - on.unwrap() - begun).min(0.01 * N_ROWS as f64);
            assert!(0.01 * n_rows as f64 >= measured - LOST, "{name}: {n_rows} rows of {measured:.2} s");
        } else {
            let error = outcome.error(2);
            assert!(error.contains("whole"), "{error}");
            // Slewing takes 0.3 s at most, settling 0.5 s.
            assert!(on.is_none_or(|on| off - released - on < 0.8 + LOST), "{name}: no row of {torques:?}");
        }
    } else if is_whole {
        assert!(Recording::read(rig.file(&out)).unwrap().n_samples() >= N_ROWS, "{name}");
    } else {
        // The journal is begun as soon as the torque is on.
        let is_too_early = on.is_none_or(|on| off - released - on < LOST);
        assert!(!was_over && is_too_early, "{name}: nothing left of {torques:?}: {own_words}");
    }

    let again = recorded(rig, &out);
    assert!(Recording::read(rig.file(&out)).unwrap().n_samples() >= N_ROWS, "{name}");
    if !is_whole {
        assert!(!journal.exists(), "{name}");
        let rescued = rig.file(&format!("{name}.crashed-1.parquet"));
        assert_eq!(rescued.exists(), n_rows > 0, "{name}: {}", again.stderr);
        assert!(n_rows == 0 || Recording::read(rescued).unwrap().n_samples() == n_rows, "{name}");
    }
    match (is_whole, n_rows) {
        (true, _) => Left::Recording,
        (false, 0) => Left::Nothing,
        (false, _) => Left::Rows,
    }
}

/// Records until it succeeds; only a computer that paused longer than the servos' watchdog, which ends a run
/// on purpose, is a reason for another try.
fn recorded(rig: &EmulatedRig, out: &str) -> Outcome {
    for _ in 0..3 {
        let outcome = ended(rig.record(out).spawn().unwrap());
        if !(outcome.code == Some(1) && outcome.stderr.contains("standstill")) {
            return outcome.succeeded();
        }
    }
    panic!("{out}: the computer stood still three times");
}

#[test]
fn a_run_that_is_killed_at_any_moment_lets_go_and_loses_a_second_at_most() {
    use rand::RngExt;
    let mut rng = rng(7, "tests/kill");
    // Starting takes some tenths of a second, slewing and settling 0.7 s, the plan 2.2 s, the return 0.6 s.
    let moments = (0..50).map(|number| (number, rng.random_range(0.0..4.2)));
    let queue = Mutex::new(moments.collect::<VecDeque<(usize, f64)>>());
    let left = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..10 {
            scope.spawn(|| {
                let rig = EmulatedRig::start("", 0.6);
                loop {
                    let next = queue.lock().unwrap().pop_front();
                    let Some((number, after)) = next else { return };
                    let found = kill(&rig, &format!("kill-{number}"), after);
                    left.lock().unwrap().push(found);
                }
            });
        }
    });
    let left = left.into_inner().unwrap();
    let n = |what| left.iter().filter(|found| **found == what).count();
    assert!(left.len() == 50 && n(Left::Nothing) > 0 && n(Left::Rows) > 20, "{left:?}");
}

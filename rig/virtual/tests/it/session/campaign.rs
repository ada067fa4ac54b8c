//! Faults, drawn from a seed, while rigs on their ports are recorded or calibrated and other programs try to use them.
//!
//! After any fault: no panic; the run continues or ends with its reason; no servo is under torque in the end; what broke
//! is in the log; no measurement is lost; and no other program gets a port that is in use. `HYSTERON_CAMPAIGN=10` draws
//! ten times as many.

use super::campaign_calibration;
use super::probe::{Probe, Read, Rig, simulated, wait_for};
use super::{TURN, small_circle};
use hysteron_base::{Metadata, Recording, json, rng};
use hysteron_rig::config::RigConfig;
use hysteron_rig::session::{
    Outcome, RecordOptions, RigRecorder, RigSession, Stop, events_path, journal_path,
};
use hysteron_rig::{Event, EventKind, Hardware, LiveRig};
use hysteron_virtual_rig::emulator::{BusFault, FaultKind, FaultMoment};
use rand::RngExt;
use std::collections::{BTreeMap, VecDeque};
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Instant;

/// Rigs at once.
const AT_ONCE: usize = 10;
/// A cycle that begins so late shows that the machine was busy [ms].
const MACHINE_LATE_MS: f64 = 100.0;
/// Recordings with faults that they survive, recordings and calibrations with one that ends them; each kind once, at
/// least.
const RUNS: [u64; 3] = [4, 18, 9];
/// Changes to the rig file. A busy machine answers late, which is not what is tested here.
pub(super) const RIG: [(&str, &str); 3] = [
    ("reply_timeout_ms = 4.0", "reply_timeout_ms = 40.0"),
    ("stale_ms = 300.0", "stale_ms = 1200.0"),
    ("retries = 2", "retries = 3"),
];
/// As in [`RIG`] [s].
const STALE: f64 = 1.2;
/// From a fault to its event, in addition to the duration of the fault itself [s]: a cycle until it strikes, and the timeouts of
/// one read with its retries.
const NOTICED: f64 = 0.01 + 5.0 * 0.04;
/// Same for those which the session sees at its slow reads, and which the tracker reports once a second [s].
const NOTICED_SLOWLY: f64 = 1.1;
/// Threads of a busy machine may be this late [s].
const SLACK: f64 = 0.5;

/// One recording and what will break.
#[derive(Debug, Clone)]
pub(super) struct Script {
    n_rows: usize,
    /// When after the torque went on [s], and what.
    pub faults: Vec<(f64, BusFault)>,
    end: End,
}

/// How the recording shall end.
#[derive(Debug, Clone, Copy, PartialEq)]
enum End {
    Plan,
    Stopped,
    /// The fault strikes on the way back to rest.
    Either,
}

/// Faults that a run survives, one after the other: of the bus, and now and then of the tracker.
pub(super) fn survivable(seed: u64) -> Script {
    let mut rng = rng(seed, "tests/campaign/survivable");
    let n_rows = 1000;
    let mut faults = Vec::new();
    let mut time = rng.random_range(0.0..0.3);
    while time < 0.01 * n_rows as f64 {
        use FaultKind::{CorruptPacket, DelayPacket, DropInstruction, DropPacket, Noise};
        let kind = [DropPacket, CorruptPacket, DelayPacket, DropInstruction, Noise][rng.random_range(0..5)];
        let mut fault = BusFault::new(0.0, kind);
        if kind == DelayPacket {
            fault.delay_ms = Some(rng.random_range(70.0..100.0));
        }
        if rng.random_bool(0.5) && kind != Noise {
            fault = fault.of_servo(rng.random_range(1..=4));
        }
        fault.count = Some(match kind {
            Noise => rng.random_range(1..60),
            DelayPacket => 1,
            // The first may be a sync write, to which there is no answer that could be missed.
            DropInstruction => rng.random_range(2..=3),
            _ => rng.random_range(1..=3),
        });
        faults.push((time, fault));
        time += rng.random_range(0.3..0.4);
    }
    let mut time = rng.random_range(0.8..1.0);
    while time < 0.01 * n_rows as f64 - 1.0 {
        let (kind, duration) = [
            (FaultKind::UnplugTracker, 0.1),
            (FaultKind::TrackerDropout, 0.15),
            (FaultKind::TrackerInvalid, 0.15),
            (FaultKind::TrackerFreeze, 0.4),
            (FaultKind::TrackerJump, 0.1),
            (FaultKind::TrackerCorrupt, 0.15),
        ][rng.random_range(0..6)];
        faults.push((time, BusFault::new(0.0, kind).lasting(duration)));
        time += rng.random_range(1.5..1.6);
    }
    faults.sort_by(|a, b| a.0.total_cmp(&b.0));
    Script { n_rows, faults, end: End::Plan }
}

/// One fault that ends a run, at any moment from torque on to torque off; variants of every kind by turns.
pub(super) fn fatal(seed: u64) -> Script {
    let mut rng = rng(seed, "tests/campaign/fatal");
    let id = rng.random_range(1..=4);
    let of = |kind| BusFault::new(0.0, kind);
    let fault = match seed % 18 {
        0 => of(FaultKind::UnplugBus).lasting(rng.random_range(0.1..1.5)),
        1 => of(FaultKind::UnplugBus).lasting(4.5), // longer than the session's patience
        2 => of(FaultKind::UnplugServo).of_servo(id).lasting(rng.random_range(0.05..1.5)),
        3 => of(FaultKind::Overload).of_servo(id),
        4 => of(FaultKind::Overheat).of_servo(id).lasting(rng.random_range(0.1..0.8)),
        5 | 6 => {
            let torque_nm = Some(if rng.random_bool(0.5) { 1.35 } else { -1.35 });
            BusFault { torque_nm, ..of(FaultKind::Hold).of_servo(id).lasting(0.4) }
        }
        7 => of(FaultKind::BrownOut).lasting(rng.random_range(0.05..0.5)),
        8 => of(FaultKind::BrownOut).of_servo(id).lasting(rng.random_range(0.05..0.5)),
        9 => BusFault { volts: Some(rng.random_range(5.2..9.0)), ..of(FaultKind::BrownOut).lasting(1.5) },
        10 => of(FaultKind::DropPacket).times(120),
        11 => of(FaultKind::DropInstruction).times(150),
        12 => of(FaultKind::UnplugTracker).lasting(2.0),
        13 => of(FaultKind::TrackerDropout).lasting(2.0),
        14 => of(FaultKind::TrackerInvalid).lasting(2.0),
        15 => of(FaultKind::TrackerFreeze).lasting(2.0),
        16 => of(FaultKind::TrackerJump).lasting(2.0),
        _ => of(FaultKind::TrackerCorrupt).lasting(2.0),
    };
    let is_late = seed % 7 == 6 && !fault.kind.is_of_tracker();
    if is_late {
        // Slewing and settling take 0.7 s, so does the way back.
        let time = rng.random_range(1.25..1.7);
        return Script { n_rows: 60, faults: vec![(time, fault)], end: End::Either };
    }
    Script { n_rows: 300, faults: vec![(rng.random_range(0.0..1.8), fault)], end: End::Stopped }
}

/// Events of which at least one reports a fault, and how long after its beginning at the latest [s]; none for what
/// cannot be distinguished from silence.
fn reported_by(fault: &BusFault, is_fatal: bool) -> Option<(&'static [EventKind], f64)> {
    use EventKind::{
        BusLost, Corrupt, HardwareError, Limit, Reset, Timeout, TrackerCorrupt, TrackerLost, TrackerQuality,
        TrackerStale,
    };
    let duration = fault.duration_s.unwrap_or(0.0);
    Some(match fault.kind {
        FaultKind::DropPacket | FaultKind::DropInstruction => (&[Timeout], NOTICED),
        FaultKind::CorruptPacket => (&[Corrupt, Timeout], NOTICED),
        FaultKind::DelayPacket => (&[Timeout], NOTICED),
        // It passes between the answers, and the search for the next header skips it.
        FaultKind::Noise => return None,
        FaultKind::UnplugBus => (&[BusLost], NOTICED),
        FaultKind::UnplugServo => (&[Timeout, Reset], NOTICED),
        FaultKind::Overload | FaultKind::Overheat => (&[Limit, HardwareError], NOTICED),
        // The load rises while the servo gives way.
        FaultKind::Hold => (&[Limit], duration + NOTICED),
        FaultKind::BrownOut => (&[Timeout, Reset, Limit], NOTICED_SLOWLY),
        FaultKind::UnplugTracker => (&[TrackerLost], NOTICED),
        // A short one shows as rows without a pose, a longer one as this.
        FaultKind::TrackerDropout if is_fatal => (&[TrackerStale], STALE + NOTICED),
        FaultKind::TrackerDropout => return None,
        FaultKind::TrackerInvalid | FaultKind::TrackerFreeze | FaultKind::TrackerJump => {
            (&[TrackerQuality], duration + NOTICED_SLOWLY)
        }
        FaultKind::TrackerCorrupt => (&[TrackerCorrupt], NOTICED_SLOWLY),
    })
}

/// Result of a script.
struct Found {
    injected: Vec<(f64, BusFault)>,
    outcome: Outcome,
    problems: Vec<String>,
}

fn run_script(script: &Script, n_tries: u32) -> Found {
    let rig = Rig::among_others(&RIG);
    let (rounds_before, slipped_before) =
        (rig.emulator.counts().complete_rounds, rig.emulator.counts().slipped_ms);
    let (ports, servos) = rig.ready();
    let calibration = rig.calibration(&servos);
    let mut probe = Probe::new(ports, &rig.emulator);
    let start = probe.now();
    probe.due = script.faults.iter().map(|(after, fault)| (start + after, fault.clone())).collect();
    let n_reads = probe.n_reads.clone();
    // Reads before the first row's, and up to the last row's.
    let rows = std::cell::Cell::new(None);
    let options = RecordOptions::new(rig.out(), Metadata::default());
    let recorder = RigRecorder::begin(&rig.config, &calibration, options).unwrap();
    let session = match RigSession::start(&mut probe, &rig.config, &calibration, 100.0) {
        Ok(session) => session,
        // A machine too busy for the emulator to answer, or a fault too early: that is no recording.
        Err(_) if n_tries > 0 && rig.comes_to_be_released() => return run_script(script, n_tries - 1),
        Err(error) => panic!("{error}, torque {:?}", rig.emulator.torque_on()),
    };
    let progress = &mut |_| {
        let n = n_reads.get();
        rows.set(Some((rows.get().map_or(n - 1, |(first, _)| first), n)));
    };
    let other = OtherProgram::start(&rig.config);
    let outcome = recorder.run(session, &small_circle(script.n_rows), &|| false, progress).unwrap();
    let n_taken = other.end();

    let mut problems = Vec::new();
    // A bus that was unplugged comes back as a free port.
    if n_taken > 0 && script.faults.iter().all(|(_, fault)| fault.kind != FaultKind::UnplugBus) {
        problems.push(format!("another program got the port {n_taken} times"));
    }
    let Probe { injected, reads, n_slow, rig: ports, .. } = probe;
    // Others may have them now.
    drop(ports);
    let slack = SLACK + 1e-3 * outcome.stats.summary().late_max_ms;
    match (script.end, &outcome.stopped) {
        (End::Plan, None) | (End::Either, _) | (End::Stopped, Some(Stop::Limit(_) | Stop::Failed(_))) => {}
        (expected, found) => problems.push(format!("expected {expected:?}, got {found:?}")),
    }
    check_events(script, &injected, &outcome.events, slack, &mut problems);
    check_data(&rig, &outcome, (&reads, rows.get()), script.n_rows, &mut problems);
    // Each round that the emulator answered as a whole was read, unless the port went meanwhile, or the emulator had
    // to wait for its processor until the answer had timed out.
    let n_whole = reads.iter().filter(|read| read.servos.iter().all(Option::is_some)).count() as u64;
    let n_unread = reads.len() as u64 - n_whole;
    let n_rounds = rig.emulator.counts().complete_rounds - rounds_before;
    if n_rounds > n_whole + n_slow + n_unread {
        problems.push(format!("{n_rounds} rounds answered, {n_whole} + {n_slow} + {n_unread} read"));
    }
    check_torque(&rig, outcome.is_torque_settled, &injected, &mut problems);
    // Where servos and tracker did not get the processor, their silence is another fault than those of the script.
    let is_starved = rig.emulator.counts().slipped_ms > slipped_before
        || outcome.stats.summary().late_max_ms > MACHINE_LATE_MS;
    if !problems.is_empty() && is_starved && n_tries > 0 {
        return run_script(script, n_tries - 1);
    }
    Found { injected, outcome, problems }
}

fn check_events(
    script: &Script,
    injected: &[(f64, BusFault)],
    events: &[Event],
    slack: f64,
    problems: &mut Vec<String>,
) {
    if injected.len() != script.faults.len() && script.end != End::Either {
        problems.push(format!("only {} faults of {}", injected.len(), script.faults.len()));
    }
    for (time, fault) in injected {
        let Some((kinds, within)) = reported_by(fault, script.end != End::Plan) else { continue };
        let is_logged = events.iter().any(|event| {
            kinds.contains(&event.kind) && event.time_s >= *time && event.time_s <= time + within + slack
        });
        if !is_logged {
            let near: Vec<&Event> =
                events.iter().filter(|e| (e.time_s - time).abs() < within + slack + 1.0).collect();
            problems.push(format!("{fault:?} at {time:.3} s is not in the log: {near:?}"));
        }
    }
}

/// Every read of the recording is a row, in order, to the last bit; and the files are as they should be.
fn check_data(
    rig: &Rig,
    outcome: &Outcome,
    (reads, rows): (&[Read], Option<(usize, usize)>),
    n_rows: usize,
    problems: &mut Vec<String>,
) {
    if journal_path(&rig.out()).exists() {
        problems.push("the journal is still there".into());
    }
    if rig.out().exists() != outcome.stopped.is_none() {
        problems.push("only a run that came to its end has the final name".into());
    }
    let kept = if outcome.n_rows == 0 { rig.out() } else { outcome.out.clone() };
    let log = std::fs::read_to_string(events_path(&kept)).unwrap();
    let logged: Vec<Event> = log.lines().map(|line| json::from_text(line).unwrap()).collect();
    if logged.len() != outcome.events.len() {
        problems.push(format!("{} events in the log, {} happened", logged.len(), outcome.events.len()));
    }
    if outcome.n_rows == 0 {
        if rows.is_some() || rig.out().exists() {
            problems.push("rows are lost".into());
        }
        return;
    }
    let recording = Recording::read(&outcome.out).unwrap();
    // Of a servo that never answered there is no channel.
    let column = |stem: &str, k: usize| {
        let channel = recording.channel(&format!("{stem}_{}", k + 1));
        channel.map_or_else(|| vec![f64::NAN; recording.n_samples()], <[f64]>::to_vec)
    };
    let columns: Vec<(Vec<f64>, Vec<f64>)> =
        (0..4).map(|k| (column("tick_present", k), column("load", k))).collect();
    let Some((first, mut end)) = rows else { return };
    // The cycle in which a limit is found is a row, too, except on the way back.
    if end - first < n_rows
        && let Some(Stop::Limit(violation)) = &outcome.stopped
        && !violation.message.contains("commanded")
    {
        end += 1;
    }
    let mut row = 0;
    for read in reads[first..end].iter().filter(|read| read.servos.iter().all(Option::is_some)) {
        let is_row = |row: usize| {
            read.servos.iter().zip(&columns).all(|(servo, (ticks, loads))| {
                servo.is_some_and(|(tick, load)| f64::from(tick) == ticks[row] && load == loads[row])
            })
        };
        while row < recording.n_samples() && !is_row(row) {
            row += 1;
        }
        if row == recording.n_samples() {
            problems.push(format!("{read:?} is not in the recording"));
            return;
        }
        row += 1;
    }
}

/// Another program that wants the port.
struct OtherProgram {
    is_over: Arc<AtomicBool>,
    thread: JoinHandle<usize>,
}

impl OtherProgram {
    fn start(config: &RigConfig) -> Self {
        let is_over = Arc::new(AtomicBool::new(false));
        let (flag, config) = (is_over.clone(), config.clone());
        let thread = std::thread::spawn(move || {
            let mut n_taken = 0;
            while !flag.load(Ordering::Relaxed) {
                n_taken += usize::from(LiveRig::open(&config).is_ok());
            }
            n_taken
        });
        Self { is_over, thread }
    }

    /// Ends it; returns how often it got the port.
    fn end(self) -> usize {
        self.is_over.store(true, Ordering::Relaxed);
        self.thread.join().unwrap()
    }
}

/// No torque once the faults are over; after a long time without bus, after the next request.
pub(super) fn check_torque(
    rig: &Rig,
    is_torque_settled: bool,
    injected: &[(f64, BusFault)],
    problems: &mut Vec<String>,
) {
    let is_over = || {
        let log = rig.emulator.fault_log();
        injected.iter().filter(|(_, fault)| fault.duration_s.is_some()).all(|(_, fault)| {
            log.iter().any(|record| record.moment == FaultMoment::Ended && record.fault == *fault)
        })
    };
    wait_for(is_over);
    if is_torque_settled {
        // Torque is only noted at the next tick of the emulator.
        if !wait_for(|| rig.is_released()) {
            problems.push(format!("torque {:?} in the end", rig.emulator.torque_on()));
        }
        return;
    }
    // The servos have stopped by themselves.
    let world = rig.emulator.world();
    let is_still = || (0..4).all(|k| world.lock().unwrap().servo(k).state.velocity.abs() < 0.02);
    if !wait_for(is_still) {
        problems.push("out of reach and moving".into());
    }
    let mut hardware = rig.open();
    if !wait_for(|| hardware.disable_torque().is_ok() && rig.is_released()) {
        problems.push(format!("torque {:?} although asked again", rig.emulator.torque_on()));
    }
}

/// Script to try.
#[derive(Debug, Clone)]
enum Trial {
    Recording(Script),
    Calibration(campaign_calibration::Script),
}

#[test]
fn after_any_fault_the_rig_is_safe_and_the_data_are_kept() {
    let _turn = TURN.write().unwrap_or_else(PoisonError::into_inner);
    let factor: u64 = std::env::var("HYSTERON_CAMPAIGN").map_or(1, |factor| factor.parse().unwrap());
    simulated();
    let start = Instant::now();
    let [n_survivable, n_fatal, n_calibrations] = RUNS.map(|n| factor * n);
    let recordings = (0..n_survivable).map(survivable).chain((0..n_fatal).map(fatal)).map(Trial::Recording);
    let calibrations = (0..n_calibrations).map(campaign_calibration::drawn).map(Trial::Calibration);
    let trials: VecDeque<(usize, Trial)> = recordings.chain(calibrations).enumerate().collect();
    let (queue, found) = (Mutex::new(trials), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..AT_ONCE {
            scope.spawn(|| {
                loop {
                    let next = queue.lock().unwrap().pop_front();
                    let Some((number, trial)) = next else { return };
                    let result = catch_unwind(AssertUnwindSafe(|| match &trial {
                        Trial::Recording(script) => {
                            let Found { injected, outcome, problems } = run_script(script, 3);
                            let how = format!("{} rows, {:?}", outcome.n_rows, outcome.stopped);
                            (injected, how, problems)
                        }
                        Trial::Calibration(script) => campaign_calibration::run_script(script),
                    }));
                    found.lock().unwrap().push((number, trial, result.ok()));
                }
            });
        }
    });
    let found = found.into_inner().unwrap();
    let mut kinds: BTreeMap<String, usize> = BTreeMap::new();
    let mut report = String::new();
    for (number, trial, result) in &found {
        let Some((injected, how, problems)) = result else {
            report.push_str(&format!("run {number} panicked: {trial:?}\n"));
            continue;
        };
        for (_, fault) in injected {
            *kinds.entry(format!("{:?}", fault.kind)).or_default() += 1;
        }
        for problem in problems {
            report.push_str(&format!("run {number} ({how}): {problem}\n"));
        }
    }
    let n_faults: usize = kinds.values().sum();
    let seconds = start.elapsed().as_secs_f64();
    let table = format!(
        "{n_faults} faults in {n_survivable} + {n_fatal} recordings and {n_calibrations} calibrations, {seconds:.0} s: \
         {kinds:#?}"
    );
    assert!(report.is_empty(), "{report}{table}");
    assert!(n_faults >= 100 && kinds.len() == FaultKind::ALL.len(), "{table}");
    if factor > 1 {
        writeln!(std::io::stderr(), "{table}\nno panic, no torque left, nothing lost, no port shared")
            .unwrap();
    }
}

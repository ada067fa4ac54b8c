//! Calibrations of the campaign: after any fault, interruption or failure no torque is left, although
//! `at_end` is hold.

use super::campaign::{RIG, check_torque, fatal, survivable};
use super::probe::{Probe, Rig, wait_for};
use hysteron_base::rng;
use hysteron_rig::calibration::calibrate;
use hysteron_rig::{Hardware, LiveRig};
use hysteron_virtual_rig::emulator::{BusFault, FaultKind};
use rand::RngExt;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::time::Instant;

const HOLD: (&str, &str) = ("at_end = \"release\"", "at_end = \"hold\"");
/// Latest that something happens in a calibration [s]; it takes a minute.
const LATEST: f64 = 8.0;

/// One calibration and what will happen.
#[derive(Debug, Clone)]
pub(super) struct Script {
    /// When after the beginning [s], and what.
    faults: Vec<(f64, BusFault)>,
    end: End,
}

/// End of a calibration at a time [s], unless a fault ends it before.
#[derive(Debug, Clone, Copy)]
enum End {
    Asked(f64),
    Panic(f64),
}

/// Of every three one breaks, one is asked to stop and one panics among faults that it survives.
pub(super) fn drawn(seed: u64) -> Script {
    let mut rng = rng(seed, "tests/campaign/calibration");
    let moment = rng.random_range(0.5..LATEST);
    if seed.is_multiple_of(3) {
        let faults = fatal(seed / 3 + 1).faults.into_iter().map(|(_, fault)| (moment, fault)).collect();
        return Script { faults, end: End::Asked(LATEST + 4.0) };
    }
    let faults = survivable(seed).faults.into_iter().filter(|(time, _)| *time < moment).collect();
    Script { faults, end: if seed % 3 == 1 { End::Asked(moment) } else { End::Panic(moment) } }
}

/// Calibrates; returns what broke, how it ended, and what was wrong with that.
pub(super) fn run_script(script: &Script) -> (Vec<(f64, BusFault)>, String, Vec<String>) {
    let rig = Rig::among_others(&[&RIG[..], &[HOLD]].concat());
    let mut probe = Probe::new(rig.open(), &rig.emulator);
    let begun = Instant::now();
    let start = probe.now();
    probe.due = script.faults.iter().map(|(after, fault)| (start + after, fault.clone())).collect();
    let asked = || match script.end {
        End::Asked(time) => begun.elapsed().as_secs_f64() > time,
        End::Panic(time) => {
            if begun.elapsed().as_secs_f64() > time {
                // Unwinds without a message: to write the stack of each takes seconds of every processor.
                resume_unwind(Box::new("on purpose"));
            }
            false
        }
    };
    let ended = catch_unwind(AssertUnwindSafe(|| {
        calibrate(&mut probe, &rig.config, "today".into(), &asked, &mut |_| {})
    }));
    let mut problems = Vec::new();
    let how = match ended {
        Ok(Ok(_)) => {
            problems.push("it came to its end in seconds".into());
            "calibrated".to_owned()
        }
        Ok(Err(error)) => error.to_string(),
        Err(_) => "panicked on purpose".to_owned(),
    };
    let Probe { injected, rig: ports, .. } = probe;
    drop(ports);
    // It is unknown whether the servos could be reached: a bus that was away or deaf for longer than the session's
    // patience leaves them to the watchdog process, whose part is played here; a servo that has lost its plug has
    // lost its power.
    let outlasts = |fault: &BusFault| match fault.kind {
        FaultKind::UnplugBus => fault.duration_s.is_some_and(|duration| duration > 1.0),
        FaultKind::DropPacket | FaultKind::DropInstruction => fault.count.is_some_and(|count| count > 100),
        _ => false,
    };
    let is_reached = !injected.iter().any(|(_, fault)| outlasts(fault));
    check_torque(&rig, is_reached, &injected, &mut problems);
    // And the port is free for the next program.
    if !wait_for(|| LiveRig::open(&rig.config).is_ok()) {
        problems.push("the port is not free".into());
    }
    (injected, how, problems)
}

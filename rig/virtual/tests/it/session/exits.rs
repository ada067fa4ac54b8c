//! Every way out of a session leaves no servo under torque.

use super::probe::{Probe, Read, Rig};
use super::small_circle;
use hysteron_base::{Metadata, Recording};
use hysteron_rig::session::{RecordOptions, RigRecorder, RigSession, journal_path, recover};
use hysteron_virtual_rig::emulator::{BusFault, FaultKind};
use std::panic::{AssertUnwindSafe, catch_unwind};

const PATIENT: (&str, &str) = ("reply_timeout_ms = 4.0", "reply_timeout_ms = 400.0");

fn record_on(rig: &Rig, n: usize, asked: &dyn Fn() -> bool, progress: &mut dyn FnMut(usize)) -> bool {
    let (mut hardware, servos) = rig.ready();
    let calibration = rig.calibration(&servos);
    let options = RecordOptions::new(rig.out(), Metadata::default());
    let Ok(recorder) = RigRecorder::begin(&rig.config, &calibration, options) else { return false };
    let session = RigSession::start(&mut hardware, &rig.config, &calibration, 100.0).unwrap();
    assert_eq!(rig.emulator.torque_on(), [true; 4]);
    recorder.run(session, &small_circle(n), asked, progress).is_ok()
}

#[test]
fn a_panic_in_the_middle_lets_go_and_leaves_a_journal_that_opens() {
    let rig = Rig::new(&[PATIENT]);
    let panicked = catch_unwind(AssertUnwindSafe(|| {
        record_on(&rig, 300, &|| false, &mut |row| assert!(row < 120, "on purpose"))
    }));
    assert_eq!(panicked.unwrap_err().downcast_ref::<&str>(), Some(&"on purpose"));
    assert!(rig.comes_to_be_released());
    let rescued = rig.out().with_extension("rescued.parquet");
    let (n_rows, n_gaps) = recover(&journal_path(&rig.out()), &rescued).unwrap();
    // All but those that still waited for their poses, 0.4 s at most.
    assert!(n_rows >= 80 && n_rows - n_gaps <= 120, "{n_rows}, {n_gaps} of them filled in");
    assert_eq!(Recording::read(rescued).unwrap().n_samples(), n_rows);
}

#[test]
fn a_panic_before_the_first_row_lets_go() {
    let rig = Rig::new(&[PATIENT]);
    let panicked =
        catch_unwind(AssertUnwindSafe(|| record_on(&rig, 300, &|| panic!("on purpose"), &mut |_| {})));
    assert_eq!(panicked.unwrap_err().downcast_ref::<&str>(), Some(&"on purpose"));
    assert!(rig.comes_to_be_released());
    assert!(!journal_path(&rig.out()).exists());
}

#[test]
fn a_recording_that_cannot_be_begun_lets_go() {
    let rig = Rig::new(&[PATIENT]);
    std::fs::write(journal_path(&rig.out()), "in the way").unwrap();
    assert!(!record_on(&rig, 300, &|| false, &mut |_| {}));
    assert!(rig.comes_to_be_released());
}

#[test]
fn a_stop_before_the_first_row_is_a_stop_and_leaves_no_journal() {
    let rig = Rig::new(&[PATIENT]);
    assert!(record_on(&rig, 300, &|| true, &mut |_| {}));
    assert!(rig.comes_to_be_released() && !rig.out().exists() && !journal_path(&rig.out()).exists());
}

#[test]
fn a_start_that_fails_half_way_lets_go_even_where_the_end_would_hold() {
    // Three times three tries take less than the session's patience.
    let rig = Rig::new(&[
        ("reply_timeout_ms = 4.0", "reply_timeout_ms = 100.0"),
        ("at_end = \"release\"", "at_end = \"hold\""),
    ]);
    let (hardware, servos) = rig.ready();
    let calibration = rig.calibration(&servos);
    // From when the servos were read and before the torque goes on: the answers of the last one to all tries to switch it on are lost; it
    // switches all the same.
    let n = 1 + rig.config.servos.retries;
    let mut probe = Probe::new(hardware, &rig.emulator);
    probe.due.push_back((0.0, BusFault::new(0.0, FaultKind::DropPacket).of_servo(4).times(3 * n)));
    let started = RigSession::start(&mut probe, &rig.config, &calibration, 100.0);
    let error = started.err().unwrap().to_string();
    assert!(error.contains("servo 4"), "{error}");
    let has_read_all = |read: &Read| read.servos.iter().all(Option::is_some);
    assert!(probe.reads.first().is_some_and(has_read_all) && probe.injected.len() == 1);
    assert!(rig.comes_to_be_released(), "{:?}", rig.emulator.torque_on());
}

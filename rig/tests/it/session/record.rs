//! A recording without mishaps.

use super::{Stand, circle};
use hysteron_base::Recording;
use hysteron_rig::EventKind;

#[test]
fn every_cycle_becomes_a_row_and_the_torque_is_off_in_the_end() {
    let stand = Stand::new();
    let n = 300;
    let mut rows = 0;
    let outcome = stand.record(n, &|| false, &mut |done| rows = done).unwrap();
    assert!(outcome.stopped.is_none(), "{outcome:?}");
    // A busy machine may miss a cycle; its row is then there, and marked.
    assert_eq!((outcome.n_rows - outcome.n_gaps, rows), (n, n));
    assert_eq!(stand.emulator.torque_on(), [false; 4]);

    let recording = Recording::read(stand.out()).unwrap();
    assert!((recording.rate_hz().unwrap() - 100.0).abs() < 1e-6);
    let commands = circle(n);
    let measured: Vec<usize> = (0..recording.n_samples()).filter(|i| !recording.gap()[*i]).collect();
    // A command is what the servo was told, to half a tick.
    let half_tick = 0.5 * std::f64::consts::TAU * 0.01 / 4096.0;
    for (told, planned) in recording.strokes().iter().zip(commands.strokes()) {
        for (i, planned) in measured.iter().zip(planned) {
            assert!((told[*i] - planned).abs() <= half_tick * (1.0 + 1e-9));
        }
    }
    let kinds: Vec<EventKind> = outcome.events.iter().map(|event| event.kind).collect();
    assert!(
        kinds.iter().all(|kind| matches!(kind, EventKind::Run | EventKind::Late)),
        "{:?}",
        outcome.events
    );
    assert!(outcome.stats.summary().bus.lost == 0);
}

#[test]
fn a_run_that_is_asked_to_stop_keeps_what_it_has() {
    let stand = Stand::new();
    let done = std::cell::Cell::new(0);
    let outcome = stand.record(300, &|| done.get() >= 50, &mut |rows| done.set(rows)).unwrap();
    assert_eq!(outcome.n_rows - outcome.n_gaps, 50);
    assert_eq!(Recording::read(stand.out()).unwrap().n_samples(), outcome.n_rows);
    assert_eq!(stand.emulator.torque_on(), [false; 4]);
}

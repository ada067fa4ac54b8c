//! Cells side by side.
//!
//! A training of some arms uses two threads, and its comparisons less: on more threads more cells run at a time. Each has
//! a thread of its own outside the pool, so that none waits in the middle for another that its thread took up.

use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};

use hysteron_base::parallel;
use hysteron_learn::{Result, TrainingProgress};

use super::cells::{Listener, StudyProgress};

/// Threads that a cell uses.
const THREADS_OF_A_CELL: usize = 2;

/// Computes a cell by its number, and reports its training; None where that was ended.
pub type Compute<'a, R> =
    &'a (dyn Fn(usize, &mut dyn FnMut(&TrainingProgress) -> bool) -> Result<Option<R>> + Sync);

/// Message of a thread about its cell.
enum Report<R> {
    Begun,
    Training(TrainingProgress),
    Over(Result<Option<R>>),
}

/// As many cells as the program has threads for.
pub fn at_once() -> NonZeroUsize {
    NonZeroUsize::new(parallel::threads() / THREADS_OF_A_CELL).unwrap_or(NonZeroUsize::MIN)
}

/// Cells that threads take in turn.
struct Queue<'a, R> {
    next: AtomicUsize,
    n: usize,
    is_running: AtomicBool,
    compute: Compute<'a, R>,
}

impl<R> Queue<'_, R> {
    /// Computes cells until there are no more, or the receiver is closed.
    fn work(&self, reports: &SyncSender<(usize, Report<R>)>) {
        let report = |k, report| reports.send((k, report)).is_ok() && self.is_running.load(Ordering::Relaxed);
        loop {
            let k = self.next.fetch_add(1, Ordering::Relaxed);
            if k >= self.n || !self.is_running.load(Ordering::Relaxed) || !report(k, Report::Begun) {
                return;
            }
            let found = (self.compute)(k, &mut |p| report(k, Report::Training(*p)));
            report(k, Report::Over(found));
        }
    }

    fn end(&self) {
        self.is_running.store(false, Ordering::Relaxed);
    }
}

/// All cells, `at_once` at a time, in the order of their names. None where the listener ended it.
///
/// # Errors
/// The first error of a cell; running cells are then ended, as by the listener.
pub fn side_by_side<R: Send>(
    at_once: NonZeroUsize,
    names: &[&str],
    listener: Listener<'_>,
    compute: Compute<'_, R>,
) -> Result<Option<Vec<R>>> {
    let n = names.len();
    let queue = Queue { next: AtomicUsize::new(0), n, is_running: AtomicBool::new(true), compute };
    // Without a buffer, a training never runs ahead of a listener that ends it.
    let (sender, reports) = sync_channel(0);
    let mut found: Vec<Result<Option<R>>> = names.iter().map(|_| Ok(None)).collect();
    std::thread::scope(|scope| {
        for _ in 0..at_once.get().min(n) {
            let (queue, sender) = (&queue, sender.clone());
            scope.spawn(move || queue.work(&sender));
        }
        drop(sender);
        let mut n_done = 0;
        for (k, report) in reports {
            let mut training = None;
            match report {
                Report::Begun => {}
                Report::Training(progress) => training = Some(progress),
                Report::Over(one) => {
                    match &one {
                        Ok(one) => n_done += usize::from(one.is_some()),
                        Err(_) => queue.end(),
                    }
                    found[k] = one;
                }
            }
            if !listener(&StudyProgress { cell: names[k], done: [n_done, n], training }) {
                queue.end();
            }
        }
    });
    // An error counts even if cells before it were ended for it.
    let found: Vec<Option<R>> = found.into_iter().collect::<Result<_>>()?;
    Ok(found.into_iter().collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use std::sync::Barrier;

    use hysteron_base::BadInput;

    use super::*;

    const NAMES: [&str; 5] = ["a", "b", "c", "d", "e"];
    const STEP: TrainingProgress = TrainingProgress::Step { epoch: 0, done: 0, of: 1 };

    fn three() -> NonZeroUsize {
        NonZeroUsize::new(3).unwrap()
    }

    #[test]
    fn as_many_cells_as_asked_for_are_at_work_and_come_in_order() {
        // The first three wait for each other: fewer at a time would never end.
        let together = Barrier::new(3);
        let compute = |k: usize, report: &mut dyn FnMut(&TrainingProgress) -> bool| {
            if k < 3 {
                together.wait();
            }
            Ok(report(&STEP).then_some(10 * k))
        };
        let mut reports = Vec::new();
        let mut listener = |p: &StudyProgress<'_>| {
            reports.push((p.cell.to_owned(), p.done, p.training.is_some()));
            true
        };
        let found = side_by_side(three(), &NAMES, &mut listener, &compute).unwrap();
        assert_eq!(found, Some(vec![0, 10, 20, 30, 40]));
        // Of each cell its beginning, its training and its end, of which only the end counts as done.
        assert_eq!(reports.len(), 3 * NAMES.len());
        assert_eq!(reports.last().map(|one| one.1), Some([5, 5]));
        assert!(reports.iter().filter(|one| one.2).count() == NAMES.len());
        assert!(reports.is_sorted_by_key(|one| one.1));
        assert!(side_by_side::<()>(three(), &[], &mut |_| true, &|_, _| Ok(None)).unwrap().is_some());
    }

    #[test]
    fn a_listener_and_an_error_end_what_is_at_work() {
        let forever = |_: usize, report: &mut dyn FnMut(&TrainingProgress) -> bool| {
            while report(&STEP) {}
            Ok(None::<()>)
        };
        let mut n_reports = 0;
        let mut listener = |_: &StudyProgress<'_>| {
            n_reports += 1;
            n_reports < 20
        };
        assert!(side_by_side(three(), &NAMES, &mut listener, &forever).unwrap().is_none());

        let fails = |k: usize, report: &mut dyn FnMut(&TrainingProgress) -> bool| match k {
            1 => Err(BadInput::new("b", "a cell", "none").into()),
            _ => forever(k, report),
        };
        let error = side_by_side(three(), &NAMES, &mut |_| true, &fails).unwrap_err();
        assert!(error.to_string().contains("a cell"), "{error}");
    }
}

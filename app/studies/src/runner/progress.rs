//! Cells as a progress bar.

use std::time::{Duration, Instant};

use hysteron_learn::TrainingProgress;
use hysteron_workflow::Context;

use super::cells::StudyProgress;

/// Cells that are done sooner were computed by a study before.
const FOUND_WITHIN: Duration = Duration::from_secs(1);

/// Cells as a bar, with the epoch and error of the training at hand.
pub(super) struct Bar<'a> {
    bar: Option<Box<dyn hysteron_workflow::Progress>>,
    context: &'a Context<'a>,
    /// Cells done, and since when.
    done: usize,
    since: Instant,
}

impl<'a> Bar<'a> {
    pub fn new(context: &'a Context<'a>) -> Self {
        Self { bar: None, context, done: 0, since: Instant::now() }
    }

    pub fn show(&mut self, p: &StudyProgress<'_>) -> bool {
        let [done, of] = p.done;
        if done > self.done {
            let took = self.since.elapsed();
            (self.done, self.since) = (done, Instant::now());
            // Cells found in files do not predict the time of others: rate and remaining time are reset.
            if took < FOUND_WITHIN {
                self.clear();
                self.bar = None;
            }
        }
        let bar = self.bar.get_or_insert_with(|| self.context.progress("cells", of, done));
        bar.set_position(done as u64);
        match p.training {
            Some(TrainingProgress::Epoch(epoch)) => {
                bar.set_message(format!(
                    "{}: {}/{}, error {:.2e}",
                    p.cell, epoch.number, epoch.of, epoch.best
                ));
            }
            Some(TrainingProgress::Step { .. }) => {}
            None => bar.set_message(p.cell.to_owned()),
        }
        !self.context.is_cancelled()
    }

    pub fn clear(&self) {
        self.bar.iter().for_each(|bar| bar.finish());
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;
    use hysteron_workflow::{ProgressSink, Silent};

    /// Where bars began.
    #[derive(Default)]
    struct Begins(Mutex<Vec<[usize; 2]>>);

    impl ProgressSink for Begins {
        fn start(&self, _: &str, length: usize, done: usize) -> Box<dyn hysteron_workflow::Progress> {
            self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push([done, length]);
            Box::new(Silent)
        }

        fn is_cancelled(&self) -> bool {
            false
        }

        fn print(&self, _: &str) {}
    }

    #[test]
    fn cells_that_were_found_do_not_count_for_the_remaining_time() {
        let begins = Begins::default();
        let context = Context { progress: &begins, command: String::new(), overwrite: false, watchdog: None };
        let mut bar = Bar::new(&context);
        for done in 0..3 {
            bar.show(&StudyProgress { cell: "found", done: [done, 9], training: None });
        }
        // One that took longer advances the bar.
        bar.since = Instant::now().checked_sub(2 * FOUND_WITHIN).unwrap_or_else(Instant::now);
        bar.show(&StudyProgress { cell: "computed", done: [3, 9], training: None });
        assert_eq!(begins.0.into_inner().unwrap_or_default(), [[0, 9], [1, 9], [2, 9]]);
    }
}

//! Options of the paper's networks, which both trainings take.

use hysteron_learn::{MOST_ROWS, WindowedOptions};

use crate::number;

/// The paper's design, as published or with less to learn from.
#[derive(Debug, clap::Args)]
pub struct PaperDesign {
    /// Only every Nth window of the paper's design; 1 is published
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = number::count::<MOST_ROWS>)]
    stride: usize,
    /// Windows of a step of the paper's design; 256 is published
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = number::count::<MOST_ROWS>)]
    batch: usize,
}

impl PaperDesign {
    /// The published options, with what was asked for instead.
    pub fn options(
        &self,
        published: WindowedOptions,
        [epochs, hidden]: [Option<usize>; 2],
        seed: u64,
    ) -> WindowedOptions {
        WindowedOptions {
            epochs: epochs.unwrap_or(published.epochs),
            hidden: hidden.unwrap_or(published.hidden),
            stride: self.stride,
            batch: self.batch,
            seed,
            ..published
        }
    }
}

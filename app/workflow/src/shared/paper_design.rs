//! Options of the paper's networks, which both trainings take.

use hysteron_learn::WindowOptions;

/// Which network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum DesignName {
    /// One cell update a sample
    #[cfg_attr(feature = "clap", value(alias = "stateful"))]
    Recurrent,
    /// As published
    Paper,
}

/// The paper's design, as published or with less data.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct PaperDesign {
    /// Only every Nth window of the paper's design; 1 is published
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 1, value_parser = crate::shared::number::count::<{ hysteron_learn::MAX_ROWS }>))]
    pub stride: usize,
    /// Windows of a step of the paper's design; 256 is published
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 256, value_parser = crate::shared::number::count::<{ hysteron_learn::MAX_ROWS }>))]
    pub batch: usize,
}

impl PaperDesign {
    /// The published options, with those that were given instead.
    pub fn options(
        &self,
        published: WindowOptions,
        [epochs, hidden]: [Option<usize>; 2],
        seed: u64,
    ) -> WindowOptions {
        WindowOptions {
            epochs: epochs.unwrap_or(published.epochs),
            hidden: hidden.unwrap_or(published.hidden),
            stride: self.stride,
            batch: self.batch,
            seed,
            ..published
        }
    }
}

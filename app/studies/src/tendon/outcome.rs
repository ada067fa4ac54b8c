//! The outcome of a study of tendon robots: what was measured, on which machine.

use hysteron_workflow::shared::outcome::MetricsFormat;
use hysteron_workflow::{COMMIT, Context};
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// The outcome of a study of tendon robots.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome<M> {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Name of the study.
    pub study: String,
    /// The machine that it ran on.
    pub machine: Machine,
    /// Numbers of the study.
    pub metrics: M,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

impl<M: Serialize + DeserializeOwned + JsonSchema> hysteron_workflow::shared::outcome::Outcome
    for Outcome<M>
{
}

impl<M> Outcome<M> {
    pub(super) fn new(study: &str, metrics: M, context: &Context) -> Self {
        Self {
            format: MetricsFormat,
            version: 1,
            study: study.to_owned(),
            machine: Machine::here(),
            metrics,
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

/// A machine: what times depend on.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Machine {
    /// Processor, where the system names it.
    pub cpu: Option<String>,
    /// Threads.
    pub threads: usize,
    /// Set of instructions that kernels use.
    pub isa: Option<String>,
}

impl Machine {
    fn here() -> Self {
        let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = info.lines().find_map(|line| line.strip_prefix("model name"));
        Self {
            cpu: model.map(|rest| rest.trim_start_matches(['\t', ' ', ':']).to_owned()),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            // `Isa(V4(V4 { … }))`: the name of the set.
            isa: format!("{:?}", hysteron_base::lanes::Isa::detect()).split('(').nth(1).map(str::to_owned),
        }
    }
}

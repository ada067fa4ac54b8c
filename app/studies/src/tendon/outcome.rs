//! The outcome of a study of tendon robots: what was measured, on which machine.

use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_report::verdict::Verdict;
use hysteron_workflow::shared::outcome::MetricsFormat;
use hysteron_workflow::{COMMIT, Context};
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::runner::table::aligned;

/// The outcome of a study of tendon robots.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome<M> {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Name of the study.
    pub study: String,
    /// Whether the result can be used.
    pub verdict: Verdict,
    /// The machine that it ran on.
    pub machine: Machine,
    /// Numbers of the study.
    pub metrics: M,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

impl<M: StudyMetrics> hysteron_workflow::shared::outcome::Outcome for Outcome<M> {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }

    fn lines(&self) -> Vec<String> {
        self.metrics.tables().iter().flat_map(StudyTable::lines).collect()
    }
}

/// The numbers of a study of tendon robots, and how they are assessed and shown.
pub trait StudyMetrics: Serialize + DeserializeOwned + JsonSchema {
    /// Title of the page.
    const TITLE: &'static str;
    /// Comparison that the study makes, for a reader of the page.
    const ABOUT: &'static str;

    /// Whether the result can be used.
    fn verdict(&self) -> Verdict;

    /// The numbers as tables, for the page and for a terminal.
    fn tables(&self) -> Vec<StudyTable>;

    /// Adds the figures to a page.
    ///
    /// # Errors
    /// A figure that cannot be drawn or written.
    fn show(&self, folder: &ReportFolder<'_>, page: &mut Page) -> anyhow::Result<()>;
}

/// A table with its title.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyTable {
    /// Title.
    pub title: String,
    /// Headings of its columns.
    pub headings: Vec<String>,
    /// Rows of cells.
    pub rows: Vec<Vec<String>>,
}

impl StudyTable {
    /// A table of these rows.
    pub(super) fn new<H: Into<String>>(
        title: impl Into<String>,
        headings: impl IntoIterator<Item = H>,
        rows: impl IntoIterator<Item = Vec<String>>,
    ) -> Self {
        Self {
            title: title.into(),
            headings: headings.into_iter().map(Into::into).collect(),
            rows: rows.into_iter().collect(),
        }
    }

    /// Lines of a terminal: an empty one, the title, headings and rows.
    fn lines(&self) -> Vec<String> {
        let cells = [std::slice::from_ref(&self.headings), &self.rows[..]].concat();
        [vec![String::new(), self.title.clone()], aligned(&cells)].concat()
    }

    /// Adds it to a page.
    pub(super) fn show(&self, page: &mut Page) {
        page.heading(&self.title);
        let headings: Vec<&str> = self.headings.iter().map(String::as_str).collect();
        page.table(&headings, self.rows.iter().cloned());
    }
}

impl<M: StudyMetrics> Outcome<M> {
    pub(super) fn new(study: &str, metrics: M, context: &Context) -> Self {
        Self {
            format: MetricsFormat,
            version: 1,
            study: study.to_owned(),
            verdict: metrics.verdict(),
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

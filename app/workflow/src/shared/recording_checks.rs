//! Checks of the recordings of every verb that fits, learns or scores, printed before it works.

use std::path::{Path, PathBuf};

use hysteron_arm_dynamics::Model;
use hysteron_base::checks::{CheckContext, Finding, Purpose, Severity, Warning, check_recordings};
use hysteron_base::{BadInput, Recording};
use hysteron_report::page::Page;
use hysteron_twin::Twin;
use serde::Serialize;

use crate::shared::inputs::Input;

/// Most findings that are printed one by one; the rest is in `metrics.json`.
const MAX_PRINTED: usize = 12;

/// Warnings about the recordings of a verb, none of them an error: `recording_warnings` of its result, and a
/// section of its page.
#[derive(Debug, Serialize)]
#[serde(transparent)]
pub(crate) struct Findings(Vec<Warning>);

/// Checks recordings that were read.
///
/// # Errors
/// `BadInput` for the first finding that cannot be right, after all have been printed.
pub(crate) fn of_inputs(inputs: &[Input], checks: &CheckContext) -> anyhow::Result<Findings> {
    let named = inputs.iter().map(|input| (input.name.as_str(), &input.recording)).collect::<Vec<_>>();
    of_named(&named, checks)
}

/// Checks recordings that are not read yet.
///
/// # Errors
/// As [`of_inputs`], and those of reading.
pub(crate) fn of_files(paths: &[PathBuf], checks: &CheckContext) -> anyhow::Result<Findings> {
    let recordings = paths.iter().map(Recording::read).collect::<Result<Vec<_>, _>>()?;
    of_recordings(paths, &recordings, checks)
}

/// Checks the recordings of these files.
///
/// # Errors
/// As [`of_inputs`].
pub(crate) fn of_recordings(
    paths: &[PathBuf],
    recordings: &[Recording],
    checks: &CheckContext,
) -> anyhow::Result<Findings> {
    let names: Vec<String> = paths.iter().map(|path| name_of(path)).collect();
    let named = names.iter().map(String::as_str).zip(recordings).collect::<Vec<_>>();
    of_named(&named, checks)
}

/// Checks recordings under their names.
///
/// # Errors
/// As [`of_inputs`].
pub(crate) fn of_named(named: &[(&str, &Recording)], checks: &CheckContext) -> anyhow::Result<Findings> {
    let found = check_recordings(named, checks);
    let groups = grouped(&found);
    for (first, others) in groups.iter().take(MAX_PRINTED) {
        tracing::warn!("{}", line(first, *others));
    }
    if groups.len() > MAX_PRINTED {
        tracing::warn!("and {} kinds of findings more: hysteron check shows all", groups.len() - MAX_PRINTED);
    }
    match found.iter().find(|found| found.severity == Severity::Error) {
        Some(error) => Err(refused(error).into()),
        None => Ok(Findings(found)),
    }
}

/// A finding that cannot be right, as an error.
pub(crate) fn refused(error: &Warning) -> BadInput {
    error.clone().into_bad_input("a recording that can be right")
}

/// Findings of one kind and channel, each with the number of other recordings that show it too.
fn grouped(found: &[Warning]) -> Vec<(&Warning, usize)> {
    let mut groups: Vec<(&Warning, usize)> = Vec::new();
    for one in found {
        let is_same = |(first, _): &&mut (&Warning, usize)| {
            first.kind == one.kind && first.channel == one.channel && first.kind != Finding::CopyOfRecording
        };
        match groups.iter_mut().find(is_same) {
            Some((_, others)) => *others += 1,
            None => groups.push((one, 0)),
        }
    }
    groups
}

fn line(first: &Warning, others: usize) -> String {
    match others {
        0 => first.to_string(),
        1 => format!("{first}; so does one recording more"),
        _ => format!("{first}; so do {others} recordings more"),
    }
}

impl Findings {
    /// The findings.
    pub fn warnings(&self) -> &[Warning] {
        &self.0
    }

    /// The findings, as a result holds them.
    pub fn into_warnings(self) -> Vec<Warning> {
        self.0
    }

    /// Adds them to a page, if there are any.
    pub fn show(&self, page: &mut Page) {
        show(&self.0, page);
    }
}

/// Adds warnings about recordings to a page, if there are any.
pub(crate) fn show(warnings: &[Warning], page: &mut Page) {
    if !warnings.is_empty() {
        page.heading("Warnings about the recordings");
        page.table(&HEADINGS, warnings.iter().map(|one| cells(one).to_vec()));
    }
}

/// Headings of [`cells`].
pub(crate) const HEADINGS: [&str; 5] = ["Recording", "Channel", "Rows", "Finding", "Hint"];

/// A finding as cells of a table.
pub(crate) fn cells(found: &Warning) -> [String; 5] {
    let recording = if found.recording.is_empty() { "all".to_owned() } else { found.recording.clone() };
    [recording, found.channel.clone(), found.rows_text(), found.finding.clone(), found.hint.clone()]
}

/// File name without its ending.
pub(crate) fn name_of(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Context that a twin gives to the checks of its robot's recordings.
pub(crate) fn context_of(twin: &Twin, purpose: Purpose) -> CheckContext<'static> {
    CheckContext { body_length: Some(body_length(twin)), ..CheckContext::new(purpose) }
}

/// Length of the body from its far end to its tip, along its tendons where these are longer [m].
pub(crate) fn body_length(twin: &Twin) -> f64 {
    let tip = twin.tip_of(&twin.rest());
    let distance = |node: &[f64; 4]| (0..3).map(|c| (node[c] - tip[c]).powi(2)).sum::<f64>().sqrt();
    let straight = twin.body.rest.iter().map(distance).fold(0.0, f64::max);
    twin.cables.rest_lengths[..twin.n_primary].iter().copied().fold(straight, f64::max)
}

/// Ranges of the joints of an arm [rad or m].
pub(crate) fn joint_ranges(model: &Model) -> Vec<Option<[f64; 2]>> {
    model.joints().iter().map(|joint| joint.drive.range).collect()
}

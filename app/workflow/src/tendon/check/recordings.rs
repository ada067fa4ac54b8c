//! The checks of recordings as one table.

use std::path::{Path, PathBuf};

use hysteron_base::checks::{CheckContext, Purpose, Severity, Warning, check_recordings};
use hysteron_base::{BadInput, Recording};

use super::outcome::{Described, Outcome, RecordingFindings, SceneSummary};
use super::refused::Refused;
use crate::shared::outcome::Printed;
use crate::shared::recording_checks::{name_of, refused};
use crate::{Context, shared::inputs};

/// Checks the recordings in `paths`, against a scene and the length of its body [m] where there is one.
pub(super) fn check(
    paths: &[&PathBuf],
    (scene, body_length): (Option<SceneSummary>, Option<f64>),
    context: &Context,
) -> anyhow::Result<Outcome> {
    let named: Vec<PathBuf> = paths.iter().map(|path| (*path).clone()).collect();
    let files = inputs::files(&named)?;
    let (mut read, mut unreadable) = (Vec::new(), Vec::new());
    for path in &files {
        match crate::shared::memory::recording(path) {
            Ok(recording) => read.push((name_of(path), path, recording)),
            Err(hysteron_base::Error::BadInput(bad)) => unreadable.push((path, bad)),
            Err(other) => return Err(other.into()),
        }
    }
    let checks = CheckContext { body_length, ..CheckContext::new(Purpose::Fit) };
    let named: Vec<(&str, &Recording)> =
        read.iter().map(|(name, _, recording)| (name.as_str(), recording)).collect();
    let found = check_recordings(&named, &checks);
    let described: Vec<Described> =
        read.iter().map(|(name, path, recording)| Described::of(name, path, recording)).collect();
    described.iter().for_each(|one| one.print(context));
    print(&found, &unreadable, context);
    let of_severity = |severity| found.iter().filter(|one| one.severity == severity).count();
    let n_errors = of_severity(Severity::Error) + unreadable.len();
    let outcome = Outcome::Recordings(RecordingFindings {
        recordings: described,
        unreadable: unreadable
            .iter()
            .map(|(path, bad)| [path.display().to_string(), bad.to_string()])
            .collect(),
        warnings: of_severity(Severity::Warning),
        errors: n_errors,
        findings: found.clone(),
        scene,
    });
    let first = unreadable.into_iter().map(|(_, bad)| bad);
    let errors = found.iter().filter(|one| one.severity == Severity::Error).map(refused);
    match first.chain(errors).next() {
        Some(first) => Err(Refused { outcome: Printed::new(&outcome)?, n_errors, first }.into()),
        None => Ok(outcome),
    }
}

impl Described {
    fn of(name: &str, path: &Path, recording: &Recording) -> Self {
        let time = recording.time();
        Self {
            name: name.to_owned(),
            path: path.to_owned(),
            samples: recording.n_samples(),
            duration_s: time[time.len() - 1] - time[0],
            rate_hz: recording.rate_hz(),
            channels: recording.channels().len(),
        }
    }

    fn print(&self, context: &Context) {
        let rate = self.rate_hz.map_or_else(|| "uneven steps".to_owned(), |rate| format!("{rate:.2} Hz"));
        context.print(format_args!(
            "{}: {} rows, {:.2} s, {rate}, {} channels",
            self.name, self.samples, self.duration_s, self.channels
        ));
    }
}

/// One line for each finding, its hint below.
fn print(found: &[Warning], unreadable: &[(&PathBuf, BadInput)], context: &Context) {
    context.print("");
    for (_, bad) in unreadable {
        context.print(format_args!("error    {bad}"));
    }
    if found.is_empty() {
        if unreadable.is_empty() {
            context.print("no warnings");
        }
        return;
    }
    let cell = |one: &Warning| {
        let recording = if one.recording.is_empty() { "all" } else { &one.recording };
        [recording.to_owned(), one.channel.clone(), one.rows_text()]
    };
    let cells: Vec<[String; 3]> = found.iter().map(cell).collect();
    let headings = ["recording", "channel", "rows"];
    let width = |k: usize| {
        let widest = cells.iter().map(|row| row[k].chars().count()).max().unwrap_or(0);
        widest.max(headings[k].len())
    };
    let [recording, channel, rows] = [0, 1, 2].map(width);
    context.print(format_args!(
        "         {:<recording$}  {:<channel$}  {:<rows$}  finding",
        headings[0], headings[1], headings[2]
    ));
    for (one, [name, of, at]) in found.iter().zip(&cells) {
        let severity = if one.severity == Severity::Error { "error" } else { "warning" };
        context.print(format_args!(
            "{severity:<8} {name:<recording$}  {of:<channel$}  {at:<rows$}  {}",
            one.finding
        ));
        context.print(format_args!(
            "{:>indent$}{}",
            "",
            one.hint,
            indent = 9 + recording + channel + rows + 6
        ));
    }
}

//! The recipe: recordings that followed a target, their scores, their report.

use std::path::{Path, PathBuf};

use hysteron_base::BadInput;
use hysteron_base::checks::{CheckContext, Purpose};
use hysteron_base::schema::text as base_text;
use hysteron_control::TargetPath;
use hysteron_control::path::is_untimed;
use hysteron_control::tracking::{CurvePart, TipOrigin, TrackedTip, score};
use hysteron_report::folder::ReportFolder;

use super::options::Options;
use super::outcome::Outcome;
use super::page;
use super::table::{Commanded, Row, ScoredRecordings, cells, headings};
use crate::shared::inputs::{self, Input};
use crate::shared::outputs::Outputs;
use crate::shared::recording_checks;
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    let outcome = run_commanded(options, None, context)?;
    options.out.iter().for_each(|folder| context.reported(folder));
    Ok(outcome)
}

/// Runs the verb for recordings of strokes with metadata.
///
/// # Errors
/// Those of [`run`].
pub fn run_commanded(
    options: &Options,
    commanded: Option<&Commanded>,
    context: &Context,
) -> anyhow::Result<Outcome> {
    let target = TargetPath::open(&options.target)?;
    let part = if options.whole { CurvePart::Whole } else { CurvePart::AtTheSameTimes };
    let origin = if options.relative_to_rest { TipOrigin::Rest } else { TipOrigin::Frame };
    let mut results = Vec::new();
    for (name, paths) in named(&options.results)? {
        results.push((name, inputs::read_paths(&paths)?));
    }
    let read = results.iter().flat_map(|(_, inputs)| inputs.iter().map(|input| &input.path));
    let outputs = Outputs::reading(read).target(&options.target)?;
    let _lock = outputs.report("--out", options.out.as_deref()).check(context)?;
    let all = results.iter().flat_map(|(_, inputs)| inputs);
    let named = all.map(|input| (input.name.as_str(), &input.recording)).collect::<Vec<_>>();
    let findings = recording_checks::of_named(&named, &CheckContext::new(Purpose::Score))?;
    let mut rows = Vec::new();
    for (name, inputs) in results {
        rows.extend(result(name, self::rows(&target, inputs, part, origin)?));
    }
    let shown = ScoredRecordings { target: &target, rows: &rows, commanded, findings: &findings };
    let outcome = Outcome::new(&shown, context);
    if let Some(folder) = &options.out {
        page::write(&ReportFolder { path: folder, png: options.png }, &shown, &outcome)?;
    }
    print(&rows, context);
    Ok(outcome)
}

/// The name of a result, and the recordings that are its repeats.
type NamedRecordings = (Option<String>, Vec<PathBuf>);

/// The recordings of each result, by its name; one without a name where none has one.
fn named(typed: &[String]) -> Result<Vec<NamedRecordings>, BadInput> {
    let mut results: Vec<NamedRecordings> = Vec::new();
    for typed in typed {
        // A file may have such a name.
        let split = if Path::new(typed).exists() { None } else { typed.split_once('=') };
        let (name, path) = match split {
            Some((name, path)) => (Some(base_text("NAME", name.to_owned())?), path),
            None => (None, typed.as_str()),
        };
        match results.iter_mut().find(|(known, _)| *known == name) {
            Some((_, paths)) => paths.push(path.into()),
            None => results.push((name, vec![path.into()])),
        }
    }
    if results.len() > 1 && results.iter().any(|(name, _)| name.is_none()) {
        let found = results.iter().filter_map(|(name, _)| name.clone()).collect::<Vec<_>>().join(", ");
        return Err(BadInput::new("recordings", "a name for all or for none, as NAME=REC", found));
    }
    Ok(results)
}

/// Recordings as repeats of a result, if it has a name.
fn result(name: Option<String>, rows: Vec<Row>) -> Vec<Row> {
    let Some(result) = name else { return rows };
    let is_alone = rows.len() == 1;
    let of = |row: Row| {
        let name = if is_alone { result.clone() } else { format!("{result}, {}", row.name) };
        Row { name, result: Some(result.clone()), ..row }
    };
    rows.into_iter().map(of).collect()
}

/// Measures recordings of a target.
pub fn rows(
    target: &TargetPath,
    inputs: Vec<Input>,
    part: CurvePart,
    origin: TipOrigin,
) -> Result<Vec<Row>, BadInput> {
    let row = |input: Input| {
        // Without times there is nothing but the geometry.
        let part = if is_untimed(&input.recording) { CurvePart::Whole } else { part };
        let tracked = TrackedTip::new(target, &input.recording, part, origin)
            .map_err(|bad| bad.within(input.path.display()))?;
        Ok(Row {
            name: input.name,
            result: None,
            sha256: input.hash,
            source: input.recording.meta().source.clone(),
            score: score(target, &tracked),
            tracked,
        })
    };
    inputs.into_iter().map(row).collect()
}

/// Width of a terminal as it opens [characters].
const TERMINAL: usize = 80;

/// Prints the table in columns: where it is wider than a terminal, with a line for each number.
fn print(rows: &[Row], context: &Context) {
    let headings = headings().into_iter().map(str::to_owned).collect();
    let mut table: Vec<Vec<String>> = [headings].into_iter().chain(cells(rows)).collect();
    let width = |table: &[Vec<String>]| -> usize {
        (0..table[0].len())
            .map(|column| table.iter().map(|row| row[column].chars().count() + 2).max().unwrap_or(0))
            .sum()
    };
    let turned: Vec<Vec<String>> =
        (0..table[0].len()).map(|column| table.iter().map(|row| row[column].clone()).collect()).collect();
    if width(&table) > TERMINAL && width(&turned) < width(&table) {
        table = turned;
    }
    let width = |column: usize| table.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..table[0].len()).map(width).collect();
    for row in &table {
        let numbers = row.iter().zip(&widths).skip(1).map(|(cell, width)| format!("  {cell:>width$}"));
        context.print(format!("{:<width$}{}", row[0], numbers.collect::<String>(), width = widths[0]));
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    fn names(typed: &[&str]) -> Result<Vec<(Option<String>, usize)>, BadInput> {
        let typed: Vec<String> = typed.iter().map(|&word| word.to_owned()).collect();
        Ok(named(&typed)?.into_iter().map(|(name, paths)| (name, paths.len())).collect())
    }

    #[test]
    fn repeats_have_one_name_and_rivals_their_own() {
        assert_eq!(names(&["a.csv", "b.csv"]).unwrap(), [(None, 2)]);
        let methods = names(&["twin=a.csv", "network=b.csv", "twin=c.csv"]).unwrap();
        assert_eq!(methods, [(Some("twin".to_owned()), 2), (Some("network".to_owned()), 1)]);
        assert_eq!(names(&["twin=a.csv", "b.csv"]).unwrap_err().place, "recordings");
        assert_eq!(names(&["=a.csv"]).unwrap_err().place, "NAME");
    }
}

//! The import, step by step: files and map, recordings, what arms need, files, page.

use std::path::{Path, PathBuf};

use hysteron_arm_estimation::{
    ArmProperties, ArmRecording, BadRows, CURRENTS_BY, ColumnMap, UnitCheck, with_arm,
};
use hysteron_base::import::{self, Assembled, Request};
use hysteron_base::{BadInput, Recording, RowFilter, file};
use hysteron_report::folder::ReportFolder;

use super::options::Options;
use super::outcome::{Imported, ImportedRecording, Outcome, Proposed, is_of_arm, out_of, verdict};
use super::page;
use crate::arm::{drive, file_of, meta};
use crate::shared::outcome::MetricsFormat;
use crate::shared::outputs::Outputs;
use crate::{COMMIT, Context, WorkflowError};

/// Channels that the console names.
const MAX_NAMED: usize = 24;

/// Runs the verb.
///
/// # Errors
/// Bad input; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(import_or_propose(options, context)?)
}

fn import_or_propose(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    if let Some(out) = &options.propose {
        return propose(options, out, context);
    }
    let Some(out) = &options.out else {
        return Err(BadInput::new("--out", "a recording to write, .csv or .parquet", "nothing").into());
    };
    let robot = |text: &str| options.robot_options.model_of_any_mass(text, context);
    let known_model = options.model.as_deref().map(robot).transpose()?;
    let known_drive = options.drive.as_deref().map(drive).transpose()?;
    let columns = options.map.as_deref().map(ColumnMap::named).transpose()?;
    let known = ArmProperties {
        model: known_model.as_ref(),
        unit_check: if options.accept_units { UnitCheck::Accept } else { UnitCheck::Refuse },
        drive: known_drive.as_ref(),
    };
    let request = Request {
        columns,
        rate_hz: options.rate,
        filter: options.filter.as_deref().map(|text| RowFilter::parse("--where", text)).transpose()?,
        episode: options.episodes.clone(),
        bad_rows: if options.leave_out_bad_rows { BadRows::LeaveOut } else { BadRows::Refuse },
    };
    let read =
        import::read(&options.sources, &request, known.described(meta(context, "imported recording")))?;
    let (imported, joints) = checked(read, &known, &options.sources[0])?;
    let files: Vec<PathBuf> = (0..imported.len()).map(|k| out_of(out, k, imported.len())).collect();
    let named = [&options.map, &options.drive, &options.model].into_iter().flatten();
    let reads = Outputs::reading(&options.sources).and(named.filter_map(|text| file_of(text)));
    let outputs = files.iter().fold(reads, |outputs, path| outputs.file("--out", path));
    let _lock = outputs.report("--figures", options.figures.as_deref()).check(context)?;
    for (path, one) in files.iter().zip(&imported) {
        one.recording.write(path)?;
    }
    let outcome = outcome(&files, &imported, joints, context);
    print(&outcome, &imported, (known.drive.is_some(), out), context);
    if let Some(folder) = &options.figures {
        let recordings: Vec<Recording> = imported.into_iter().map(|one| one.recording).collect();
        page::write(&ReportFolder { path: folder, png: options.png }, &outcome, &recordings)?;
        context.reported(folder);
    }
    Ok(Outcome::Imported(outcome))
}

/// The recordings of an arm with its known properties, or those of a tendon robot unchanged; and the number of joints.
fn checked(
    read: Vec<Assembled>,
    known: &ArmProperties,
    source: &Path,
) -> anyhow::Result<(Vec<Assembled>, usize)> {
    let mut joints = 0;
    let mut imported = Vec::with_capacity(read.len());
    for one in read {
        if !is_of_arm(&one.recording) {
            if known.model.is_some() || known.drive.is_some() {
                let option = if known.model.is_some() { "--model" } else { "--drive" };
                return Err(BadInput::new(option, "the recording of an arm, with q_1_rad", "none")
                    .hint("leave it out, or map the columns of the joints")
                    .into());
            }
            imported.push(one);
            continue;
        }
        let recording = with_arm(one.recording, known).map_err(|bad| bad.within(source.display()))?;
        joints = ArmRecording::of(&recording)?.joints.len();
        imported.push(Assembled { recording, ..one });
    }
    Ok((imported, joints))
}

fn outcome(files: &[PathBuf], imported: &[Assembled], joints: usize, context: &Context) -> Imported {
    let recordings: Vec<ImportedRecording> =
        files.iter().zip(imported).map(|(path, one)| ImportedRecording::of(path, one)).collect();
    let sum = |count: fn(&ImportedRecording) -> usize| recordings.iter().map(count).sum();
    Imported {
        format: MetricsFormat,
        version: 1,
        verdict: verdict(&recordings),
        columns: imported.first().map_or_else(String::new, |one| one.columns.clone()),
        joints,
        rows: sum(|one| one.rows),
        gaps: sum(|one| one.gaps),
        left_out: sum(|one| one.left_out),
        command: context.command.clone(),
        commit: COMMIT.to_owned(),
        recordings,
    }
}

fn print(outcome: &Imported, imported: &[Assembled], (has_drive, out): (bool, &Path), context: &Context) {
    let print = |line: String| context.print(&line);
    let Some(first) = imported.first() else { return };
    if let Some(flaw) = imported.iter().find_map(|one| one.first_left_out.as_ref()) {
        print(format!("{} rows skipped, the first: {flaw}", outcome.left_out));
    }
    let has_currents = |one: &Assembled| !one.recording.meta().extra.contains_key(CURRENTS_BY);
    if has_drive && imported.iter().any(has_currents) {
        print("the file has currents: they are kept, --drive has no effect".to_owned());
    }
    let whose = if outcome.joints > 0 { format!("{} joints", outcome.joints) } else { "channels".to_owned() };
    let channels = first.recording.channels();
    let mut names: Vec<&str> = channels.iter().take(MAX_NAMED).map(|c| c.name.as_str()).collect();
    if channels.len() > MAX_NAMED {
        names.push("…");
    }
    print(format!("{whose} as {}: {}", outcome.columns, names.join(", ")));
    let one = &outcome.recordings[0];
    let place = match outcome.recordings.len() {
        1 => out.display().to_string(),
        n => format!("{n} recordings, {} and on", one.out.display()),
    };
    print(format!("{} rows at {}, {} of them gaps: {place}", outcome.rows, one.rate(), outcome.gaps));
    print(outcome.verdict.clone());
}

/// Writes the map that the program proposes.
fn propose(options: &Options, out: &Path, context: &Context) -> anyhow::Result<Outcome> {
    let source = &options.sources[0];
    let text = import::propose_for(source)?;
    if out == Path::new("-") {
        context.print(text.trim_end());
    } else {
        let _lock = Outputs::reading(&options.sources).file("--propose", out).check(context)?;
        file::write_bytes(out, &text)?;
        context.print(format!("map to edit: {}", out.display()));
    }
    Ok(Outcome::Proposed(Proposed { map: text, out: out.to_owned() }))
}

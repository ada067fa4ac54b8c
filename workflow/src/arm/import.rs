//! `hysteron arm import`: recordings of arms from the files of other programs.

use std::path::PathBuf;

use hysteron_arm::{BadRows, CURRENTS_BY, Columns, ImportOptions, Quantity, Recorded, UnitCheck, import};
use hysteron_base::{BadInput, Filter, json};
use serde_json::Value;

use crate::Caller;
use crate::outputs::Outputs;

/// Import a recording of an arm from another program's file
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Table, log or folder of lists
    pub source: PathBuf,
    /// Where the recording goes, .csv or .parquet
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub out: PathBuf,
    /// What the columns are: a file of TOML or a built-in name [default: by the names of the columns]
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMNS"))]
    pub columns: Option<String>,
    /// Robot whose joints these are: a file of URDF or MJCF, or a built-in name
    #[cfg_attr(feature = "clap", arg(long, value_name = "MODEL"))]
    pub model: Option<String>,
    /// Rate to resample to [default: the file's own]
    #[cfg_attr(feature = "clap", arg(long, value_name = "HZ", allow_negative_numbers = true))]
    pub rate: Option<f64>,
    /// Only rows in which a column has this value
    #[cfg_attr(feature = "clap", arg(long = "where", value_name = "COLUMN=VALUE"))]
    pub filter: Option<String>,
    /// Leave out rows that cannot be read, up to a tenth of all, and mark the gap
    #[cfg_attr(feature = "clap", arg(long))]
    pub leave_out_bad_rows: bool,
    /// Take numbers that look as if they had another unit
    #[cfg_attr(feature = "clap", arg(long))]
    pub accept_units: bool,
    /// Compute currents that the file leaves out by the voltage equation of this drive, a name or a file of TOML, which every joint has
    #[cfg_attr(feature = "clap", arg(long, value_name = "DRIVE"))]
    pub drive: Option<String>,
}

/// Carries out the verb.
///
/// # Errors
/// Bad input; files that cannot be written.
pub fn run(options: &Options, caller: &Caller) -> anyhow::Result<Value> {
    let model = options.model.as_deref().map(super::model).transpose()?;
    let named = [&options.columns, &options.drive].into_iter().flatten();
    let outputs = Outputs::reading([&options.source]).and(named.filter_map(|text| super::file_of(text)));
    let _claim = outputs.file("--out", &options.out).check(caller)?;
    let drive = options.drive.as_deref().map(super::drive).transpose()?;
    let wanted = ImportOptions {
        columns: options.columns.as_deref().map(Columns::named).transpose()?,
        model: model.as_ref(),
        rate_hz: options.rate,
        filter: options.filter.as_deref().map(filter).transpose()?,
        bad_rows: if options.leave_out_bad_rows { BadRows::LeaveOut } else { BadRows::Refuse },
        unit_check: if options.accept_units { UnitCheck::Accept } else { UnitCheck::Refuse },
        drive: drive.as_ref(),
    };
    let imported = import(&options.source, &wanted, super::meta(caller, "imported recording of an arm"))?;
    let recording = &imported.recording;
    recording.write(&options.out)?;
    if let Some(first) = &imported.first_left_out {
        caller.say(format_args!("{} rows left out, the first: {first}", imported.n_left_out));
    }
    if drive.is_some() && !recording.meta().extra.contains_key(CURRENTS_BY) {
        caller.say("the file has currents: they stay as they are, --drive changes nothing");
    }
    let recorded = Recorded::of(recording)?;
    let has = |quantity: &&Quantity| recorded.joints[0].of(**quantity).is_some();
    let names: Vec<String> = Quantity::ALL
        .iter()
        .filter(has)
        .map(|q| recorded.joints[0].name_of(*q, 0).replace("_1_", "_k_"))
        .collect();
    caller.say(format_args!(
        "{} joints as {}: {}",
        recorded.joints.len(),
        imported.columns,
        names.join(", ")
    ));
    let rate = recording.rate_hz().map_or_else(String::new, |rate| format!(" at {rate:.3} Hz"));
    let n_gaps = recording.gap().iter().filter(|gap| **gap).count();
    caller.say(format_args!(
        "{} rows{rate}, {n_gaps} of them gaps: {}",
        recording.n_samples(),
        options.out.display()
    ));
    Ok(json!({
        "joints": recorded.joints.len(), "columns": imported.columns.to_string(), "channels": names,
        "rows": recording.n_samples(), "gaps": n_gaps, "left_out": imported.n_left_out, "out": options.out,
    }))
}

fn filter(text: &str) -> Result<Filter, BadInput> {
    match text.split_once('=') {
        Some((column, value)) if !column.trim().is_empty() => {
            Ok(Filter { column: column.trim().to_owned(), value: value.trim().to_owned() })
        }
        _ => Err(BadInput::new("--where", "COLUMN=VALUE", format!("\"{text}\""))),
    }
}

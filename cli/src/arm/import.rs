//! `hysteron arm import`: recordings of arms from the files of other programs.

use std::path::PathBuf;

use hysteron_arm::{BadRows, Columns, ImportOptions, Quantity, Recorded, UnitCheck, import};
use hysteron_base::{BadInput, Filter};

use crate::terminal::say;
use hysteron_workflow::Caller;
use hysteron_workflow::outputs::Outputs;

const HELP: &str = "\
SOURCE is a table (.csv, .txt, .tsv, .npz, .npy, .parquet), a log of bam (.json) or a folder of lists. Which column is what says a file \
of TOML, or one that is built in: bam-dynamixel, bam-feetech, bam-swing, baxter, flobaroid, franka-friction, lerobot-deg, \
lerobot-rad, nad-omx, nad-panda, nad-so101, panda-gaz, ur10e. Most are found by the names of the columns; those of LeRobot and \
of the UR10e have to be named.

A file of columns:

  format = \"hysteron-columns\"
  version = 1
  joint_names = [\"shoulder\", \"elbow\"]
  missing = [-999]                                # numbers that stand for no value
  [columns]
  time_ms = 1                                     # by number, or by name
  \"q_*_deg\" = [\"shoulder_angle\", \"elbow_angle\"]   # joint 1, joint 2; the ending is the unit in the file
  \"current_*_ma\" = { columns = \"i*\", times = 2.69 }

Channels of a joint: q_k_rad, dq_k_rad_s, ddq_k_rad_s2, tau_k_n_m, goal_k_rad, current_k_a, voltage_k_v, temperature_k_degc, \
pwm_k_ratio (and q_k_m, … where it slides); of the tip: force_x_n, force_y_n, force_z_n. Times start at zero. Uneven ones are \
resampled onto a fixed rate; what was missing is interpolated and marked in gap.

Examples:
  hysteron arm import log.json --out swing.parquet
  hysteron arm import robot.csv --columns ur10e --out run.parquet
  hysteron arm import episode.parquet --columns lerobot-deg --where episode_index=3 --model so101 --out episode.csv

Exit codes: 0 done, 1 failed, 2 bad input (nothing is written).";

/// Import a recording of an arm from another program's file
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// Table, log or folder of lists
    source: PathBuf,
    /// Where the recording goes, .csv or .parquet
    #[arg(long, value_name = "REC")]
    out: PathBuf,
    /// What the columns are: a file of TOML or a built-in name [default: by the names of the columns]
    #[arg(long, value_name = "COLUMNS")]
    columns: Option<String>,
    /// Robot whose joints these are: a file of URDF or MJCF, or a built-in name
    #[arg(long, value_name = "MODEL")]
    model: Option<String>,
    /// Rate to resample to [default: the file's own]
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    rate: Option<f64>,
    /// Only rows in which a column has this value
    #[arg(long = "where", value_name = "COLUMN=VALUE")]
    filter: Option<String>,
    /// Leave out rows that cannot be read, up to a tenth of all, and mark the gap
    #[arg(long)]
    leave_out_bad_rows: bool,
    /// Take numbers that look as if they had another unit
    #[arg(long)]
    accept_units: bool,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments, caller: &Caller) -> anyhow::Result<()> {
    let model = arguments.model.as_deref().map(super::model).transpose()?;
    let outputs =
        Outputs::reading([&arguments.source]).and(arguments.columns.as_deref().filter(|c| c.contains('.')));
    let _claim = outputs.file("--out", &arguments.out).check(caller)?;
    let options = ImportOptions {
        columns: arguments.columns.as_deref().map(Columns::named).transpose()?,
        model: model.as_ref(),
        rate_hz: arguments.rate,
        filter: arguments.filter.as_deref().map(filter).transpose()?,
        bad_rows: if arguments.leave_out_bad_rows { BadRows::LeaveOut } else { BadRows::Refuse },
        unit_check: if arguments.accept_units { UnitCheck::Accept } else { UnitCheck::Refuse },
    };
    let imported = import(&arguments.source, &options, super::meta("imported recording of an arm"))?;
    let recording = &imported.recording;
    recording.write(&arguments.out)?;
    if let Some(first) = &imported.first_left_out {
        say(format_args!("{} rows left out, the first: {first}", imported.n_left_out));
    }
    let recorded = Recorded::of(recording)?;
    let has = |quantity: &&Quantity| recorded.joints[0].of(**quantity).is_some();
    let names: Vec<String> = Quantity::ALL
        .iter()
        .filter(has)
        .map(|q| recorded.joints[0].name_of(*q, 0).replace("_1_", "_k_"))
        .collect();
    say(format_args!("{} joints as {}: {}", recorded.joints.len(), imported.columns, names.join(", ")));
    let rate = recording.rate_hz().map_or_else(String::new, |rate| format!(" at {rate:.3} Hz"));
    let n_gaps = recording.gap().iter().filter(|gap| **gap).count();
    say(format_args!(
        "{} rows{rate}, {n_gaps} of them gaps: {}",
        recording.n_samples(),
        arguments.out.display()
    ));
    Ok(())
}

fn filter(text: &str) -> Result<Filter, BadInput> {
    match text.split_once('=') {
        Some((column, value)) if !column.trim().is_empty() => {
            Ok(Filter { column: column.trim().to_owned(), value: value.trim().to_owned() })
        }
        _ => Err(BadInput::new("--where", "COLUMN=VALUE", format!("\"{text}\""))),
    }
}

//! Recordings of arms from the files of other programs.
//!
//! The files are read by [`hysteron_base::import`]; this module adds what is specific to arms: joints are counted and named,
//! numbers in an unlikely unit are suspected, and currents that a file leaves out come from the voltage equation of its drives,
//! where these are known.

mod drive;

use std::path::Path;

use hysteron_actuator::CatalogueDrive;
use hysteron_base::checks::check_joint_units;
use hysteron_base::import::{Assembled, Request, read};
pub use hysteron_base::import::{BadRows, ColumnMap, POSITION_GAIN};
use hysteron_base::{BadInput, Metadata, Recording, Result, RowFilter};

use crate::ArmRecording;
pub use drive::CURRENTS_BY;
pub use drive::position_gain;
use hysteron_arm_dynamics::Model;

/// Treatment of numbers that look as if they had another unit than the one stated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum UnitCheck {
    /// The file is refused.
    #[default]
    Refuse,
    /// They are taken as they are.
    Accept,
}

/// How a file is read.
#[derive(Debug, Clone, Default)]
pub struct ImportOptions<'a> {
    /// Meaning of the columns; found among the built-in maps where there is none.
    pub columns: Option<ColumnMap>,
    /// Rate of the recording; that of the file where there is none [Hz].
    pub rate_hz: Option<f64>,
    /// The rows to read.
    pub filter: Option<RowFilter>,
    /// Treatment of rows that cannot be read.
    pub bad_rows: BadRows,
    /// Known properties of the arm.
    pub arm: ArmProperties<'a>,
}

/// Known properties of an arm whose recording is imported.
#[derive(Debug, Clone, Copy, Default)]
pub struct ArmProperties<'a> {
    /// The robot, whose joints name those of the recording and must be as many.
    pub model: Option<&'a Model>,
    /// Treatment of numbers that look as if they had another unit.
    pub unit_check: UnitCheck,
    /// The drive of every joint, by which currents are computed that the file leaves out.
    pub drive: Option<&'a CatalogueDrive>,
}

/// A recording, and what was done to get it.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmImport {
    /// Channels in SI at a fixed rate, from time zero; see [`crate::ArmRecording`].
    pub recording: Recording,
    /// The map: a name or a file.
    pub columns: String,
    /// Rows of the file that were skipped.
    pub n_left_out: usize,
    /// Why, of the first one.
    pub first_left_out: Option<BadInput>,
}

/// Reads `path` as a recording of an arm, see [`read`]. `meta` is its provenance; the source, the joints and the first time are
/// added.
///
/// # Errors
/// `BadInput` naming the file, the row and the column: as [`read`], and as [`with_arm`].
pub fn import(path: &Path, options: &ImportOptions, meta: Metadata) -> Result<ArmImport> {
    let request = Request {
        columns: options.columns.clone(),
        rate_hz: options.rate_hz,
        filter: options.filter.clone(),
        episode: None,
        bad_rows: options.bad_rows,
    };
    let mut episodes = read(&[path.to_owned()], &request, options.arm.described(meta))?;
    let place = path.display().to_string();
    if episodes.len() > 1 {
        let bad = BadInput::new(place, "one episode", format!("{}", episodes.len()));
        return Err(bad.hint("--where COLUMN=VALUE takes one").into());
    }
    let Some(Assembled { recording, columns, n_left_out, first_left_out, .. }) = episodes.pop() else {
        return Err(BadInput::new(place, "an episode", "none").into());
    };
    let recording = with_arm(recording, &options.arm).map_err(|bad| bad.within(place))?;
    Ok(ArmImport { recording, columns, n_left_out, first_left_out })
}

impl ArmProperties<'_> {
    /// Metadata with the robot's name and joints.
    pub fn described(&self, mut meta: Metadata) -> Metadata {
        if let Some(model) = self.model {
            let names: Vec<&str> = model.joints().iter().map(|joint| joint.name.as_str()).collect();
            meta.extra.insert("robot".to_owned(), model.name().to_owned());
            meta.extra.insert("joint_names".to_owned(), names.join(", "));
        }
        meta
    }
}

/// The recording of an arm, checked by its known properties, with currents computed from the drive.
///
/// # Errors
/// `BadInput` for joints that differ in number between quantities or from the model's, numbers that look as if they had another
/// unit, or what currents of a drive need.
pub fn with_arm(recording: Recording, known: &ArmProperties) -> std::result::Result<Recording, BadInput> {
    let recorded = ArmRecording::of(&recording)?;
    check_names(&recorded, known.model)?;
    let joints = known.model.map_or(&[][..], |model| model.joints());
    let ranges: Vec<Option<[f64; 2]>> = joints.iter().map(|joint| joint.drive.range).collect();
    if known.unit_check == UnitCheck::Refuse
        && let Some(warning) = check_joint_units(&recording, &ranges)
    {
        return Err(warning.into_bad_input("numbers in the unit that is stated"));
    }
    match known.drive {
        Some(drive) => drive::with_currents(recording, drive),
        None => Ok(recording),
    }
}

/// As many names as joints.
fn check_names(recorded: &ArmRecording, model: Option<&Model>) -> std::result::Result<(), BadInput> {
    let n = recorded.joints.len();
    let (expected, whose) = match (model, recorded.joint_names.len()) {
        (Some(model), _) => (model.n_joints(), format!("\"{}\" has", model.name())),
        (None, 0) => return Ok(()),
        (None, names) => (names, "joint_names says".to_owned()),
    };
    if n == expected {
        return Ok(());
    }
    Err(BadInput::new("joints", format!("{expected}, as {whose}"), n.to_string()))
}

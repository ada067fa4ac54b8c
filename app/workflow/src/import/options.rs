//! Options of an import.

use std::path::PathBuf;

use crate::arm::RobotOptions;

/// Import recordings of a tendon robot or of an arm from files of other programs
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Table, log or folder of lists; further ones are joined to the rows of the first
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "SOURCE"))]
    pub sources: Vec<PathBuf>,
    /// Where the recording goes, .csv or .parquet; with episodes OUT-001, OUT-002, ...
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC", required_unless_present = "propose"))]
    pub out: Option<PathBuf>,
    /// Meaning of the columns: a file of TOML, a built-in name, or "tip_x_mm=X; stroke_*_mm=cmd*" [default: by the names of the
    /// columns]
    #[cfg_attr(feature = "clap", arg(long, value_name = "MAP", alias = "columns"))]
    pub map: Option<String>,
    /// Write a map to edit, from names, units and ranges, to a file or the console, and import nothing
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "-", conflicts_with_all = ["out", "map"])
    )]
    pub propose: Option<PathBuf>,
    /// Column with the number of the episode: a recording for each
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN"))]
    pub episodes: Option<String>,
    /// Rate to resample to [default: the file's own]
    #[cfg_attr(feature = "clap", arg(long, value_name = "HZ", allow_negative_numbers = true))]
    pub rate: Option<f64>,
    /// Only rows in which a column has this value
    #[cfg_attr(feature = "clap", arg(long = "where", value_name = "COLUMN=VALUE"))]
    pub filter: Option<String>,
    /// Skip rows that cannot be read, up to a tenth of all, and mark the gap
    #[cfg_attr(feature = "clap", arg(long))]
    pub leave_out_bad_rows: bool,
    /// Accept numbers that look as if they had another unit
    #[cfg_attr(feature = "clap", arg(long))]
    pub accept_units: bool,
    /// Arm whose joints these are: a file of URDF or MJCF, or a built-in name
    #[cfg_attr(feature = "clap", arg(long, value_name = "MODEL"))]
    pub model: Option<String>,
    /// How that arm is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: RobotOptions,
    /// Compute missing currents by the voltage equation of this drive, a name or a file of TOML, which every joint has
    #[cfg_attr(feature = "clap", arg(long, value_name = "DRIVE"))]
    pub drive: Option<String>,
    /// Folder of the page that shows every channel
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Figures as PNG too
    #[cfg_attr(feature = "clap", arg(long, requires = "figures"))]
    pub png: bool,
}

//! What the columns of a table are: files of TOML, of which the known ones are part of the program.

use std::collections::BTreeMap;
use std::path::Path;

use hysteron_base::{BadInput, Column, Result, Table, file, schema};
use serde::Deserialize;

/// Name and text of every built-in description; each file names its source.
const FILES: [(&str, &str); 13] = [
    ("bam-dynamixel", include_str!("../../columns/bam-dynamixel.toml")),
    ("bam-feetech", include_str!("../../columns/bam-feetech.toml")),
    ("bam-swing", include_str!("../../columns/bam-swing.toml")),
    ("baxter", include_str!("../../columns/baxter.toml")),
    ("flobaroid", include_str!("../../columns/flobaroid.toml")),
    ("franka-friction", include_str!("../../columns/franka-friction.toml")),
    ("lerobot-deg", include_str!("../../columns/lerobot-deg.toml")),
    ("lerobot-rad", include_str!("../../columns/lerobot-rad.toml")),
    ("nad-omx", include_str!("../../columns/nad-omx.toml")),
    ("nad-panda", include_str!("../../columns/nad-panda.toml")),
    ("nad-so101", include_str!("../../columns/nad-so101.toml")),
    ("panda-gaz", include_str!("../../columns/panda-gaz.toml")),
    ("ur10e", include_str!("../../columns/ur10e.toml")),
];
/// Those that leave something open which the file does not say: never taken unasked.
const ASKED_FOR: [&str; 3] = ["lerobot-deg", "lerobot-rad", "ur10e"];
/// Most columns of a list.
const WIDEST: usize = 1000;

/// What the columns of a table are.
#[derive(Debug, Clone, PartialEq)]
pub struct Columns {
    /// Where it comes from: a name or a file.
    pub(super) source: String,
    pub(super) robot: Option<String>,
    pub(super) joint_names: Option<Vec<String>>,
    /// Numbers that stand for a missing value.
    pub(super) missing: Vec<f64>,
    /// Rate of a table without times [Hz].
    pub(super) rate_hz: Option<f64>,
    lists: BTreeMap<String, List>,
    /// Channels by name, `*` for the number of the joint.
    pub(super) channels: BTreeMap<String, Selection>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct ColumnsFile {
    format: String,
    version: i64,
    robot: Option<String>,
    joint_names: Option<Vec<String>>,
    #[serde(default)]
    missing: Vec<f64>,
    rate_hz: Option<f64>,
    #[serde(default)]
    lists: BTreeMap<String, List>,
    columns: BTreeMap<String, Typed>,
}

/// A file of numbers without names, row by row.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    file: String,
    width: i64,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged, expecting = "a column, a list of columns, or { columns = ..., times = ... }")]
enum Typed {
    Plain(Which),
    Scaled(Scaled),
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged, expecting = "a number (from 1) or a name of a column, or a list of them")]
enum Which {
    One(Name),
    Many(Vec<Name>),
}

/// A column: its number from 1, or its name, `*` for the number of the joint.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
pub(super) enum Name {
    Number(i64),
    Text(String),
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Scaled {
    columns: Which,
    times: Option<f64>,
    divided_by: Option<f64>,
    unlabelled: Option<f64>,
    encoding: Option<Encoding>,
}

/// How a register holds its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub(super) enum Encoding {
    /// Two's complement of 16 bits, read without sign.
    #[serde(rename = "int16")]
    Int16,
}

/// Columns of one quantity.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Selection {
    pub(super) columns: Vec<Name>,
    pub(super) times: f64,
    pub(super) divided_by: f64,
    /// The number that stands for "no label".
    pub(super) unlabelled: Option<f64>,
    pub(super) encoding: Option<Encoding>,
}

impl Selection {
    /// The number of a cell in the unit of its channel's name.
    pub(super) fn value(&self, cell: f64) -> f64 {
        let number = match self.encoding {
            Some(Encoding::Int16) if (32_768.0..65_536.0).contains(&cell) => cell - 65_536.0,
            _ => cell,
        };
        number * self.times / self.divided_by
    }

    fn of(key: &str, typed: Typed) -> std::result::Result<Self, BadInput> {
        let Scaled { columns, times, divided_by, unlabelled, encoding } = match typed {
            Typed::Scaled(scaled) => scaled,
            Typed::Plain(columns) => {
                Scaled { columns, times: None, divided_by: None, unlabelled: None, encoding: None }
            }
        };
        let factor = |name: &str, typed: Option<f64>| match typed {
            Some(x) if x.is_finite() && x != 0.0 => Ok(x),
            Some(x) => {
                Err(BadInput::new(format!("{key}.{name}"), "a finite number other than 0", format!("{x:?}")))
            }
            None => Ok(1.0),
        };
        let columns = match columns {
            Which::One(column) => vec![column],
            Which::Many(columns) => columns,
        };
        if columns.is_empty() {
            return Err(BadInput::new(key, "at least one column", "none"));
        }
        let (times, divided_by) = (factor("times", times)?, factor("divided_by", divided_by)?);
        Ok(Self { columns, times, divided_by, unlabelled, encoding })
    }
}

impl Columns {
    /// Names of the built-in descriptions.
    pub fn builtin_names() -> impl Iterator<Item = &'static str> {
        FILES.iter().map(|(name, _)| *name)
    }

    /// The built-in description of that name, else the one in that file.
    ///
    /// # Errors
    /// `BadInput` naming the key that is wrong, or the names there are; `Io` if the file cannot be read.
    pub fn named(text: &str) -> Result<Self> {
        if let Some((name, toml)) = FILES.iter().find(|(name, _)| *name == text) {
            return Ok(Self::parse(toml, name)?);
        }
        let path = Path::new(text);
        if !text.contains(['.', '/']) && !path.exists() {
            let names: Vec<&str> = Self::builtin_names().collect();
            let expected = format!("a file, or one of {}", names.join(", "));
            return Err(BadInput::new("columns", expected, format!("\"{text}\"")).into());
        }
        Ok(Self::parse(&file::read_text(path)?, text).map_err(|bad| bad.within(text))?)
    }

    /// Reads a description; `source` is what the recording says of it.
    ///
    /// # Errors
    /// `BadInput` naming line and key.
    pub fn parse(toml: &str, source: &str) -> std::result::Result<Self, BadInput> {
        let typed: ColumnsFile = schema::parse(toml)?;
        schema::check_header((&typed.format, typed.version), ("hysteron-columns", 1))?;
        for (name, list) in &typed.lists {
            schema::count(&format!("lists.{name}.width"), list.width, WIDEST as i64)?;
            if Path::new(&list.file).components().any(|part| !matches!(part, std::path::Component::Normal(_)))
            {
                let place = format!("lists.{name}.file");
                return Err(BadInput::new(place, "a name within the folder", format!("\"{}\"", list.file)));
            }
        }
        let rate_hz = typed.rate_hz.map(|rate| schema::positive("rate_hz", rate)).transpose()?;
        if typed.columns.is_empty() {
            return Err(BadInput::new("columns", "at least one", "none"));
        }
        let channels = typed.columns.into_iter().map(|(key, typed)| {
            let selection = Selection::of(&format!("columns.{key}"), typed)?;
            Ok((key, selection))
        });
        Ok(Self {
            source: source.to_owned(),
            robot: typed.robot,
            joint_names: typed.joint_names,
            missing: typed.missing,
            rate_hz,
            lists: typed.lists,
            channels: channels.collect::<std::result::Result<_, BadInput>>()?,
        })
    }

    /// The built-in description that fits a table: of those whose columns are all there, the one with the most.
    pub(super) fn for_table(
        table: &Table,
        notes: &[(String, String)],
    ) -> std::result::Result<Self, BadInput> {
        let motor = notes.iter().find(|(key, _)| key == "motor").map_or("", |(_, motor)| motor.as_str());
        let of_motor = if motor.starts_with("sts") || motor.starts_with("feetech") {
            "bam-dynamixel"
        } else {
            "bam-feetech"
        };
        let known = FILES.iter().filter(|(name, _)| !ASKED_FOR.contains(name) && *name != of_motor);
        let mut fitting = Vec::new();
        for (name, toml) in known {
            let columns = Self::parse(toml, name)?;
            if columns.lists.is_empty()
                && columns
                    .channels
                    .values()
                    .all(|selection| selection.columns.iter().all(|name| name.is_in(table)))
            {
                fitting.push(columns);
            }
        }
        fitting.into_iter().max_by_key(|columns| columns.channels.len()).ok_or_else(|| {
            let names: Vec<&str> = Self::builtin_names().collect();
            let hint = match table.index("observation.state[1]") {
                Some(_) => "are the angles of this LeRobot data set in degrees or radians? --columns lerobot-deg or lerobot-rad"
                    .to_owned(),
                None => format!("--columns FILE says what its columns are; built in are {}", names.join(", ")),
            };
            BadInput::new("columns", "those of a known data set", table.names()).hint(hint)
        })
    }

    /// The built-in description of a folder of lists.
    pub(super) fn for_folder(folder: &Path) -> std::result::Result<Self, BadInput> {
        for (name, toml) in FILES {
            let columns = Self::parse(toml, name)?;
            if !columns.lists.is_empty()
                && columns.lists.values().all(|list| folder.join(&list.file).is_file())
            {
                return Ok(columns);
            }
        }
        Err(BadInput::new("", "a file, or a folder of a known data set", "another folder")
            .hint("import one file at a time, or say with --columns which lists it holds"))
    }

    /// The lists of a folder as a table with the columns `name[1]`, `name[2]`, ….
    pub(super) fn read_lists(&self, folder: &Path) -> Result<Table> {
        let mut columns: Vec<Column> = Vec::new();
        if self.lists.is_empty() {
            let bad = BadInput::new(folder.display().to_string(), "a file", "a folder");
            return Err(bad.hint("the description of its columns names no lists").into());
        }
        for (name, list) in &self.lists {
            let path = folder.join(&list.file);
            let table = Table::read(&path, None)?;
            let place = path.display().to_string();
            let bad =
                |found: String| BadInput::new(&place, format!("numbers in rows of {}", list.width), found);
            let [column] = table.columns() else {
                return Err(bad(format!("{} columns", table.columns().len())).into());
            };
            let width = list.width as usize;
            if column.values.len() % width != 0 {
                return Err(bad(format!("{} numbers", column.values.len())).into());
            }
            if let Some(row) = column.values.iter().position(|x| !x.is_finite()) {
                return Err(bad(table.shown(0, row)).within(table.row_name(row)).into());
            }
            columns.extend((0..width).map(|k| Column {
                name: format!("{name}[{}]", k + 1),
                values: column.values.iter().skip(k).step_by(width).copied().collect(),
            }));
        }
        Ok(Table::new(columns).map_err(|bad| bad.within(folder.display()))?)
    }
}

impl Name {
    /// The columns that are meant; `*` stands for 1, 2, … as long as there are such columns.
    pub(super) fn indices(&self, table: &Table) -> Vec<usize> {
        match self {
            Self::Number(k) => {
                let index = usize::try_from(*k).ok().and_then(|k| k.checked_sub(1));
                index.filter(|index| *index < table.columns().len()).into_iter().collect()
            }
            Self::Text(name) if name.contains('*') => {
                (1..).map_while(|k: usize| table.index(&name.replace('*', &k.to_string()))).collect()
            }
            Self::Text(name) => table.index(name).into_iter().collect(),
        }
    }

    fn is_in(&self, table: &Table) -> bool {
        matches!(self, Self::Text(_)) && !self.indices(table).is_empty()
    }
}

impl std::fmt::Display for Name {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(k) => write!(f, "column number {k}"),
            Self::Text(name) => write!(f, "a column \"{name}\""),
        }
    }
}

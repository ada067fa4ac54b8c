//! Maps: what the columns of a table are. Files of TOML, of which those of known data sets are part of the program.

use std::collections::BTreeMap;
use std::path::Path;

use super::pose::TrackerTransform;
use super::streams::{ClockedColumns, Join};
use crate::recording::names::is_unitless;
use crate::units::Unit;
use crate::{BadInput, Column, Result, RowFilter, Table, TextFormat, file, schema};
use serde::Deserialize;

/// Name and text of every built-in description; each file names its source.
const FILES: [(&str, &str); 17] = [
    ("bam-dynamixel", include_str!("../../columns/bam-dynamixel.toml")),
    ("bam-feetech", include_str!("../../columns/bam-feetech.toml")),
    ("bam-swing", include_str!("../../columns/bam-swing.toml")),
    ("baxter", include_str!("../../columns/baxter.toml")),
    ("delan-characters", include_str!("../../columns/delan-characters.toml")),
    ("flobaroid", include_str!("../../columns/flobaroid.toml")),
    ("franka-friction", include_str!("../../columns/franka-friction.toml")),
    ("ftdcr", include_str!("../../columns/ftdcr.toml")),
    ("lerobot-deg", include_str!("../../columns/lerobot-deg.toml")),
    ("lerobot-rad", include_str!("../../columns/lerobot-rad.toml")),
    ("nad-omx", include_str!("../../columns/nad-omx.toml")),
    ("nad-panda", include_str!("../../columns/nad-panda.toml")),
    ("nad-so101", include_str!("../../columns/nad-so101.toml")),
    ("panda-gaz", include_str!("../../columns/panda-gaz.toml")),
    ("tentacle", include_str!("../../columns/tentacle.toml")),
    ("trunk", include_str!("../../columns/trunk.toml")),
    ("ur10e", include_str!("../../columns/ur10e.toml")),
];
/// Maps that leave something undefined: used only by name.
const ASKED_FOR: [&str; 5] = ["delan-characters", "lerobot-deg", "lerobot-rad", "trunk", "ur10e"];
/// Most columns of a list.
const WIDEST: usize = 1000;

/// Meaning of the columns of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnMap {
    /// Where it comes from: a name or a file.
    pub(super) source: String,
    pub(super) robot: Option<String>,
    pub(super) joint_names: Option<Vec<String>>,
    /// Numbers that mark a missing value.
    pub(super) missing: Vec<f64>,
    /// Rate of a table without times [Hz].
    pub(super) rate_hz: Option<f64>,
    /// True where rows at uneven times stay where they are: holds, one after the other.
    pub(super) keep_times: bool,
    /// How a table of text is divided.
    pub(super) text: TextFormat,
    /// The column with the number of the episode.
    pub(super) episode: Option<String>,
    pub(super) filter: Option<RowFilter>,
    /// Channels that have one value throughout, in SI, by name.
    pub(super) constants: BTreeMap<String, f64>,
    pub(super) tracker: Option<TrackerTransform>,
    /// How further files come to the rows of the first.
    pub(super) join: Join,
    /// Columns that have a clock of their own.
    pub(super) streams: Vec<ClockedColumns>,
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
    keep_times: bool,
    delimiter: Option<String>,
    decimal: Option<String>,
    episode: Option<String>,
    #[serde(rename = "where")]
    filter: Option<String>,
    #[serde(default)]
    constants: BTreeMap<String, f64>,
    tracker: Option<TrackerTransform>,
    #[serde(default)]
    join: Join,
    #[serde(default)]
    streams: Vec<ClockedColumns>,
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
    Scaled(ScaledColumn),
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged, expecting = "a number (from 1) or a name of a column, or a list of them")]
enum Which {
    One(ColumnName),
    Many(Vec<ColumnName>),
}

/// A column: its number from 1, or its name, `*` for the number of the joint.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
pub(super) enum ColumnName {
    Number(i64),
    Text(String),
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct ScaledColumn {
    columns: Which,
    times: Option<f64>,
    divided_by: Option<f64>,
    scale: Option<f64>,
    offset: Option<f64>,
    zero: Option<Zero>,
    unlabelled: Option<f64>,
    encoding: Option<RegisterEncoding>,
}

/// Where a channel is zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub(super) enum Zero {
    /// In the first row.
    #[serde(rename = "first")]
    First,
}

/// How a register holds its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub(super) enum RegisterEncoding {
    /// Two's complement of 16 bits, read without sign.
    #[serde(rename = "int16")]
    Int16,
}

/// Columns of one quantity.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Selection {
    pub(super) columns: Vec<ColumnName>,
    pub(super) times: f64,
    pub(super) divided_by: f64,
    /// Added to what has been scaled [unit of the channel's name as typed].
    pub(super) offset: f64,
    pub(super) zero: Option<Zero>,
    /// The number that marks "no label".
    pub(super) unlabelled: Option<f64>,
    pub(super) encoding: Option<RegisterEncoding>,
}

impl ScaledColumn {
    fn plain(columns: Which) -> Self {
        Self {
            columns,
            times: None,
            divided_by: None,
            scale: None,
            offset: None,
            zero: None,
            unlabelled: None,
            encoding: None,
        }
    }
}

impl Selection {
    /// The number of a cell in the unit of its channel's name.
    pub(super) fn value(&self, cell: f64) -> f64 {
        let number = match self.encoding {
            Some(RegisterEncoding::Int16) if (32_768.0..65_536.0).contains(&cell) => cell - 65_536.0,
            _ => cell,
        };
        number * self.times / self.divided_by + self.offset
    }

    fn of(key: &str, typed: Typed) -> std::result::Result<Self, BadInput> {
        let scaled = match typed {
            Typed::Scaled(scaled) => scaled,
            Typed::Plain(columns) => ScaledColumn::plain(columns),
        };
        let factor = |name: &str, typed: Option<f64>| match typed {
            Some(x) if x.is_finite() && x != 0.0 => Ok(x),
            Some(x) => {
                Err(BadInput::new(format!("{key}.{name}"), "a finite number other than 0", format!("{x:?}")))
            }
            None => Ok(1.0),
        };
        let columns = match scaled.columns {
            Which::One(column) => vec![column],
            Which::Many(columns) => columns,
        };
        if columns.is_empty() {
            return Err(BadInput::new(key, "at least one column", "none"));
        }
        let times = factor("times", scaled.times)? * factor("scale", scaled.scale)?;
        let offset = scaled.offset.unwrap_or(0.0);
        if !offset.is_finite() {
            return Err(BadInput::new(format!("{key}.offset"), "a finite number", offset.to_string()));
        }
        let divided_by = factor("divided_by", scaled.divided_by)?;
        let (zero, unlabelled, encoding) = (scaled.zero, scaled.unlabelled, scaled.encoding);
        Ok(Self { columns, times, divided_by, offset, zero, unlabelled, encoding })
    }
}

impl ColumnMap {
    /// Names of the built-in descriptions.
    pub fn builtin_names() -> impl Iterator<Item = &'static str> {
        FILES.iter().map(|(name, _)| *name)
    }

    /// The built-in map of that name, the map in line (`tip_x_mm=X; stroke_*_mm=cmd*`), else the one in that file.
    ///
    /// # Errors
    /// `BadInput` naming the key that is wrong, or the names there are; `Io` if the file cannot be read.
    pub fn named(text: &str) -> Result<Self> {
        if text.contains('=') && !Path::new(text).exists() {
            return Ok(Self::in_line(text).map_err(|bad| bad.within("--map"))?);
        }
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

    /// Reads a description; `source` is its description in the recording.
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
        let text = TextFormat {
            delimiter: typed.delimiter.map(|text| character("delimiter", &text)).transpose()?,
            decimal: typed.decimal.map(|text| character("decimal", &text)).transpose()?,
        };
        let tracker = typed.tracker.map(TrackerTransform::checked).transpose()?;
        let constants = typed.constants.into_iter().map(|(key, value)| {
            let place = format!("constants.{key}");
            let Some((stem, unit)) = Unit::of_name(&key) else {
                return Err(BadInput::new(place, "a name that ends in its unit", format!("`{key}`")));
            };
            match value.is_finite() {
                true => Ok((format!("{stem}_{}", unit.si_suffix), unit.to_si(value))),
                false => Err(BadInput::new(place, "a finite number", value.to_string())),
            }
        });
        let constants = constants.collect::<std::result::Result<_, BadInput>>()?;
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
            keep_times: typed.keep_times,
            text,
            episode: typed.episode,
            filter: typed.filter.map(|text| RowFilter::parse("where", &text)).transpose()?,
            constants,
            tracker,
            join: typed.join,
            streams: typed.streams,
            lists: typed.lists,
            channels: channels.collect::<std::result::Result<_, BadInput>>()?,
        })
    }

    /// A map in line: `target=column` with `;` between, several columns with `,` between, `-` before one of the other sign.
    ///
    /// # Errors
    /// `BadInput` naming the part.
    fn in_line(text: &str) -> std::result::Result<Self, BadInput> {
        let mut toml = toml::Table::new();
        let mut columns = toml::Table::new();
        for part in text.split(';').map(str::trim).filter(|part| !part.is_empty()) {
            let Some((key, value)) = part.split_once('=').map(|(key, value)| (key.trim(), value.trim()))
            else {
                return Err(BadInput::new(part, "TARGET=COLUMN", format!("\"{part}\"")));
            };
            match key {
                "rate_hz" => {
                    let rate = value.parse::<f64>();
                    let rate =
                        rate.map_err(|_| BadInput::new("rate_hz", "a number", format!("\"{value}\"")))?;
                    toml.insert(key.to_owned(), rate.into());
                }
                "episode" | "delimiter" | "decimal" => {
                    toml.insert(key.to_owned(), value.into());
                }
                _ => {
                    let scale = if value.starts_with('-') { -1.0 } else { 1.0 };
                    let names = value.trim_start_matches('-').split(',').map(|name| {
                        let name = name.trim();
                        name.parse::<i64>().map_or_else(|_| toml::Value::from(name), toml::Value::from)
                    });
                    let mut scaled = toml::Table::new();
                    scaled.insert("columns".to_owned(), names.collect::<Vec<_>>().into());
                    scaled.insert("scale".to_owned(), scale.into());
                    columns.insert(key.to_owned(), scaled.into());
                }
            }
        }
        toml.insert("format".to_owned(), "hysteron-columns".into());
        toml.insert("version".to_owned(), 1.into());
        toml.insert("columns".to_owned(), columns.into());
        Self::parse(&toml.to_string(), "--map")
    }

    /// The built-in map that fits a file or folder.
    pub(super) fn found(
        path: &Path,
        table: &Table,
        notes: &[(String, String)],
    ) -> std::result::Result<Self, BadInput> {
        if path.is_dir() { Self::for_folder(path) } else { Self::for_table(table, notes) }
    }

    /// The name of the column of the times and its unit; none where rows have a rate.
    pub(super) fn time(&self) -> Option<(&'static Unit, &Selection)> {
        self.channels.iter().find_map(|(key, selection)| match Unit::of_name(key) {
            Some(("time", unit)) if unit.si_suffix == "s" => Some((unit, selection)),
            _ => None,
        })
    }

    /// The map of a table whose columns have the names of channels (`time_s`, `q_1_rad`, `stroke_1_mm`); none where one has another
    /// name, or none is the time.
    fn own_names(table: &Table) -> Option<Self> {
        let mut channels = BTreeMap::new();
        for Column { name, .. } in table.columns() {
            let is_one = Unit::of_name(name).is_some() || is_unitless(name);
            let selection =
                Selection::of(name, Typed::Plain(Which::One(ColumnName::Text(name.clone())))).ok()?;
            if !is_one || channels.insert(name.clone(), selection).is_some() {
                return None;
            }
        }
        let own = Self {
            source: "own names".to_owned(),
            robot: None,
            joint_names: None,
            missing: Vec::new(),
            rate_hz: None,
            keep_times: false,
            text: TextFormat::default(),
            episode: None,
            filter: None,
            constants: BTreeMap::new(),
            tracker: None,
            join: Join::default(),
            streams: Vec::new(),
            lists: BTreeMap::new(),
            channels,
        };
        (own.time().is_some() && own.channels.len() > 1).then_some(own)
    }

    /// The built-in description that fits a table: of those whose columns are all there, the one with the most; else the names
    /// of channels themselves.
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
        let widest = fitting.into_iter().max_by_key(|columns| columns.channels.len());
        widest.or_else(|| Self::own_names(table)).ok_or_else(|| {
            let names: Vec<&str> = Self::builtin_names().collect();
            let hint = match table.index("observation.state[1]") {
                Some(_) => "are the angles of this LeRobot data set in degrees or radians? --map lerobot-deg or lerobot-rad"
                    .to_owned(),
                None => format!("--propose writes a map to edit, --map FILE takes it; built in are {}", names.join(", ")),
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
            .hint("import one file at a time, or name its lists with --map"))
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

impl ColumnName {
    /// The columns that are meant, see [`expanded`].
    pub(super) fn indices(&self, table: &Table) -> Vec<usize> {
        match self {
            Self::Number(k) => {
                let index = usize::try_from(*k).ok().and_then(|k| k.checked_sub(1));
                index.filter(|index| *index < table.columns().len()).into_iter().collect()
            }
            Self::Text(name) if name.contains('*') => expanded(name, table),
            Self::Text(name) => table.index(name).into_iter().collect(),
        }
    }

    fn is_in(&self, table: &Table) -> bool {
        matches!(self, Self::Text(_)) && !self.indices(table).is_empty()
    }
}

/// Columns of a name with `*`, which is 1, 2, … (or 0, 1, … or 01, 02, …) as long as there are such columns; where there
/// are none, for any text, in the order of the file.
fn expanded(name: &str, table: &Table) -> Vec<usize> {
    let numbered = |first: usize, width: usize| -> Vec<usize> {
        (first..).map_while(|k| table.index(&name.replace('*', &format!("{k:0width$}")))).collect()
    };
    let found = [(0, 1), (1, 1), (0, 2), (1, 2)].into_iter().map(|(first, width)| numbered(first, width));
    let by_text = || {
        let Some((before, after)) = name.split_once('*') else { return Vec::new() };
        let is_meant = |column: &Column| {
            column.name.len() > before.len() + after.len()
                && column.name.starts_with(before)
                && column.name.ends_with(after)
        };
        (0..table.columns().len()).filter(|k| is_meant(&table.columns()[*k])).collect()
    };
    found.into_iter().find(|found| !found.is_empty()).unwrap_or_else(by_text)
}

fn character(key: &str, text: &str) -> std::result::Result<char, BadInput> {
    let mut characters = text.chars();
    match (text, characters.next(), characters.next()) {
        ("tab", ..) => Ok('\t'),
        ("space", ..) => Ok(' '),
        ("comma", ..) => Ok(','),
        ("point", ..) => Ok('.'),
        (_, Some(only), None) => Ok(only),
        _ => Err(BadInput::new(key, "one character, or tab, space, comma, point", format!("\"{text}\""))),
    }
}

impl std::fmt::Display for ColumnName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(k) => write!(f, "column number {k}"),
            Self::Text(name) => write!(f, "a column \"{name}\""),
        }
    }
}

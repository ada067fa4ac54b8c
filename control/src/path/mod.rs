//! Target paths: where the tip should go, at a fixed rate.
//!
//! A target is a curve relative to where the robot's tip rests, run through at one speed with smooth start and end;
//! before it the tip rests and moves over to the curve, after it the tip moves back and rests. Only the samples of
//! the curve itself are measured ([`crate::tracking`]). A target knows no strokes and no robot. x and y are what
//! counts; z is free unless the curve gives it.
//!
//! The sizes are those of the CoReAct paper (section V-B, tables II to IV): diameter of circles, diagonal of
//! diamonds, and full height of Lissajous curves, which the paper calls their vertical amplitude.

mod convert;
mod csv;
mod family;
mod outline;
mod schema;
mod span;
mod svg;
mod timing;

use crate::plan::rise;
use crate::{Error, Result};
use hysteron_base::{BadInput, Channel, Metadata, Recording, file};
use std::collections::BTreeMap;
use std::ops::{Range, RangeInclusive};
use std::path::{Path, PathBuf};

pub use outline::{Outline, OutlinePoint};
pub use span::PathSpan;

/// Curves that have a name on the command line, as in `circle:40`, and what is written for them in `[curve]`; `SIZE`
/// stands for the size.
const BUILT_IN: [(&str, &str); 8] = [
    ("circle", "size_mm = SIZE"),
    ("diamond", "size_mm = SIZE"),
    ("square", "size_mm = SIZE"),
    ("lissajous", "size_mm = SIZE\nwidth_mm = WIDTH\ncycles = [1, 2]\nphase_deg = 0"),
    ("figure_eight", "size_mm = SIZE"),
    ("ellipse", "size_mm = SIZE\naspect = 0.6"),
    ("rose", "size_mm = SIZE\nk = 2"),
    ("spiral", "size_mm = SIZE\nturns = 3"),
];
/// Width of the built-in Lissajous curve over its height. Tables II and III give RMSE / NRMSE = size to the digits
/// printed; table IV gives 0.95 of the height, which is the mean over both axes for this width.
const LISSAJOUS_ASPECT: f64 = 0.9;

/// Bytes of a table in which its header is looked for.
const HEAD: usize = 1 << 16;

/// Timing of targets that are named and not written.
const HEADER: &str = "format = \"hysteron-target\"\nversion = 1\nrate_hz = 100\nspeed_mm_s = 10\nramp_s = 1\n\
                      rest_s = 1\nlead_in_s = 3\n";

/// Where the tip should go, sample by sample; see the module.
#[derive(Debug, Clone, PartialEq)]
pub struct TargetPath {
    /// Its name.
    pub name: String,
    /// Family of its curve, as in a target file.
    pub family: String,
    /// SHA-256 of the target file, and of the outline's file after it; 64 hexadecimal digits.
    pub hash: String,
    /// Samples per second [Hz].
    pub rate_hz: f64,
    /// True where only x and y are given.
    pub is_planar: bool,
    /// The curve without time, one lap of it.
    pub outline: Outline,
    /// Where the tip is to be (n_samples), from where it rests [m].
    points: Vec<OutlinePoint>,
    /// Samples at which a lap begins, and that at which the last one ends; at least two.
    bounds: Vec<usize>,
}

/// Whether a file is a recording: Parquet, or CSV with a column of times; an outline in CSV has none.
///
/// # Errors
/// `File` if it cannot be read.
pub fn is_recording(path: &Path) -> Result<bool> {
    Ok(match path.extension().and_then(|ending| ending.to_str()) {
        Some("parquet") => true,
        Some("csv") => {
            let head = file::read_head(path, HEAD)?;
            String::from_utf8_lossy(&head)
                .lines()
                .any(|line| !line.starts_with('#') && line.contains("time_"))
        }
        _ => false,
    })
}

/// Whether a recording is a path without times; see [`read_untimed`].
pub fn is_untimed(recording: &Recording) -> bool {
    recording.meta().extra.contains_key(UNTIMED)
}

/// A path without times, a .csv with columns x and y as outlines have them (`x_mm,y_mm`, or `tip_x_mm,tip_y_mm`), as the recording of a
/// tip; its rows are counted in place of seconds.
///
/// # Errors
/// `BadInput` naming the line; `File` if it cannot be read.
pub fn read_untimed(path: &Path) -> Result<Recording> {
    let (points, _) = csv::read(&file::read_text(path)?).map_err(|bad| bad.within(path.display()))?;
    let channel = |c: usize, name: &str| Channel::new(name, points.iter().map(|point| point[c]).collect());
    let time = (0..points.len()).map(|row| row as f64).collect();
    let extra = BTreeMap::from([(UNTIMED.to_owned(), "true".to_owned())]);
    let meta = Metadata { extra, source: "a path without times".to_owned(), ..Metadata::default() };
    let channels = vec![channel(0, "tip_x_m"), channel(1, "tip_y_m")];
    Ok(Recording::new(time, channels, Vec::new(), meta).map_err(|bad| bad.within(path.display()))?)
}

/// Metadata key of what [`read_untimed`] gives.
const UNTIMED: &str = "path.untimed";

impl TargetPath {
    /// The target that a person names: the file of one (.toml), an outline (.svg, or .csv with x and y), a recording
    /// of one (.parquet, or .csv with time_s), or a curve and its size in mm, as `circle:40`.
    ///
    /// # Errors
    /// `BadInput` naming the file and what is wrong with it; `File` if it cannot be read.
    pub fn open(named: &str) -> Result<Self> {
        let path = Path::new(named);
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("toml") => Self::read(path),
            Some("svg") => Self::outline_file(path),
            Some("csv" | "parquet") if is_recording(path)? => Self::read_recording(path),
            Some("csv") => Self::outline_file(path),
            _ => Self::named(named),
        }
    }

    /// The files that [`TargetPath::open`] reads for this name: none for a curve and its size.
    ///
    /// # Errors
    /// As there.
    pub fn files(named: &str) -> Result<Vec<PathBuf>> {
        let path = Path::new(named);
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("toml") => {
                let typed: schema::TargetFile = hysteron_base::schema::parse(&file::read_text(path)?)
                    .map_err(|bad| bad.within(path.display()))?;
                let folder = path.parent().unwrap_or(Path::new(""));
                let outline = typed.curve.file.map(|name| folder.join(name));
                Ok([path.to_owned()].into_iter().chain(outline).collect())
            }
            Some("svg" | "csv" | "parquet") => Ok(vec![path.to_owned()]),
            _ => Ok(Vec::new()),
        }
    }

    /// Reads and validates a target file.
    ///
    /// # Errors
    /// As [`TargetPath::open`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::from_toml(&file::read_text(path)?, folder).map_err(|error| error.within(path.display()))
    }

    /// The target in the text of a target file; outlines that it names are looked for in `folder`.
    ///
    /// # Errors
    /// As [`TargetPath::open`].
    pub fn from_toml(text: &str, folder: &Path) -> Result<Self> {
        hysteron_base::size::check_at_most("bytes of the file", text.len(), convert::MAX_BYTES)?;
        let valid = convert::target(hysteron_base::schema::parse(text)?, folder)?;
        let hash = file::sha256_hex(format!("{text}{}", valid.outline_file).as_bytes());
        Ok(Self::timed(valid, hash))
    }

    /// A built-in curve with its size, as `circle:40`: at 100 Hz and 10 mm/s.
    ///
    /// # Errors
    /// `BadInput` listing the curves, or refusing the size.
    pub fn named(named: &str) -> Result<Self> {
        let known = named.split_once(':').and_then(|(family, size)| {
            let (_, keys) = BUILT_IN.iter().find(|(known, _)| *known == family)?;
            Some((family, *keys, size.parse::<f64>().ok()?))
        });
        let Some((family, keys, size)) = known else {
            let names: Vec<String> = BUILT_IN.iter().map(|(name, _)| format!("{name}:SIZE")).collect();
            let expected = format!("one of {}, or a file", names.join(", "));
            return Err(BadInput::new("target", expected, format!("\"{named}\""))
                .hint("SIZE in mm, as in circle:40; files end in .toml, .svg, .csv or .parquet")
                .into());
        };
        let keys = keys.replace("SIZE", &format!("{size:?}"));
        let keys = keys.replace("WIDTH", &format!("{:?}", LISSAJOUS_ASPECT * size));
        let text = format!("{HEADER}name = \"{named}\"\n\n[curve]\nfamily = \"{family}\"\n{keys}\n");
        Self::from_toml(&text, Path::new("")).map_err(|error| error.within(format!("target {named}")))
    }

    fn outline_file(path: &Path) -> Result<Self> {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        let text = format!("{HEADER}name = {name:?}\n\n[curve]\nfamily = \"outline\"\nfile = {file:?}\n");
        Self::from_toml(&text, path.parent().unwrap_or(Path::new("")))
    }

    /// Samples of a valid curve.
    fn timed(valid: convert::Valid, hash: String) -> Self {
        let convert::Valid { rate_hz, outline, motion, laps, .. } = valid;
        let count = |duration: f64| (duration * rate_hz - 1e-6).ceil().max(0.0) as usize;
        let (n_rest, n_lead, n_curve) = (count(valid.rest), count(valid.lead_in), motion.n_steps(rate_hz));
        let length = outline.length();
        let along = |i: usize| motion.at(i as f64 / rate_hz);
        let start = n_rest + n_lead;
        let mut bounds = vec![start];
        for lap in 1..laps {
            // The way along the curve only grows.
            let (mut low, mut high) = (0, n_curve);
            while low < high {
                let middle = low + (high - low) / 2;
                let is_begun = along(middle) >= f64::from(lap) * length;
                if is_begun { high = middle } else { low = middle + 1 }
            }
            bounds.push(start + low);
        }
        bounds.push(start + n_curve);

        let (first, last) = (outline.at(0.0), outline.at(length));
        let lead = |i: usize, to: OutlinePoint| {
            let part = rise(i as f64 / n_lead as f64);
            outline::between([0.0; 3], to, part)
        };
        let mut points = vec![[0.0; 3]; n_rest];
        points.extend((0..n_lead).map(|i| lead(i, first)));
        points.extend((0..n_curve).map(|i| {
            let lap = (along(i) / length).floor();
            outline.at(along(i) - lap * length)
        }));
        points.push(last);
        points.extend((0..n_lead).rev().map(|i| lead(i, last)));
        points.extend(vec![[0.0; 3]; n_rest]);
        let (name, family, is_planar) = (valid.name, valid.family.to_owned(), valid.is_planar);
        Self { name, family, hash, rate_hz, is_planar, outline, points, bounds }
    }

    /// Where the tip is to be (n_samples), from where it rests [m]; sample i is at time i / rate.
    pub fn points(&self) -> &[OutlinePoint] {
        &self.points
    }

    /// Time of sample `i` [s].
    pub fn time(&self, i: usize) -> f64 {
        i as f64 / self.rate_hz
    }

    /// Samples of the curve itself, those that are measured.
    pub fn curve(&self) -> RangeInclusive<usize> {
        self.bounds[0]..=self.bounds[self.bounds.len() - 1]
    }

    /// Samples of each lap; the last of one is the first of the next.
    pub fn laps(&self) -> impl Iterator<Item = RangeInclusive<usize>> {
        self.bounds.windows(2).map(|pair| pair[0]..=pair[1])
    }

    /// Samples at rest at the beginning; at least the first.
    pub fn rest(&self) -> Range<usize> {
        0..self.points.iter().take_while(|point| **point == [0.0; 3]).count().max(1)
    }

    /// The target as a recording: `tip_x_m`, `tip_y_m` and, unless it is planar, `tip_z_m`, from where the tip rests.
    /// Its metadata name target and hash; `target.laps_s` has the times at which laps begin, and the end of the last:
    /// the samples from the first to the last of them are the curve.
    ///
    /// # Errors
    /// None for a target that was read.
    pub fn recording(&self) -> Result<Recording> {
        let n_axes = if self.is_planar { 2 } else { 3 };
        let values = |c: usize| self.points.iter().map(|point| point[c]).collect();
        let channels = ["tip_x_m", "tip_y_m", "tip_z_m"].into_iter().enumerate().take(n_axes);
        let channels = channels.map(|(c, name)| Channel::new(name, values(c))).collect();
        let times: Vec<String> = self.bounds.iter().map(|i| self.time(*i).to_string()).collect();
        let extra = [
            ("target.name", self.name.clone()),
            ("target.family", self.family.clone()),
            ("target.sha256", self.hash.clone()),
            ("target.laps_s", times.join(" ")),
        ];
        let meta = Metadata {
            source: format!("target {}", self.name),
            extra: extra.into_iter().map(|(key, value)| (key.to_owned(), value)).collect(),
            ..Metadata::default()
        };
        let time = (0..self.points.len()).map(|i| self.time(i)).collect();
        Ok(Recording::new(time, channels, vec![], meta)?)
    }

    fn read_recording(path: &Path) -> Result<Self> {
        let recording = Recording::read(path)?;
        Self::from_recording(&recording).map_err(|bad| Error::from(bad.within(path.display())))
    }

    /// The target that [`TargetPath::recording`] wrote; its outline is that of the samples of the first lap.
    ///
    /// # Errors
    /// `BadInput` if it is no recording of a target.
    pub fn from_recording(recording: &Recording) -> std::result::Result<Self, BadInput> {
        let (x, y) = (recording.require("tip_x_m")?, recording.require("tip_y_m")?);
        let z = recording.channel("tip_z_m");
        let extra = &recording.meta().extra;
        let of = |key: &str| {
            extra.get(key).cloned().ok_or_else(|| {
                BadInput::new(key, "metadata of a target", "none").hint("hysteron target writes it")
            })
        };
        let rate_hz = recording.rate_hz().filter(|_| recording.time()[0] == 0.0).ok_or_else(|| {
            BadInput::new(
                "time_s",
                "a fixed rate from 0 s on",
                format!("{} s", hysteron_base::number::shown(recording.time()[0])),
            )
        })?;
        let points: Vec<OutlinePoint> = (0..x.len()).map(|i| [x[i], y[i], z.map_or(0.0, |z| z[i])]).collect();
        let laps = of("target.laps_s")?;
        let sample = |text: &str| Some((text.parse::<f64>().ok()? * rate_hz).round() as usize);
        let bounds: Option<Vec<usize>> = laps.split_whitespace().map(sample).collect();
        let is_right = |bounds: &Vec<usize>| {
            bounds.len() >= 2
                && bounds.windows(2).all(|pair| pair[0] < pair[1])
                && bounds[bounds.len() - 1] < points.len()
        };
        let bounds = bounds.filter(is_right).ok_or_else(|| {
            BadInput::new("target.laps_s", "two or more of its times in order", format!("\"{laps}\""))
        })?;
        let lap = points[bounds[0]..=bounds[1]].to_vec();
        let is_closed = bounds.len() > 2 || outline::distance(lap[0], lap[lap.len() - 1]) < 1e-9;
        Ok(Self {
            name: of("target.name")?,
            family: of("target.family")?,
            hash: of("target.sha256")?,
            rate_hz,
            is_planar: z.is_none(),
            outline: Outline::new(lap, is_closed)?,
            points,
            bounds,
        })
    }
}

#[cfg(test)]
mod tests;

//! The recording: patterns of rows.

use std::path::Path;

use anyhow::{Context, Result};

/// Number of tendons.
pub const N_TENDONS: usize = 9;

/// One sample.
#[derive(Debug, Clone)]
pub struct Row {
    /// Strokes in the order of the tendons [m].
    pub strokes: [f64; N_TENDONS],
    /// Measured tip [m].
    pub tip: [f64; 3],
}

/// A pattern with its holds, in order of time.
#[derive(Debug, Clone)]
pub struct Pattern {
    /// Its label, without `_hold`.
    pub label: String,
    /// Its rows.
    pub rows: Vec<Row>,
}

/// All patterns; columns of strokes are in the order of the tendons, in millimetres.
///
/// # Errors
/// The file cannot be read or has other columns.
pub fn read_patterns(path: &Path) -> Result<Vec<Pattern>> {
    let place = || path.display().to_string();
    let mut reader = csv::Reader::from_path(path).with_context(place)?;
    let header = reader.headers().with_context(place)?.clone();
    let at =
        |name: &str| header.iter().position(|h| h == name).with_context(|| format!("{}: no {name}", place()));
    let label = at("pattern_label")?;
    let strokes: Vec<usize> = (0..header.len()).filter(|&k| header[k].starts_with("servo_")).collect();
    let strokes: [usize; N_TENDONS] =
        strokes.try_into().ok().with_context(|| format!("{}: not nine servos", place()))?;
    let tip = [at("tip_x")?, at("tip_y")?, at("tip_z")?];
    let mut patterns: Vec<Pattern> = Vec::new();
    for row in reader.records() {
        let row = row.with_context(place)?;
        let number =
            |k: usize| row[k].trim().parse::<f64>().with_context(|| format!("{}: {:?}", place(), &row[k]));
        let mut sample = Row { strokes: [0.0; N_TENDONS], tip: [0.0; 3] };
        for (value, k) in sample.strokes.iter_mut().zip(strokes).chain(sample.tip.iter_mut().zip(tip)) {
            *value = 1e-3 * number(k)?;
        }
        let name = row[label].trim_end_matches("_hold");
        match patterns.iter_mut().find(|pattern| pattern.label == name) {
            Some(pattern) => pattern.rows.push(sample),
            None => patterns.push(Pattern { label: name.to_owned(), rows: vec![sample] }),
        }
    }
    Ok(patterns)
}

//! The recording: patterns of rows.

use std::path::Path;

use anyhow::{Context, Result};

use crate::tendon::columns::Columns;

/// Number of tendons.
pub const N_TENDONS: usize = 9;

/// One sample.
#[derive(Debug, Clone)]
pub struct Row {
    /// Strokes in the order of the tendons [m].
    pub strokes: [f64; N_TENDONS],
    /// Measured tip [m].
    pub tip: [f64; 3],
    /// Where each tendon comes from, between -1, released, and 1, pulled; 0 in the first row of a pattern.
    pub directions: [f64; N_TENDONS],
}

impl Row {
    /// A row that is not known to come from another.
    pub fn new(strokes: [f64; N_TENDONS], tip: [f64; 3]) -> Self {
        Self { strokes, tip, directions: [0.0; N_TENDONS] }
    }
}

/// Change of a stroke from which on it is a motion, not the noise of a servo at rest [m].
const MOTION: f64 = 0.2e-3;

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
    let table = Columns::read(path)?;
    let strokes: Vec<usize> =
        (0..table.header.len()).filter(|&k| table.header[k].starts_with("servo_")).collect();
    let strokes: [usize; N_TENDONS] =
        strokes.try_into().ok().with_context(|| format!("{}: not nine servos", path.display()))?;
    let (label, tip) =
        (table.at("pattern_label")?, [table.at("tip_x")?, table.at("tip_y")?, table.at("tip_z")?]);
    let mut patterns: Vec<Pattern> = Vec::new();
    for row in &table.rows {
        let mut sample = Row::new([0.0; N_TENDONS], [0.0; 3]);
        for (value, k) in sample.strokes.iter_mut().zip(strokes).chain(sample.tip.iter_mut().zip(tip)) {
            *value = 1e-3 * table.number(row, k)?;
        }
        let name = row[label].trim_end_matches("_hold");
        match patterns.iter_mut().find(|pattern| pattern.label == name) {
            Some(pattern) => pattern.rows.push(sample),
            None => patterns.push(Pattern { label: name.to_owned(), rows: vec![sample] }),
        }
    }
    patterns.iter_mut().for_each(Pattern::find_directions);
    Ok(patterns)
}

impl Pattern {
    fn find_directions(&mut self) {
        for k in 1..self.rows.len() {
            let [before, now] = [k - 1, k].map(|k| self.rows[k].strokes);
            self.rows[k].directions = std::array::from_fn(|j| ((now[j] - before[j]) / MOTION).tanh());
        }
    }
}

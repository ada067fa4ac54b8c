//! Figures with their baseline and target: printed for people, written for programs.
#![allow(clippy::print_stdout)] // this program prints tables

use hysteron_studies::runner::table::aligned;
use serde::Serialize;

/// Target of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FigureTarget {
    /// Not less than this.
    AtLeast(f64),
    /// Not more than this.
    AtMost(f64),
}

impl FigureTarget {
    /// True where `measured` reaches it.
    pub fn is_met(self, measured: f64) -> bool {
        match self {
            Self::AtLeast(bound) => measured >= bound,
            Self::AtMost(bound) => measured <= bound,
        }
    }
}

/// One line of the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TableRow {
    /// Name of the figure.
    pub name: String,
    /// Its value; none where it could not be measured here.
    pub measured: Option<f64>,
    /// Unit of the value.
    pub unit: String,
    /// Baseline, in the same unit.
    pub baseline: Option<f64>,
    /// Where that comes from.
    pub baseline_source: Option<String>,
    /// Measured over baseline.
    pub ratio: Option<f64>,
    /// Target of the value.
    pub target: Option<FigureTarget>,
    /// Whether it does.
    pub met: Option<bool>,
}

impl TableRow {
    /// A figure without baseline or target.
    pub fn new(name: impl Into<String>, measured: impl Into<Option<f64>>, unit: &str) -> Self {
        Self {
            name: name.into(),
            measured: measured.into(),
            unit: unit.into(),
            baseline: None,
            baseline_source: None,
            ratio: None,
            target: None,
            met: None,
        }
    }

    /// The same, compared with a baseline.
    pub fn against(mut self, baseline: f64, source: &str) -> Self {
        self.baseline = Some(baseline);
        self.baseline_source = Some(source.into());
        self.ratio = self.measured.map(|measured| measured / baseline);
        self
    }

    /// The same, with a target.
    pub fn goal(mut self, goal: FigureTarget) -> Self {
        self.target = Some(goal);
        self.met = self.measured.map(|measured| goal.is_met(measured));
        self
    }
}

/// Prints the table of targets.
pub fn print_rows(rows: &[TableRow]) {
    let heading = ["name", "measured", "unit", "baseline", "ratio", "target", "met"];
    let mut cells = vec![heading.map(str::to_owned).to_vec()];
    for row in rows {
        let optional = |value: Option<f64>| value.map_or("-".to_owned(), number);
        let target = match row.target {
            Some(FigureTarget::AtLeast(bound)) => format!(">= {}", number(bound)),
            Some(FigureTarget::AtMost(bound)) => format!("<= {}", number(bound)),
            None => "-".to_owned(),
        };
        let met = row.met.map_or("-", |met| if met { "yes" } else { "NO" });
        cells.push(vec![
            row.name.clone(),
            optional(row.measured),
            row.unit.clone(),
            optional(row.baseline),
            optional(row.ratio),
            target,
            met.to_owned(),
        ]);
    }
    aligned(&cells).iter().for_each(|line| println!("{line}"));
}

/// Three or four significant digits.
pub fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".into()
    } else if !(1e-3..1e6).contains(&size) {
        format!("{value:.2e}")
    } else {
        let decimals = (2 - size.log10().floor() as i32).clamp(0, 5);
        format!("{value:.*}", decimals as usize)
    }
}

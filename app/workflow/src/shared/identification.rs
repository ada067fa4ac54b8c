//! Common parts of all identifications of joints and servos: the folder of the results, and the parameters found.

use std::path::PathBuf;

use hysteron_base::{BadInput, file, json};
use hysteron_fit::Identifiability;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Context;
use crate::shared::outputs::{OutputLock, Outputs};
use crate::shared::verdict::{AssessedParameter, Kind};

/// Where results go.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Results {
    /// File of JSON to write
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub out: PathBuf,
    /// Folder for figures, report.html and metrics.json
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Write each figure as .png too
    #[cfg_attr(feature = "clap", arg(long, requires = "figures"))]
    pub png: bool,
}

impl Results {
    pub(crate) fn lock(&self, outputs: Outputs, context: &Context) -> anyhow::Result<OutputLock> {
        outputs.file("--out", &self.out).report("--figures", self.figures.as_deref()).check(context)
    }

    /// Writes the file of what was found.
    pub(crate) fn write<T: Serialize>(&self, found: &T, context: &Context) -> anyhow::Result<()> {
        file::write_bytes(&self.out, json::to_text(found)?)?;
        if let Some(folder) = &self.figures {
            context.reported(folder);
        }
        Ok(())
    }
}

/// Name of a servo's torque at full load, as it is found where tensions are known.
pub(crate) const LOAD_SCALE: &str = "load_scale_n_m";

/// The value of `format` of an identification.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[schemars(inline)]
pub enum IdentificationFormat {
    /// In `metrics.json` and on the console.
    #[serde(rename = "hysteron-metrics")]
    Metrics,
    /// In the file of `--out`.
    #[serde(rename = "hysteron-identification")]
    Identification,
}

/// A number that was identified.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ParameterEstimate {
    /// Name with its unit.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Standard error; none where there is no estimate of it.
    pub standard_error: Option<f64>,
    /// Note on its identifiability; empty where there is nothing to note.
    pub note: String,
}

impl ParameterEstimate {
    /// As cells of a table with the headings [`ESTIMATE_HEADINGS`].
    pub(crate) fn cells(&self) -> Vec<String> {
        let error = self.standard_error.map_or_else(|| "-".to_owned(), |error| format!("{error:.2e}"));
        let value = if self.value.is_nan() { "-".to_owned() } else { format!("{:.5}", self.value) };
        vec![self.name.clone(), value, error, self.note.clone()]
    }
}

/// Headings of [`ParameterEstimate::cells`].
pub(crate) const ESTIMATE_HEADINGS: [&str; 4] = ["Number", "Value", "Standard error", ""];

/// The numbers of all rows, as results hold them.
pub(crate) fn estimates(rows: &[Row]) -> Vec<ParameterEstimate> {
    rows.iter().map(Row::estimate).collect()
}

/// An estimate with its identifiability.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    /// Name with its unit.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Standard error, where there is one.
    pub standard_error: Option<f64>,
    /// Note on its identifiability; empty where there is nothing to note.
    pub note: String,
    /// The same as a fit has it.
    pub identifiability: Identifiability,
}

impl Row {
    /// Of a fit by least squares.
    pub(crate) fn of_estimate(estimate: &hysteron_fit::IdentifiedParameter) -> Self {
        let note = match &estimate.identifiability {
            Identifiability::Fitted => String::new(),
            Identifiability::AtBound => "at its bound".into(),
            Identifiability::Vague => "vague".into(),
            Identifiability::Undetermined(others) if others.is_empty() => "not determined: fixed".into(),
            Identifiability::Undetermined(others) => {
                format!("fixed: cannot be distinguished from {}", others.join(", "))
            }
        };
        Self {
            name: estimate.name.clone(),
            value: estimate.value,
            standard_error: estimate.standard_error,
            note,
            identifiability: estimate.identifiability.clone(),
        }
    }

    /// Of a regression of bodies.
    pub(crate) fn of_term(term: &hysteron_arm_estimation::identify::TermEstimate) -> Self {
        let is_shared = term.determined == hysteron_arm_estimation::identify::Determined::Together;
        let note = if is_shared { "only together with others" } else { "" }.to_owned();
        Self {
            name: term.name.clone(),
            value: term.value,
            standard_error: Some(term.standard_error),
            note,
            identifiability: Identifiability::Fitted,
        }
    }

    /// As results hold it.
    pub(crate) fn estimate(&self) -> ParameterEstimate {
        ParameterEstimate {
            name: self.name.clone(),
            value: self.value,
            standard_error: self.standard_error,
            note: self.note.clone(),
        }
    }
}

/// As a verdict asks for them; an offset is none of the sizes that zero would abolish.
pub(crate) fn assessed<'a>(rows: &'a [Row], consequence: Option<&'static str>) -> Vec<AssessedParameter<'a>> {
    let assessed = |row: &'a Row| AssessedParameter {
        name: row.name.clone(),
        value: row.value,
        standard_error: row.standard_error,
        identifiability: &row.identifiability,
        kind: if row.name.contains("offset") { Kind::Place } else { Kind::Size },
        consequence,
    };
    rows.iter().map(assessed).collect()
}

/// Standard deviation, which a prediction by the mean is off by.
pub(crate) fn deviation(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt()
}

/// The largest error of a joint over the deviation of its torques, columns of `torques` with as many joints as errors; with the
/// number of that joint, from 1.
pub(crate) fn worst_joint(errors: &[f64], torques: &[f64]) -> (f64, usize) {
    let n = errors.len();
    let share = |j: usize| {
        let column: Vec<f64> = torques.iter().skip(j).step_by(n).copied().collect();
        (errors[j] / deviation(&column), j + 1)
    };
    (0..n).map(share).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::NAN, 0))
}

/// Prints them.
pub(crate) fn print_rows(rows: &[Row], context: &Context) {
    context.print("number                                          value      standard error");
    for row in rows {
        let [name, value, error, note] = <[String; 4]>::try_from(row.estimate().cells()).unwrap_or_default();
        context.print(format_args!("{name:<40} {value:>12} {error:>14}   {note}").to_string().trim_end());
    }
}

/// Refuses a number of an option that is not above 0.
pub(crate) fn positive(option: &str, value: f64) -> Result<(), BadInput> {
    let holds = value.is_finite() && value > 0.0;
    if holds { Ok(()) } else { Err(BadInput::new(option, "a finite number > 0", value.to_string())) }
}

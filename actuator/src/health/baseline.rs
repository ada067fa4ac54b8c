//! Baseline of servos in good condition: an earlier report, or the output of `hysteron identify-servo`.

use std::path::Path;

use hysteron_base::{BadInput, file, json};
use serde::Deserialize;

use super::{Estimate, Numbers};

/// Baseline that servos are compared with.
#[derive(Debug, Clone, PartialEq)]
pub struct Baseline {
    /// The file that it comes from.
    pub name: String,
    /// Servo by servo.
    pub servos: Vec<Numbers>,
}

/// `metrics.json` with a section of health, or the output of `identify-servo`.
#[derive(Deserialize)]
struct File {
    #[serde(default)]
    health: Option<Earlier>,
    #[serde(default)]
    servos: Vec<Identified>,
}

#[derive(Deserialize)]
struct Earlier {
    servos: Vec<Numbers>,
}

#[derive(Deserialize)]
struct Identified {
    servo: usize,
    estimates: Vec<EstimateRow>,
}

#[derive(Deserialize)]
struct EstimateRow {
    name: String,
    value: Option<f64>,
    standard_error: Option<f64>,
}

impl Baseline {
    /// Reads `metrics.json` of `hysteron record` or `hysteron track`, or the output of `hysteron identify-servo`.
    ///
    /// # Errors
    /// `BadInput` naming the file and what is missing, or where it is of a rig with other than `n` servos.
    pub fn read(path: &Path, n: usize) -> hysteron_base::Result<Self> {
        let name = path.display().to_string();
        let expected = "metrics.json with a section \"health\", or the output of `hysteron identify-servo`";
        let file: File = json::from_text(&file::read_text(path)?)
            .map_err(|e| BadInput::new(&name, expected, e.to_string()))?;
        let servos = match file.health {
            Some(earlier) => earlier.servos,
            None => identified(&file.servos).map_err(|bad| bad.within(&name))?,
        };
        if servos.is_empty() {
            return Err(BadInput::new(&name, expected, "neither").into());
        }
        if servos.len() != n {
            let found = format!("{} servos", servos.len());
            return Err(BadInput::new(&name, format!("a baseline of {n} servos"), found).into());
        }
        let numbers = servos.iter().flat_map(|one| super::Quantity::ALL.map(|quantity| one.get(quantity)));
        if let Some(bad) = numbers
            .flatten()
            .find(|it| !(it.value.is_finite() && it.standard_error >= 0.0 && it.standard_error.is_finite()))
        {
            let expected = "finite numbers with standard errors of zero or more";
            return Err(
                BadInput::new(&name, expected, format!("{} ± {}", bad.value, bad.standard_error)).into()
            );
        }
        Ok(Self { name, servos })
    }
}

/// Friction over load scale, alike in both directions. Backlash of a pulley is less than the lost motion of its tendon, and no baseline
/// of it.
fn identified(servos: &[Identified]) -> Result<Vec<Numbers>, BadInput> {
    let one = |(k, servo): (usize, &Identified)| {
        if servo.servo != k + 1 {
            return Err(BadInput::new("servos", "all servos of the rig, from 1 on", servo.servo.to_string()));
        }
        let row = |name: &str| servo.estimates.iter().find(|row| row.name == name);
        let value = |name: &str| row(name).and_then(|row| row.value);
        let (Some(friction), Some(scale)) = (value("coulomb_n_m"), value("load_scale_n_m")) else {
            return Ok(Numbers::default());
        };
        let error = |name: &str| row(name).and_then(|row| row.standard_error).unwrap_or(0.0);
        let percent = 100.0 * friction / scale;
        let relative = (error("coulomb_n_m") / friction).hypot(error("load_scale_n_m") / scale);
        let both = Some(Estimate { value: percent, standard_error: percent * relative });
        Ok(Numbers { friction_pulling_percent: both, friction_releasing_percent: both, ..Numbers::default() })
    };
    servos.iter().enumerate().map(one).collect()
}

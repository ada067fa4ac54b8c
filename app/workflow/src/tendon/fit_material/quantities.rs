//! The file that names which quantities to fit.

use std::collections::BTreeMap;
use std::path::Path;

use hysteron_base::{BadInput, Bounds, file, schema};
use hysteron_twin::fit::FitParameter;
use serde::Deserialize;

const FORMAT: &str = "hysteron-fit";
const VERSION: i64 = 1;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FitFile {
    format: String,
    version: i64,
    /// Bounds by key, and the width of the prior; an empty list for the defaults.
    fit: BTreeMap<String, Vec<f64>>,
}

/// Names and bounds in a file.
pub fn read(path: &Path) -> anyhow::Result<Vec<FitParameter>> {
    let text = file::read_text(path)?;
    Ok(names(&text).map_err(|bad| bad.within(path.display()))?)
}

fn names(text: &str) -> Result<Vec<FitParameter>, BadInput> {
    let typed: FitFile = schema::parse(text)?;
    schema::check_header((&typed.format, typed.version), (FORMAT, VERSION))?;
    let parameter = |(key, numbers): (String, Vec<f64>)| match numbers[..] {
        [] => Ok(FitParameter::named(key)),
        [min, max] if min < max => {
            Ok(FitParameter { name: key, bounds: Some(Bounds { min, max }), width: None })
        }
        [min, max, width] if min < max => {
            Ok(FitParameter { name: key, bounds: Some(Bounds { min, max }), width: Some(width) })
        }
        _ => {
            let expected = "[smallest, largest], [smallest, largest, width of the prior] or []";
            Err(BadInput::new(format!("fit.{key}"), expected, format!("{numbers:?}")))
        }
    };
    typed.fit.into_iter().map(parameter).collect()
}

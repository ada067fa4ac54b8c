//! A study exactly as typed: one field per key, units still in the names. Only `convert.rs` reads these.

use serde::Deserialize;

use super::method::Method;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StudyFile {
    pub format: String,
    pub version: i64,
    pub name: String,
    pub seed: u64,
    pub rig: String,
    pub plan: String,
    pub scene: String,
    pub calibrate: Option<Calibrate>,
    pub identify: Option<Identify>,
    pub residual: Option<Residual>,
    pub generate: Option<Generate>,
    pub train: Option<Train>,
    pub track: Option<Track>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Calibrate {
    pub recordings: Vec<String>,
    pub fit: Vec<String>,
    pub steps: Option<i64>,
    pub step_mm: Option<f64>,
    pub every_mm: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Identify {
    pub rounds: Option<i64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Residual {
    pub epochs: Option<i64>,
    pub hidden: Option<i64>,
    pub members: Option<i64>,
    pub passes: Option<i64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Generate {
    pub plan: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Train {
    pub epochs: Option<i64>,
    pub hidden: Option<i64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Track {
    pub targets: Vec<String>,
    /// `ways` in older files.
    #[serde(alias = "ways")]
    pub methods: Vec<Method>,
    pub repeats: i64,
}

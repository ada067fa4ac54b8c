//! The file of a sensor, which `fit-sensor` writes as its outcome.

use std::path::Path;

use hysteron_base::{BadInput, file, json};
use hysteron_twin::sense::ForceSensor;
use serde::Deserialize;

/// Format of the file.
pub(crate) const FORMAT: &str = "hysteron-force-sensor";
/// Its version.
pub(crate) const VERSION: u32 = 2;
/// Largest file that is read [byte].
const MAX_BYTES: u64 = 1 << 20;

/// The robot that a sensor is for: hashes of its scene, and of its network where it has one.
pub(crate) struct SensedRobot<'a> {
    /// Hash of the scene and its mesh.
    pub scene: &'a str,
    /// Hash of the network.
    pub network: Option<&'a str>,
}

#[derive(Deserialize)]
struct SensorHeader {
    format: Option<String>,
    version: Option<u32>,
}

#[derive(Deserialize)]
struct SensorContent {
    sensor: ForceSensor,
}

#[derive(Deserialize)]
struct SensorOrigin {
    scene_sha256: Option<String>,
    residual_sha256: Option<String>,
}

/// Reads a sensor of this robot.
///
/// # Errors
/// Not such a file, damaged, or of another robot.
pub(crate) fn read(path: &Path, robot: &SensedRobot) -> anyhow::Result<ForceSensor> {
    let place = path.display().to_string();
    let bytes = file::read_up_to(path, MAX_BYTES)?;
    let no_sensor =
        |error: json::Error| BadInput::new(&place, "a sensor by hysteron fit-sensor", error.to_string());
    let SensorHeader { format, version } = json::from_text(&bytes).map_err(no_sensor)?;
    if format.as_deref() != Some(FORMAT) || version != Some(VERSION) {
        let expected = format!("format {FORMAT}, version {VERSION}");
        let version = version.map_or_else(|| "none".to_owned(), |version| version.to_string());
        let found = format!("{}, {version}", format.as_deref().unwrap_or("none"));
        return Err(BadInput::new(place, expected, found).into());
    }
    let SensorContent { sensor } = json::from_text(&bytes).map_err(|error| {
        BadInput::new(format!("{place}: sensor"), "the numbers of a sensor", error.to_string())
    })?;
    sensor.check().map_err(|bad| bad.within(format!("{place}: sensor")))?;
    let origin: SensorOrigin = json::from_text(&bytes).map_err(no_sensor)?;
    for (key, expected, found, what) in [
        ("scene_sha256", Some(robot.scene), origin.scene_sha256, "scene and mesh"),
        ("residual_sha256", robot.network, origin.residual_sha256, "network (--residual)"),
    ] {
        if found.as_deref() != expected {
            let text = |hash: Option<&str>| hash.unwrap_or("none").to_owned();
            return Err(BadInput::new(format!("{place}: {key}"), text(expected), text(found.as_deref()))
                .hint(format!("the sensor was fitted with another {what}: fit it again"))
                .into());
        }
    }
    Ok(sensor)
}

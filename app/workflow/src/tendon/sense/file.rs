//! The file of a sensor.

use std::path::Path;

use hysteron_base::{BadInput, file, json};
use hysteron_twin::sense::ForceSensor;
use serde_json::Value;

use crate::{COMMIT, Context};

const FORMAT: &str = "hysteron-force-sensor";
const VERSION: u32 = 2;
/// Largest file that is read [byte].
const MAX_BYTES: u64 = 1 << 20;

/// The robot that a sensor is for: hashes of its scene, and of its network where it has one.
pub struct Robot<'a> {
    pub scene: &'a str,
    pub network: Option<&'a str>,
}

/// Content of the file.
pub fn value(sensor: &ForceSensor, robot: &Robot, recordings: Value, context: &Context) -> Value {
    json!({
        "format": FORMAT, "version": VERSION, "sensor": sensor, "scene_sha256": robot.scene,
        "residual_sha256": robot.network, "recordings": recordings, "command": context.command, "commit": COMMIT,
    })
}

/// Reads a sensor of this robot.
///
/// # Errors
/// Not such a file, damaged, or of another robot.
pub fn read(path: &Path, robot: &Robot) -> anyhow::Result<ForceSensor> {
    let place = path.display().to_string();
    let bytes = file::read_up_to(path, MAX_BYTES)?;
    let found: Value = json::from_text(&bytes)
        .map_err(|error| BadInput::new(&place, "a sensor by hysteron fit-sensor", error.to_string()))?;
    let (format, version) = (found["format"].as_str().unwrap_or("none"), &found["version"]);
    if format != FORMAT || *version != json!(VERSION) {
        let expected = format!("format {FORMAT}, version {VERSION}");
        return Err(BadInput::new(place, expected, format!("{format}, {version}")).into());
    }
    let sensor: ForceSensor = json::from_value(&found["sensor"].clone()).map_err(|error| {
        BadInput::new(format!("{place}: sensor"), "the numbers of a sensor", error.to_string())
    })?;
    sensor.check().map_err(|bad| bad.within(format!("{place}: sensor")))?;
    for (key, expected, what) in [
        ("scene_sha256", Some(robot.scene), "scene and mesh"),
        ("residual_sha256", robot.network, "network (--residual)"),
    ] {
        let found = found[key].as_str();
        if found != expected {
            let text = |hash: Option<&str>| hash.unwrap_or("none").to_owned();
            return Err(BadInput::new(format!("{place}: {key}"), text(expected), text(found))
                .hint(format!("the sensor was fitted with another {what}: fit it again"))
                .into());
        }
    }
    Ok(sensor)
}

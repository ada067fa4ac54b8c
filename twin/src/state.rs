//! All that must be saved to resume: node positions, tensions, and how much of the load is applied.

use std::path::Path;

use hysteron_base::{BadInput, file};
use serde::{Deserialize, Serialize};

use crate::{Result, Twin};

/// A configuration of the twin.
#[derive(Debug, Clone, PartialEq)]
pub struct TwinState {
    /// Node positions [m], model order, padded.
    pub positions: Vec<[f64; 4]>,
    /// Tension of each tendon [N].
    pub tensions: Vec<f64>,
    /// Part of the constant loads that is applied: 0 at rest, 1 after the first step.
    pub load: f64,
}

const FORMAT: &str = "hysteron-state";
const VERSION: u32 = 1;

/// First line of a state file; positions and tensions follow as little-endian `f64`.
#[derive(Debug, Serialize, Deserialize)]
struct Header {
    format: String,
    version: u32,
    scene_hash: String,
    n_nodes: usize,
    n_tendons: usize,
    load: f64,
}

impl TwinState {
    /// Saves the state: a line of JSON, then positions (file order) and tensions, all bits kept.
    ///
    /// # Errors
    /// Refusals of the file system.
    pub fn write(&self, path: &Path, twin: &Twin, scene_hash: &str) -> Result<()> {
        let header = Header {
            format: FORMAT.into(),
            version: VERSION,
            scene_hash: scene_hash.into(),
            n_nodes: self.positions.len(),
            n_tendons: self.tensions.len(),
            load: self.load,
        };
        let positions = twin.body.in_file_order(&self.positions);
        let numbers = positions.as_flattened().iter().chain(&self.tensions);
        file::write_with(path, |out| {
            serde_json::to_writer(&mut *out, &header)?;
            out.write_all(b"\n")?;
            for number in numbers {
                out.write_all(&number.to_le_bytes())?;
            }
            Ok(())
        })?;
        Ok(())
    }

    /// Reads a state of the same scene.
    ///
    /// # Errors
    /// Another format, version, scene or size; a truncated file; a load outside 0 to 1; a number that is not
    /// finite.
    pub fn read(path: &Path, twin: &Twin, scene_hash: &str) -> Result<Self> {
        let bytes = file::read_bytes(path)?;
        let bad = |what: &str, expected: String, found: String| {
            BadInput::new(format!("{}: {what}", path.display()), expected, found)
        };
        let end = bytes.iter().position(|&byte| byte == b'\n').unwrap_or(bytes.len());
        let header: Header = serde_json::from_slice(&bytes[..end])
            .map_err(|error| bad("header", "a state written by hysteron".into(), error.to_string()))?;
        if header.format != FORMAT || header.version != VERSION {
            let found = format!("{} {}", header.format, header.version);
            return Err(bad("format", format!("{FORMAT} {VERSION}"), found).into());
        }
        if header.scene_hash != scene_hash {
            return Err(bad("scene_hash", scene_hash.into(), header.scene_hash)
                .hint("a state belongs to the scene file it was made with")
                .into());
        }
        if !(0.0..=1.0).contains(&header.load) {
            return Err(bad("load", "0 to 1".into(), header.load.to_string()).into());
        }
        let (n_nodes, n_tendons) = (twin.body.n_nodes(), twin.cables.len());
        let body = bytes.get(end + 1..).unwrap_or_default();
        let numbers: Vec<f64> =
            body.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
        if (header.n_nodes, header.n_tendons) != (n_nodes, n_tendons)
            || body.len() != 8 * (3 * n_nodes + n_tendons)
        {
            let expected = format!("{n_nodes} nodes and {n_tendons} tendons");
            let found = format!("{} and {} in {} bytes", header.n_nodes, header.n_tendons, body.len());
            return Err(bad("size", expected, found).hint("the file may be truncated").into());
        }
        if let Some(at) = numbers.iter().position(|number| !number.is_finite()) {
            return Err(bad("numbers", "finite numbers".into(), format!("{} at {at}", numbers[at])).into());
        }
        let (positions, tensions) = numbers.split_at(3 * n_nodes);
        let place = |&file: &u32| {
            let [x, y, z] = positions.as_chunks::<3>().0[file as usize];
            [x, y, z, 0.0]
        };
        Ok(Self {
            positions: twin.body.file_node.iter().map(place).collect(),
            tensions: tensions.to_vec(),
            load: header.load,
        })
    }
}

//! All that must be saved to resume: node positions, tensions, how much of the load is applied, and what friction and
//! backlash remember.

use std::path::Path;

use hysteron_base::{BadInput, file};
use serde::{Deserialize, Serialize};

use crate::{Result, Twin};

/// A configuration of the twin.
#[derive(Debug, Clone, PartialEq)]
pub struct TwinState {
    /// Node positions [m], model order, padded.
    pub positions: Vec<[f64; 4]>,
    /// Tension of each tendon [N], then the jump of tension at each friction point, negative where the tendon is pulled
    /// through it.
    pub tensions: Vec<f64>,
    /// Part of the constant loads that is applied: 0 at rest, 1 after the first step.
    pub load: f64,
    /// Length of tendon that has slid past each friction point towards the pulled end, where it stuck last [m].
    pub slides: Vec<f64>,
    /// What came through the backlash of each real tendon [m]; none without backlash.
    pub plays: Vec<f64>,
}

const FORMAT: &str = "hysteron-state";
const VERSION: u32 = 2;
/// A file without memory of friction or backlash, otherwise the same.
const VERSION_WITHOUT_MEMORY: u32 = 1;

/// First line of a state file; positions, tensions, slides and plays follow as little-endian `f64`.
#[derive(Debug, Serialize, Deserialize)]
struct Header {
    format: String,
    version: u32,
    scene_hash: String,
    n_nodes: usize,
    n_tendons: usize,
    load: f64,
    #[serde(default)]
    n_memory: usize,
}

impl TwinState {
    /// Saves the state: a line of JSON, then positions (file order), tensions and memory, all bits kept.
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
            n_memory: self.slides.len() + self.plays.len(),
        };
        let positions = twin.body.in_file_order(&self.positions);
        let memory = self.slides.iter().chain(&self.plays);
        let numbers = positions.as_flattened().iter().chain(&self.tensions).chain(memory);
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
        if header.format != FORMAT || ![VERSION, VERSION_WITHOUT_MEMORY].contains(&header.version) {
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
        let n_memory = twin.friction.len() + twin.n_plays();
        let body = bytes.get(end + 1..).unwrap_or_default();
        let numbers: Vec<f64> =
            body.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
        let found = (header.n_nodes, header.n_tendons, header.n_memory);
        if found != (n_nodes, n_tendons, n_memory) || body.len() != 8 * (3 * n_nodes + n_tendons + n_memory) {
            let expected = format!(
                "{n_nodes} nodes, {n_tendons} tensions and {n_memory} numbers that friction remembers"
            );
            let found = format!("{}, {} and {} in {} bytes", found.0, found.1, found.2, body.len());
            return Err(bad("size", expected, found).hint("the file may be truncated").into());
        }
        if let Some(at) = numbers.iter().position(|number| !number.is_finite()) {
            return Err(bad("numbers", "finite numbers".into(), format!("{} at {at}", numbers[at])).into());
        }
        let (positions, others) = numbers.split_at(3 * n_nodes);
        let (tensions, memory) = others.split_at(n_tendons);
        let (slides, plays) = memory.split_at(twin.friction.len());
        let place = |&file: &u32| {
            let [x, y, z] = positions.as_chunks::<3>().0[file as usize];
            [x, y, z, 0.0]
        };
        Ok(Self {
            positions: twin.body.file_node.iter().map(place).collect(),
            tensions: tensions.to_vec(),
            load: header.load,
            slides: slides.to_vec(),
            plays: plays.to_vec(),
        })
    }
}

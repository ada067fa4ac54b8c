//! The state of a twin in a file.

use std::path::Path;

use hysteron_base::{BadInput, file, json};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::Result;
use crate::chain::{Interface, WARPINGS};
use crate::model::Twin;
use crate::state::TwinState;

const FORMAT: &str = "hysteron-state";
const VERSION: u32 = 3;
/// Stands for the checksum while it is computed.
const NO_CHECKSUM: &str = "0000000000000000000000000000000000000000000000000000000000000000";

/// First line of a state file; positions of nodes, interfaces, tensions, slides and plays follow as little-endian `f64`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StateHeader {
    format: String,
    version: u32,
    scene_hash: String,
    n_nodes: usize,
    #[serde(default, skip_serializing_if = "is_zero")]
    n_interfaces: usize,
    n_tendons: usize,
    load: f64,
    n_memory: usize,
    /// Command that made it.
    command: String,
    /// SHA-256 of the file with zeros in its place.
    sha256: String,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // as serde calls it
fn is_zero(n: &usize) -> bool {
    *n == 0
}

/// Numbers of an interface: its centre, its rotation by columns, its warping.
const OF_INTERFACE: usize = 3 + 9 + WARPINGS;

impl TwinState {
    /// Saves the state: a line of JSON with a checksum, then positions (file order) or interfaces, tensions and memory, all bits
    /// kept.
    /// `command` is what made it.
    ///
    /// # Errors
    /// Refusals of the file system.
    pub fn write(&self, path: &Path, twin: &Twin, scene_hash: &str, command: &str) -> Result<()> {
        let header = StateHeader {
            format: FORMAT.into(),
            version: VERSION,
            scene_hash: scene_hash.into(),
            n_nodes: self.positions.len(),
            n_interfaces: self.interfaces.len(),
            n_tendons: self.tensions.len(),
            load: self.load,
            n_memory: self.slip.len() + self.backlash.len(),
            command: command.into(),
            sha256: NO_CHECKSUM.into(),
        };
        let positions = match &twin.chain {
            Some(_) => Vec::new(),
            None => twin.body.in_file_order(&self.positions),
        };
        let interfaces = self.interfaces.iter().flat_map(|interface| {
            let Interface { center, rotation, warping } = interface;
            center.iter().chain(rotation).chain(warping)
        });
        let memory = self.slip.iter().chain(&self.backlash);
        let numbers = positions.as_flattened().iter().chain(interfaces).chain(&self.tensions).chain(memory);
        let mut bytes = json!(header).to_string().into_bytes();
        bytes.push(b'\n');
        bytes.extend(numbers.flat_map(|number| number.to_le_bytes()));
        let checksum = file::sha256_hex(&bytes);
        if let Some(place) = place_of(&bytes, NO_CHECKSUM) {
            bytes[place..place + checksum.len()].copy_from_slice(checksum.as_bytes());
        }
        Ok(file::write_bytes(path, bytes)?)
    }

    /// Reads a state of the same scene.
    ///
    /// # Errors
    /// Another format, version, scene or size; a truncated or damaged file; a load outside 0 to 1; a number that is
    /// not finite.
    pub fn read(path: &Path, twin: &Twin, scene_hash: &str) -> Result<Self> {
        let [n_nodes, n_interfaces] = twin.configuration();
        let n_memory = twin.friction.len() + twin.n_backlash();
        let expected = [n_nodes, n_interfaces, twin.cables.len(), n_memory];
        let n_configuration = 3 * n_nodes + OF_INTERFACE * n_interfaces;
        let n_bytes = 8 * (n_configuration + twin.cables.len() + n_memory);
        let mut bytes = file::read_bytes(path)?;
        let bad = |what: &str, expected: String, found: String| {
            BadInput::new(format!("{}: {what}", path.display()), expected, found)
        };
        let end = bytes.iter().position(|&byte| byte == b'\n').unwrap_or(bytes.len());
        let not_ours =
            |error: serde_json::Error| bad("header", "a state by hysteron".into(), error.to_string());
        let header: Value = json::from_text(&bytes[..end]).map_err(not_ours)?;
        let (format, version) = (header["format"].as_str().unwrap_or_default(), &header["version"]);
        if !version.is_u64() {
            let found = "a line of JSON without version".into();
            return Err(bad("header", "a state by hysteron".into(), found).into());
        }
        if format != FORMAT || *version != VERSION {
            return Err(bad("format", format!("{FORMAT} {VERSION}"), format!("{format} {version}"))
                .hint("what another version of the program wrote has to be made again")
                .into());
        }
        let header: StateHeader = json::from_value(&header).map_err(not_ours)?;
        if header.scene_hash != scene_hash {
            return Err(bad("scene_hash", scene_hash.into(), header.scene_hash)
                .hint("a state belongs to the scene and mesh that it was made with; make it again")
                .into());
        }
        if !(0.0..=1.0).contains(&header.load) {
            return Err(bad("load", "0 to 1".into(), header.load.to_string()).into());
        }
        let body = bytes.get(end + 1..).unwrap_or_default();
        let numbers: Vec<f64> =
            body.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
        let found = [header.n_nodes, header.n_interfaces, header.n_tendons, header.n_memory];
        if found != expected || body.len() != n_bytes {
            let text = |[nodes, interfaces, tensions, memory]: [usize; 4]| {
                let configuration = match interfaces {
                    0 => format!("{nodes} nodes"),
                    _ => format!("{interfaces} interfaces"),
                };
                format!("{configuration}, {tensions} tensions and {memory} numbers of the friction state")
            };
            let found = format!("{} in {} bytes", text(found), body.len());
            return Err(bad("size", text(expected), found).hint("the file may be truncated").into());
        }
        if let Some(at) = numbers.iter().position(|number| !number.is_finite()) {
            return Err(bad("numbers", "finite numbers".into(), format!("{} at {at}", numbers[at])).into());
        }
        // Last, so that what can be named is named.
        clear_checksum(&mut bytes, &header.sha256).map_err(|found| {
            bad("sha256", header.sha256.clone(), found).hint("the file was damaged or edited")
        })?;
        let (configuration, others) = numbers.split_at(n_configuration);
        let (tensions, memory) = others.split_at(twin.cables.len());
        let (slip, backlash) = memory.split_at(twin.friction.len());
        let place = |&file: &u32| {
            let [x, y, z] = configuration.as_chunks::<3>().0[file as usize];
            [x, y, z, 0.0]
        };
        let has_nodes = n_interfaces == 0;
        Ok(Self {
            positions: twin.body.file_node.iter().filter(|_| has_nodes).map(place).collect(),
            interfaces: configuration.chunks_exact(OF_INTERFACE).take(n_interfaces).map(interface).collect(),
            tensions: tensions.to_vec(),
            load: header.load,
            slip: slip.to_vec(),
            backlash: backlash.to_vec(),
        })
    }
}

/// From its numbers.
fn interface(numbers: &[f64]) -> Interface {
    let (center, rest) = numbers.split_at(3);
    let (rotation, warping) = rest.split_at(9);
    let mut interface = Interface {
        center: Vector3::from_column_slice(center),
        rotation: Matrix3::from_column_slice(rotation),
        warping: [0.0; WARPINGS],
    };
    interface.warping.copy_from_slice(warping);
    interface
}

/// Offset of the checksum in the first line.
fn place_of(bytes: &[u8], checksum: &str) -> Option<usize> {
    let key = "\"sha256\":\"";
    let entry = format!("{key}{checksum}\"");
    let line = bytes.split(|byte| *byte == b'\n').next().unwrap_or_default();
    line.windows(entry.len()).position(|window| window == entry.as_bytes()).map(|place| place + key.len())
}

/// Puts zeros in the place of the checksum; the one that the file has, if it is not the one that it states.
fn clear_checksum(bytes: &mut [u8], stated: &str) -> std::result::Result<(), String> {
    let place = place_of(bytes, stated).filter(|_| stated.len() == NO_CHECKSUM.len());
    if let Some(place) = place {
        bytes[place..place + NO_CHECKSUM.len()].copy_from_slice(NO_CHECKSUM.as_bytes());
    }
    let found = file::sha256_hex(bytes);
    if place.is_some() && found == stated { Ok(()) } else { Err(found) }
}

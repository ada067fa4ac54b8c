//! Messages of OpenIGTLink: contents and encoding.
//!
//! A reader of its own and not the crate `openigtlink-rust`: that one drags a TLS stack along, and a tracker needs
//! five message types. Written after the protocol's specification (openigtlink.org, version 3) and checked against
//! `pyigtl`. Lengths are millimetres on the wire and metres here.

use super::crc::crc64;
use super::fields::{Fields, padded};
use hysteron_base::LengthUnit::Millimetre;
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion};

/// Bytes of a header.
pub(super) const HEADER: usize = 58;
/// Bytes of the extended header of protocol 3.
const EXTENDED: usize = 12;
/// Bytes of a tool in a TDATA body.
const TOOL: usize = 70;
/// Bytes of a tool in a QTDATA body: name, type, reserved, position and quaternion.
const QUATERNION_TOOL: usize = 50;
/// Largest deviation of a rotation from orthonormal, in any entry of RᵀR, that is rounding [-]. Trackers that
/// round a quaternion to four decimals deviate by 2e-4.
const ORTHONORMAL: f64 = 1e-3;

/// A message.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    /// Name of what sends it: of the tool, for a transform. At most 20 bytes.
    pub device: String,
    /// When its content was true, on the sender's clock [s]; `None` if the sender does not give it.
    pub time: Option<f64>,
    /// Content of the message.
    pub content: MessageContent,
}

/// Content of a message, by its type.
#[derive(Debug, Clone, PartialEq)]
pub enum MessageContent {
    /// TRANSFORM: the pose of the device.
    Transform(ToolPose),
    /// POSITION, also called QTRANS: the same with a quaternion.
    Position(ToolPose),
    /// TDATA, and QTDATA with quaternions: name and pose of each of several tools.
    Tools(Vec<(String, ToolPose)>),
    /// STATUS: how the sender is.
    Status {
        /// 1 if all is well.
        code: u16,
        /// Text of the sender, possibly empty.
        text: String,
    },
}

/// A pose as the sender gives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolPose {
    /// Position [m]; finite.
    pub position: [f64; 3],
    /// Orientation, a unit quaternion w, x, y, z [-].
    pub orientation: [f64; 4],
    /// Whether it can be one; where its rotation was none, the orientation is 1, 0, 0, 0.
    pub validity: Validity,
}

/// Whether a pose can be one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Validity {
    /// Nothing speaks against it.
    Valid,
    /// The sender calls it invalid.
    Marked,
    /// All numbers of the rotation are zero.
    Zeros,
    /// No rotation and no translation at all, to the last bit: not a measurement.
    Identity,
    /// The rotation is none: stretched, sheared or mirrored.
    NoRotation,
}

impl Validity {
    /// For a person, with what to do.
    pub fn words(self) -> &'static str {
        match self {
            Self::Valid => "valid",
            Self::Marked => "marked as invalid by the tracker, or out of its range",
            Self::Zeros => {
                "a matrix of zeros (hint: the sensor is out of sight, or nothing feeds the server's transform)"
            }
            Self::Identity => {
                "the identity, to the last bit (hint: a server sends this until its transform is set)"
            }
            Self::NoRotation => {
                "no rotation: its matrix is stretched, sheared or mirrored, or its quaternion not of length 1 (hint: does the                  server send another matrix, a scaled one, or its transpose with the translation in the last row?)"
            }
        }
    }
}

/// How to write a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MessageFormat {
    /// Versions 1 and 2: no metadata, so invalid poses cannot be distinguished from others.
    Plain,
    /// Version 3: with a status of the transform as metadata, as PlusServer writes it.
    WithStatus,
}

/// Header of a message: its first 58 bytes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MessageHeader {
    pub version: u16,
    pub kind: String,
    pub device: String,
    pub time: Option<f64>,
    pub body: u64,
    pub crc: u64,
}

impl MessageHeader {
    /// Reads a header.
    ///
    /// # Errors
    /// Which field cannot be one.
    pub fn read(bytes: &[u8; HEADER]) -> Result<Self, &'static str> {
        let mut fields = Fields::new(bytes);
        let short = "a header cut short";
        let version = fields.u16().ok_or(short)?;
        if !(1..=3).contains(&version) {
            return Err("no header where one should be: its version is none of 1 to 3");
        }
        Ok(Self {
            version,
            kind: fields.word(12).ok_or("no header where one should be: its type is no word")?,
            device: fields.name(20).ok_or("no header where one should be: its device's name is no text")?,
            time: Some(fields.u64().ok_or(short)?).filter(|&stamp| stamp != 0).map(seconds),
            body: fields.u64().ok_or(short)?,
            crc: fields.u64().ok_or(short)?,
        })
    }

    /// Whether the body is read, or skipped.
    pub fn is_known(&self) -> bool {
        ["TRANSFORM", "POSITION", "QTRANS", "TDATA", "QTDATA", "STATUS"].contains(&self.kind.as_str())
    }

    /// Whether a body of that type can have that size.
    pub fn size_fits(&self) -> bool {
        let fits = |size: u64| match self.kind.as_str() {
            "TRANSFORM" => size == 48,
            "POSITION" | "QTRANS" => [12, 24, 28].contains(&size),
            "TDATA" => size.is_multiple_of(TOOL as u64),
            "QTDATA" => size.is_multiple_of(QUATERNION_TOOL as u64),
            "STATUS" => size >= 30,
            _ => true,
        };
        if self.version == 1 { fits(self.body) } else { self.body >= EXTENDED as u64 }
    }
}

/// Reads the body of a known type, its checksum already compared.
///
/// # Errors
/// A description of the damage.
pub(super) fn read_body(header: &MessageHeader, body: &[u8]) -> Result<Message, String> {
    let short = || format!("{} of {} bytes is too short", header.kind, body.len());
    let (content, status) = if header.version == 1 {
        (body, None)
    } else {
        let mut fields = Fields::new(body);
        let (size, meta_header) = (fields.u16().ok_or_else(short)?, fields.u16().ok_or_else(short)?);
        let meta_body = fields.u32().ok_or_else(short)?;
        let meta = usize::from(meta_header).saturating_add(meta_body as usize);
        let end = body.len().checked_sub(meta).ok_or_else(short)?;
        let content = body.get(usize::from(size)..end).ok_or_else(short)?;
        (content, read_status(&body[end..], usize::from(meta_header), &header.device).ok_or_else(short)?)
    };
    let mut fields = Fields::new(content);
    let content = match header.kind.as_str() {
        "TRANSFORM" => MessageContent::Transform(read_matrix(&mut fields).ok_or_else(short)??),
        "TDATA" => {
            let mut tools = Vec::with_capacity(content.len() / TOOL);
            while !fields.is_empty() {
                let name = fields.name(20).ok_or("TDATA: a tool's name is no text")?;
                fields.u16().ok_or_else(short)?; // type of the tool, reserved
                tools.push((name, read_matrix(&mut fields).ok_or_else(short)??));
            }
            MessageContent::Tools(tools)
        }
        "QTDATA" => {
            let mut tools = Vec::with_capacity(content.len() / QUATERNION_TOOL);
            while !fields.is_empty() {
                let name = fields.name(20).ok_or("QTDATA: a tool's name is no text")?;
                fields.u16().ok_or_else(short)?; // type of the tool, reserved
                let mut pose = Fields::new(fields.take(28).ok_or_else(short)?);
                tools.push((name, read_position(&mut pose).ok_or_else(short)??));
            }
            MessageContent::Tools(tools)
        }
        "STATUS" => {
            let code = fields.u16().ok_or_else(short)?;
            fields.u64().ok_or_else(short)?; // subcode
            let name = fields.name(20).unwrap_or_default();
            let text = String::from_utf8_lossy(fields.rest());
            let text = format!("{name} {}", text.trim_end_matches('\0'));
            MessageContent::Status { code, text: text.trim().to_owned() }
        }
        _ => MessageContent::Position(read_position(&mut fields).ok_or_else(short)??),
    };
    if !fields.is_empty() {
        return Err(format!("{} has bytes to spare", header.kind));
    }
    let mut message = Message { device: header.device.clone(), time: header.time, content };
    if status == Some(false) {
        message.poses_mut().for_each(|pose| pose.validity = Validity::Marked);
    }
    Ok(message)
}

/// The status of the transform in the metadata of protocol 3: `ProbeToTrackerTransformStatus = OK`. The inner
/// `None` if there is none of this device, the outer one if the metadata are damaged.
fn read_status(meta: &[u8], header: usize, device: &str) -> Option<Option<bool>> {
    if meta.is_empty() {
        return Some(None);
    }
    let (mut index, mut data) = (Fields::new(meta.get(..header)?), Fields::new(meta.get(header..)?));
    let mut status = None;
    for _ in 0..index.u16()? {
        let key_size = index.u16()?;
        index.u16()?; // encoding
        let value_size = index.u32()?;
        let key = String::from_utf8_lossy(data.take(usize::from(key_size))?);
        let value = String::from_utf8_lossy(data.take(value_size as usize)?).to_ascii_uppercase();
        let Some(stem) = key.strip_suffix("Status") else { continue };
        let stem = stem.strip_suffix("Transform").unwrap_or(stem);
        if stem.is_empty() || stem == device {
            // Switches on a tool do not concern its pose.
            status = Some(value == "OK" || value.starts_with("SWITCH"));
        }
    }
    Some(status)
}

/// A transform: the columns of the rotation, then the position [mm].
fn read_matrix(fields: &mut Fields) -> Option<Result<ToolPose, String>> {
    let mut values = [0.0; 12];
    for value in &mut values {
        *value = fields.f32()?;
    }
    let rotation = Matrix3::from_column_slice(&values[..9]);
    Some(finite(&values).map(|()| {
        let error = (rotation.transpose() * rotation - Matrix3::identity()).amax();
        let is_rotation = error <= ORTHONORMAL && rotation.determinant() > 0.0;
        let orientation = if is_rotation {
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation)).into_inner()
        } else {
            Quaternion::identity()
        };
        let validity = match () {
            () if rotation == Matrix3::zeros() => Validity::Zeros,
            () if !is_rotation => Validity::NoRotation,
            () if rotation == Matrix3::identity() && values[9..] == [0.0; 3] => Validity::Identity,
            () => Validity::Valid,
        };
        tool_pose(&values[9..], orientation, validity)
    }))
}

/// Position [mm], and the quaternion x, y, z, w: all of it, without w, or none.
fn read_position(fields: &mut Fields) -> Option<Result<ToolPose, String>> {
    let mut values = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let n = [3, 6, 7].into_iter().find(|n| 4 * n == fields.remaining())?;
    for value in &mut values[..n] {
        *value = fields.f32()?;
    }
    Some(finite(&values).map(|()| {
        let [x, y, z, w] = [values[3], values[4], values[5], values[6]];
        let w = if n == 6 { (1.0 - x * x - y * y - z * z).max(0.0).sqrt() } else { w };
        let q = Quaternion::new(w, x, y, z);
        let is_rotation = (q.norm_squared() - 1.0).abs() <= ORTHONORMAL;
        let is_at_origin = values[..3] == [0.0; 3];
        // Without a quaternion only the position is left.
        let validity = match () {
            () if n > 3 && q.norm_squared() == 0.0 => Validity::Zeros,
            () if !is_rotation => Validity::NoRotation,
            () if is_at_origin && q == Quaternion::identity() => Validity::Identity,
            () => Validity::Valid,
        };
        tool_pose(&values[..3], if is_rotation { q } else { Quaternion::identity() }, validity)
    }))
}

fn tool_pose(position: &[f64], orientation: Quaternion<f64>, validity: Validity) -> ToolPose {
    let q = orientation.normalize();
    let position = [position[0], position[1], position[2]].map(|x| x * Millimetre.to_m());
    ToolPose { position, orientation: [q.w, q.i, q.j, q.k], validity }
}

fn finite(values: &[f64]) -> Result<(), String> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(i) => Err(format!("number {} of the pose is {}", i + 1, values[i])),
        None => Ok(()),
    }
}

/// Seconds of a timestamp: 32 bits, then 32 of the fraction [s].
fn seconds(stamp: u64) -> f64 {
    (stamp >> 32) as f64 + (stamp & 0xFFFF_FFFF) as f64 / 4_294_967_296.0
}

/// The timestamp of a time [s]; 0, which means none, if it cannot be one.
fn stamp(time: Option<f64>) -> u64 {
    time.map_or(0, |time| ((time.trunc() as u64) << 32) | (time.fract() * 4_294_967_296.0) as u64)
}

impl ToolPose {
    /// Whether nothing speaks against it.
    pub fn is_valid(&self) -> bool {
        self.validity == Validity::Valid
    }
}

impl Message {
    /// The poses in it.
    fn poses_mut(&mut self) -> impl Iterator<Item = &mut ToolPose> {
        let (one, several): (Option<&mut ToolPose>, &mut [(String, ToolPose)]) = match &mut self.content {
            MessageContent::Transform(pose) | MessageContent::Position(pose) => (Some(pose), &mut []),
            MessageContent::Tools(tools) => (None, tools),
            MessageContent::Status { .. } => (None, &mut []),
        };
        one.into_iter().chain(several.iter_mut().map(|(_, pose)| pose))
    }

    /// The bytes of the message. Names are cut at 20 bytes; values are rounded to `f32`.
    pub fn to_bytes(&self, protocol: MessageFormat) -> Vec<u8> {
        let mut content = Vec::new();
        let (kind, valid) = match &self.content {
            MessageContent::Transform(pose) => {
                put(&mut content, &matrix(pose));
                ("TRANSFORM", pose.is_valid())
            }
            MessageContent::Position(pose) => {
                let [w, x, y, z] = pose.orientation;
                put(&mut content, &pose.position.map(|x| x / Millimetre.to_m()));
                put(&mut content, &[x, y, z, w]);
                ("POSITION", pose.is_valid())
            }
            MessageContent::Tools(tools) => {
                for (name, pose) in tools {
                    content.extend(padded::<20>(name));
                    content.extend([2, 0]); // a 6-DOF tool; reserved
                    put(&mut content, &matrix(pose));
                }
                ("TDATA", tools.iter().all(|(_, pose)| pose.is_valid()))
            }
            MessageContent::Status { code, text } => {
                content.extend(code.to_be_bytes());
                content.extend([0; 28]); // subcode, name of the error
                content.extend(text.bytes());
                content.push(0);
                ("STATUS", true)
            }
        };
        match protocol {
            MessageFormat::Plain => frame(1, kind, self, &content),
            MessageFormat::WithStatus => {
                let (key, value) =
                    (format!("{}TransformStatus", self.device), if valid { "OK" } else { "MISSING" });
                let mut body = Vec::new();
                body.extend((EXTENDED as u16).to_be_bytes());
                body.extend(10_u16.to_be_bytes()); // size of the index of the metadata
                body.extend(((key.len() + value.len()) as u32).to_be_bytes());
                body.extend(0_u32.to_be_bytes()); // number of the message
                body.extend(&content);
                body.extend(1_u16.to_be_bytes()); // pairs
                body.extend((key.len() as u16).to_be_bytes());
                body.extend(3_u16.to_be_bytes()); // US-ASCII, by its number at IANA
                body.extend((value.len() as u32).to_be_bytes());
                body.extend(key.bytes().chain(value.bytes()));
                frame(2, kind, self, &body)
            }
        }
    }
}

/// The request to send TDATA every `interval` [s], rounded to milliseconds: some servers wait for it.
pub fn start_request(device: &str, interval: f64) -> Vec<u8> {
    let mut body = Vec::from(((interval * 1e3).round() as u32).to_be_bytes());
    body.extend([0; 32]); // name of the coordinate system
    let message =
        Message { device: device.to_owned(), time: None, content: MessageContent::Tools(Vec::new()) };
    frame(1, "STT_TDATA", &message, &body)
}

/// Header and body. Protocol 3 calls its header version 2.
fn frame(version: u16, kind: &str, message: &Message, body: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEADER + body.len());
    bytes.extend(version.to_be_bytes());
    bytes.extend(padded::<12>(kind));
    bytes.extend(padded::<20>(&message.device));
    bytes.extend(stamp(message.time).to_be_bytes());
    bytes.extend((body.len() as u64).to_be_bytes());
    bytes.extend(crc64(0, body).to_be_bytes());
    bytes.extend(body);
    bytes
}

/// Appends numbers as `f32`.
fn put(content: &mut Vec<u8>, values: &[f64]) {
    values.iter().for_each(|value| content.extend((*value as f32).to_be_bytes()));
}

/// Columns of the rotation, then the position [mm]; a rotation of zeros if the pose is invalid, which no reader
/// can take for one.
fn matrix(pose: &ToolPose) -> [f64; 12] {
    let mut values = [0.0; 12];
    if pose.is_valid() {
        let [w, x, y, z] = pose.orientation;
        let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)).to_rotation_matrix();
        values[..9].copy_from_slice(rotation.matrix().as_slice());
    }
    for k in 0..3 {
        values[9 + k] = pose.position[k] / Millimetre.to_m();
    }
    values
}

#[cfg(test)]
mod tests;

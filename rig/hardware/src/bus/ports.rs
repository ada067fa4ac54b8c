//! Serial ports: which there are, and which of them is a U2D2. The only module that knows `serialport` on the host's
//! side.

use crate::{Error, Result};
use serialport::SerialPortType;
use std::path::{Path, PathBuf};

/// USB ids of the converters that speak to Dynamixel servos: vendor, product, name.
const CONVERTERS: [(u16, u16, &str); 3] =
    [(0x0403, 0x6014, "U2D2"), (0x2f5d, 0x2202, "OpenRB-150"), (0x16d0, 0x06a7, "USB2AX")];
/// How long the kernel may keep bytes of a U2D2 back [ms].
const LATENCY_MAX_MS: u32 = 1;

/// A serial port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortInfo {
    /// Its device.
    pub path: PathBuf,
    /// Name of the converter, if it is one that is known to speak to servos.
    pub converter: Option<&'static str>,
    /// Description from USB; empty for other ports.
    pub description: String,
    /// Latency timer of the kernel [ms], where it is known.
    pub latency_ms: Option<u32>,
}

impl PortInfo {
    /// Recommended change of its settings; `None` if none is needed.
    pub fn advice(&self) -> Option<String> {
        let latency = self.latency_ms.filter(|latency| *latency > LATENCY_MAX_MS)?;
        let name = self.path.file_name()?.to_string_lossy();
        Some(format!(
            "its latency timer is {latency} ms, too slow for 100 Hz: \
             echo 1 | sudo tee /sys/bus/usb-serial/devices/{name}/latency_timer"
        ))
    }
}

/// All serial ports of this machine.
///
/// # Errors
/// `Bus` if the system does not give them.
pub fn list_ports() -> Result<Vec<PortInfo>> {
    let ports = serialport::available_ports().map_err(|e| Error::Bus(format!("listing the ports: {e}")))?;
    let mut ports: Vec<PortInfo> = ports
        .into_iter()
        .map(|port| {
            let path = PathBuf::from(&port.port_name);
            let (converter, description) = match port.port_type {
                SerialPortType::UsbPort(usb) => {
                    let known = CONVERTERS.iter().find(|(vid, pid, _)| (usb.vid, usb.pid) == (*vid, *pid));
                    let names = [usb.manufacturer, usb.product, usb.serial_number];
                    let names: Vec<String> = names.into_iter().flatten().collect();
                    (
                        known.map(|(_, _, name)| *name),
                        format!("{:04x}:{:04x} {}", usb.vid, usb.pid, names.join(" ")),
                    )
                }
                _ => (None, String::new()),
            };
            let latency_ms = latency_of(&path);
            PortInfo { path, converter, description, latency_ms }
        })
        .collect();
    ports.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(ports)
}

fn latency_of(path: &Path) -> Option<u32> {
    let name = path.file_name()?.to_str()?;
    let timer = format!("/sys/bus/usb-serial/devices/{name}/latency_timer");
    std::fs::read_to_string(timer).ok()?.trim().parse().ok()
}

/// The port of a rig file: itself, or the only known converter for `auto`.
///
/// # Errors
/// `Bus` listing what is there.
pub fn find_port(named: &Path) -> Result<PathBuf> {
    if named != Path::new("auto") {
        return Ok(named.to_owned());
    }
    let ports = list_ports()?;
    let known: Vec<&PortInfo> = ports.iter().filter(|port| port.converter.is_some()).collect();
    match known[..] {
        [port] => Ok(port.path.clone()),
        [] => {
            let there: Vec<String> = ports.iter().map(|port| port.path.display().to_string()).collect();
            let there = if there.is_empty() { "no serial port at all".into() } else { there.join(", ") };
            Err(Error::Bus(format!(
                "no U2D2 found; there is {there} (hint: plug it in, or name the port in servos.port)"
            )))
        }
        _ => {
            let there: Vec<String> = known.iter().map(|port| port.path.display().to_string()).collect();
            Err(Error::Bus(format!(
                "several converters: {} (hint: name one of them in servos.port)",
                there.join(", ")
            )))
        }
    }
}

/// Hint for a port that does not open.
pub(super) fn hint(error: &std::io::Error) -> &'static str {
    match error.kind() {
        std::io::ErrorKind::NotFound => {
            "`hysteron rig check` lists the ports that are there; is the converter plugged in, or the emulator running?"
        }
        std::io::ErrorKind::PermissionDenied => {
            "add yourself to the group that owns the port, usually dialout"
        }
        std::io::ErrorKind::WouldBlock => "another hysteron uses it",
        _ => "does another program use it?",
    }
}

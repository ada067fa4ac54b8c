//! The rig file: which servos pull which tendons, where the tracker is, and what must never be passed.

mod schema;

use crate::Result;
use crate::bus::model::{ServoModel, XL430_W250};
use crate::bus::{ServoBounds, xl430};
use hysteron_base::number::shown;
use hysteron_base::schema::{FixedArray, check_header, count, require, text, vector};
use hysteron_base::{BadInput, file};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// An example of a rig file: copy it.
pub const RIG_FILE: &str = include_str!("../../presets/rig.toml");

const FORMAT: &str = "hysteron-rig";
const VERSION: i64 = 1;
/// How a recording is named in place of a server.
const REPLAY: &str = "replay:";
/// Largest id that protocol 2.0 gives to one servo.
pub(crate) const ID_MAX: i64 = 252;

/// Longest name of a device in OpenIGTLink [bytes].
const DEVICE_BYTES: usize = 20;
/// Radii of pulleys on the horn of such a servo [mm].
pub(crate) const PULLEY_RADIUS_MM: (f64, f64) = (1.0, 100.0);
/// Furthest that a stroke, or a point that a tracker sees, can be on such a rig [mm].
const FURTHEST_MM: (f64, f64) = (1000.0, 10_000.0);
/// Fastest that a limit of a stroke's rate makes sense, and of a tip's speed [mm/s].
const FASTEST_MM_S: f64 = 1000.0;
const FASTEST_TIP_MM_S: f64 = 100_000.0;
/// Largest numbers that a servo's registers of heat and supply take [degrees C, V].
const HOTTEST_DEGC: f64 = 100.0;
const SUPPLY_MAX_V: f64 = 16.0;

pub(crate) type Check<T> = std::result::Result<T, BadInput>;

/// A number within bounds.
pub(crate) fn within(key: &str, typed: f64, low: f64, high: f64) -> Check<f64> {
    require(key, &format!("{low} to {high}"), typed, (low..=high).contains(&typed))
}

/// A number above zero, up to a bound.
pub(crate) fn above_zero(key: &str, typed: f64, high: f64) -> Check<f64> {
    require(key, &format!("0 < x <= {high}"), typed, 0.0 < typed && typed <= high)
}

/// A point that a tracker can see.
fn point(key: &str, typed: FixedArray<f64, 3>) -> Check<[f64; 3]> {
    let furthest = FURTHEST_MM.1;
    for (axis, x) in typed.0.into_iter().enumerate() {
        within(key, x, -furthest, furthest)
            .map_err(|bad| BadInput { place: format!("{key}[{axis}]"), ..bad })?;
    }
    vector(key, typed)
}

/// A rig: everything valid, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct RigConfig {
    /// For people.
    pub name: String,
    /// SHA-256 of the file.
    pub hash: String,
    /// The bus.
    pub servos: ServoConfig,
    /// One per tendon, in the order of strokes.
    pub tendons: Vec<TendonConfig>,
    /// The tracker, if there is one.
    pub tracker: Option<TrackerConfig>,
    /// Safety limits.
    pub limits: SafetyLimits,
    /// How it moves before and after a run.
    pub motion: RigMotion,
    /// How it is calibrated.
    pub calibration: CalibrationConfig,
}

/// The servo bus.
#[derive(Debug, Clone, PartialEq)]
pub struct ServoConfig {
    /// Serial port, or `auto` for the only U2D2 that is plugged in.
    pub port: PathBuf,
    /// Speed of the bus [bit/s].
    pub baud: u32,
    /// Within one turn, or over many.
    pub mode: ServoMode,
    /// Gains of the position loop, as the registers take them: P, I, D.
    pub gains: [u16; 3],
    /// Silence on the bus after which a servo's watchdog stops it [s]; 0: never.
    pub bus_watchdog: f64,
    /// How long to wait for an answer beyond its time on the wire [s].
    pub reply_timeout: f64,
    /// How often to ask again.
    pub retries: u32,
}

/// How a servo counts its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ServoMode {
    /// Within one turn.
    Position,
    /// Over many turns.
    Extended,
}

/// Which way a servo turns to wind its tendon up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WindingDirection {
    /// Towards larger ticks.
    Positive,
    /// Towards smaller ticks.
    Negative,
}

impl WindingDirection {
    /// 1 or -1.
    pub fn sign(self) -> f64 {
        match self {
            Self::Positive => 1.0,
            Self::Negative => -1.0,
        }
    }
}

/// One tendon and the servo that pulls it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TendonConfig {
    /// Id of the servo on the bus.
    pub servo_id: u8,
    /// Which way it winds.
    pub winds: WindingDirection,
    /// Radius at which the tendon lies on its pulley [m].
    pub pulley_radius: f64,
    /// Where the tendon runs in the body, from x towards y of the robot's frame [rad].
    pub angle: f64,
}

/// Where poses come from.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackerConfig {
    /// Live, or repeated.
    pub source: TrackerSource,
    /// Name of the device to listen to; empty for the first that speaks.
    pub device: String,
    /// Poses per second that are to be expected [Hz].
    pub rate: f64,
    /// From measuring to arriving, at the least [s].
    pub latency: f64,
    /// Silence after which the tip counts as not tracked [s].
    pub stale: f64,
    /// Fastest that the tip can move [m/s].
    pub speed_max: f64,
    /// Where the tip rests in the robot's frame [m].
    pub tip_rest: [f64; 3],
}

/// Source of the tip's position.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TrackerSource {
    /// Host and port of an OpenIGTLink server.
    OpenIgtLink(String),
    /// A recording, to try servos without a tracker: its tip, in the robot's frame.
    Replay(PathBuf),
}

/// Safety limits of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SafetyLimits {
    /// Smallest stroke [m].
    pub stroke_min: f64,
    /// Largest stroke [m].
    pub stroke_max: f64,
    /// Largest speed of a stroke, either way [m/s].
    pub stroke_rate_max: f64,
    /// Furthest that a servo may be from its goal [m of stroke]: something blocks it, or its watchdog
    /// has stopped it.
    pub lag_max: f64,
    /// Largest load, of the stall torque [-].
    pub load_max: f64,
    /// Load above which a tendon is pulled no further, of the stall torque [-].
    pub load_limiting: Option<f64>,
    /// Largest temperature of a servo [°C].
    pub temperature_max: f64,
    /// Smallest supply voltage [V].
    pub voltage_min: f64,
    /// Largest supply voltage [V].
    pub voltage_max: f64,
    /// Corners of the box that the tip stays in, in the robot's frame [m].
    pub tip_min: [f64; 3],
    /// See `tip_min` [m].
    pub tip_max: [f64; 3],
}

/// How the rig moves before and after a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigMotion {
    /// Speed of strokes on the way to the start and back to rest [m/s].
    pub slew: f64,
    /// Torque at the end of a run, for any reason of the end.
    pub at_end: AtEnd,
}

/// State of the torque at the end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AtEnd {
    /// Switched off: the tendons go slack.
    Release,
    /// Left on: the robot keeps its shape, and the servos their heat.
    Hold,
}

/// How the rig is calibrated.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationConfig {
    /// Where the calibration is, relative to the rig file.
    pub file: PathBuf,
    /// Load at which a tendon counts as no longer slack [-].
    pub slack_load: f64,
    /// Load of every tendon at rest [-].
    pub pretension_load: f64,
    /// Furthest that a tendon is pulled in search of its slack's end [m].
    pub search_max: f64,
    /// Stroke with which each tendon is pulled to find the tracker's frame [m].
    pub probe: f64,
}

impl RigConfig {
    /// Reads a rig file.
    ///
    /// # Errors
    /// `BadInput` naming file, line and key.
    pub fn read(path: &Path) -> Result<Self> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let text = file::read_text(path)?;
        Ok(Self::from_toml(&text, folder).map_err(|bad| bad.within(path.display()))?)
    }

    /// The rig in the text of a rig file; relative paths in it start at `folder`.
    ///
    /// # Errors
    /// `BadInput` naming line and key.
    pub fn from_toml(text: &str, folder: &Path) -> Check<Self> {
        let typed: schema::RigFile = hysteron_base::schema::parse(text)?;
        check_header((&typed.format, typed.version), (FORMAT, VERSION))?;
        let mut config = Self {
            name: self::text("name", typed.name)?,
            hash: file::sha256_hex(text.as_bytes()),
            servos: servos(&typed.servos)?,
            tendons: tendons(&typed.tendon)?,
            tracker: typed.tracker.as_ref().map(|typed| tracker(typed, folder)).transpose()?,
            limits: limits(&typed.limits)?,
            motion: RigMotion {
                slew: above_zero("motion.slew_mm_s", typed.motion.slew_mm_s, FASTEST_MM_S)?,
                at_end: typed.motion.at_end,
            },
            calibration: calibration(&typed.calibration)?,
        };
        config.calibration.file = folder.join(&config.calibration.file);
        if config.servos.port != Path::new("auto") {
            config.servos.port = folder.join(&config.servos.port);
        }
        config.check_together()?;
        Ok(config)
    }

    /// Ids of the servos, in the order of the tendons.
    pub fn ids(&self) -> Vec<u8> {
        self.tendons.iter().map(|tendon| tendon.servo_id).collect()
    }

    /// Expected model and bounds of each servo, in the order of the tendons.
    pub fn servo_bounds(&self) -> Vec<(&'static ServoModel, ServoBounds)> {
        vec![(&XL430_W250, self.limits.servo_bounds()); self.tendons.len()]
    }

    /// Check of the keys against each other.
    fn check_together(&self) -> Check<()> {
        if self.motion.slew > self.limits.stroke_rate_max {
            return Err(BadInput::new(
                "motion.slew_mm_s",
                "at most limits.stroke_rate_max_mm_s",
                format!("{}", 1e3 * self.motion.slew),
            ));
        }
        if let Some(tracker) = &self.tracker {
            self.check_rest(tracker)?;
        }
        let load = self.calibration.slack_load.max(self.calibration.pretension_load);
        if load >= self.limits.load_max {
            return Err(BadInput::new(
                "calibration.slack_load_percent",
                "a load of the calibration below limits.load_max_percent",
                format!("{:?}", 100.0 * load),
            ));
        }
        let turn = |tendon: &TendonConfig| std::f64::consts::TAU * tendon.pulley_radius;
        let range = self.limits.stroke_max - self.limits.stroke_min;
        match self.tendons.iter().position(|tendon| range > turn(tendon)) {
            Some(i) if self.servos.mode == ServoMode::Position => Err(BadInput::new(
                format!("tendon[{}].pulley_radius_mm", i + 1),
                format!("one turn for all {} mm of stroke", shown(1e3 * range)),
                format!("{:.1} mm a turn", 1e3 * turn(&self.tendons[i])),
            )
            .hint("use operating_mode = \"extended\"")),
            _ => Ok(()),
        }
    }
}

impl RigConfig {
    /// A tip that rests out of its bounds, or a tracker that counts as silent between two poses, would end every run.
    fn check_rest(&self, tracker: &TrackerConfig) -> Check<()> {
        for axis in 0..3 {
            let (low, x, high) =
                (self.limits.tip_min[axis], tracker.tip_rest[axis], self.limits.tip_max[axis]);
            if !(low..=high).contains(&x) {
                return Err(BadInput::new(
                    format!("tracker.tip_rest_mm[{axis}]"),
                    format!("within limits.tip_min_mm and tip_max_mm, {:?} to {:?}", 1e3 * low, 1e3 * high),
                    format!("{:?}", 1e3 * x),
                ));
            }
        }
        if tracker.stale * tracker.rate < 1.0 {
            return Err(BadInput::new(
                "tracker.stale_ms",
                format!("at least one period of the tracker, {:.1} ms", 1e3 / tracker.rate),
                format!("{:?}", 1e3 * tracker.stale),
            ));
        }
        Ok(())
    }
}

/// Speed of a bus [bit/s].
pub(crate) fn baud(key: &str, typed: i64) -> Check<u32> {
    let known = u32::try_from(typed).ok().filter(|baud| xl430::BAUDS.contains(baud));
    known.ok_or_else(|| BadInput::new(key, format!("one of {:?}", xl430::BAUDS), typed.to_string()))
}

/// A gain of the position loop, as its register takes it.
pub(crate) fn gain(key: &str, typed: i64) -> Check<u16> {
    let fits = u16::try_from(typed).ok().filter(|gain| *gain <= 16_383);
    fits.ok_or_else(|| BadInput::new(key, "a whole number from 0 to 16383", typed.to_string()))
}

/// Silence after which servos stop by themselves, as typed [ms].
pub(crate) fn bus_watchdog(key: &str, typed: f64) -> Check<f64> {
    let is_possible = typed == 0.0 || (100.0..=2540.0).contains(&typed);
    require(key, "0 for none, or 100 to 2540", typed, is_possible)
}

/// Wait for an answer, as typed [ms].
pub(crate) fn reply_timeout(key: &str, typed: f64) -> Check<f64> {
    require(key, "0 < x <= 1000", typed, 0.0 < typed && typed <= 1000.0)
}

/// How often to ask again.
pub(crate) fn retries(key: &str, typed: i64) -> Check<u32> {
    let fits = u32::try_from(typed).ok().filter(|retries| *retries <= 10);
    fits.ok_or_else(|| BadInput::new(key, "a whole number from 0 to 10", typed.to_string()))
}

fn servos(typed: &schema::RigServosTable) -> Check<ServoConfig> {
    Ok(ServoConfig {
        port: PathBuf::from(text("servos.port", typed.port.clone())?),
        baud: baud("servos.baud", typed.baud)?,
        mode: typed.operating_mode,
        gains: [
            gain("servos.position_p_gain", typed.position_p_gain)?,
            gain("servos.position_i_gain", typed.position_i_gain)?,
            gain("servos.position_d_gain", typed.position_d_gain)?,
        ],
        bus_watchdog: bus_watchdog("servos.bus_watchdog_ms", typed.bus_watchdog_ms)?,
        reply_timeout: reply_timeout("servos.reply_timeout_ms", typed.reply_timeout_ms)?,
        retries: retries("servos.retries", typed.retries)?,
    })
}

fn tendons(typed: &[schema::RigTendonTable]) -> Check<Vec<TendonConfig>> {
    if typed.is_empty() {
        return Err(BadInput::new("tendon", "at least one [[tendon]]", "none"));
    }
    let mut tendons: Vec<TendonConfig> = Vec::new();
    for (i, typed) in typed.iter().enumerate() {
        let key = |name: &str| format!("tendon[{}].{name}", i + 1);
        let id = count(&key("servo_id"), typed.servo_id, ID_MAX)?;
        let servo_id = u8::try_from(id).unwrap_or(u8::MAX);
        if tendons.iter().any(|earlier| earlier.servo_id == servo_id) {
            return Err(BadInput::new(key("servo_id"), "a unique servo", format!("{id} again")));
        }
        tendons.push(TendonConfig {
            servo_id,
            winds: typed.winds,
            pulley_radius: within(
                &key("pulley_radius_mm"),
                typed.pulley_radius_mm,
                PULLEY_RADIUS_MM.0,
                PULLEY_RADIUS_MM.1,
            )?,
            angle: within(&key("angle_deg"), typed.angle_deg, -360.0, 360.0)?,
        });
    }
    Ok(tendons)
}

fn tracker(typed: &schema::RigTrackerTable, folder: &Path) -> Check<TrackerConfig> {
    Ok(TrackerConfig {
        source: match text("tracker.address", typed.address.clone())?.strip_prefix(REPLAY) {
            Some(path) => TrackerSource::Replay(folder.join(text("tracker.address", path.to_owned())?)),
            None => TrackerSource::OpenIgtLink(server("tracker.address", &typed.address)?),
        },
        device: device("tracker.device", &typed.device)?,
        rate: within("tracker.rate_hz", typed.rate_hz, 1.0, 1000.0)?,
        latency: within("tracker.latency_ms", typed.latency_ms, 0.0, 1000.0)?,
        stale: above_zero("tracker.stale_ms", typed.stale_ms, 60_000.0)?,
        speed_max: above_zero("tracker.speed_max_mm_s", typed.speed_max_mm_s, FASTEST_TIP_MM_S)?,
        tip_rest: point("tracker.tip_rest_mm", typed.tip_rest_mm)?,
    })
}

/// Host and port of a server; whether it is there is seen when it is asked.
fn server(key: &str, typed: &str) -> Check<String> {
    let is_host = |host: &str| !host.is_empty() && !host.contains(|c: char| c.is_whitespace() || c == '/');
    let is_port =
        |port: &str| port.bytes().all(|b| b.is_ascii_digit()) && port.parse::<u16>().is_ok_and(|n| n > 0);
    match typed.rsplit_once(':') {
        Some((host, port)) if is_host(host) && is_port(port) => Ok(typed.to_owned()),
        _ => Err(BadInput::new(
            key,
            "HOST:PORT with a port from 1 to 65535, or replay:FILE",
            format!("{typed:?}"),
        )
        .hint("such as 192.168.0.5:18944")),
    }
}

/// The name of a device, as OpenIGTLink can hold it; empty for the first that speaks.
fn device(key: &str, typed: &str) -> Check<String> {
    if typed.len() > DEVICE_BYTES || typed.chars().any(char::is_control) {
        let expected = format!("a name of at most {DEVICE_BYTES} bytes");
        return Err(BadInput::new(key, expected, format!("{typed:?}")));
    }
    Ok(typed.to_owned())
}

fn limits(typed: &schema::SafetyLimitsTable) -> Check<SafetyLimits> {
    let limits = SafetyLimits {
        // Rest, where every run begins and ends, is at zero.
        stroke_min: within("limits.stroke_min_mm", typed.stroke_min_mm, -FURTHEST_MM.0, 0.0)?,
        stroke_max: within("limits.stroke_max_mm", typed.stroke_max_mm, 0.0, FURTHEST_MM.0)?,
        stroke_rate_max: above_zero("limits.stroke_rate_max_mm_s", typed.stroke_rate_max_mm_s, FASTEST_MM_S)?,
        lag_max: above_zero("limits.lag_max_mm", typed.lag_max_mm, FURTHEST_MM.0)?,
        load_max: require(
            "limits.load_max_percent",
            "0 < x <= 100",
            typed.load_max_percent,
            0.0 < typed.load_max_percent && typed.load_max_percent <= 100.0,
        )?,
        load_limiting: match typed.load_limit_percent {
            Some(hold) => Some(require(
                "limits.load_limit_percent",
                &format!("0 < x <= load_max_percent = {:?}", typed.load_max_percent),
                hold,
                0.0 < hold && hold <= typed.load_max_percent,
            )?),
            None => None,
        },
        temperature_max: above_zero("limits.temperature_max_degc", typed.temperature_max_degc, HOTTEST_DEGC)?,
        voltage_min: within("limits.voltage_min_v", typed.voltage_min_v, 0.0, SUPPLY_MAX_V)?,
        voltage_max: above_zero("limits.voltage_max_v", typed.voltage_max_v, SUPPLY_MAX_V)?,
        tip_min: point("limits.tip_min_mm", typed.tip_min_mm)?,
        tip_max: point("limits.tip_max_mm", typed.tip_max_mm)?,
    };
    let ordered = [
        ("limits.stroke_min_mm", typed.stroke_min_mm, "stroke_max_mm", typed.stroke_max_mm),
        ("limits.voltage_min_v", typed.voltage_min_v, "voltage_max_v", typed.voltage_max_v),
        ("limits.tip_min_mm[0]", typed.tip_min_mm[0], "tip_max_mm[0]", typed.tip_max_mm[0]),
        ("limits.tip_min_mm[1]", typed.tip_min_mm[1], "tip_max_mm[1]", typed.tip_max_mm[1]),
        ("limits.tip_min_mm[2]", typed.tip_min_mm[2], "tip_max_mm[2]", typed.tip_max_mm[2]),
    ];
    match ordered.iter().find(|(_, low, _, high)| low >= high) {
        Some((key, low, name, high)) => {
            Err(BadInput::new(*key, format!("below {name} = {high:?}"), format!("{low:?}")))
        }
        None => Ok(limits),
    }
}

fn calibration(typed: &schema::CalibrationTable) -> Check<CalibrationConfig> {
    let percent = |key: &str, typed: f64| require(key, "0 < x < 100", typed, 0.0 < typed && typed < 100.0);
    Ok(CalibrationConfig {
        file: PathBuf::from(text("calibration.file", typed.file.clone())?),
        slack_load: percent("calibration.slack_load_percent", typed.slack_load_percent)?,
        pretension_load: percent("calibration.pretension_load_percent", typed.pretension_load_percent)?,
        search_max: above_zero("calibration.search_max_mm", typed.search_max_mm, FURTHEST_MM.0)?,
        probe: above_zero("calibration.probe_mm", typed.probe_mm, FURTHEST_MM.0)?,
    })
}

#[cfg(test)]
mod tests;

//! The calibration file: written by `hysteron rig calibrate`, read by everything that moves.

use super::{ChannelMap, RigCalibration};
use crate::Result;
use crate::bus::registers::StoredRegisters;
use crate::config::{PULLEY_RADIUS_MM, RigConfig, WindingDirection};
use crate::tracker::Registration;
use hysteron_base::schema::{FixedArray, check_header, require, text, vector};
use hysteron_base::{BadInput, file};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

const FORMAT: &str = "hysteron-calibration";
const VERSION: i64 = 1;
/// Positions beyond this are no angle that a servo reaches [ticks].
const FURTHEST: i64 = 1 << 24;

/// Furthest from its zero that a tendon's slack can end [mm].
const FURTHEST_MM: f64 = 1000.0;

type Check<T> = std::result::Result<T, BadInput>;

/// A number within bounds.
fn within(key: &str, typed: f64, (low, high): (f64, f64)) -> Check<f64> {
    require(key, &format!("{low} to {high}"), typed, (low..=high).contains(&typed))
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CalibrationFile {
    format: String,
    version: i64,
    date: String,
    rig: String,
    channel: Vec<ChannelFile>,
    registration: Option<RegistrationFile>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ChannelFile {
    servo_id: u8,
    model: u16,
    ticks_per_turn: i64,
    pulley_radius_mm: f64,
    winds: WindingDirection,
    zero_ticks: i64,
    slack_end_mm: f64,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    registers: BTreeMap<String, i64>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RegistrationFile {
    rotation_wxyz: FixedArray<f64, 4>,
    translation_mm: FixedArray<f64, 3>,
    residual_deg: f64,
}

impl RigCalibration {
    /// Reads a calibration.
    ///
    /// # Errors
    /// `BadInput` naming file, line and key.
    pub fn read(path: &Path, rig: &RigConfig) -> Result<Self> {
        let text = file::read_text(path).map_err(|error| match error {
            hysteron_base::Error::BadInput(bad) if bad.found == "nothing there" => {
                hysteron_base::Error::BadInput(bad.hint(format!(
                    "make it with `hysteron rig calibrate`; rig \"{}\" has none yet",
                    rig.name
                )))
            }
            other => other,
        })?;
        let found = Self::from_toml(&text).and_then(|found| found.check_rig(rig).map(|()| found));
        Ok(found.map_err(|bad| bad.within(path.display()))?)
    }

    /// Refuses the calibration of another rig file.
    fn check_rig(&self, rig: &RigConfig) -> Check<()> {
        let hint = "it is the calibration of another rig; run `hysteron rig calibrate`";
        let ids: Vec<u8> = self.channels.iter().map(|channel| channel.servo_id).collect();
        if ids != rig.ids() {
            let expected = format!("servos {:?}, as the rig file has", rig.ids());
            return Err(BadInput::new("channel", expected, format!("{ids:?}")).hint(hint));
        }
        for (k, (channel, tendon)) in self.channels.iter().zip(&rig.tendons).enumerate() {
            if channel.pulley_radius != tendon.pulley_radius || channel.winds != tendon.winds {
                let place = format!("channel[{}]", k + 1);
                let found = format!("{:?} mm, {:?}", 1e3 * channel.pulley_radius, channel.winds);
                return Err(BadInput::new(place, "pulley and direction of the rig file", found).hint(hint));
            }
        }
        Ok(())
    }

    /// The calibration in the text of a file.
    ///
    /// # Errors
    /// `BadInput` naming line and key.
    pub fn from_toml(text: &str) -> Check<Self> {
        let typed: CalibrationFile = hysteron_base::schema::parse(text)?;
        check_header((&typed.format, typed.version), (FORMAT, VERSION))?;
        if typed.channel.is_empty() {
            return Err(BadInput::new("channel", "at least one [[channel]]", "none"));
        }
        let channels: Check<Vec<ChannelMap>> =
            typed.channel.iter().enumerate().map(|(i, typed)| channel(i + 1, typed)).collect();
        Ok(Self {
            date: self::text("date", typed.date)?,
            rig: self::text("rig", typed.rig)?,
            channels: channels?,
            registration_residual: match &typed.registration {
                Some(typed) => within("registration.residual_deg", typed.residual_deg, (0.0, 180.0))?,
                None => 0.0,
            },
            registration: typed.registration.as_ref().map(registration).transpose()?,
            registers: registers(&typed.channel)?,
        })
    }

    /// SHA-256 of its contents, numbers to nine digits: the same however often it was written and read.
    pub fn hash(&self) -> String {
        let mut text = format!("{} {}", self.date, self.rig);
        let mut numbers: Vec<f64> = Vec::new();
        for channel in &self.channels {
            numbers.extend([f64::from(channel.servo_id), f64::from(channel.model)]);
            numbers.extend([channel.ticks_per_turn, channel.zero].map(f64::from));
            numbers.extend([channel.pulley_radius, channel.winds.sign(), channel.slack_end]);
        }
        if let Some(found) = &self.registration {
            numbers.extend(found.rotation());
            numbers.extend(found.translation());
        }
        // One that knows nothing of registers has the hash that it always had.
        numbers.extend(self.registers.iter().flat_map(StoredRegisters::numbers));
        for x in numbers {
            text.push_str(&format!(" {x:.8e}"));
        }
        file::sha256_hex(text.as_bytes())
    }

    /// The text of a calibration file.
    pub fn to_toml(&self) -> String {
        let typed = CalibrationFile {
            format: FORMAT.into(),
            version: VERSION,
            date: self.date.clone(),
            rig: self.rig.clone(),
            channel: self.typed_channels(),
            registration: self.registration.map(|found| RegistrationFile {
                rotation_wxyz: FixedArray(found.rotation()),
                translation_mm: FixedArray(found.translation().map(|x| 1e3 * x)),
                residual_deg: self.registration_residual.to_degrees(),
            }),
        };
        // Plain numbers and text always have a form in TOML.
        toml::to_string(&typed).unwrap_or_default()
    }

    fn typed_channels(&self) -> Vec<ChannelFile> {
        let registers = |k: usize| self.registers.get(k).map(StoredRegisters::to_keys).unwrap_or_default();
        self.channels.iter().enumerate().map(|(k, channel)| typed_channel(channel, registers(k))).collect()
    }
}

/// Registers of all servos, or of none: a calibration knows them or does not.
fn registers(typed: &[ChannelFile]) -> Check<Vec<StoredRegisters>> {
    if typed.iter().all(|channel| channel.registers.is_empty()) {
        return Ok(Vec::new());
    }
    let one = |(i, typed): (usize, &ChannelFile)| {
        let place = format!("channel[{}].registers", i + 1);
        if typed.registers.is_empty() {
            return Err(BadInput::new(place, "registers of every servo, or of none", "none"));
        }
        StoredRegisters::from_keys(&place, &typed.registers)
    };
    typed.iter().enumerate().map(one).collect()
}

fn typed_channel(channel: &ChannelMap, registers: BTreeMap<String, i64>) -> ChannelFile {
    ChannelFile {
        registers,
        servo_id: channel.servo_id,
        model: channel.model,
        ticks_per_turn: channel.ticks_per_turn.into(),
        pulley_radius_mm: 1e3 * channel.pulley_radius,
        winds: channel.winds,
        zero_ticks: channel.zero.into(),
        slack_end_mm: 1e3 * channel.slack_end,
    }
}

fn channel(number: usize, typed: &ChannelFile) -> Check<ChannelMap> {
    let key = |name: &str| format!("channel[{number}].{name}");
    let ticks = |name: &str, typed: i64, low: i64| {
        i32::try_from(typed).ok().filter(|_| (low..=FURTHEST).contains(&typed)).ok_or_else(|| {
            BadInput::new(key(name), format!("a whole number from {low} to {FURTHEST}"), typed.to_string())
        })
    };
    Ok(ChannelMap {
        servo_id: typed.servo_id,
        model: typed.model,
        ticks_per_turn: ticks("ticks_per_turn", typed.ticks_per_turn, 1)?,
        pulley_radius: within(&key("pulley_radius_mm"), typed.pulley_radius_mm, PULLEY_RADIUS_MM)?,
        winds: typed.winds,
        zero: ticks("zero_ticks", typed.zero_ticks, -FURTHEST)?,
        slack_end: within(&key("slack_end_mm"), typed.slack_end_mm, (-FURTHEST_MM, FURTHEST_MM))?,
    })
}

fn registration(typed: &RegistrationFile) -> Check<Registration> {
    let translation = vector("registration.translation_mm", typed.translation_mm)?;
    Registration::new(typed.rotation_wxyz.0, translation)
        .map_err(|bad| BadInput { place: "registration.rotation_wxyz".into(), ..bad })
}

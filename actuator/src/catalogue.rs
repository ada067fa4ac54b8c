//! Drives from files of TOML: those of the catalogue come with the program, others a person writes.
//!
//! A file states where its numbers come from. Numbers of data sheets are those of a motor without friction; `hysteron arm
//! identify servo` brings them to a recording and finds friction.

use std::collections::BTreeMap;

use hysteron_base::schema::{FixedArray, between, within};
use hysteron_base::{BadInput, schema};
use serde::{Deserialize, Serialize};

use crate::drive::{Drive, Gear};
use crate::law::{JointFriction, Law};
use crate::motor::{Motor, Supply, Winding};
use crate::position_loop::LoopSpec;

/// A drive and where its numbers come from; other files hold it as the text of its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct CatalogueDrive {
    /// Name of the product.
    pub name: String,
    /// Where the numbers come from.
    pub source: String,
    /// The drive.
    pub drive: Drive,
}

const FILES: [(&str, &str); 7] = [
    ("mx-106", include_str!("../drives/mx-106.toml")),
    ("mx-64", include_str!("../drives/mx-64.toml")),
    ("sts3215", include_str!("../drives/sts3215.toml")),
    ("sts3250", include_str!("../drives/sts3250.toml")),
    ("xl330-m288", include_str!("../drives/xl330-m288.toml")),
    ("xl430-w250", include_str!("../drives/xl430-w250.toml")),
    ("xm430-w350", include_str!("../drives/xm430-w350.toml")),
];

/// Header of the files.
const FORMAT: (&str, i64) = ("hysteron-drive", 1);

/// Numbers that a motor on a bench can have, from a hearing aid's to a crane's, in the unit of the key. An ideal supply has no
/// resistance, and a winding or a magnet may not feel the heat.
const VOLTAGE_V: [f64; 2] = [0.1, 1e3];
const SUPPLY_OHM: [f64; 2] = [0.0, 1e3];
const TORQUE_CONSTANT: [f64; 2] = [1e-5, 1e4];
const RESISTANCE_OHM: [f64; 2] = [1e-4, 1e5];
const CURRENT_A: [f64; 2] = [1e-4, 1e4];
const HEAT_CAPACITY: [f64; 2] = [1e-3, 1e9];
const HEAT_RESISTANCE: [f64; 2] = [1e-4, 1e5];
const SLOPE_PER_K: [f64; 2] = [0.0, 0.1];
const TEMPERATURE_DEGC: f64 = 200.0;
const ARMATURE_KG_M2: [f64; 2] = [1e-10, 1e4];
const BACKLASH_DEG: [f64; 2] = [0.0, 45.0];
/// Of a law: torques [N m], their slopes by speed and angle, shares, speeds and exponents.
const FRICTION: [f64; 2] = [0.0, 1e7];
const TICKS: [f64; 2] = [4.0, 1e9];
const DEAD_BAND_TICKS: [f64; 2] = [0.0, 1e6];
const PWM: [f64; 2] = [1.0, 1e9];
const GAIN_UNIT: [f64; 2] = [1e-9, 1e12];
const PERIOD_MS: [f64; 2] = [1e-3, 1e3];

type Check<T> = Result<T, BadInput>;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct DriveFile {
    format: String,
    version: i64,
    name: String,
    source: String,
    motor: MotorTable,
    supply: SupplyTable,
    winding: WindingTable,
    gear: GearTable,
    #[serde(rename = "loop")]
    position_loop: LoopTable,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct MotorTable {
    torque_constant_n_m_per_a: f64,
    resistance_ohm: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    current_limit_a: Option<f64>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SupplyTable {
    voltage_v: f64,
    resistance_ohm: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct WindingTable {
    heat_capacity_j_per_k: f64,
    to_case_k_per_w: f64,
    case_heat_capacity_j_per_k: f64,
    to_air_k_per_w: f64,
    resistance_slope_per_k: f64,
    magnet_slope_per_k: f64,
    reference_degc: f64,
    air_degc: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct GearTable {
    armature_kg_m2: f64,
    /// None where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    backlash_deg: Option<f64>,
    law: String,
    friction: BTreeMap<String, f64>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LoopTable {
    ticks_per_turn: f64,
    pwm_full_scale: f64,
    gain_units: FixedArray<f64, 3>,
    period_ms: f64,
    /// None where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    dead_band_ticks: Option<f64>,
}

impl CatalogueDrive {
    /// Names of the drives that come with the program.
    pub fn names() -> impl Iterator<Item = &'static str> {
        FILES.iter().map(|(name, _)| *name)
    }

    /// The drive of that name.
    ///
    /// # Errors
    /// `BadInput` with the names there are.
    pub fn named(name: &str) -> Check<Self> {
        let Some((_, text)) = FILES.iter().find(|(known, _)| *known == name) else {
            let names: Vec<&str> = Self::names().collect();
            let expected = format!("a file of TOML, or one of {}", names.join(", "));
            return Err(BadInput::new("drive", expected, format!("{name:?}")));
        };
        Self::parse(text)
    }

    /// The drive of a file's text.
    ///
    /// # Errors
    /// `BadInput` naming the key, prefix the file with [`BadInput::within`]: a number that cannot be, a law that is none, a
    /// parameter that the law has not or lacks.
    pub fn parse(text: &str) -> Check<Self> {
        let typed: DriveFile = schema::parse(text)?;
        schema::check_header((&typed.format, typed.version), FORMAT)?;
        let supply = Supply {
            voltage: between("supply.voltage_v", typed.supply.voltage_v, VOLTAGE_V)?,
            resistance: between("supply.resistance_ohm", typed.supply.resistance_ohm, SUPPLY_OHM)?,
        };
        Ok(Self {
            name: schema::text("name", typed.name)?,
            source: source(&typed.source)?,
            drive: Drive {
                motor: motor(&typed.motor, supply.voltage)?,
                supply,
                winding: winding(&typed.winding)?,
                gear: gear(typed.gear)?,
                position_loop: position_loop(&typed.position_loop)?,
            },
        })
    }
}

impl TryFrom<String> for CatalogueDrive {
    type Error = BadInput;

    fn try_from(text: String) -> Check<Self> {
        Self::parse(&text)
    }
}

/// The text of its file.
impl From<CatalogueDrive> for String {
    fn from(CatalogueDrive { name, source, drive }: CatalogueDrive) -> Self {
        let Drive { motor, supply, winding, gear, position_loop } = drive;
        let some = |value: f64| (value > 0.0 && value.is_finite()).then_some(value);
        let names = gear.law.parameters().into_iter().map(|parameter| parameter.name.into_owned());
        let file = DriveFile {
            format: FORMAT.0.to_owned(),
            version: FORMAT.1,
            name,
            source,
            motor: MotorTable {
                torque_constant_n_m_per_a: motor.torque_constant(),
                resistance_ohm: motor.resistance(),
                current_limit_a: some(motor.current_limit),
            },
            supply: SupplyTable { voltage_v: supply.voltage, resistance_ohm: supply.resistance },
            winding: WindingTable {
                heat_capacity_j_per_k: winding.heat_capacity,
                to_case_k_per_w: winding.to_case,
                case_heat_capacity_j_per_k: winding.case_heat_capacity,
                to_air_k_per_w: winding.to_air,
                resistance_slope_per_k: winding.resistance_slope,
                magnet_slope_per_k: winding.magnet_slope,
                reference_degc: winding.reference,
                air_degc: winding.air,
            },
            gear: GearTable {
                armature_kg_m2: gear.armature,
                backlash_deg: some(gear.backlash.to_degrees()),
                law: gear.law.name().to_owned(),
                friction: names.zip(gear.friction).collect(),
            },
            position_loop: LoopTable {
                ticks_per_turn: position_loop.ticks_per_turn,
                pwm_full_scale: position_loop.pwm_full_scale,
                gain_units: FixedArray(position_loop.gains),
                period_ms: 1e3 * position_loop.period,
                dead_band_ticks: some(position_loop.dead_band),
            },
        };
        toml::to_string(&file).unwrap_or_default()
    }
}

/// Source of a file's numbers, as one line.
fn source(typed: &str) -> Check<String> {
    let line = typed.split_whitespace().collect::<Vec<_>>().join(" ");
    match line.is_empty() {
        true => Err(BadInput::new("source", "where the numbers come from", "nothing")),
        false => Ok(line),
    }
}

fn motor(typed: &MotorTable, rated_voltage: f64) -> Check<Motor> {
    let torque_constant =
        between("motor.torque_constant_n_m_per_a", typed.torque_constant_n_m_per_a, TORQUE_CONSTANT)?;
    let resistance = between("motor.resistance_ohm", typed.resistance_ohm, RESISTANCE_OHM)?;
    let current_limit = (typed.current_limit_a)
        .map_or(Ok(f64::INFINITY), |limit| between("motor.current_limit_a", limit, CURRENT_A))?;
    Ok(Motor { current_limit, ..Motor::new(torque_constant, resistance, rated_voltage) })
}

fn winding(typed: &WindingTable) -> Check<Winding> {
    Ok(Winding {
        heat_capacity: between("winding.heat_capacity_j_per_k", typed.heat_capacity_j_per_k, HEAT_CAPACITY)?,
        to_case: between("winding.to_case_k_per_w", typed.to_case_k_per_w, HEAT_RESISTANCE)?,
        case_heat_capacity: between(
            "winding.case_heat_capacity_j_per_k",
            typed.case_heat_capacity_j_per_k,
            HEAT_CAPACITY,
        )?,
        to_air: between("winding.to_air_k_per_w", typed.to_air_k_per_w, HEAT_RESISTANCE)?,
        resistance_slope: between(
            "winding.resistance_slope_per_k",
            typed.resistance_slope_per_k,
            SLOPE_PER_K,
        )?,
        magnet_slope: between("winding.magnet_slope_per_k", typed.magnet_slope_per_k, SLOPE_PER_K)?,
        reference: within("winding.reference_degc", typed.reference_degc, TEMPERATURE_DEGC)?,
        air: within("winding.air_degc", typed.air_degc, TEMPERATURE_DEGC)?,
    })
}

fn gear(typed: GearTable) -> Check<Gear> {
    let armature = between("gear.armature_kg_m2", typed.armature_kg_m2, ARMATURE_KG_M2)?;
    let backlash = between("gear.backlash_deg", typed.backlash_deg.unwrap_or(0.0), BACKLASH_DEG)?;
    let law = Law::named(&typed.law).map_err(|bad| BadInput { place: "gear.law".to_owned(), ..bad })?;
    let parameters = law.parameters();
    let is_known = |name: &str| parameters.iter().any(|parameter| parameter.name == name);
    if let Some(name) = typed.friction.keys().find(|name| !is_known(name)) {
        let names: Vec<&str> = parameters.iter().map(|parameter| parameter.name.as_ref()).collect();
        let place = format!("gear.friction.{name}");
        return Err(BadInput::new(place, format!("one of {}", names.join(", ")), "another"));
    }
    let value = |name: &str| {
        let place = format!("gear.friction.{name}");
        match typed.friction.get(name) {
            Some(value) => between(&place, *value, FRICTION),
            None => Err(BadInput::new(place, "this key, of the law", "nothing")),
        }
    };
    let friction = parameters.iter().map(|parameter| value(&parameter.name)).collect::<Check<_>>()?;
    Ok(Gear { armature, backlash, law, friction })
}

fn position_loop(typed: &LoopTable) -> Check<LoopSpec> {
    for (k, unit) in typed.gain_units.iter().enumerate() {
        between(&format!("loop.gain_units[{k}]"), *unit, GAIN_UNIT)?;
    }
    Ok(LoopSpec {
        ticks_per_turn: between("loop.ticks_per_turn", typed.ticks_per_turn, TICKS)?,
        pwm_full_scale: between("loop.pwm_full_scale", typed.pwm_full_scale, PWM)?,
        gains: typed.gain_units.0,
        period: between("loop.period_ms", typed.period_ms, PERIOD_MS)?,
        dead_band: between("loop.dead_band_ticks", typed.dead_band_ticks.unwrap_or(0.0), DEAD_BAND_TICKS)?,
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may stop where it stands
mod tests {
    use super::*;
    use crate::{Bridge, DriveLoad, DriveState};

    /// Stall torque and free speed of the data sheets [N m, rev/min] at their voltage [V]; friction is in what a drive does.
    const DATA_SHEETS: [(&str, f64, f64, f64); 7] = [
        ("xl330-m288", 5.0, 0.52, 103.0),
        ("xl430-w250", 12.0, 1.5, 61.0),
        ("xm430-w350", 12.0, 4.1, 46.0),
        ("mx-64", 12.0, 6.0, 63.0),
        ("mx-106", 12.0, 8.4, 45.0),
        ("sts3215", 7.4, 1.9, 45.0),
        ("sts3250", 12.0, 4.9, 75.0),
    ];

    #[test]
    fn every_drive_of_the_catalogue_turns_about_as_fast_as_in_its_data_sheet() {
        assert_eq!(CatalogueDrive::names().count(), DATA_SHEETS.len());
        for (name, voltage, _, speed) in DATA_SHEETS {
            let mut drive = CatalogueDrive::named(name).unwrap().drive;
            (drive.supply.voltage, drive.winding.heat_capacity) = (voltage, f64::INFINITY);
            let mut state = DriveState::resting(0.0, drive.winding.reference);
            for _ in 0..5000 {
                drive.step(&mut state, Bridge::Driven(1.0), DriveLoad::torque(0.0), 1e-3);
            }
            let free = state.velocity * 60.0 / std::f64::consts::TAU;
            // Identified samples and data sheets differ by that much: bam's two MX, our XL330.
            assert!((free / speed - 1.0).abs() < 0.25, "{name}: {free} rev/min, data sheet {speed}");
        }
    }

    #[test]
    fn stalled_torque_is_below_what_motor_and_supply_give() {
        for (name, voltage, torque, _) in DATA_SHEETS {
            let drive = CatalogueDrive::named(name).unwrap().drive;
            let current = (voltage / drive.motor.resistance()).min(drive.motor.current_limit);
            let ratio = current * drive.motor.torque_constant() / torque;
            assert!((0.8..2.2).contains(&ratio), "{name}: {ratio} times the stall torque of the data sheet");
        }
    }

    #[test]
    fn the_text_of_a_drive_is_that_drive() {
        for (name, file) in FILES {
            let one = CatalogueDrive::parse(file).unwrap();
            let [there, back] = [
                String::from(one.clone()),
                String::from(CatalogueDrive::parse(&String::from(one.clone())).unwrap()),
            ];
            for (there, back) in there.lines().zip(back.lines()) {
                let number =
                    |line: &str| line.split(" = ").nth(1).and_then(|value| value.parse::<f64>().ok());
                // What is divided and multiplied on the way is off by a rounding.
                let is_same = match (number(there), number(back)) {
                    (Some(a), Some(b)) => (a - b).abs() <= 1e-15 * a.abs(),
                    _ => there == back,
                };
                assert!(is_same, "{name}: {there} is not {back}");
            }
            // Everything that a person types comes back.
            for line in file.lines().filter(|line| line.contains(" = ") && !line.contains("version")) {
                let key = line.split(" = ").next().unwrap_or_default();
                assert!(there.lines().any(|there| there.starts_with(key)), "{name}: {line} in {there}");
            }
        }
        let backlash = CatalogueDrive::named("xm430-w350").unwrap().drive.gear.backlash;
        assert!((backlash - 0.25_f64.to_radians()).abs() < 1e-15, "{backlash} rad");
    }

    #[test]
    fn damaged_files_name_the_key() {
        let text = FILES[4].1;
        let place = |from: &str, to: &str| {
            assert!(text.contains(from), "{from}");
            CatalogueDrive::parse(&text.replacen(from, to, 1)).unwrap_err().place
        };
        assert_eq!(place("hysteron-drive", "hysteron-scene"), "format");
        assert_eq!(place("law = \"m4\"", "law = \"m9\""), "gear.law");
        assert_eq!(place("alpha", "beta"), "gear.friction.beta");
        assert_eq!(place("alpha = 1.0\n", ""), "gear.friction.alpha");
        assert_eq!(place("resistance_ohm = 2.8", "resistance_ohm = -2.8"), "motor.resistance_ohm");
        assert_eq!(place("resistance_ohm = 2.8", "resistance_ohm = nan"), "motor.resistance_ohm");
        assert_eq!(place("law = \"m4\"", "backlash_deg = -0.1\nlaw = \"m4\""), "gear.backlash_deg");
        assert_eq!(place("period_ms = ", "dead_band_ticks = -1.0\nperiod_ms = "), "loop.dead_band_ticks");
        assert_eq!(CatalogueDrive::named("xl999").unwrap_err().place, "drive");
    }

    /// Keys of numbers that no drive may have as zero.
    const NOT_ZERO: [&str; 12] = [
        "torque_constant_n_m_per_a",
        "resistance_ohm", // of the motor, which comes first
        "voltage_v",
        "heat_capacity_j_per_k",
        "to_case_k_per_w",
        "case_heat_capacity_j_per_k",
        "to_air_k_per_w",
        "armature_kg_m2",
        "ticks_per_turn",
        "pwm_full_scale",
        "gain_units",
        "period_ms",
    ];

    #[test]
    fn numbers_that_no_drive_has_are_refused_with_the_range() {
        let text = FILES[4].1;
        let (mut n_far, mut n_zero) = (0, 0);
        for (line, typed) in text.lines().filter_map(|line| Some((line, line.split_once(" = ")?))) {
            let (key, value) = (typed.0, typed.1.split('#').next().unwrap_or_default().trim());
            let is_number = value.parse::<f64>().is_ok() && key != "version";
            if !is_number && key != "gain_units" {
                continue;
            }
            let with = |number: &str| {
                let value = if is_number { number.to_owned() } else { format!("[{number}, 1.0, 1.0]") };
                CatalogueDrive::parse(&text.replacen(line, &format!("{key} = {value}"), 1))
            };
            for far in ["1e300", "-1e300"] {
                let bad = with(far).unwrap_err();
                assert!(bad.place.contains(key) && bad.expected.contains(" to "), "{bad}");
                n_far += 1;
            }
            if NOT_ZERO.contains(&key) {
                n_zero += usize::from(with("0.0").is_err_and(|bad| bad.place.contains(key)));
            }
        }
        // The supply's resistance may be zero; it has the motor's name.
        assert_eq!(n_zero, NOT_ZERO.len());
        assert!(n_far > 40, "{n_far}");
    }
}

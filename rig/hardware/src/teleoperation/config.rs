//! The file of two arms: which servo of the leader moves which of the follower, and what must never be passed.

use super::schema;
use crate::Result;
use crate::bus::ServoBounds;
use crate::bus::model::ServoModel;
use crate::bus::registers::StoredRegisters;
use crate::bus::xl430::TICKS_PER_TURN;
use crate::config::{
    Check, ID_MAX, ServoConfig, ServoMode, WindingDirection, above_zero, baud, bus_watchdog, gain,
    reply_timeout, retries, within,
};
use hysteron_base::schema::{check_header, count, text};
use hysteron_base::{BadInput, file};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

const VERSION: i64 = 1;
/// Rates at which an arm can be led [Hz].
const RATES_HZ: (f64, f64) = (5.0, 200.0);
/// Most joints with the gripper, and so servos on a bus.
const MAX_JOINTS: usize = 16;
/// Furthest that a joint turns either way, as typed [degrees].
const FURTHEST_DEG: f64 = 720.0;
/// Fastest that a goal moves, as typed [degrees/s].
const FASTEST_DEG_S: f64 = 2000.0;
/// Largest current of such a servo [A].
const CURRENT_MAX_A: f64 = 10.0;
/// Largest numbers that a servo's registers of heat and supply take [degrees C, V].
const HOTTEST_DEGC: f64 = 100.0;
const SUPPLY_MAX_V: f64 = 16.0;

/// Two arms: everything valid, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmsConfig {
    /// For people.
    pub name: String,
    /// SHA-256 of the file.
    pub hash: String,
    /// Time between two rows [s].
    pub period: f64,
    /// The leader's bus; only port, speed and patience of it are used.
    pub leader: ServoConfig,
    /// The follower's bus.
    pub follower: ServoConfig,
    /// From the base to the gripper.
    pub joints: Vec<JointConfig>,
    /// Whether the last joint moves jaws, and how.
    pub gripper: Option<GripperConfig>,
    /// Safety limits.
    pub limits: ArmLimits,
    /// Speed with which the follower goes to the leader, and to rest [rad/s].
    pub approach: f64,
}

/// A joint and its servos.
#[derive(Debug, Clone, PartialEq)]
pub struct JointConfig {
    /// As the robot's file calls it.
    pub name: String,
    /// Of the leader.
    pub leader: ServoMount,
    /// Of the follower.
    pub follower: ServoMount,
    /// Least and greatest angle that the follower is sent to [rad].
    pub range: [f64; 2],
    /// Where it rests without torque [rad].
    pub rest: f64,
}

/// How a servo sits in its joint.
#[derive(Debug, Clone, PartialEq)]
pub struct ServoMount {
    /// Id on its bus.
    pub id: u8,
    /// Which servo it is.
    pub model: &'static ServoModel,
    /// Position at the joint's zero [ticks].
    pub zero: i32,
    /// Which way its ticks grow.
    pub turns: WindingDirection,
    /// Registers whose value intentionally differs from the factory's.
    pub registers: StoredRegisters,
}

/// Jaws of a gripper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GripperConfig {
    /// Aperture per angle of the motor [m/rad].
    pub lever: f64,
    /// Angle at which the jaws touch [rad].
    pub closed: f64,
}

/// Safety limits of the arms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmLimits {
    /// Fastest that a goal moves, however fast the leader is [rad/s].
    pub speed_max: f64,
    /// Furthest that the follower may be from its goal [rad].
    pub lag_max: f64,
    /// Largest current of a motor [A].
    pub current_max: f64,
    /// Supply and heat of the follower's servos.
    pub servos: ServoBounds,
}

impl ServoMount {
    /// Angle of the joint at a position [rad].
    pub fn angle(&self, ticks: i32) -> f64 {
        self.turns.sign() * f64::from(ticks - self.zero) * TAU / f64::from(TICKS_PER_TURN)
    }

    /// Position at an angle of the joint [ticks].
    pub fn ticks(&self, angle: f64) -> i32 {
        self.zero + (self.turns.sign() * angle * f64::from(TICKS_PER_TURN) / TAU).round() as i32
    }
}

impl GripperConfig {
    /// Aperture at an angle of the motor [m].
    pub fn aperture(&self, angle: f64) -> f64 {
        self.lever * (angle - self.closed)
    }
}

impl ArmsConfig {
    /// Format name in such a file.
    pub const FORMAT: &str = "hysteron-arms";

    /// Reads a file of two arms.
    ///
    /// # Errors
    /// `BadInput` naming file, line and key.
    pub fn read(path: &Path) -> Result<Self> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let text = file::read_text(path)?;
        Ok(Self::from_toml(&text, folder).map_err(|bad| bad.within(path.display()))?)
    }

    /// The arms in the text of a file; relative paths in it start at `folder`.
    ///
    /// # Errors
    /// `BadInput` naming line and key.
    pub fn from_toml(text: &str, folder: &Path) -> Check<Self> {
        let typed: schema::ArmsFile = hysteron_base::schema::parse(text)?;
        check_header((&typed.format, typed.version), (Self::FORMAT, VERSION))?;
        let hash = file::sha256_hex(text.as_bytes());
        let config = Self {
            name: self::text("name", typed.name)?,
            hash,
            period: 1.0 / within("rate_hz", typed.rate_hz, RATES_HZ.0, RATES_HZ.1)?,
            leader: leader(&typed.leader, folder)?,
            follower: follower(&typed.follower, folder)?,
            joints: joints(&typed.joint)?,
            gripper: typed.gripper.as_ref().map(gripper).transpose()?,
            limits: limits(&typed.limits)?,
            approach: above_zero("motion.approach_deg_s", typed.motion.approach_deg_s, FASTEST_DEG_S)?,
        };
        config.check_together()?;
        Ok(config)
    }

    /// Check of the keys against each other.
    fn check_together(&self) -> Check<()> {
        if self.approach > self.limits.speed_max {
            let found = format!("{}", self.approach.to_degrees());
            return Err(BadInput::new("motion.approach_deg_s", "at most limits.speed_max_deg_s", found));
        }
        let is_auto = |bus: &ServoConfig| bus.port == Path::new("auto");
        if is_auto(&self.leader) || is_auto(&self.follower) || self.leader.port == self.follower.port {
            let hint = "name both, such as /dev/serial/by-id/…, so that they cannot be exchanged";
            let found = self.follower.port.display().to_string();
            return Err(BadInput::new("follower.port", "a separate port, named", found).hint(hint));
        }
        Ok(())
    }
}

/// A port as typed, relative to the file's folder.
fn port(key: &str, typed: &str, folder: &Path) -> Check<PathBuf> {
    let typed = text(key, typed.to_owned())?;
    Ok(if typed == "auto" { PathBuf::from(typed) } else { folder.join(typed) })
}

fn leader(typed: &schema::LeaderTable, folder: &Path) -> Check<ServoConfig> {
    Ok(ServoConfig {
        port: port("leader.port", &typed.port, folder)?,
        baud: baud("leader.baud", typed.baud)?,
        mode: ServoMode::Extended,
        gains: [0; 3],
        bus_watchdog: 0.0,
        reply_timeout: reply_timeout("leader.reply_timeout_ms", typed.reply_timeout_ms)?,
        retries: retries("leader.retries", typed.retries)?,
    })
}

fn follower(typed: &schema::FollowerTable, folder: &Path) -> Check<ServoConfig> {
    Ok(ServoConfig {
        port: port("follower.port", &typed.port, folder)?,
        baud: baud("follower.baud", typed.baud)?,
        mode: typed.operating_mode,
        gains: [
            gain("follower.position_p_gain", typed.position_p_gain)?,
            gain("follower.position_i_gain", typed.position_i_gain)?,
            gain("follower.position_d_gain", typed.position_d_gain)?,
        ],
        bus_watchdog: bus_watchdog("follower.bus_watchdog_ms", typed.bus_watchdog_ms)?,
        reply_timeout: reply_timeout("follower.reply_timeout_ms", typed.reply_timeout_ms)?,
        retries: retries("follower.retries", typed.retries)?,
    })
}

fn joints(typed: &[schema::JointTable]) -> Check<Vec<JointConfig>> {
    if !(1..=MAX_JOINTS).contains(&typed.len()) {
        let expected = format!("1 to {MAX_JOINTS} of [[joint]]");
        return Err(BadInput::new("joint", expected, typed.len().to_string()));
    }
    let mut joints: Vec<JointConfig> = Vec::new();
    for (i, typed) in typed.iter().enumerate() {
        let key = |name: &str| format!("joint[{}].{name}", i + 1);
        let joint = JointConfig {
            name: text(&key("name"), typed.name.clone())?,
            leader: mount(&key("leader"), &typed.leader)?,
            follower: mount(&key("follower"), &typed.follower)?,
            range: [
                within(&key("min_deg"), typed.min_deg, -FURTHEST_DEG, FURTHEST_DEG)?,
                within(&key("max_deg"), typed.max_deg, typed.min_deg, FURTHEST_DEG)?,
            ],
            rest: within(&key("rest_deg"), typed.rest_deg, typed.min_deg, typed.max_deg)?,
        };
        for (which, id_of) in
            [("leader", leader_id as fn(&JointConfig) -> u8), ("follower", |joint| joint.follower.id)]
        {
            if joints.iter().any(|earlier| id_of(earlier) == id_of(&joint)) {
                let found = format!("{} again", id_of(&joint));
                return Err(BadInput::new(key(&format!("{which}.id")), "a unique servo", found));
            }
        }
        joints.push(joint);
    }
    Ok(joints)
}

fn leader_id(joint: &JointConfig) -> u8 {
    joint.leader.id
}

fn mount(key: &str, typed: &schema::TeleoperationServoTable) -> Check<ServoMount> {
    let furthest = f64::from(TICKS_PER_TURN) * 256.0;
    let zero = within(&format!("{key}.zero_ticks"), typed.zero_ticks as f64, -furthest, furthest)?;
    Ok(ServoMount {
        id: u8::try_from(count(&format!("{key}.id"), typed.id, ID_MAX)?).unwrap_or(u8::MAX),
        model: ServoModel::named(&format!("{key}.model"), &typed.model)?,
        zero: zero as i32,
        turns: typed.turns,
        registers: StoredRegisters::from_keys(&format!("{key}.registers"), &typed.registers)?,
    })
}

/// Smallest aperture of a gripper's jaws per radian of its servo [mm].
const LEVER_MIN_MM: f64 = 0.1;

fn gripper(typed: &schema::TeleoperationGripperTable) -> Check<GripperConfig> {
    let lever = typed.aperture_mm_per_rad;
    if lever.abs() < LEVER_MIN_MM {
        let expected = format!("jaws that open: at least {LEVER_MIN_MM} mm for a radian, either way");
        return Err(BadInput::new("gripper.aperture_mm_per_rad", expected, lever.to_string()));
    }
    Ok(GripperConfig {
        lever: 1e-3 * within("gripper.aperture_mm_per_rad", lever, -1000.0, 1000.0)?,
        closed: within("gripper.closed_deg", typed.closed_deg, -FURTHEST_DEG, FURTHEST_DEG)?,
    })
}

fn limits(typed: &schema::ArmLimitsTable) -> Check<ArmLimits> {
    Ok(ArmLimits {
        speed_max: above_zero("limits.speed_max_deg_s", typed.speed_max_deg_s, FASTEST_DEG_S)?,
        lag_max: above_zero("limits.lag_max_deg", typed.lag_max_deg, FURTHEST_DEG)?,
        current_max: above_zero("limits.current_max_a", typed.current_max_a, CURRENT_MAX_A)?,
        servos: ServoBounds {
            voltage_min: within("limits.voltage_min_v", typed.voltage_min_v, 0.0, SUPPLY_MAX_V)?,
            voltage_max: within(
                "limits.voltage_max_v",
                typed.voltage_max_v,
                typed.voltage_min_v,
                SUPPLY_MAX_V,
            )?,
            temperature_max: above_zero(
                "limits.temperature_max_degc",
                typed.temperature_max_degc,
                HOTTEST_DEGC,
            )?,
        },
    })
}

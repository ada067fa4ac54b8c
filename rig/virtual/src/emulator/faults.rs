//! Injected faults: a file of faults with their times, or a draw from a seed.
//!
//! ```toml
//! format = "hysteron-faults"
//! version = 1
//!
//! [[fault]]
//! at_s = 1.5
//! kind = "drop_packet"
//! servo = 2
//! count = 3
//! ```
//!
//! `servo` is an id; without it a fault concerns whichever comes first, or all.

use std::ops::RangeInclusive;
use std::path::Path;

use hysteron_base::{BadInput, file, json, rng, schema};
use hysteron_rig::Result;
use rand::RngExt;
use serde::{Deserialize, Serialize};

const FORMAT: (&str, i64) = ("hysteron-faults", 1);
/// Largest id of a servo.
const LAST_ID: u8 = 252;
/// Latest that a fault comes, and longest that it lasts: a year [s].
const LONGEST: f64 = 31_536_000.0;
/// Most packets that one fault may concern.
const MAX_PACKETS: u32 = 1_000_000;

/// Kind of a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// Answers get lost: the next `count`.
    DropPacket,
    /// Answers arrive damaged: the next `count`.
    CorruptPacket,
    /// Answers come late by `delay_ms`: the next `count`.
    DelayPacket,
    /// Instructions are not heard: the next `count`.
    DropInstruction,
    /// Noise on the bus instead of silence: `count` bytes.
    Noise,
    /// The serial port disappears.
    UnplugBus,
    /// A servo loses its plug, and with it its power.
    UnplugServo,
    /// A servo reports an overload.
    Overload,
    /// A servo reads as too hot.
    Overheat,
    /// Something holds the pulley of a servo with `torque_nm`.
    Hold,
    /// The supply dips to `volts`, 3 V by default; below 5 V servos stop and lose their RAM. With `servo`:
    /// only that one loses its power.
    BrownOut,
    /// The connection to the tracker breaks.
    UnplugTracker,
    /// The tracker sends nothing.
    TrackerDropout,
    /// The tracker marks its poses as invalid.
    TrackerInvalid,
    /// The tracker repeats its last pose.
    TrackerFreeze,
    /// The tracker sends poses from elsewhere.
    TrackerJump,
    /// The tracker sends damaged messages.
    TrackerCorrupt,
}

/// Keys that a fault may have in addition to `at_s` and `kind`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FaultKey {
    Servo,
    Duration,
    Count,
    Delay,
    Torque,
    Volts,
}

impl FaultKind {
    /// All kinds.
    pub const ALL: [Self; 17] = [
        Self::DropPacket,
        Self::CorruptPacket,
        Self::DelayPacket,
        Self::DropInstruction,
        Self::Noise,
        Self::UnplugBus,
        Self::UnplugServo,
        Self::Overload,
        Self::Overheat,
        Self::Hold,
        Self::BrownOut,
        Self::UnplugTracker,
        Self::TrackerDropout,
        Self::TrackerInvalid,
        Self::TrackerFreeze,
        Self::TrackerJump,
        Self::TrackerCorrupt,
    ];

    /// Whether it is the tracker that breaks.
    pub fn is_of_tracker(self) -> bool {
        use FaultKind::{
            TrackerCorrupt, TrackerDropout, TrackerFreeze, TrackerInvalid, TrackerJump, UnplugTracker,
        };
        matches!(
            self,
            UnplugTracker | TrackerDropout | TrackerInvalid | TrackerFreeze | TrackerJump | TrackerCorrupt
        )
    }

    /// Keys that apply, and whether each is needed.
    fn keys(self) -> &'static [(FaultKey, bool)] {
        use FaultKey::{Count, Delay, Duration, Servo, Torque, Volts};
        match self {
            Self::DropPacket | Self::CorruptPacket | Self::DropInstruction => {
                &[(Servo, false), (Count, false)]
            }
            Self::DelayPacket => &[(Servo, false), (Count, false), (Delay, true)],
            Self::Noise => &[(Count, false)],
            Self::UnplugServo => &[(Servo, true), (Duration, false)],
            Self::Overload => &[(Servo, true)],
            Self::Overheat => &[(Servo, true), (Duration, false)],
            Self::Hold => &[(Servo, true), (Duration, false), (Torque, true)],
            Self::BrownOut => &[(Servo, false), (Duration, false), (Volts, false)],
            _ => &[(Duration, false)],
        }
    }

    /// Default duration [s]; unplugged devices stay unplugged.
    fn usual_duration(self) -> Option<f64> {
        match self {
            Self::UnplugBus | Self::UnplugServo | Self::UnplugTracker | Self::Hold => None,
            Self::BrownOut => Some(0.1),
            _ => Some(1.0),
        }
    }
}

/// One thing that breaks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BusFault {
    /// When [s], on the clock of the virtual rig.
    pub at_s: f64,
    /// Kind of the fault.
    pub kind: FaultKind,
    /// Id of the servo that it concerns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub servo: Option<u8>,
    /// How long it lasts [s]; without it the default of its kind; unplugged devices stay unplugged.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub duration_s: Option<f64>,
    /// Packets, or bytes of noise; 1 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<u32>,
    /// How late answers come [ms].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delay_ms: Option<f64>,
    /// Torque that holds a pulley [N m], positive against positive ticks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_nm: Option<f64>,
    /// Supply voltage during a dip [V].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volts: Option<f64>,
}

impl BusFault {
    /// A fault with only time and kind.
    pub fn new(at_s: f64, kind: FaultKind) -> Self {
        let (servo, duration_s, count, delay_ms, torque_nm, volts) = (None, None, None, None, None, None);
        Self { at_s, kind, servo, duration_s, count, delay_ms, torque_nm, volts }
    }

    /// The same for one servo, by its id.
    pub fn of_servo(mut self, id: u8) -> Self {
        self.servo = Some(id);
        self
    }

    /// The same for this long [s].
    pub fn lasting(mut self, duration_s: f64) -> Self {
        self.duration_s = Some(duration_s);
        self
    }

    /// The same for so many packets or bytes.
    pub fn times(mut self, count: u32) -> Self {
        self.count = Some(count);
        self
    }

    /// When it ends [s], if it does; `now` [s] is when it began.
    pub(super) fn ends_at(&self, now: f64) -> Option<f64> {
        Some(now + self.duration_s.or(self.kind.usual_duration())?)
    }

    /// Accepts what makes sense.
    ///
    /// # Errors
    /// `BadInput` naming the key, without the fault that it belongs to.
    pub fn check(&self) -> std::result::Result<(), BadInput> {
        within("at_s", Some(self.at_s), 0.0, LONGEST)?;
        let kind = json::to_value(self.kind).ok();
        let kind = kind.as_ref().and_then(|kind| kind.as_str()).unwrap_or_default().to_owned();
        let given = [
            (FaultKey::Servo, "servo", self.servo.is_some()),
            (FaultKey::Duration, "duration_s", self.duration_s.is_some()),
            (FaultKey::Count, "count", self.count.is_some()),
            (FaultKey::Delay, "delay_ms", self.delay_ms.is_some()),
            (FaultKey::Torque, "torque_nm", self.torque_nm.is_some()),
            (FaultKey::Volts, "volts", self.volts.is_some()),
        ];
        for (key, name, is_given) in given {
            let rule = self.kind.keys().iter().find(|(known, _)| *known == key);
            if is_given && rule.is_none() {
                let expected = format!("no such key for kind = \"{kind}\"");
                return Err(BadInput::new(name, expected, "one"));
            }
            if !is_given && rule.is_some_and(|(_, is_needed)| *is_needed) {
                return Err(BadInput::new(name, format!("this key for kind = \"{kind}\""), "nothing"));
            }
        }
        if self.kind == FaultKind::BrownOut && self.servo.is_some() && self.volts.is_some() {
            return Err(BadInput::new("volts", "no such key together with servo", "one")
                .hint("a dip to some voltage concerns all; one servo alone just loses its power"));
        }
        if let Some(id) = self.servo.filter(|id| *id > LAST_ID) {
            return Err(BadInput::new("servo", format!("an id from 0 to {LAST_ID}"), id.to_string()));
        }
        if let Some(count) = self.count {
            schema::count("count", i64::from(count), i64::from(MAX_PACKETS))?;
        }
        self.duration_s.map_or(Ok(0.0), |x| schema::positive("duration_s", x))?;
        within("duration_s", self.duration_s, 0.0, LONGEST)?;
        // Beyond these a servo would be no servo any more.
        self.delay_ms.map_or(Ok(0.0), |x| schema::positive("delay_ms", x))?;
        within("delay_ms", self.delay_ms, 0.0, 10_000.0)?;
        within("torque_nm", self.torque_nm, -100.0, 100.0)?;
        within("volts", self.volts, 0.0, 30.0)?;
        Ok(())
    }
}

/// A number that may be missing, within bounds.
fn within(key: &str, given: Option<f64>, low: f64, high: f64) -> std::result::Result<(), BadInput> {
    let Some(x) = given else { return Ok(()) };
    schema::require(key, &format!("{low} to {high}"), x, (low..=high).contains(&x)).map(|_| ())
}

/// A list of faults, in order of time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Faults {
    /// The faults; `at_s` never decreases.
    pub list: Vec<BusFault>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FaultsFile {
    format: String,
    version: i64,
    #[serde(default)]
    fault: Vec<BusFault>,
}

impl Faults {
    /// Reads a file.
    ///
    /// # Errors
    /// `BadInput` naming the line or key, `File` if it cannot be read.
    pub fn read(path: &Path) -> Result<Self> {
        let text = file::read_text(path)?;
        Ok(Self::parse(&text).map_err(|bad| bad.within(path.display()))?)
    }

    /// Takes the text of a file.
    ///
    /// # Errors
    /// `BadInput` naming the line or key.
    pub fn parse(text: &str) -> std::result::Result<Self, BadInput> {
        let typed: FaultsFile = schema::parse(text)?;
        schema::check_header((&typed.format, typed.version), FORMAT)?;
        for (k, fault) in typed.fault.iter().enumerate() {
            fault
                .check()
                .map_err(|bad| BadInput { place: format!("fault[{}].{}", k + 1, bad.place), ..bad })?;
        }
        Ok(Self::sorted(typed.fault))
    }

    /// Draws `n` faults of the first `span` [s], over `n_servos` servos with ids from 1 on.
    ///
    /// All of them pass: what is unplugged comes back.
    pub fn draw(seed: u64, n: usize, span: f64, n_servos: u8) -> Self {
        let mut rng = rng(seed, "rig/faults");
        let mut list = Vec::with_capacity(n);
        for _ in 0..n {
            let kind = FaultKind::ALL[rng.random_range(0..FaultKind::ALL.len())];
            let mut fault = BusFault::new(rng.random_range(0.0..=span.max(0.0)), kind);
            for (key, is_needed) in kind.keys() {
                // Optional keys are given half of the time; except the duration, without which a fault may last for ever.
                if !is_needed && *key != FaultKey::Duration && rng.random_bool(0.5) {
                    continue;
                }
                match key {
                    FaultKey::Servo => fault.servo = Some(rng.random_range(1..=n_servos.max(1))),
                    FaultKey::Duration => fault.duration_s = Some(rng.random_range(0.05..0.5)),
                    FaultKey::Count => fault.count = Some(rng.random_range(1..=5)),
                    FaultKey::Delay => fault.delay_ms = Some(rng.random_range(1.0..60.0)),
                    FaultKey::Torque => fault.torque_nm = Some(rng.random_range(-1.0..1.0)),
                    FaultKey::Volts if fault.servo.is_some() => {}
                    FaultKey::Volts => fault.volts = Some(rng.random_range(2.0..7.0)),
                }
            }
            list.push(fault);
        }
        Self::sorted(list)
    }

    /// Refuses faults of servos that are not there: whose ids are not `ids`.
    ///
    /// # Errors
    /// `BadInput` naming when and what.
    pub fn check_servos(&self, ids: &RangeInclusive<u8>) -> std::result::Result<(), BadInput> {
        let is_there = |fault: &&BusFault| fault.servo.is_none_or(|id| ids.contains(&id));
        match self.list.iter().find(|fault| !is_there(fault)) {
            Some(BusFault { servo: Some(id), at_s, .. }) => {
                let expected = format!("a servo that is there, {} to {}", ids.start(), ids.end());
                Err(BadInput::new(format!("the fault at {at_s} s: servo"), expected, id.to_string()))
            }
            _ => Ok(()),
        }
    }

    /// Adds more.
    pub fn add(&mut self, more: Self) {
        let list = std::mem::take(&mut self.list);
        *self = Self::sorted([list, more.list].concat());
    }

    fn sorted(mut list: Vec<BusFault>) -> Self {
        list.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
        Self { list }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    const HEAD: &str = "format = \"hysteron-faults\"\nversion = 1\n";

    fn refused(fault: &str) -> String {
        Faults::parse(&format!("{HEAD}[[fault]]\n{fault}\n")).unwrap_err().to_string()
    }

    #[test]
    fn a_file_is_read_in_order_of_time() {
        let text = format!(
            "{HEAD}[[fault]]\nat_s = 2\nkind = \"unplug_bus\"\nduration_s = 0.5\n\
             [[fault]]\nat_s = 1.5\nkind = \"delay_packet\"\nservo = 2\ncount = 3\ndelay_ms = 20\n"
        );
        let faults = Faults::parse(&text).unwrap();
        assert_eq!(faults.list[0].kind, FaultKind::DelayPacket);
        assert_eq!(faults.list[0].count, Some(3));
        assert_eq!(faults.list[1], BusFault::new(2.0, FaultKind::UnplugBus).lasting(0.5));
        assert!(Faults::parse(HEAD).unwrap().list.is_empty());
    }

    #[test]
    fn what_makes_no_sense_is_refused_by_name() {
        for (fault, part) in [
            ("at_s = -1\nkind = \"unplug_bus\"", "fault[1].at_s: expected 0 to 31536000"),
            ("at_s = 1e300\nkind = \"unplug_bus\"", "at_s"),
            ("at_s = 1\nkind = \"unplug_bus\"\nduration_s = 1e300", "duration_s"),
            ("at_s = nan\nkind = \"unplug_bus\"", "at_s"),
            ("at_s = 1\nkind = \"unplug_bus\"\nservo = 1", "servo: expected no such key"),
            ("at_s = 1\nkind = \"overload\"", "servo: expected this key"),
            ("at_s = 1\nkind = \"overload\"\nservo = 253", "from 0 to 252"),
            ("at_s = 1\nkind = \"delay_packet\"", "delay_ms"),
            ("at_s = 1\nkind = \"delay_packet\"\ndelay_ms = 0", "delay_ms"),
            ("at_s = 1\nkind = \"drop_packet\"\ncount = 0", "count"),
            ("at_s = 1\nkind = \"brown_out\"\nvolts = -1", "volts"),
            ("at_s = 1\nkind = \"brown_out\"\nvolts = 3\nservo = 1", "together with servo"),
            ("at_s = 1\nkind = \"hold\"\nservo = 1\ntorque_nm = inf", "torque_nm"),
            ("at_s = 1\nkind = \"unplug_bus\"\nduration_s = 0", "duration_s"),
            ("at_s = 1\nkind = \"unplug_buss\"", "one of drop_packet"),
            ("at_s = 1\nkind = \"unplug_bus\"\nsirvo = 1", "sirvo"),
            ("kind = \"unplug_bus\"", "at_s"),
        ] {
            assert!(refused(fault).contains(part), "{fault}: {}", refused(fault));
        }
        assert!(Faults::parse("format = \"x\"\nversion = 1").unwrap_err().place == "format");
        assert!(
            Faults::parse("format = \"hysteron-faults\"\nversion = 2").unwrap_err().to_string().contains("1")
        );
    }

    #[test]
    fn a_servo_that_the_rig_does_not_have_is_named() {
        for (id, is_there) in [(0, false), (1, true), (4, true), (5, false), (99, false)] {
            let text = format!("{HEAD}[[fault]]\nat_s = 1.5\nkind = \"overload\"\nservo = {id}\n");
            let checked = Faults::parse(&text).unwrap().check_servos(&(1..=4));
            assert_eq!(checked.is_ok(), is_there, "{id}");
            assert!(
                is_there || checked.unwrap_err().to_string().contains("at 1.5 s: servo: expected a servo")
            );
        }
    }

    #[test]
    fn draws_are_valid_pass_and_depend_on_the_seed_alone() {
        let drawn = Faults::draw(7, 200, 10.0, 4);
        assert_eq!(drawn, Faults::draw(7, 200, 10.0, 4));
        assert_ne!(drawn, Faults::draw(8, 200, 10.0, 4));
        for fault in &drawn.list {
            fault.check().unwrap();
            assert!(fault.at_s <= 10.0 && fault.ends_at(0.0).is_some(), "{fault:?}");
        }
        for kind in FaultKind::ALL {
            assert!(drawn.list.iter().any(|fault| fault.kind == kind), "{kind:?}");
        }
    }
}

//! Health of a rig's servos, from what was recorded of them anyway: friction in either direction, lost motion, heat, and how likely a servo
//! is as good as at a baseline. `docs/rig.md` has the equations.
//!
//! A window is a minute of recordings. Each gives an estimate with a standard error; a random walk joins them, so that the last one
//! is the present state of the servo.

mod baseline;
mod window;

use std::path::Path;

use hysteron_base::{BadInput, Recording};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use baseline::Baseline;
use window::{ServoRecordings, Window};

/// How fast a quantity may change, as a part of itself over the root of an hour.
const DRIFT: f64 = 0.1;
/// Change of a quantity that counts as wear, as a part of the baseline.
const WEAR: f64 = 0.25;
/// A lost motion counts as no less than this: a quarter of it is what recordings of a minute resolve [mm].
const MIN_LOST_MM: f64 = 0.2;
/// Part of the value that recordings of one healthy servo differ by beyond their standard errors: motion is never quite the same.
const UNLIKE: f64 = 0.03;
/// Probabilities below this are an alarm.
const ALARM: f64 = 0.05;

/// A number with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// Monitored quantity of a servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Dry friction while it pulls, as a part of its full load [%].
    Pulling,
    /// The same while it releases.
    Releasing,
    /// How far the pulley turns back before the tip follows [mm].
    LostMotion,
}

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Pulling, Self::Releasing, Self::LostMotion];

    /// As `metrics.json` has it.
    pub fn key(self) -> &'static str {
        match self {
            Self::Pulling => "friction_pulling_percent",
            Self::Releasing => "friction_releasing_percent",
            Self::LostMotion => "lost_motion_mm",
        }
    }

    /// As people read it.
    pub fn label(self) -> &'static str {
        match self {
            Self::Pulling => "friction pulling [% of full load]",
            Self::Releasing => "friction releasing [% of full load]",
            Self::LostMotion => "lost motion [mm]",
        }
    }
}

/// Everything of one servo.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ServoHealth {
    /// Number, from 1.
    pub servo: usize,
    /// Value at the end; none where the motion does not determine it.
    #[serde(flatten)]
    pub now: Numbers,
    /// Highest temperature of its case [°C].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature_max_degc: Option<f64>,
    /// Changes from the baseline, as parts of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub change: Option<Numbers>,
    /// Probability that no quantity has grown by a quarter of the baseline; none without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub condition: Option<f64>,
    /// Window by window.
    pub windows: Vec<Numbers>,
}

/// The quantities at one time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Numbers {
    /// Dry friction pulling, of full load [%].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_pulling_percent: Option<Estimate>,
    /// Dry friction releasing, of full load [%].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_releasing_percent: Option<Estimate>,
    /// Lost motion [mm].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lost_motion_mm: Option<Estimate>,
    /// Mean temperature [°C].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature_degc: Option<f64>,
}

impl Numbers {
    /// One of them.
    pub fn get(&self, quantity: Quantity) -> Option<Estimate> {
        match quantity {
            Quantity::Pulling => self.friction_pulling_percent,
            Quantity::Releasing => self.friction_releasing_percent,
            Quantity::LostMotion => self.lost_motion_mm,
        }
    }

    fn set(&mut self, quantity: Quantity, estimate: Option<Estimate>) {
        *match quantity {
            Quantity::Pulling => &mut self.friction_pulling_percent,
            Quantity::Releasing => &mut self.friction_releasing_percent,
            Quantity::LostMotion => &mut self.lost_motion_mm,
        } = estimate;
    }
}

/// Health of all servos.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Health {
    /// Middle of every window, in time of recording, one recording after the other [s].
    pub time_s: Vec<f64>,
    /// Baseline of the comparison.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub baseline: Option<String>,
    /// Servo by servo.
    pub servos: Vec<ServoHealth>,
}

impl Health {
    /// Of recordings of one rig, in the order in which they were made; `None` where these have no servos.
    ///
    /// # Errors
    /// `BadInput` naming what is wrong with a recording.
    pub fn of(recordings: &[&Recording], baseline: Option<&Baseline>) -> Result<Option<Self>, BadInput> {
        let Some(source) = ServoRecordings::new(recordings)? else { return Ok(None) };
        let windows = source.windows();
        let n = source.n_servos();
        let servos = (0..n).map(|k| servo(k, &windows, baseline.and_then(|baseline| baseline.servos.get(k))));
        Ok(Some(Self {
            time_s: windows.iter().map(|window| 0.5 * (window.from + window.until)).collect(),
            baseline: baseline.map(|baseline| baseline.name.clone()),
            servos: servos.collect(),
        }))
    }

    /// Reads the recordings again and looks at their servos.
    ///
    /// # Errors
    /// As [`Self::of`], and those of files.
    pub fn of_files(
        paths: &[impl AsRef<Path>],
        baseline: Option<&Baseline>,
    ) -> hysteron_base::Result<Option<Self>> {
        let recordings = paths.iter().map(Recording::read).collect::<Result<Vec<_>, _>>()?;
        Ok(Self::of(&recordings.iter().collect::<Vec<_>>(), baseline)?)
    }

    /// Servos whose condition is an alarm, by number from 1.
    pub fn alarms(&self) -> Vec<usize> {
        let is_worn = |servo: &&ServoHealth| servo.condition.is_some_and(|condition| condition < ALARM);
        self.servos.iter().filter(is_worn).map(|servo| servo.servo).collect()
    }
}

fn servo(k: usize, windows: &[Window], baseline: Option<&Numbers>) -> ServoHealth {
    let own: Vec<Numbers> = windows.iter().map(|window| window.servos[k]).collect();
    let mut now = Numbers::default();
    for quantity in Quantity::ALL {
        let series = own.iter().zip(windows).map(|(numbers, window)| (window.until, numbers.get(quantity)));
        now.set(quantity, joined(series));
    }
    now.temperature_degc = own.last().and_then(|numbers| numbers.temperature_degc);
    let change = baseline.map(|before| {
        let mut change = Numbers::default();
        Quantity::ALL
            .into_iter()
            .for_each(|quantity| change.set(quantity, self::change(quantity, before, &now)));
        change
    });
    let condition = change.and_then(|change| {
        let of = |quantity| change.get(quantity).map(|change| unworn(&change));
        Quantity::ALL.into_iter().filter_map(of).reduce(f64::min)
    });
    let temperatures = windows.iter().filter_map(|window| window.hottest.get(k).copied());
    ServoHealth {
        servo: k + 1,
        now,
        temperature_max_degc: temperatures.reduce(f64::max),
        change,
        condition,
        windows: own,
    }
}

/// The last of a series of estimates that follow a random walk: the scalar Kalman filter.
fn joined(series: impl Iterator<Item = (f64, Option<Estimate>)>) -> Option<Estimate> {
    let mut state: Option<(f64, f64, f64)> = None;
    for (time, estimate) in series {
        let Some(Estimate { value, standard_error }) = estimate else { continue };
        let noise = standard_error * standard_error;
        state = Some(match state {
            None => (time, value, noise),
            Some((before, mean, variance)) => {
                let predicted = variance + (DRIFT * mean).powi(2) * (time - before) / 3600.0;
                let share = if noise > 0.0 { predicted / (predicted + noise) } else { 1.0 };
                (time, mean + share * (value - mean), (1.0 - share) * predicted)
            }
        });
    }
    state.map(|(_, value, variance)| Estimate { value, standard_error: variance.sqrt() })
}

/// Change from the baseline as a part of it; a lost motion counts as no less than [`MIN_LOST_MM`].
fn change(quantity: Quantity, before: &Numbers, now: &Numbers) -> Option<Estimate> {
    let (before, now) = (before.get(quantity)?, now.get(quantity)?);
    let least = if quantity == Quantity::LostMotion { MIN_LOST_MM } else { f64::MIN_POSITIVE };
    let scale = before.value.abs().max(least);
    let unlike = UNLIKE * scale;
    let error = now.standard_error.hypot(before.standard_error).hypot(unlike);
    Some(Estimate { value: (now.value - before.value) / scale, standard_error: error / scale })
}

/// Probability that a quantity has grown by less than [`WEAR`].
fn unworn(change: &Estimate) -> f64 {
    normal((WEAR - change.value) / change.standard_error)
}

/// Distribution function of the normal distribution.
fn normal(z: f64) -> f64 {
    0.5 * libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_normal_distribution_is_that_of_tables() {
        for (z, p) in [(0.0, 0.5), (1.0, 0.841_344_746), (-1.959_964, 0.025), (3.0, 0.998_650_102)] {
            assert!((normal(z) - p).abs() < 1e-7, "{z}: {}", normal(z));
        }
    }

    #[test]
    fn windows_are_joined_by_their_errors_and_the_time_between() {
        let of = |value, standard_error| Some(Estimate { value, standard_error });
        // At one time it is the mean weighed by the inverse squares, as of two measurements of one thing.
        let found = joined([(10.0, of(3.0, 0.3)), (10.0, None), (10.0, of(4.0, 0.4))].into_iter());
        let Some(Estimate { value, standard_error }) = found else { panic!("nothing") };
        let weights = [1.0 / 0.09, 1.0 / 0.16];
        assert!((value - (3.0 * weights[0] + 4.0 * weights[1]) / (weights[0] + weights[1])).abs() < 1e-12);
        assert!((standard_error - (weights[0] + weights[1]).sqrt().recip()).abs() < 1e-12);
        // After a hundred hours the walk has forgotten the first.
        let late = joined([(0.0, of(3.0, 0.01)), (3.6e5, of(4.0, 0.01))].into_iter());
        assert!(late.is_some_and(|late| (late.value - 4.0).abs() < 1e-4), "{late:?}");
        assert_eq!(joined([(0.0, None)].into_iter()), None);
    }

    #[test]
    fn a_condition_is_the_probability_of_less_than_a_quarter_more() {
        let change = |value, standard_error| unworn(&Estimate { value, standard_error });
        assert!((change(0.25, 0.1) - 0.5).abs() < 1e-7);
        assert!(change(0.0, 0.05) > 0.999 && change(0.5, 0.05) < 0.001);
    }
}

//! Samples of steady motion from what was recorded of a pulley.

use std::f64::consts::TAU;
use std::ops::Range;

use hysteron_base::BadInput;

use crate::load::{SteadyLoad, SteadyMotion};
use crate::servo::TICKS_PER_TURN;

/// Samples over which a mean is taken.
const SPAN: usize = SteadyMotion::SPAN;

/// Recording of one pulley and its servo, sample by sample; all positive where it pulls.
#[derive(Debug, Clone, Copy)]
pub struct PulleyRecord<'a> {
    /// Angle of the pulley [rad].
    pub angle: &'a [f64],
    /// Load of its servo, 1 for the largest [-].
    pub load: &'a [f64],
    /// Tension of the tendon at the pulley, where it was measured [N].
    pub tension: Option<&'a [f64]>,
}

/// Ticks in a sample from which on motion counts as even: goals go by whole ticks, so at less a servo all but stops between some of them.
const TICKS: f64 = 1.5;

/// Slowest speed at which a servo whose goals come every `period` [s] moves evenly [rad/s]. Friction that changes below it is blurred.
pub fn finest_speed(period: f64) -> f64 {
    TICKS * TAU / TICKS_PER_TURN / period
}

/// Samples of steady motion, recording by recording.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SteadySamples {
    /// Speed [rad/s].
    pub velocity: Vec<f64>,
    /// Change of the speed [rad/s²].
    pub acceleration: Vec<f64>,
    /// Load [-].
    pub load: Vec<f64>,
    /// Tension and its rate [N, N/s]; empty where they are not known.
    pub tension: Vec<[f64; 2]>,
    /// Samples of every recording.
    pub series: Vec<Range<usize>>,
    /// Number of the sample in its recording.
    pub at: Vec<usize>,
}

impl SteadySamples {
    /// Motion at `slowest` [rad/s] or faster, in samples of `period` [s]: means over a tenth of a second at 100 Hz, where the speed has kept
    /// its sign for as long before and after.
    ///
    /// # Errors
    /// `BadInput` for series of different lengths, numbers that are not finite, or tensions in some recordings only.
    pub fn of(records: &[PulleyRecord], period: f64, slowest: f64) -> Result<Self, BadInput> {
        let has_tension = records.iter().any(|record| record.tension.is_some());
        let mut found = Self::default();
        for record in records {
            check(record, has_tension)?;
            let first = found.velocity.len();
            found.add(record, period, slowest);
            found.series.push(first..found.velocity.len());
        }
        Ok(found)
    }

    fn add(&mut self, record: &PulleyRecord, period: f64, slowest: f64) {
        let mut motion = SteadyMotion::new(period);
        let pairs = record.angle.iter().zip(record.load);
        let steady: Vec<Option<SteadyLoad>> = pairs.map(|(angle, load)| motion.step(*angle, *load)).collect();
        for i in SPAN..steady.len().saturating_sub(SPAN) {
            let [Some(before), Some(now), Some(after)] = [steady[i - SPAN], steady[i], steady[i + SPAN]]
            else {
                continue;
            };
            let is_one_way = before.velocity * now.velocity > 0.0 && after.velocity * now.velocity > 0.0;
            if !is_one_way || now.velocity.abs() < slowest {
                continue;
            }
            let span = SPAN as f64 * period;
            self.velocity.push(now.velocity);
            self.acceleration.push((after.velocity - before.velocity) / (2.0 * span));
            self.load.push(now.load);
            if let Some(tension) = record.tension {
                let mean = tension[i + 1 - SPAN..=i].iter().sum::<f64>() / SPAN as f64;
                self.tension.push([mean, (tension[i] - tension[i - SPAN]) / span]);
            }
            self.at.push(i);
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.velocity.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.velocity.is_empty()
    }

    /// Those for which `keep` holds, as of a slack tendon: without tensions, which are zero.
    pub fn slack(&self, keep: &[bool]) -> Self {
        Self { tension: Vec::new(), ..self.selected(keep) }
    }

    /// Those for which `keep` holds.
    pub fn selected(&self, keep: &[bool]) -> Self {
        let mut found = Self::default();
        for series in &self.series {
            let first = found.velocity.len();
            for i in series.clone().filter(|i| keep[*i]) {
                found.velocity.push(self.velocity[i]);
                found.acceleration.push(self.acceleration[i]);
                found.load.push(self.load[i]);
                found.tension.extend(self.tension.get(i));
                found.at.push(self.at[i]);
            }
            found.series.push(first..found.velocity.len());
        }
        found
    }
}

fn check(record: &PulleyRecord, has_tension: bool) -> Result<(), BadInput> {
    if record.tension.is_some() != has_tension {
        return Err(BadInput::new("tension", "in every recording or in none", "in some")
            .hint("identify the recordings with tensions by themselves"));
    }
    let n = record.angle.len();
    let series = [("angle", Some(record.angle)), ("load", Some(record.load)), ("tension", record.tension)];
    for (name, values) in series.into_iter().filter_map(|(name, values)| Some((name, values?))) {
        if values.len() != n {
            return Err(BadInput::new(name, format!("{n} samples"), values.len().to_string()));
        }
        if let Some(k) = values.iter().position(|x| !x.is_finite()) {
            let place = format!("{name}, sample {}", k + 1);
            return Err(BadInput::new(place, "a finite number", values[k].to_string()));
        }
    }
    Ok(())
}

//! How a run kept its time.

use crate::SlowSample;
use crate::bus::BusCounts;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Width of the bins in which times are counted [s].
const BIN: f64 = 10e-6;
/// Bins; later times fall into the last.
const N_BINS: usize = 4000;

/// Counts of times, for percentiles without keeping them all.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    bins: Vec<u32>,
    n: u64,
    max: f64,
    sum: f64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self::new()
    }
}

impl Histogram {
    /// Of no times.
    pub fn new() -> Self {
        Self { bins: vec![0; N_BINS], n: 0, max: 0.0, sum: 0.0 }
    }

    /// Counts a time [s].
    pub fn add(&mut self, time: f64) {
        let bin = (time.max(0.0) / BIN) as usize;
        self.bins[bin.min(N_BINS - 1)] += 1;
        self.n += 1;
        self.max = self.max.max(time);
        self.sum += time;
    }

    /// Time that this part of all do not exceed, to a bin [s].
    pub fn percentile(&self, part: f64) -> f64 {
        let rank = (part * self.n as f64).ceil() as u64;
        let mut below = 0;
        for (i, count) in self.bins.iter().enumerate() {
            below += u64::from(*count);
            if below >= rank && below > 0 {
                return (BIN * (i + 1) as f64).min(self.max);
            }
        }
        self.max
    }

    /// Mean [s].
    pub fn mean(&self) -> f64 {
        if self.n == 0 { 0.0 } else { self.sum / self.n as f64 }
    }

    /// Largest [s].
    pub fn max(&self) -> f64 {
        self.max
    }

    /// Part of all that do not exceed this time [-].
    pub fn within(&self, time: f64) -> f64 {
        let bins = ((time / BIN).round() as usize).min(N_BINS);
        let inside: u64 = self.bins[..bins].iter().map(|count| u64::from(*count)).sum();
        if self.n == 0 { 1.0 } else { inside as f64 / self.n as f64 }
    }
}

/// Temperatures over time, in bounded memory: when there are too many, every other one goes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TemperatureHistory {
    /// Time [s], then the temperature of every servo [°C].
    rows: Vec<Vec<f64>>,
    /// Readings that are passed over between two that are kept, and those since the last.
    every: usize,
    since: usize,
}

impl TemperatureHistory {
    /// Most readings that are kept.
    const MAX_READINGS: usize = 240;

    /// Takes a reading of all servos; one in which a servo did not answer is left out.
    pub fn add(&mut self, time: f64, servos: &[Option<SlowSample>]) {
        self.since += 1;
        if self.since <= self.every || servos.iter().any(Option::is_none) {
            return;
        }
        self.since = 0;
        let temperatures = servos.iter().flatten().map(|servo| servo.temperature);
        self.rows.push([time].into_iter().chain(temperatures).collect());
        if self.rows.len() == Self::MAX_READINGS {
            let mut is_kept = false;
            self.rows.retain(|_| {
                is_kept = !is_kept;
                is_kept
            });
            self.every = 2 * self.every + 1;
        }
    }

    /// Counts times from `start` [s] on.
    pub(super) fn begin_at(&mut self, start: f64) {
        self.rows.iter_mut().for_each(|row| row[0] -= start);
    }
}

/// How a run kept its time.
#[derive(Debug, Clone, PartialEq)]
pub struct RunStats {
    /// Planned time of a cycle [s].
    pub period: f64,
    /// Cycles.
    pub n_cycles: u64,
    /// Cycles that did not take place, because one before them came too late.
    pub n_missed: u64,
    /// How late cycles began.
    pub lateness: Histogram,
    /// Time that the transfers of a cycle took.
    pub bus: Histogram,
    /// Time that their bytes take on the wire [s].
    pub wire: f64,
    /// Age of a trusted pose when a cycle took it.
    pub pose_age: Histogram,
    /// Poses that were not trusted.
    pub n_doubtful: u64,
    /// Temperatures of the servos as they were read.
    pub heat: TemperatureHistory,
    /// Part of one core that the process used, in real time [-].
    pub processor: Option<f64>,
    /// Counts of the bus traffic and its errors.
    pub counts: BusCounts,
}

/// The same for a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StatsSummary {
    /// Cycles.
    pub n_cycles: u64,
    /// Cycles that did not take place, because one before them came too late.
    pub n_missed: u64,
    /// Part of all cycles that began within 1 ms of their time [-].
    pub within_1ms: f64,
    /// Lateness that 99 % of all cycles do not exceed [ms].
    pub late_p99_ms: f64,
    /// Largest lateness [ms].
    pub late_max_ms: f64,
    /// Median of the transfers of a cycle [ms].
    pub bus_median_ms: f64,
    /// 99 % of them do not exceed this [ms].
    pub bus_p99_ms: f64,
    /// Time that the bytes of a cycle take on the wire [ms].
    pub wire_ms: f64,
    /// Poses that were trusted, and those that were not.
    pub n_poses: [u64; 2],
    /// Median age of a trusted pose when a cycle took it [ms].
    pub pose_age_median_ms: f64,
    /// 99 % of them are no older [ms].
    pub pose_age_p99_ms: f64,
    /// Time since the first row [s], then the temperature of every servo [°C].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub temperature_degc: Vec<Vec<f64>>,
    /// Part of one core that the process used, in real time [%].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub processor_percent: Option<f64>,
    /// Counts of the traffic and faults of the bus.
    pub bus: BusCounts,
}

impl RunStats {
    pub(super) fn new(period: f64) -> Self {
        Self {
            period,
            n_cycles: 0,
            n_missed: 0,
            lateness: Histogram::new(),
            bus: Histogram::new(),
            wire: 0.0,
            pose_age: Histogram::new(),
            n_doubtful: 0,
            heat: TemperatureHistory::default(),
            processor: None,
            counts: BusCounts::default(),
        }
    }

    pub(super) fn add_cycle(&mut self, lateness: f64, (bus, wire): (f64, f64)) {
        self.n_cycles += 1;
        self.lateness.add(lateness);
        self.bus.add(bus);
        self.wire = wire;
    }

    /// Report of the cycles missed on a busy machine, for a person; `None` if no cycle was missed.
    pub fn missed_cycles(&self) -> Option<String> {
        if self.n_missed == 0 {
            return None;
        }
        let (missed, planned) = (self.n_missed, self.n_missed + self.n_cycles);
        let part = 100.0 * missed as f64 / planned as f64;
        let latest = 1e3 * self.lateness.max();
        Some(format!(
            "{missed} of {planned} cycles were missed ({part:.1} %), the latest came {latest:.0} ms late: this computer was busy"
        ))
    }

    /// The same for a file.
    pub fn summary(&self) -> StatsSummary {
        StatsSummary {
            n_cycles: self.n_cycles,
            n_missed: self.n_missed,
            within_1ms: self.lateness.within(1e-3),
            late_p99_ms: 1e3 * self.lateness.percentile(0.99),
            late_max_ms: 1e3 * self.lateness.max(),
            bus_median_ms: 1e3 * self.bus.percentile(0.5),
            bus_p99_ms: 1e3 * self.bus.percentile(0.99),
            wire_ms: 1e3 * self.wire,
            n_poses: [self.pose_age.n, self.n_doubtful],
            pose_age_median_ms: 1e3 * self.pose_age.percentile(0.5),
            pose_age_p99_ms: 1e3 * self.pose_age.percentile(0.99),
            temperature_degc: self.heat.rows.clone(),
            processor_percent: self.processor.map(|part| 100.0 * part),
            bus: self.counts,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_of_known_times_are_right_to_a_bin() {
        let mut histogram = Histogram::new();
        (1..=1000).for_each(|i| histogram.add(1e-5 * f64::from(i)));
        for part in [0.01, 0.5, 0.99] {
            assert!((histogram.percentile(part) - 1e-2 * part).abs() <= 2.0 * BIN, "{part}");
        }
        assert_eq!(histogram.max(), 1e-2);
        assert!((histogram.within(1e-3) - 0.1).abs() <= 2e-3);
    }

    #[test]
    fn heat_is_kept_over_the_whole_run_in_bounded_memory() {
        let mut heat = TemperatureHistory::default();
        for i in 0..5000 {
            let warm = SlowSample { voltage: 12.0, temperature: 25.0 + 0.001 * f64::from(i) };
            heat.add(f64::from(i), &[Some(warm), if i == 0 { None } else { Some(warm) }]);
        }
        heat.begin_at(1.0);
        assert!(
            (TemperatureHistory::MAX_READINGS / 3..TemperatureHistory::MAX_READINGS)
                .contains(&heat.rows.len()),
            "{}",
            heat.rows.len()
        );
        assert!(heat.rows[0][0] < 100.0 && heat.rows.last().is_some_and(|row| row[0] > 4900.0));
        assert!(
            heat.rows.iter().all(|row| row.len() == 3 && (row[1] - 25.001 - 0.001 * row[0]).abs() < 1e-9)
        );
        let gaps: Vec<f64> = heat.rows.windows(2).map(|pair| pair[1][0] - pair[0][0]).collect();
        assert!(gaps.iter().all(|gap| *gap <= 2.0 * gaps[0]), "{gaps:?}");
    }

    #[test]
    fn missed_cycles_are_reported_with_their_share() {
        let mut stats = RunStats::new(0.01);
        (0..98).for_each(|_| stats.add_cycle(0.0, (0.0, 0.0)));
        assert_eq!(stats.missed_cycles(), None);
        stats.n_missed = 2;
        stats.add_cycle(0.02, (0.0, 0.0));
        stats.add_cycle(0.0, (0.0, 0.0));
        let message = stats.missed_cycles().unwrap_or_default();
        assert!(
            message.starts_with("2 of 102 cycles were missed (2.0 %), the latest came 20 ms late"),
            "{message}"
        );
        assert_eq!(stats.summary().n_missed, 2);
    }

    #[test]
    fn times_beyond_the_bins_are_still_counted() {
        let mut histogram = Histogram::new();
        histogram.add(1.0);
        assert_eq!((histogram.percentile(0.5), histogram.within(1e-3)), (N_BINS as f64 * BIN, 0.0));
    }
}

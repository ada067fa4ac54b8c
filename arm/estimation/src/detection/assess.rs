//! How good a test is, where contacts are known.

use std::ops::Range;

use super::Alarm;

/// When an arm was really touched.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Samples of every contact, in order.
    pub contacts: Vec<Range<usize>>,
    /// Samples after a contact in which an alarm is not counted as false: the estimate comes down, the arm recovers.
    pub settling: usize,
    /// Time between samples [s].
    pub period: f64,
}

/// Recall, delay and false alarms of a test at one threshold.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Assessment {
    /// The value of the test above which the alarm went on.
    pub threshold: f64,
    /// Share of the contacts that were found before they ended [-].
    pub recall: f64,
    /// Samples from the beginning of a contact to its alarm, mean and largest of those found; NaN where none was.
    pub delay_samples: [f64; 2],
    /// Alarms that went on without a contact.
    pub false_alarms: usize,
    /// The same for each hour without contact [1/h].
    pub false_alarms_per_hour: f64,
}

/// Compares `values` of a test, sample by sample, with the truth. The alarm goes on above `threshold`, off below `release` times that.
pub fn assess(values: &[f64], threshold: f64, release: f64, truth: &Truth) -> Assessment {
    let mut alarm = Alarm::new(release);
    let alarms: Vec<bool> = values.iter().map(|value| alarm.update(value / threshold)).collect();
    let delays: Vec<f64> = truth
        .contacts
        .iter()
        .filter_map(|contact| Some(alarms[contact.clone()].iter().position(|on| *on)? as f64))
        .collect();
    let mut is_free = vec![true; values.len()];
    for contact in &truth.contacts {
        let end = (contact.end + truth.settling).min(values.len());
        is_free[contact.start..end].fill(false);
    }
    // An alarm that begins in a contact and lasts is not false.
    let rises = |k: usize| alarms[k] && (k == 0 || !alarms[k - 1]);
    let false_alarms = (0..values.len()).filter(|k| is_free[*k] && rises(*k)).count();
    let hours = is_free.iter().filter(|free| **free).count() as f64 * truth.period / 3600.0;
    let found = delays.len() as f64;
    Assessment {
        threshold,
        recall: found / truth.contacts.len() as f64,
        delay_samples: [delays.iter().sum::<f64>() / found, delays.iter().copied().fold(f64::NAN, f64::max)],
        false_alarms,
        false_alarms_per_hour: false_alarms as f64 / hours,
    }
}

/// [`assess`] at every threshold: the receiver operating characteristic, with false alarms an hour in place of a rate of samples.
pub fn roc(values: &[f64], thresholds: &[f64], release: f64, truth: &Truth) -> Vec<Assessment> {
    thresholds.iter().map(|threshold| assess(values, *threshold, release, truth)).collect()
}

/// `n` numbers from `least` to `most`, evenly spread in their logarithm.
pub fn logarithmic(least: f64, most: f64, n: usize) -> Vec<f64> {
    (0..n).map(|k| least * (most / least).powf(k as f64 / (n.max(2) - 1) as f64)).collect()
}

//! The range of strokes and rates that a twin was calibrated on.

use hysteron_base::{Bounds, Recording};
use hysteron_control::StrokeLimits;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::inputs::Input;
use crate::shared::network::Network;

/// Strokes and rates of every tendon, and where they are from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CalibratedRange {
    /// Robot that carried them out.
    pub source: String,
    /// Smallest and largest stroke of each tendon [m].
    pub strokes_m: Vec<[f64; 2]>,
    /// Fastest change of each tendon [m/s]; none where it is not known.
    pub rates_m_s: Option<Vec<f64>>,
}

impl CalibratedRange {
    /// Of the recordings that a residual network was trained on: the range of its inputs, which its checkpoint holds. `None`
    /// where the checkpoint does not name them.
    pub fn of_network(network: &Network, n_tendons: usize, path: &str) -> Option<Self> {
        let channels = &network.model().inputs.channels;
        let range = |name: String| {
            let channel = channels.iter().find(|channel| channel.name == name)?;
            Some([channel.min, channel.max])
        };
        let strokes_m =
            (1..=n_tendons).map(|k| range(format!("stroke_{k}_m"))).collect::<Option<Vec<_>>>()?;
        // The published design does not see rates.
        let rate = |k: usize| range(format!("stroke_rate_{k}_m_s")).map(|[min, max]| max.max(-min));
        let rates_m_s = (1..=n_tendons).map(rate).collect();
        Some(Self { source: path.to_owned(), strokes_m, rates_m_s })
    }

    /// Of recordings of the robot; `None` where these have not so many tendons.
    pub fn of_recordings(inputs: &[Input], n_tendons: usize) -> Option<Self> {
        let recordings: Vec<&Recording> = inputs
            .iter()
            .map(|input| &input.recording)
            .filter(|recording| recording.strokes().len() == n_tendons)
            .collect();
        if recordings.is_empty() {
            return None;
        }
        let empty = ([f64::INFINITY, f64::NEG_INFINITY], 0.0);
        let of = |k: usize| {
            recordings.iter().fold(empty, |([min, max], rate), recording| {
                let (stroke, time) = (recording.strokes()[k], recording.time());
                let [min, max] = stroke.iter().fold([min, max], |[min, max], s| [min.min(*s), max.max(*s)]);
                let changes = stroke.windows(2).zip(time.windows(2));
                let rates = changes.map(|(s, t)| ((s[1] - s[0]) / (t[1] - t[0])).abs());
                ([min, max], rates.fold(rate, f64::max))
            })
        };
        let (strokes_m, rates): (Vec<_>, Vec<_>) = (0..n_tendons).map(of).unzip();
        Some(Self { source: "the recordings of --real".to_owned(), strokes_m, rates_m_s: Some(rates) })
    }

    /// As limits of a plan, one for each tendon.
    pub fn limits(&self) -> Vec<StrokeLimits> {
        let rate = |k: usize| self.rates_m_s.as_ref().map_or(f64::INFINITY, |rates| rates[k]);
        let limits = |(k, [min, max]): (usize, &[f64; 2])| StrokeLimits {
            stroke: Bounds { min: *min, max: *max },
            stroke_rate: rate(k),
        };
        self.strokes_m.iter().enumerate().map(limits).collect()
    }

    /// In words: what it spans over all tendons.
    pub fn describe(&self) -> String {
        let fold = |start: f64, of: fn(f64, f64) -> f64, at: usize| {
            1e3 * self.strokes_m.iter().map(|range| range[at]).fold(start, of)
        };
        let [min, max] = [fold(f64::INFINITY, f64::min, 0), fold(f64::NEG_INFINITY, f64::max, 1)];
        let fastest = |rates: &Vec<f64>| 1e3 * rates.iter().copied().fold(0.0, f64::max);
        let rate = self.rates_m_s.as_ref().map(fastest);
        let rate = rate.map_or_else(String::new, |rate| format!(" and at most {rate:.2} mm/s"));
        format!("strokes of {min:.2} to {max:.2} mm{rate}")
    }
}

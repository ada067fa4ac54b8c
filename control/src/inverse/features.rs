//! Features of a path, inputs of the recurrent network.
//!
//! The path is known before it is followed, so features look ahead: where the tip shall be, how fast and in
//! which direction it shall go, now and a few tenths of a second later. A measured tip carries noise, so
//! positions and rates come from straight lines through the samples around. Play operators model the memory
//! of friction, first-order filters that of the material: both are given, of the strokes that the static
//! regression asks for.

use hysteron_actuator::OperatorBank;
use hysteron_base::BadInput;
use serde::{Deserialize, Serialize};

use super::Axes;
use super::path_point::{PathPoint, PathSmoothing};

/// Which features there are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FeatureSpec {
    /// Coordinates of a tip.
    pub axes: Axes,
    /// Duration of a sample [s].
    pub step_s: f64,
    /// Number of tendons.
    pub n_tendons: usize,
    /// Which samples a line is drawn through.
    pub smoothing: PathSmoothing,
    /// Half the time that a line spans [s].
    pub half_width_s: f64,
    /// Times ahead at which features are taken [s].
    pub horizons_s: Vec<f64>,
    /// Speed at which the direction counts about half; below, noise decides it [m/s].
    pub slow_m_s: f64,
    /// Widths of the plays [m].
    pub plays_m: Vec<f64>,
    /// Time constants of the first-order filters [s].
    #[serde(alias = "lags_s")]
    pub filters_s: Vec<f64>,
    /// How far ahead of itself the path is read, for the tip comes that much later than its strokes [s].
    #[serde(default)]
    pub delay_s: f64,
}

impl FeatureSpec {
    /// # Errors
    /// `BadInput` naming a time or width that cannot be.
    pub(super) fn check(&self) -> Result<(), BadInput> {
        let positive = |v: f64| v > 0.0 && v.is_finite();
        let all = |values: &[f64]| values.iter().all(|v| positive(*v));
        let one = |value: &f64| vec![*value];
        let horizons = all(&self.horizons_s) && self.horizons_s.iter().all(|h| *h < 100.0);
        let half_width = self.half_width_s >= self.step_s && self.half_width_s < 10.0;
        let checks = [
            ("step_s", positive(self.step_s), "a duration > 0", one(&self.step_s)),
            ("half_width_s", half_width, "one sample to 10 s", one(&self.half_width_s)),
            ("slow_m_s", positive(self.slow_m_s), "a speed > 0", one(&self.slow_m_s)),
            ("horizons_s", horizons, "0 < s < 100", self.horizons_s.clone()),
            ("plays_m", all(&self.plays_m), "widths > 0", self.plays_m.clone()),
            ("filters_s", all(&self.filters_s), "times > 0", self.filters_s.clone()),
            ("delay_s", (0.0..100.0).contains(&self.delay_s), "0 <= s < 100", one(&self.delay_s)),
        ];
        match checks.into_iter().find(|(_, fits, ..)| !fits) {
            Some((name, _, expected, found)) => {
                let found = found.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
                Err(BadInput::new(format!("features: {name}"), expected, found))
            }
            None => Ok(()),
        }
    }

    /// Names of all features, in order.
    pub fn names(&self) -> Vec<String> {
        let axes = |of: &str, unit: &str| -> Vec<String> {
            self.axes.names().iter().map(|axis| format!("{of}{axis}_{unit}")).collect()
        };
        let mut names = [axes("tip_", "m"), axes("rate_", "m_s"), axes("direction_", "ratio")].concat();
        for h in 1..=self.horizons_s.len() {
            names.extend(axes(&format!("ahead_{h}_"), "m"));
            names.extend(axes(&format!("ahead_{h}_rate_"), "m_s"));
        }
        for k in 1..=self.n_tendons {
            names.extend((1..=self.plays_m.len()).map(|p| format!("play_{p}_{k}_m")));
            names.extend((1..=self.filters_s.len()).map(|p| format!("filter_{p}_{k}_m")));
        }
        names
    }

    /// Numbers of the features whose names `is_one` accepts.
    pub(super) fn numbers(&self, is_one: impl Fn(&str) -> bool) -> Vec<usize> {
        let names = self.names();
        (0..names.len()).filter(|&k| is_one(&names[k])).collect()
    }
}

/// The features of a path, sample by sample.
#[derive(Debug, Clone)]
pub struct Features {
    spec: FeatureSpec,
    /// Horizons [samples].
    ahead: Vec<usize>,
    /// Of the strokes.
    operators: OperatorBank,
}

impl Features {
    /// Before the first sample.
    pub fn new(spec: &FeatureSpec) -> Self {
        Self {
            ahead: spec.horizons_s.iter().map(|h| (h / spec.step_s).round() as usize).collect(),
            operators: OperatorBank::new(&spec.plays_m, &spec.filters_s, spec.step_s),
            spec: spec.clone(),
        }
    }

    /// Appends the features of sample `i` of a smoothed path to `out`; after its end the last point is repeated. Samples come in
    /// order. `strokes` (n_tendons) are those of the static regression [m].
    pub fn append(&mut self, path: &[PathPoint], i: usize, strokes: &[f64], out: &mut Vec<f64>) {
        let PathPoint { position, rate } = path[i];
        let n = self.spec.axes.len();
        out.extend(&position[..n]);
        out.extend(&rate[..n]);
        let speed = rate[0].hypot(rate[1]).hypot(rate[2]).hypot(self.spec.slow_m_s);
        out.extend(rate[..n].iter().map(|v| v / speed));
        for ahead in &self.ahead {
            let then = path.get(i + ahead).copied();
            let then = then.unwrap_or(PathPoint { position: path[path.len() - 1].position, rate: [0.0; 3] });
            out.extend((0..n).map(|c| then.position[c] - position[c]));
            out.extend(&then.rate[..n]);
        }
        if i == 0 {
            self.operators.begin(strokes);
        }
        for (k, &stroke) in strokes.iter().enumerate() {
            self.operators.append(k, stroke, out);
        }
    }
}

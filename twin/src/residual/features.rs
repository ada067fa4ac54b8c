//! Features of the commands, inputs of the recurrent network.
//!
//! Friction and backlash make play operators (Prandtl-Ishlinskii), viscous material makes first-order filters (Maxwell
//! elements). A network that gets these has the memory it needs in front of it, over times that back-propagation does
//! not reach.

use hysteron_actuator::OperatorBank;
use serde::{Deserialize, Serialize};

/// Which features there are, for every primary tendon.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FeatureSpec {
    /// Primary tendons.
    pub n_primary: usize,
    /// Widths of the plays [m].
    pub plays_m: Vec<f64>,
    /// Time constants of the first-order filters [s].
    #[serde(alias = "lags_s")]
    pub filters_s: Vec<f64>,
    /// Whether the twin's tip of the sample before comes too (eq. 11).
    pub feedback: bool,
    /// Duration of a sample [s].
    pub step_s: f64,
}

impl FeatureSpec {
    /// Names of all features, in order.
    pub fn names(&self) -> Vec<String> {
        let mut names = Vec::new();
        for k in 1..=self.n_primary {
            names.push(format!("stroke_{k}_m"));
            names.push(format!("stroke_rate_{k}_m_s"));
            names.extend((1..=self.plays_m.len()).map(|p| format!("play_{p}_{k}_m")));
            names.extend((1..=self.filters_s.len()).map(|p| format!("filter_{p}_{k}_m")));
        }
        if self.feedback {
            names.extend(["x", "y", "z"].map(|axis| format!("tip_{axis}_m")));
        }
        names
    }

    /// Whether all widths and times are above zero.
    pub fn is_valid(&self) -> bool {
        let mut values = self.plays_m.iter().chain(&self.filters_s).chain([&self.step_s]);
        values.all(|value| *value > 0.0 && value.is_finite())
    }

    /// Number of features without the tip.
    pub fn n_of_strokes(&self) -> usize {
        self.n_primary * (2 + self.plays_m.len() + self.filters_s.len())
    }

    /// Number of features.
    pub fn len(&self) -> usize {
        self.n_of_strokes() + if self.feedback { 3 } else { 0 }
    }

    /// True when there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The features of a command sequence, sample by sample.
#[derive(Debug, Clone)]
pub struct Features {
    step_s: f64,
    /// Strokes of the sample before [m]; none before the first.
    before: Option<Vec<f64>>,
    operators: OperatorBank,
}

impl Features {
    /// Before the first sample.
    pub fn new(spec: &FeatureSpec) -> Self {
        let operators = OperatorBank::new(&spec.plays_m, &spec.filters_s, spec.step_s);
        Self { step_s: spec.step_s, before: None, operators }
    }

    /// Appends the features of the next sample to `out`, strokes (n_primary) [m]; the tip is the caller's.
    pub fn append(&mut self, strokes: &[f64], out: &mut Vec<f64>) {
        if self.before.is_none() {
            self.operators.begin(strokes);
        }
        let before = self.before.get_or_insert_with(|| strokes.to_vec());
        for (k, &stroke) in strokes.iter().enumerate() {
            out.push(stroke);
            out.push((stroke - before[k]) / self.step_s);
            self.operators.append(k, stroke, out);
        }
        before.copy_from_slice(strokes);
    }
}

//! What the stateful network sees of the commands.
//!
//! Friction and backlash make play operators (Prandtl-Ishlinskii), viscous material makes first-order lags (Maxwell
//! elements). A network that gets these has the memory it needs in front of it, over times that back-propagation does
//! not reach.

use hysteron_actuator::Play;
use serde::{Deserialize, Serialize};

/// Which features there are, for every primary tendon.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FeatureSpec {
    /// Primary tendons.
    pub n_primary: usize,
    /// Widths of the plays [m].
    pub plays_m: Vec<f64>,
    /// Time constants of the lags [s].
    pub lags_s: Vec<f64>,
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
            names.extend((1..=self.lags_s.len()).map(|p| format!("lag_{p}_{k}_m")));
        }
        if self.feedback {
            names.extend(["x", "y", "z"].map(|axis| format!("tip_{axis}_m")));
        }
        names
    }

    /// Whether all widths and times are above zero.
    pub fn is_valid(&self) -> bool {
        let mut values = self.plays_m.iter().chain(&self.lags_s).chain([&self.step_s]);
        values.all(|value| *value > 0.0 && value.is_finite())
    }

    /// Number of features without the tip.
    pub fn n_of_strokes(&self) -> usize {
        self.n_primary * (2 + self.plays_m.len() + self.lags_s.len())
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
    spec: FeatureSpec,
    /// Strokes of the sample before [m]; none before the first.
    before: Option<Vec<f64>>,
    /// For each tendon, its plays.
    plays: Vec<Play>,
    /// For each tendon, its lagging strokes [m].
    lags: Vec<f64>,
}

impl Features {
    /// Before the first sample.
    pub fn new(spec: &FeatureSpec) -> Self {
        Self { spec: spec.clone(), before: None, plays: Vec::new(), lags: Vec::new() }
    }

    /// Appends the features of the next sample to `out`, strokes (n_primary) [m]; the tip is the caller's.
    pub fn append(&mut self, strokes: &[f64], out: &mut Vec<f64>) {
        let (n_plays, n_lags) = (self.spec.plays_m.len(), self.spec.lags_s.len());
        if self.before.is_none() {
            let plays = |&stroke: &f64| self.spec.plays_m.iter().map(move |&width| Play::new(width, stroke));
            self.plays = strokes.iter().flat_map(plays).collect();
            self.lags = strokes.iter().flat_map(|&stroke| std::iter::repeat_n(stroke, n_lags)).collect();
        }
        let before = self.before.get_or_insert_with(|| strokes.to_vec());
        for (k, &stroke) in strokes.iter().enumerate() {
            out.push(stroke);
            out.push((stroke - before[k]) / self.spec.step_s);
            for play in &mut self.plays[k * n_plays..(k + 1) * n_plays] {
                out.push(play.follow(stroke) - stroke);
            }
            for (lag, time) in self.lags[k * n_lags..(k + 1) * n_lags].iter_mut().zip(&self.spec.lags_s) {
                // Exact for a stroke that is constant over the sample.
                *lag += (1.0 - (-self.spec.step_s / time).exp()) * (stroke - *lag);
                out.push(*lag - stroke);
            }
        }
        before.copy_from_slice(strokes);
    }
}

//! The median of neighbours: spikes vanish, steps stay.

/// Running median over the last samples, causal; half a window late.
#[derive(Debug, Clone, PartialEq)]
pub struct Median {
    last: Vec<f64>,
    sorted: Vec<f64>,
    at: usize,
}

impl Median {
    /// Over `window` samples (at least one), all of them `first` before the start.
    pub fn new(window: usize, first: f64) -> Self {
        let window = window.max(1);
        Self { last: vec![first; window], sorted: vec![first; window], at: 0 }
    }

    /// The next output; allocates nothing. Numbers that are not finite sort last.
    pub fn next(&mut self, input: f64) -> f64 {
        self.last[self.at] = input;
        self.at = (self.at + 1) % self.last.len();
        self.sorted.copy_from_slice(&self.last);
        self.sorted.sort_unstable_by(f64::total_cmp);
        middle(&self.sorted)
    }
}

fn middle(sorted: &[f64]) -> f64 {
    let n = sorted.len();
    if n % 2 == 1 { sorted[n / 2] } else { 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]) }
}

/// The median of `half` neighbours to both sides and the sample itself, without delay; at the ends of the neighbours there are.
pub fn median_of(signal: &[f64], half: usize) -> Vec<f64> {
    let mut sorted = Vec::with_capacity(2 * half + 1);
    let mut at = |k: usize| {
        sorted.clear();
        sorted.extend_from_slice(&signal[k.saturating_sub(half)..(k + half + 1).min(signal.len())]);
        sorted.sort_unstable_by(f64::total_cmp);
        middle(&sorted)
    };
    (0..signal.len()).map(&mut at).collect()
}

//! Backlash: the play operator. Its output follows only when the input has crossed the gap.

/// A gap between a driving and a driven part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Play {
    /// How far the input moves from one flank to the other [unit of the input].
    pub width: f64,
    /// Output, the operator's memory [unit of the input].
    pub output: f64,
}

impl Play {
    /// A gap of that width, with the output in its middle at `input`. A negative width counts as none.
    pub fn new(width: f64, input: f64) -> Self {
        Self { width: width.max(0.0), output: input }
    }

    /// Output for the next input: the nearest to the last one that the gap allows.
    pub fn follow(&mut self, input: f64) -> f64 {
        let half = 0.5 * self.width;
        self.output = self.output.clamp(input - half, input + half);
        self.output
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn output_lags_half_the_gap_and_rests_on_reversal() {
        let mut play = Play::new(0.2, 0.0);
        assert_eq!(play.follow(0.05), 0.0);
        assert!((play.follow(1.0) - 0.9).abs() < 1e-15);
        assert!((play.follow(0.85) - 0.9).abs() < 1e-15);
        assert!((play.follow(0.0) - 0.1).abs() < 1e-15);
    }

    #[test]
    fn loop_area_is_width_times_travel() {
        let mut play = Play::new(0.2, 0.0);
        let mut area = 0.0;
        let path: Vec<f64> = (0..=4000).map(|k| (k as f64 * std::f64::consts::TAU / 2000.0).sin()).collect();
        play.follow(path[0]);
        for (k, pair) in path.windows(2).enumerate() {
            let before = play.output;
            let after = play.follow(pair[1]);
            if k >= 2000 {
                area += 0.5 * (pair[0] + pair[1]) * (after - before);
            }
        }
        // Travel of the output: 2 (2 - width); input ahead of it by half the width.
        assert!((area - 0.1 * 2.0 * 1.8).abs() < 1e-3, "{area}");
    }
}

//! Butterworth low pass as second-order sections.
//!
//! # Reference
//! Oppenheim, Schafer, Discrete-time signal processing, 7.2 (bilinear transform, order from a specification); Gustafsson (1996),
//! Determining the initial states in forward-backward filtering, for the ends as scipy's `sosfiltfilt` treats them.

use std::f64::consts::PI;

use hysteron_base::BadInput;

/// Specification of a low pass: gains in the pass band and in the stop band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Specification {
    /// Up to here the gain is at least `pass_db` [Hz].
    pub pass: f64,
    /// Gain that is left at `pass`, below 0 [dB].
    pub pass_db: f64,
    /// From here on the gain is at most `stop_db` [Hz].
    pub stop: f64,
    /// Gain that is left at `stop`, below `pass_db` [dB].
    pub stop_db: f64,
}

/// A section b₀ + b₁ z⁻¹ + b₂ z⁻² over 1 + a₁ z⁻¹ + a₂ z⁻².
#[derive(Debug, Clone, Copy, PartialEq)]
struct BiquadSection {
    b: [f64; 3],
    a: [f64; 2],
}

/// A Butterworth low pass.
#[derive(Debug, Clone, PartialEq)]
pub struct LowPass {
    sections: Vec<BiquadSection>,
    /// Order n.
    pub order: usize,
    /// Frequency at which half of the power passes [Hz].
    pub cutoff: f64,
    /// Samples per second [Hz].
    pub rate: f64,
}

/// Largest order that is designed.
const MAX_ORDER: usize = 40;

impl LowPass {
    /// Of order `order` with half of the power at `cutoff`, for `rate` samples per second [Hz].
    ///
    /// # Errors
    /// `BadInput` for order 0 or above 40, or a cutoff outside (0, rate/2).
    pub fn new(order: usize, cutoff: f64, rate: f64) -> Result<Self, BadInput> {
        if !(1..=MAX_ORDER).contains(&order) {
            return Err(BadInput::new("order of the filter", format!("1 to {MAX_ORDER}"), order.to_string()));
        }
        if !(cutoff > 0.0 && cutoff < 0.5 * rate && rate.is_finite()) {
            let expected = format!("above 0 and below half of the {rate} samples per second");
            return Err(BadInput::new("cutoff", expected, format!("{cutoff} Hz")));
        }
        // Analogue cutoff before the bilinear transform s = (z - 1)/(z + 1).
        let w = (PI * cutoff / rate).tan();
        let mut sections = Vec::new();
        for k in 0..order / 2 {
            // Poles w exp(±i φ): s² + 2 ζ w s + w².
            let zeta = (PI * (2.0 * k as f64 + 1.0) / (2.0 * order as f64)).sin();
            let d = 1.0 + 2.0 * zeta * w + w * w;
            sections.push(BiquadSection {
                b: [w * w / d, 2.0 * w * w / d, w * w / d],
                a: [2.0 * (w * w - 1.0) / d, (1.0 - 2.0 * zeta * w + w * w) / d],
            });
        }
        if order % 2 == 1 {
            sections.push(BiquadSection {
                b: [w / (1.0 + w), w / (1.0 + w), 0.0],
                a: [(w - 1.0) / (1.0 + w), 0.0],
            });
        }
        Ok(Self { sections, order, cutoff, rate })
    }

    /// The filter of lowest order that meets the specification, with exactly `pass_db` at `pass`.
    ///
    /// # Errors
    /// `BadInput` for a specification that contradicts itself, or needs an order above 40.
    pub fn meeting(specification: Specification, rate: f64) -> Result<Self, BadInput> {
        let Specification { pass, pass_db, stop, stop_db } = specification;
        if !(pass > 0.0 && pass < stop && stop < 0.5 * rate && pass_db < 0.0 && stop_db < pass_db) {
            let expected = "0 < pass < stop < rate/2 and 0 > pass gain > stop gain";
            return Err(BadInput::new(
                "specification of the filter",
                expected,
                format!(
                    "{pass_db} dB up to {pass} Hz and {stop_db} dB from {stop} Hz on, at a rate of {rate} Hz"
                ),
            ));
        }
        let analogue = |f: f64| (PI * f / rate).tan();
        let excess = |db: f64| 10f64.powf(-0.1 * db) - 1.0;
        let order = (excess(stop_db) / excess(pass_db)).ln() / (2.0 * (analogue(stop) / analogue(pass)).ln());
        if order > MAX_ORDER as f64 {
            let expected = format!("a band between pass and stop that an order up to {MAX_ORDER} can cross");
            return Err(BadInput::new("specification of the filter", expected, format!("order {order:.1}")));
        }
        let order = order.ceil().max(1.0);
        let w = analogue(pass) / excess(pass_db).powf(0.5 / order);
        Self::new(order as usize, w.atan() / PI * rate, rate)
    }

    /// Gain at `frequency` [Hz].
    pub fn gain(&self, frequency: f64) -> f64 {
        let angle = 2.0 * PI * frequency / self.rate;
        let size = |[p, q, r]: [f64; 3]| {
            let (re, im) =
                (p + q * angle.cos() + r * (2.0 * angle).cos(), q * angle.sin() + r * (2.0 * angle).sin());
            re.hypot(im)
        };
        self.sections.iter().map(|s| size(s.b) / size([1.0, s.a[0], s.a[1]])).product()
    }

    /// A filter at rest as if `first` had always been its input.
    pub fn start(&self, first: f64) -> LowPassState {
        let memory = self.sections.iter().map(|s| s.settled().map(|z| z * first)).collect();
        LowPassState { sections: self.sections.clone(), memory }
    }

    /// `signal` filtered forwards and backwards: no delay, and the gain squared.
    ///
    /// Both ends are continued by their reflection through the last sample, as scipy's `sosfiltfilt` does.
    pub fn zero_phase(&self, signal: &[f64]) -> Vec<f64> {
        let n = signal.len();
        if n < 2 {
            return signal.to_vec();
        }
        // scipy: 3 × (2 sections + 1 - the smaller number of zeros among b2 and a2).
        let odd = self.order % 2;
        let pad = (3 * (2 * self.sections.len() + 1 - odd)).min(n - 1);
        let (first, last) = (signal[0], signal[n - 1]);
        let mut padded: Vec<f64> = (1..=pad).rev().map(|k| 2.0 * first - signal[k]).collect();
        padded.extend_from_slice(signal);
        padded.extend((1..=pad).map(|k| 2.0 * last - signal[n - 1 - k]));
        for _ in 0..2 {
            let mut state = self.start(padded[0]);
            padded.iter_mut().for_each(|x| *x = state.next(*x));
            padded.reverse();
        }
        padded[pad..pad + n].to_vec()
    }
}

impl BiquadSection {
    /// Memory of a constant input of 1: direct form II transposed at rest, gain 1.
    fn settled(&self) -> [f64; 2] {
        let second = self.b[2] - self.a[1];
        [self.b[1] - self.a[0] + second, second]
    }
}

/// A low pass in motion.
#[derive(Debug, Clone, PartialEq)]
pub struct LowPassState {
    sections: Vec<BiquadSection>,
    memory: Vec<[f64; 2]>,
}

impl LowPassState {
    /// The next output; allocates nothing.
    pub fn next(&mut self, input: f64) -> f64 {
        let mut x = input;
        for (s, z) in self.sections.iter().zip(&mut self.memory) {
            let y = s.b[0] * x + z[0];
            *z = [s.b[1] * x - s.a[0] * y + z[1], s.b[2] * x - s.a[1] * y];
            x = y;
        }
        x
    }
}

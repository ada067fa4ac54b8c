//! Creep and relaxation: a spring with Maxwell elements in parallel (Prony series, generalised Maxwell
//! solid).
//!
//! With strain ε, relaxed modulus E∞ and weights g_k relative to it, σ = E∞ (ε + Σ g_k y_k), where the elastic part of a
//! Maxwell element's strain y_k = ε - α_k decays: τ_k α_k' = ε - α_k. The step is exact for strain that is linear in
//! time, so its length is free.

use hysteron_base::BadInput;

/// Weights and times of the Maxwell elements; the strain of each belongs to the caller.
#[derive(Debug, Clone, PartialEq)]
pub struct Prony {
    /// Stiffness of each element over the relaxed one, g_k (n_terms) [-].
    pub weights: Vec<f64>,
    /// Relaxation time of each, τ_k (n_terms) [s].
    pub times: Vec<f64>,
}

/// Coefficients of a step of one length, for each element.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PronyStep {
    /// exp(-h/τ_k): remaining share of the elastic strain at the beginning (n_terms) [-].
    pub decay: Vec<f64>,
    /// (1 - exp(-h/τ_k)) τ_k/h: remaining share of the strain added during the step (n_terms) [-].
    pub gain: Vec<f64>,
    /// g_k (n_terms) [-].
    pub weights: Vec<f64>,
    /// dσ/dε over E∞ at the end of the step: 1 + Σ g_k gain_k [-].
    pub tangent: f64,
}

impl Prony {
    /// A series from `weights` [-] and `times` [s], as many of the one as of the other.
    ///
    /// # Errors
    /// `BadInput` naming the term that cannot be.
    pub fn new(weights: Vec<f64>, times: Vec<f64>) -> Result<Self, BadInput> {
        if weights.len() != times.len() {
            let found = format!("{} weights and {} times", weights.len(), times.len());
            return Err(BadInput::new("prony", "as many weights as times", found));
        }
        for (k, (&weight, &time)) in weights.iter().zip(&times).enumerate() {
            if !(weight.is_finite() && weight >= 0.0) {
                let place = format!("prony.weights[{k}]");
                return Err(BadInput::new(place, "a finite number >= 0", format!("{weight:?}")));
            }
            if !(time.is_finite() && time > 0.0) {
                let place = format!("prony.times[{k}]");
                return Err(BadInput::new(place, "a finite number > 0", format!("{time:?}")));
            }
        }
        Ok(Self { weights, times })
    }

    /// Number of Maxwell elements.
    pub fn n_terms(&self) -> usize {
        self.weights.len()
    }

    /// Stiffness at once over the relaxed one, 1 + Σ g_k [-].
    pub fn instantaneous(&self) -> f64 {
        1.0 + self.weights.iter().sum::<f64>()
    }

    /// Relaxation at time `t` [s] after a strain step, over the relaxed stress [-].
    pub fn relaxation(&self, t: f64) -> f64 {
        1.0 + self.weights.iter().zip(&self.times).map(|(g, tau)| g * (-t / tau).exp()).sum::<f64>()
    }

    /// Writes what a step of `h` [s] does; `h` = 0 is a jump. Allocates only when `step` has never been used.
    pub fn step_into(&self, h: f64, step: &mut PronyStep) {
        step.decay.clear();
        step.gain.clear();
        step.weights.clone_from(&self.weights);
        step.tangent = 1.0;
        for (&g, &tau) in self.weights.iter().zip(&self.times) {
            let x = h / tau;
            let gain = if x < 1e-9 { 1.0 - 0.5 * x } else { -(-x).exp_m1() / x };
            step.decay.push((-x).exp());
            step.gain.push(gain);
            step.tangent += g * gain;
        }
    }
}

impl PronyStep {
    /// Stress over E∞ at the end of a step to `strain` that adds `increment`, from the elastic strains `y` (n_terms) at its
    /// beginning [-].
    pub fn stress(&self, strain: f64, increment: f64, y: &[f64]) -> f64 {
        let mut stress = strain;
        for k in 0..self.weights.len() {
            stress += self.weights[k] * (self.decay[k] * y[k] + self.gain[k] * increment);
        }
        stress
    }

    /// Advances the elastic strains `y` (n_terms) over a step that adds `increment` to the strain [-].
    pub fn advance(&self, increment: f64, y: &mut [f64]) {
        for k in 0..self.weights.len() {
            y[k] = self.decay[k] * y[k] + self.gain[k] * increment;
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may stop where it stands
mod tests {
    use super::*;

    fn series() -> Prony {
        Prony::new(vec![0.3, 0.15], vec![0.4, 20.0]).unwrap()
    }

    #[test]
    fn relaxation_is_exact_for_any_step() {
        let prony = series();
        for n in [1, 7] {
            let mut y = [0.0; 2];
            let mut step = PronyStep::default();
            prony.step_into(0.0, &mut step);
            assert!((step.stress(0.01, 0.01, &y) - 0.01 * prony.instantaneous()).abs() < 1e-15);
            step.advance(0.01, &mut y);
            prony.step_into(3.0 / n as f64, &mut step);
            for _ in 0..n {
                step.advance(0.0, &mut y);
            }
            let now = 0.01 + prony.weights.iter().zip(&y).map(|(g, y)| g * y).sum::<f64>();
            assert!((now - 0.01 * prony.relaxation(3.0)).abs() < 1e-15);
        }
    }

    #[test]
    fn ramp_is_exact_for_any_step() {
        let prony = series();
        // σ(t) = rate (t + Σ g τ (1 - exp(-t/τ))).
        let (rate, t) = (0.02, 1.7);
        let exact = rate
            * (t + prony
                .weights
                .iter()
                .zip(&prony.times)
                .map(|(g, tau)| g * tau * (1.0 - f64::exp(-t / tau)))
                .sum::<f64>());
        for n in [1, 10] {
            let (mut y, mut step) = ([0.0; 2], PronyStep::default());
            prony.step_into(t / n as f64, &mut step);
            for _ in 0..n {
                step.advance(rate * t / n as f64, &mut y);
            }
            let stress = rate * t + prony.weights.iter().zip(&y).map(|(g, y)| g * y).sum::<f64>();
            assert!((stress - exact).abs() < 1e-15, "{stress} {exact}");
        }
    }

    /// Creep of one element in parallel with the spring: ε(t) = σ/E∞ (1 - g/(1+g) exp(-t/(τ(1+g)))).
    #[test]
    fn creep_under_constant_stress_meets_the_closed_form() {
        let (g, tau) = (0.4, 2.0);
        let prony = Prony::new(vec![g], vec![tau]).unwrap();
        let error = |h: f64| {
            let (mut y, mut step, mut strain) = ([0.0], PronyStep::default(), 0.0);
            prony.step_into(0.0, &mut step);
            let mut settle = |step: &PronyStep, strain: &mut f64| {
                let missing = 1.0 - step.stress(*strain, 0.0, &y);
                let increment = missing / step.tangent;
                *strain += increment;
                step.advance(increment, &mut y);
            };
            settle(&step, &mut strain);
            prony.step_into(h, &mut step);
            for _ in 0..(3.0 / h).round() as usize {
                settle(&step, &mut strain);
            }
            strain - (1.0 - g / (1.0 + g) * f64::exp(-3.0 / (tau * (1.0 + g))))
        };
        let (coarse, fine) = (error(0.1), error(0.05));
        assert!(fine.abs() < 1e-4, "{fine}");
        assert!((coarse / fine - 4.0).abs() < 0.2, "second order: {}", coarse / fine);
    }

    #[test]
    fn series_rejects_bad_terms() {
        assert_eq!(Prony::new(vec![0.1], vec![]).unwrap_err().place, "prony");
        assert_eq!(Prony::new(vec![-0.1], vec![1.0]).unwrap_err().place, "prony.weights[0]");
        assert_eq!(Prony::new(vec![0.1], vec![0.0]).unwrap_err().place, "prony.times[0]");
    }
}

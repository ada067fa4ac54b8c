//! The next equilibrium of the body: Newton's method with the exact residual, a line search, and substeps.
//!
//! A factor of the tangent serves over many steps: guides change between sticking and sliding far less often than the
//! body is balanced. The residual decides, so an old factor costs iterations and never accuracy.

use super::body::{FactorReuse, TendonBody};

/// Residual at which a state counts as balanced, as strain of one section [-].
const ACCURACY: f64 = 1e-9;
/// Residual that is still better than no step at all.
const LAST_RESORT: f64 = 1e-5;
/// A factor is used again while every iteration takes the residual below this part of itself.
const KEPT_BELOW: f64 = 0.2;
const MAX_ITERATIONS: usize = 40;
const MAX_HALVINGS: usize = 8;
/// Substeps of a step that fails, at most two to the power of this.
const MAX_SPLITS: u32 = 6;

/// Cost and outcome of a step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct StepReport {
    /// Residuals evaluated.
    pub(crate) evaluations: usize,
    /// Tangents factorised.
    pub(crate) factorisations: usize,
    /// Substeps in which no balance was found.
    pub(crate) failures: usize,
}

impl TendonBody {
    /// Takes the body to the strokes less slack `pulled` (n_tendons) [m] over `h` [s].
    ///
    /// A step that does not converge is divided; a part that never does leaves the best state found, and is counted.
    pub(crate) fn step(&mut self, pulled: &[f64], h: f64) -> StepReport {
        let mut report = StepReport::default();
        if !(pulled.iter().all(|pulled| pulled.is_finite()) && h >= 0.0) {
            return StepReport { failures: 1, ..report };
        }
        if self.newton(pulled, h, NewtonEffort::Full, &mut report) {
            self.commit(pulled, h);
            return report;
        }
        for splits in 1..=MAX_SPLITS {
            let n = 1usize << splits;
            let is_last = splits == MAX_SPLITS;
            if self.divided(pulled, h, n, is_last, &mut report) {
                break;
            }
        }
        report
    }

    /// The step in `n` parts; stops at the first failure unless it is the last try.
    fn divided(&mut self, pulled: &[f64], h: f64, n: usize, is_last: bool, report: &mut StepReport) -> bool {
        let saved = if is_last { None } else { Some(self.clone()) };
        let start = self.pulled.clone();
        let mut part = start.clone();
        for i in 1..=n {
            let share = i as f64 / n as f64;
            for k in 0..part.len() {
                part[k] = start[k] + share * (pulled[k] - start[k]);
            }
            let patience = if is_last { NewtonEffort::Last } else { NewtonEffort::Full };
            if self.newton(&part, h / n as f64, patience, report) {
                self.commit(&part, h / n as f64);
            } else if let Some(saved) = saved {
                *self = saved;
                return false;
            } else {
                // Stays where it is; the next part starts from here.
                report.failures += 1;
                self.restore();
            }
        }
        true
    }

    /// Newton's method; true where the trial state is balanced.
    fn newton(&mut self, pulled: &[f64], h: f64, patience: NewtonEffort, report: &mut StepReport) -> bool {
        if self.work.prony_step != h {
            self.spec.prony.step_into(h, &mut self.work.prony);
            self.work.prony_step = h;
        }
        let unit = self.stiffness.iter().flatten().copied().fold(f64::INFINITY, f64::min).sqrt();
        self.predict(h);
        let mut norm = self.evaluate(pulled);
        report.evaluations += 1;
        if !norm.is_finite() {
            self.restore();
            norm = self.evaluate(pulled);
        }
        for _ in 0..MAX_ITERATIONS {
            if norm <= ACCURACY * unit {
                return true;
            }
            let is_fresh = !self.work.has_factor;
            if is_fresh {
                self.assemble();
                report.factorisations += 1;
                self.work.has_factor = self.work.lu.factorize();
                if !self.work.has_factor {
                    break;
                }
            }
            self.work.direction.copy_from_slice(&self.work.residual);
            self.work.lu.solve(&mut self.work.direction);
            let most_halvings = if is_fresh { MAX_HALVINGS } else { 1 };
            let next = self.search(pulled, norm, most_halvings, report);
            // An old factor is kept while it serves, a new one only if it serves at once.
            self.work.has_factor = self.use_of_factor != FactorReuse::AlwaysNew
                && next.is_some_and(|next| next <= KEPT_BELOW * norm);
            match next {
                Some(next) => norm = next,
                None if is_fresh => break,
                None => {
                    // Back to where the old factor led astray.
                    self.work.trial_strains.copy_from_slice(&self.work.best_strains);
                    norm = self.evaluate(pulled);
                    report.evaluations += 1;
                }
            }
        }
        self.work.has_factor = false;
        patience == NewtonEffort::Last && norm <= LAST_RESORT * unit
    }

    /// Strains as the last step suggests.
    fn predict(&mut self, h: f64) {
        let ratio = if self.last_step > 0.0 { (h / self.last_step).min(2.0) } else { 0.0 };
        for (trial, (now, last)) in
            self.work.trial_strains.iter_mut().zip(self.strains.iter().zip(&self.last_strains))
        {
            for a in 0..4 {
                trial[a] = now[a] + ratio * (now[a] - last[a]);
            }
        }
    }

    /// Goes along the direction as far as the residual falls; its norm there, or `None` where it does not fall.
    fn search(
        &mut self,
        pulled: &[f64],
        norm: f64,
        most_halvings: usize,
        report: &mut StepReport,
    ) -> Option<f64> {
        self.work.best_strains.copy_from_slice(&self.work.trial_strains);
        let mut part = 1.0;
        // A section that turns or stretches too much at once leaves what the tangent knows.
        let largest = (0..self.work.direction.len())
            .map(|i| (self.work.direction[i] / self.stiffness[i / 4][i % 4].sqrt()).abs())
            .fold(0.0, f64::max);
        if largest > 0.3 {
            part = 0.3 / largest;
        }
        for _ in 0..most_halvings {
            for (s, strain) in self.work.trial_strains.iter_mut().enumerate() {
                for a in 0..4 {
                    let step = self.work.direction[4 * s + a] / self.stiffness[s][a].sqrt();
                    strain[a] = self.work.best_strains[s][a] - part * step;
                }
            }
            let next = self.evaluate(pulled);
            report.evaluations += 1;
            if next < norm * (1.0 - 1e-4 * part) {
                return Some(next);
            }
            part *= 0.5;
        }
        None
    }
}

/// Effort of Newton's method.
#[derive(Clone, Copy, PartialEq)]
enum NewtonEffort {
    Full,
    Last,
}

//! Load scale and friction of a servo from steady motion.

use hysteron_base::{BadInput, Bounds};
use hysteron_fit::{Fit, Options, Parameter, ParameterScale, TOLERANCE, least_squares};

use super::slack::find_slack;
use super::steady::SteadySamples;
use crate::identify::friction::{Neighbours, Regression, best_start};
use crate::law::{JointFriction, Law, Sliding};

/// Known parameters of a servo and its pulley.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PulleyServo {
    /// Torque of the stalled output at full load, by the data sheet [N m].
    pub stall_torque: f64,
    /// Radius at which the tendon lies on the pulley [m].
    pub radius: f64,
}

/// Fit result of a servo with its pulley, and the samples it comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct PulleyFit {
    /// Torque of a load of 1 [N m]; by the data sheet where no tensions were measured.
    pub load_scale: f64,
    /// Values of the law's parameters.
    pub parameters: Vec<f64>,
    /// Every estimate by name; standard errors include the model error of the law: `misfit`, and the change
    /// of an estimate, beyond noise, without the slowest samples.
    pub fit: Fit,
    /// By how much the law misses the mean of samples of like speed, in what their spread explains; standard errors have been
    /// multiplied by it where it is above 1 (Birge, 1932) [-].
    pub misfit: f64,
    /// Samples that it was found from.
    pub samples: SteadySamples,
    /// Torque of friction as measured, sample by sample: the load's less all other terms [N m].
    pub friction: Vec<f64>,
    /// Measured less predicted torque, sample by sample [N m].
    pub residuals: Vec<f64>,
}

/// Fewest samples of either direction.
const MIN_SAMPLES: usize = 200;
/// Largest factor between the load scale and the data sheet's.
const FACTOR: f64 = 20.0;
/// Longest that a load may lag by, either way [s].
const LAG: f64 = 0.3;
/// Loads above which they are no shares of the largest.
const LARGEST_LOAD: f64 = 1.5;
/// Groups of like speed in which the law is compared with the mean.
const GROUPS: usize = 16;
/// How much faster than the slowest samples are that a fit is repeated with.
const FASTER: f64 = 1.5;
/// Smallest range of speeds, over the slowest, that separates dry from viscous friction.
const RANGE: f64 = 1.5;

/// Names of the terms next to the law's parameters.
const LOAD_SCALE: &str = "load_scale_n_m";
const INERTIA: &str = "inertia_less_lag_kg_m2";
const DELAY: &str = "tension_lag_s";

/// Fits load scale and `law` to `samples`; where these have no tensions, to those of a slack tendon, with the load scale of the data
/// sheet.
///
/// # Errors
/// `BadInput` saying what to record: hardly any motion or hardly any slack tendon, one direction alone, one speed alone, loads that are no
/// shares of the largest; those of the fit.
pub fn identify_pulley(
    samples: &SteadySamples,
    law: &Law,
    servo: &PulleyServo,
) -> Result<PulleyFit, BadInput> {
    check_loads(&samples.load)?;
    check_motion(samples, "")?;
    let has_tension = !samples.tension.is_empty();
    let samples = if has_tension {
        check_tension(samples)?;
        samples.clone()
    } else {
        let slack = samples.slack(&find_slack(samples));
        check_motion(&slack, " on a slack tendon")?;
        slack
    };
    let problem = PulleyProblem { samples: &samples, law, servo, has_tension };
    let mut found = problem.fit()?;
    let faster = samples.selected(&faster(&samples.velocity));
    if check_motion(&faster, "").is_ok() {
        let other = PulleyProblem { samples: &faster, ..problem }.fit()?;
        found.add_change(&other.fit);
    }
    Ok(found)
}

/// True for speeds [`FASTER`] times the slowest or more.
fn faster(velocity: &[f64]) -> Vec<bool> {
    let slowest = velocity.iter().fold(f64::INFINITY, |least: f64, v| least.min(v.abs()));
    velocity.iter().map(|v| v.abs() > FASTER * slowest).collect()
}

impl PulleyFit {
    /// Adds to every variance the square of its estimate's change to that of `other`, found from a part of the data, less what noise
    /// alone causes, the difference of the variances.
    ///
    /// # Reference
    /// Hausman (1978), Specification tests in econometrics.
    fn add_change(&mut self, other: &Fit) {
        for (own, other) in self.fit.estimates.iter_mut().zip(&other.estimates) {
            if let (Some(a), Some(b)) = (own.standard_error, other.standard_error) {
                let noise = (b * b - a * a).max(0.0);
                let change = ((own.value - other.value).powi(2) - noise).max(0.0);
                own.standard_error = Some((a * a + change).sqrt());
            }
        }
    }
}

fn check_loads(load: &[f64]) -> Result<(), BadInput> {
    let largest = load.iter().fold(0.0, |most: f64, load| most.max(load.abs()));
    if largest > LARGEST_LOAD {
        let bad = BadInput::new("load", "shares of the largest, -1 to 1", format!("up to {largest:.4}"));
        return Err(bad.hint(if largest > 100.0 {
            "the register counts 0.1 %: divide by 1000"
        } else {
            "these look like percent: divide by 100"
        }));
    }
    Ok(())
}

fn check_motion(samples: &SteadySamples, where_: &str) -> Result<(), BadInput> {
    let [load, velocity] = [&samples.load, &samples.velocity];
    let one_way = |sign: f64| velocity.iter().filter(|v| sign * **v > 0.0).count();
    for (n, direction) in [(one_way(1.0), "pulling"), (one_way(-1.0), "releasing")] {
        if n < MIN_SAMPLES {
            let expected = format!("at least {MIN_SAMPLES} samples of steady motion, {direction}{where_}");
            return Err(BadInput::new("friction", expected, n.to_string())
                .hint("record a plan of some minutes in which every tendon is pulled and goes slack, such as `paper`"));
        }
    }
    if load.windows(2).all(|pair| pair[0] == pair[1]) {
        return Err(BadInput::new("load", "loads that change", format!("{} throughout", 0.0 + load[0]))
            .hint("does the rig read the register of the load?"));
    }
    let [slowest, fastest] =
        velocity.iter().fold([f64::INFINITY, 0.0], |[a, b]: [f64; 2], v| [a.min(v.abs()), b.max(v.abs())]);
    if fastest < RANGE * slowest {
        let expected = format!("speeds that differ by {RANGE} times{where_}");
        return Err(BadInput::new("friction", expected, format!("{slowest:.3} to {fastest:.3} rad/s"))
            .hint("record motion of several speeds: dry and viscous friction look alike at one"));
    }
    Ok(())
}

fn check_tension(samples: &SteadySamples) -> Result<(), BadInput> {
    let largest = samples.tension.iter().fold(0.0, |most: f64, [tension, _]| most.max(*tension));
    let least = samples.tension.iter().fold(f64::INFINITY, |least: f64, [tension, _]| least.min(*tension));
    if largest <= least {
        return Err(BadInput::new("tension", "tensions that change", format!("{least} N throughout"))
            .hint("different tensions determine the scale of the load; remove the columns to identify friction alone"));
    }
    Ok(())
}

#[derive(Clone, Copy)]
struct PulleyProblem<'a> {
    samples: &'a SteadySamples,
    law: &'a Law,
    servo: &'a PulleyServo,
    has_tension: bool,
}

impl PulleyProblem<'_> {
    fn fit(&self) -> Result<PulleyFit, BadInput> {
        let torque: Vec<f64> = self.samples.load.iter().map(|load| self.servo.stall_torque * load).collect();
        // Bounds of the law's parameters, and its offset, are relative to friction alone.
        let slack = match self.has_tension {
            true => torque
                .iter()
                .zip(&self.samples.tension)
                .map(|(t, [n, _])| t - self.servo.radius * n)
                .collect(),
            false => torque,
        };
        let bounds = Regression::new(self.law, [&self.samples.velocity, &slack], Neighbours::ErrAlike)?;
        let residuals = |values: &[f64]| Ok::<_, BadInput>(self.series(&self.errors(values)));
        let largest = slack.iter().fold(0.0, |most: f64, t| most.max(t.abs()));
        let options = Options {
            huber: None,
            smallest_effect: 1e-5 * largest / self.servo.stall_torque,
            n_nuisance: 0,
            tolerance: TOLERANCE,
            watch: &|_, _| true,
        };
        let started = best_start(|place| self.parameters(&bounds, place, largest), &options, residuals)?;
        let mut fit = least_squares(&started, &options, residuals)?;
        let values = fit.values();
        let scale = self.load_scale(&values);
        let residuals: Vec<f64> = self.errors(&values).iter().map(|error| -scale * error).collect();
        let misfit = self.misfit(&residuals, fit.n_effective);
        for estimate in &mut fit.estimates {
            estimate.standard_error = estimate.standard_error.map(|error| error * misfit.max(1.0));
        }
        let parameters = values[..self.law.parameters().len()].to_vec();
        let law = |v: f64| self.law.torque(&parameters, &Sliding::at(v));
        let friction = self.samples.velocity.iter().zip(&residuals).map(|(v, left)| law(*v) + left).collect();
        let samples = self.samples.clone();
        Ok(PulleyFit { load_scale: scale, parameters, fit, misfit, samples, friction, residuals })
    }

    /// Those of the law, its offset if it has none of its own, and the other terms.
    fn parameters(&self, bounds: &Regression, place: f64, largest: f64) -> Vec<Parameter> {
        let mut parameters = bounds.parameters(place);
        let even = |name: &str, most: f64| Parameter {
            name: name.into(),
            start: 0.0,
            bounds: Bounds { min: -most, max: most },
            scale: ParameterScale::Linear,
            prior: None,
        };
        let hardest = self.samples.acceleration.iter().fold(1e-3, |most: f64, a| most.max(a.abs()));
        parameters.push(even(INERTIA, largest / hardest));
        if self.has_tension {
            parameters.push(even(DELAY, LAG));
            let start = self.servo.stall_torque;
            parameters.push(Parameter {
                name: LOAD_SCALE.into(),
                start,
                bounds: Bounds { min: start / FACTOR, max: start * FACTOR },
                scale: ParameterScale::Logarithmic,
                prior: None,
            });
        }
        parameters
    }

    fn load_scale(&self, values: &[f64]) -> f64 {
        match values.last() {
            Some(scale) if self.has_tension => *scale,
            _ => self.servo.stall_torque,
        }
    }

    /// Predicted less measured load, sample by sample [-].
    fn errors(&self, values: &[f64]) -> Vec<f64> {
        let (p, rest) = values.split_at(self.law.parameters().len());
        let n_others = if self.has_tension { 3 } else { 1 };
        let (offset, others) = rest.split_at(rest.len() - n_others);
        let offset = offset.first().unwrap_or(&0.0);
        let scale = self.load_scale(values);
        let at = |i: usize| {
            let SteadySamples { velocity, acceleration, load, tension, .. } = self.samples;
            let pull = tension
                .get(i)
                .map_or(0.0, |[tension, rate]| self.servo.radius * (tension + others[1] * rate));
            let torque =
                self.law.torque(p, &Sliding::at(velocity[i])) + pull + others[0] * acceleration[i] + offset;
            torque / scale - load[i]
        };
        (0..self.samples.len()).map(at).collect()
    }

    fn series(&self, errors: &[f64]) -> Vec<Vec<f64>> {
        let series = self.samples.series.iter().filter(|series| !series.is_empty());
        series.map(|series| errors[series.clone()].to_vec()).collect()
    }

    /// Means of the residuals in groups of like speed, over what a mean of so many independent residuals may have.
    fn misfit(&self, residuals: &[f64], n_effective: f64) -> f64 {
        let n = residuals.len();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|a, b| self.samples.velocity[*a].total_cmp(&self.samples.velocity[*b]));
        let variance = residuals.iter().map(|r| r * r).sum::<f64>() / n as f64;
        let groups = (0..GROUPS).map(|g| &order[g * n / GROUPS..(g + 1) * n / GROUPS]);
        let square = |group: &[usize]| {
            let mean = group.iter().map(|i| residuals[*i]).sum::<f64>() / group.len() as f64;
            let independent = group.len() as f64 * n_effective / n as f64;
            mean * mean * independent / variance
        };
        let free = GROUPS.saturating_sub(self.law.parameters().len() + 1).max(1);
        (groups.map(square).sum::<f64>() / free as f64).sqrt()
    }
}

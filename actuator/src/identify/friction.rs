//! A law of friction from speeds and torques, by regression.

use hysteron_base::{BadInput, Bounds};
use hysteron_fit::{Fit, Options, Parameter, ParameterScale, least_squares, minimum};

use crate::law::{JointFriction, Law, LawParameter, ScalesWith, Sliding};

/// A law with its parameters and the offset of the torque.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionFit {
    /// Values of the law's parameters.
    pub parameters: Vec<f64>,
    /// Offset of the torque beyond friction [N m].
    pub offset: f64,
    /// Fit result of each; the offset comes last, if the law leaves room for one.
    pub fit: Fit,
}

/// Where a search starts between the bounds: of torques, and of speeds, of which every one is tried.
const TORQUE_START: f64 = 0.15;
const STARTS: [f64; 4] = [0.3, 0.5, 0.7, 0.85];

/// Fits `law`, and an offset where the law has none of its own, to `torque` [N m] at `velocity` [rad/s] (n_samples each); residuals above `huber` [N m]
/// count linearly, where given.
///
/// # Errors
/// `BadInput` for series of different lengths, a speed or torque that never changes, numbers that are not finite; those of the fit.
pub fn identify_friction(
    law: &Law,
    velocity: &[f64],
    torque: &[f64],
    huber: Option<f64>,
) -> Result<FrictionFit, BadInput> {
    let problem = Regression::new(law, [velocity, torque], Neighbours::ErrAlike)?;
    problem.least_squares(huber, &|_, _| true)
}

/// How independent the errors of samples that follow each other are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Neighbours {
    /// As those of a recording.
    ErrAlike,
    /// As those of a curve without noise, where they cannot be estimated.
    AreIndependent,
}

/// Torques that a law is to give at speeds.
pub(super) struct Regression<'a> {
    pub law: &'a Law,
    pub velocity: &'a [f64],
    pub torque: &'a [f64],
    neighbours: Neighbours,
    /// Largest torque [N m] and speed [rad/s]: what bounds are relative to.
    largest: f64,
    fastest: f64,
}

impl<'a> Regression<'a> {
    /// See [`identify_friction`].
    pub fn new(
        law: &'a Law,
        [velocity, torque]: [&'a [f64]; 2],
        neighbours: Neighbours,
    ) -> Result<Self, BadInput> {
        for (name, series) in [("speed", velocity), ("torque", torque)] {
            check(name, series, velocity.len())?;
        }
        let size = |series: &[f64]| series.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let (largest, fastest) = (size(torque), size(velocity));
        Ok(Self { law, velocity, torque, neighbours, largest, fastest })
    }

    /// The law's parameters, and the offset unless each direction's own Coulomb friction holds it already; speeds start at
    /// `place` of their bounds.
    pub fn parameters(&self, place: f64) -> Vec<Parameter> {
        let of = |p: LawParameter| {
            let (factor, scale) = match p.scales_with {
                ScalesWith::Torque => (self.largest, ParameterScale::Linear),
                ScalesWith::Speed => (self.fastest, ParameterScale::Logarithmic),
                ScalesWith::TorquePerSpeed => (self.largest / self.fastest, ParameterScale::Linear),
                ScalesWith::Nothing => (1.0, ParameterScale::Linear),
            };
            let bounds = Bounds { min: factor * p.bounds[0], max: factor * p.bounds[1] };
            let start = match scale {
                ParameterScale::Linear => bounds.min + TORQUE_START * (bounds.max - bounds.min),
                ParameterScale::Logarithmic => bounds.min * (bounds.max / bounds.min).powf(place),
            };
            Parameter { name: p.name.into_owned(), start, bounds, scale, prior: None }
        };
        let has_offset = !matches!(self.law, Law::DirectedStribeck(_) | Law::PiecewiseLinear(_));
        let bounds = Bounds { min: -self.largest, max: self.largest };
        let offset = Parameter {
            name: "offset_n_m".into(),
            start: 0.0,
            bounds,
            scale: ParameterScale::Linear,
            prior: None,
        };
        self.law.parameters().into_iter().map(of).chain(has_offset.then_some(offset)).collect()
    }

    /// Parameters of the law, and the offset.
    pub fn split(&self, mut values: Vec<f64>) -> (Vec<f64>, f64) {
        let offset = values.split_off(self.law.parameters().len()).first().copied().unwrap_or_default();
        (values, offset)
    }

    /// Torque of law and offset less the measured one, sample by sample [N m].
    pub fn errors(&self, values: &[f64]) -> Vec<f64> {
        let (p, offset) = values.split_at(self.law.parameters().len());
        let offset = offset.first().unwrap_or(&0.0);
        let left = |i: usize| self.law.torque(p, &Sliding::at(self.velocity[i])) + offset - self.torque[i];
        (0..self.velocity.len()).map(left).collect()
    }

    /// The fit, from the best of several starts; `watch` is called with evaluations and error.
    pub fn least_squares(
        &self,
        huber: Option<f64>,
        watch: &(dyn Fn(usize, f64) -> bool + Sync),
    ) -> Result<FrictionFit, BadInput> {
        let options = Options {
            huber,
            smallest_effect: 1e-5 * self.largest,
            n_nuisance: 0,
            tolerance: hysteron_fit::TOLERANCE,
            watch,
        };
        let residuals = |values: &[f64]| {
            let errors = self.errors(values);
            Ok::<_, BadInput>(match self.neighbours {
                Neighbours::ErrAlike => vec![errors],
                Neighbours::AreIndependent => errors.into_iter().map(|error| vec![error]).collect(),
            })
        };
        let started = best_start(|place| self.parameters(place), &options, residuals)?;
        let fit = least_squares(&started, &options, residuals)?;
        let (parameters, offset) = self.split(fit.values());
        Ok(FrictionFit { parameters, offset, fit })
    }
}

/// Parameters that start where a quick search from one of several places ends best; `parameters` has them for each place.
pub(super) fn best_start<F>(
    parameters: impl Fn(f64) -> Vec<Parameter>,
    options: &Options,
    residuals: F,
) -> Result<Vec<Parameter>, BadInput>
where
    F: Fn(&[f64]) -> Result<Vec<Vec<f64>>, BadInput> + Sync,
{
    let mut best = (parameters(STARTS[0]), f64::INFINITY);
    for place in STARTS {
        let mut started = parameters(place);
        let (values, cost) = minimum(&started, options, &residuals)?;
        if cost < best.1 {
            started.iter_mut().zip(values).for_each(|(parameter, value)| parameter.start = value);
            best = (started, cost);
        }
    }
    Ok(best.0)
}

fn check(name: &str, series: &[f64], n: usize) -> Result<(), BadInput> {
    if series.len() != n {
        return Err(BadInput::new(name, format!("{n} samples"), series.len().to_string()));
    }
    if let Some(k) = series.iter().position(|x| !x.is_finite()) {
        return Err(BadInput::new(
            format!("{name}, sample {}", k + 1),
            "a finite number",
            series[k].to_string(),
        ));
    }
    if series.windows(2).all(|pair| pair[0] == pair[1]) {
        let found = series.first().map_or_else(|| "no sample".to_owned(), |x| format!("{x} throughout"));
        return Err(BadInput::new(name, "a channel that changes", found)
            .hint("record steady motions at ten or more speeds, in both directions"));
    }
    Ok(())
}

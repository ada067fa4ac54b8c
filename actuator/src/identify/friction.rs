//! A law of friction from speeds and torques, by regression.

use hysteron_base::{BadInput, Bounds};
use hysteron_fit::{Fit, Options, Parameter, Scale, least_squares, minimum};

use crate::law::{JointFriction, Law, ScalesWith, Sliding};

/// A law with its parameters and the offset of the torque.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionFit {
    /// Values of the law's parameters.
    pub parameters: Vec<f64>,
    /// What the torque reads beyond friction [N m].
    pub offset: f64,
    /// What the data says of each; the offset comes last, if the law leaves room for one.
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
    for (name, series) in [("speed", velocity), ("torque", torque)] {
        if series.len() != velocity.len() {
            return Err(BadInput::new(name, format!("{} samples", velocity.len()), series.len().to_string()));
        }
        if let Some(k) = series.iter().position(|x| !x.is_finite()) {
            let place = format!("{name}, sample {}", k + 1);
            return Err(BadInput::new(place, "a finite number", series[k].to_string()));
        }
        if series.windows(2).all(|pair| pair[0] == pair[1]) {
            return Err(BadInput::new(
                name,
                "a channel that changes",
                format!("{:?} throughout", series.first()),
            )
            .hint("record steady motions at ten or more speeds, in both directions"));
        }
    }
    let size = |series: &[f64]| series.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let (largest, fastest) = (size(torque), size(velocity));
    // A law with each direction's own Coulomb friction holds any offset already.
    let has_offset = !matches!(law, Law::DirectedStribeck(_) | Law::PiecewiseLinear(_));
    let parameters = |place: f64| -> Vec<Parameter> {
        let of = |p: crate::law::LawParameter| {
            let (factor, scale) = match p.scales_with {
                ScalesWith::Torque => (largest, Scale::Linear),
                ScalesWith::Speed => (fastest, Scale::Logarithmic),
                ScalesWith::Nothing => (1.0, Scale::Linear),
            };
            let bounds = Bounds { min: factor * p.bounds[0], max: factor * p.bounds[1] };
            let start = match scale {
                Scale::Linear => bounds.min + TORQUE_START * (bounds.max - bounds.min),
                Scale::Logarithmic => bounds.min * (bounds.max / bounds.min).powf(place),
            };
            Parameter { name: p.name.into_owned(), start, bounds, scale, prior: None }
        };
        let bounds = Bounds { min: -largest, max: largest };
        let offset =
            Parameter { name: "offset_n_m".into(), start: 0.0, bounds, scale: Scale::Linear, prior: None };
        law.parameters().into_iter().map(of).chain(has_offset.then_some(offset)).collect()
    };
    let n = law.parameters().len();
    let residuals = |values: &[f64]| {
        let (p, offset) = values.split_at(n);
        let offset = offset.first().unwrap_or(&0.0);
        let left = |(v, t): (&f64, &f64)| law.torque(p, &Sliding::at(*v)) + offset - t;
        Ok::<_, BadInput>(vec![velocity.iter().zip(torque).map(left).collect::<Vec<f64>>()])
    };
    let options = Options {
        huber,
        smallest_effect: 1e-5 * largest,
        n_nuisance: 0,
        tolerance: hysteron_fit::TOLERANCE,
        watch: &|_, _| true,
    };
    let mut best = (parameters(STARTS[0]), f64::INFINITY);
    for place in STARTS {
        let mut started = parameters(place);
        let (values, cost) = minimum(&started, &options, residuals)?;
        if cost < best.1 {
            started.iter_mut().zip(values).for_each(|(parameter, value)| parameter.start = value);
            best = (started, cost);
        }
    }
    let fit = least_squares(&best.0, &options, residuals)?;
    let mut parameters = fit.values();
    let offset = parameters.split_off(n).first().copied().unwrap_or_default();
    Ok(FrictionFit { parameters, offset, fit })
}

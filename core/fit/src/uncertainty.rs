//! Uncertainty of a fit: standard errors, correlation, and the parameters that the data does not determine.
//!
//! Everything is computed in places between the bounds, 0 to 1, where parameters of different units compare. A
//! direction in them is undetermined if moving along it from bound to bound does not move the residuals. A parameter is
//! vague if its standard error is more than half of its prior's standard deviation, or of that of a number
//! drawn evenly between the bounds; the search decides whether it is then fixed, for it knows what the return
//! costs.

use nalgebra::DMatrix;

use crate::parameter::Parameter;

/// Identifiability of a parameter after a fit.
#[derive(Debug, Clone, PartialEq)]
pub enum Identifiability {
    /// Fitted.
    Fitted,
    /// On one of its bounds.
    AtBound,
    /// Its standard error is large, but its start fits worse than noise allows.
    Vague,
    /// Held at its start, which fits as well: the data does not determine it, or only together with the parameters named
    /// here.
    Undetermined(Vec<String>),
}

/// A parameter after a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedParameter {
    /// Name of the parameter.
    pub name: String,
    /// Where the search began [SI].
    pub start: f64,
    /// Where it ended [SI].
    pub value: f64,
    /// Standard error [SI], for a fitted or a vague one.
    pub standard_error: Option<f64>,
    /// Its identifiability.
    pub identifiability: Identifiability,
}

/// Standard deviation of a number drawn evenly from 0 to 1.
const UNIFORM_DEVIATION: f64 = 0.2887;
/// Share of the prior's standard deviation below which the data must bring the standard error [-].
const INFORMATIVE_SHARE: f64 = 0.5;
/// Share of a direction, or correlation, from which on a parameter is named with another.
const NAMED: f64 = 0.3;
const CORRELATED: f64 = 0.9;

/// Variance of the residuals.
pub struct ResidualVariance {
    /// Residual variance, already larger by how much neighbours repeat each other.
    pub variance: f64,
    /// How many independent residuals there are.
    pub n_effective: f64,
}

impl ResidualVariance {
    /// Of residuals after a fit of `n_parameters`. Each series counts as its length over its correlation time
    /// 1 + 2 Σ ρ_k, summed until the correlation ρ_k first falls to zero. One of zeros alone, as of limits that are kept,
    /// carries no information on the spread.
    pub fn new(series: &[Vec<f64>], n_parameters: usize) -> Self {
        let series = || series.iter().filter(|series| series.iter().any(|r| *r != 0.0));
        let n: usize = series().map(Vec::len).sum();
        let squares: f64 = series().flatten().map(|r| r * r).sum();
        let n_effective: f64 = series().map(|r| r.len() as f64 / correlation_time(r)).sum();
        let white = squares / n.saturating_sub(n_parameters).max(1) as f64;
        Self { variance: white * n as f64 / n_effective.max(1.0), n_effective }
    }
}

fn correlation_time(series: &[f64]) -> f64 {
    let product = |lag: usize| series.iter().zip(&series[lag..]).map(|(a, b)| a * b).sum::<f64>();
    let square = product(0);
    let mut time = 1.0;
    for lag in 1..series.len() / 2 {
        let correlation = product(lag) / square;
        if correlation.is_nan() || correlation <= 0.0 {
            break;
        }
        time += 2.0 * correlation;
    }
    time
}

/// Those of `free` that are off their bounds. On a bound are exactly the places 0 and 1: a search that comes near one
/// settles which (`Problem::pinned`).
pub fn inside(free: &[usize], places: &[f64]) -> Vec<usize> {
    free.iter().copied().filter(|&k| places[k] > 0.0 && places[k] < 1.0).collect()
}

/// Finds the parameter with the largest share of a direction which moves the residuals by less than `smallest` (root mean
/// square) from bound to bound: its position in `free`, and the parameters that share the direction.
pub fn unidentifiable(free: &[usize], columns: &[Vec<f64>], smallest: f64) -> Option<(usize, Vec<usize>)> {
    let (singular, direction) = weakest(columns)?;
    let effect = singular / (columns[0].len() as f64).sqrt();
    (effect < smallest).then(|| most_of(&direction, free))
}

/// The covariance of places that residuals with these columns and this variance leave, prior rows included: (JᵀJ)⁻¹ σ² =
/// R⁻¹ R⁻ᵀ σ². `None` where a direction is not determined at all.
pub fn covariance(columns: &[Vec<f64>], variance: f64) -> Option<DMatrix<f64>> {
    let inverse = triangle(columns)?.try_inverse()?;
    Some(&inverse * inverse.transpose() * variance)
}

/// The change of places that makes residuals with these columns least: -J⁺ r. `None` where a direction is not determined.
pub fn correction(columns: &[Vec<f64>], residuals: &[f64]) -> Option<Vec<f64>> {
    let n = columns.first()?.len();
    let matrix = DMatrix::from_iterator(n, columns.len(), columns.iter().flatten().copied());
    let qr = matrix.qr();
    let right = qr.q().transpose() * nalgebra::DVector::from_column_slice(residuals);
    let change = qr.r().solve_upper_triangular(&right)?;
    change.iter().all(|c| c.is_finite()).then(|| change.iter().map(|c| -c).collect())
}

/// Finds the vaguest of `free`, without those in `retained`: its position, and the parameters that it can hardly
/// be distinguished from.
pub fn vague(
    parameters: &[Parameter],
    free: &[usize],
    covariance: &DMatrix<f64>,
    retained: &[usize],
) -> Option<(usize, Vec<usize>)> {
    let vagueness = |a: usize| {
        let prior = parameters[free[a]]
            .prior_width()
            .map_or(UNIFORM_DEVIATION, |width| UNIFORM_DEVIATION.min(INFORMATIVE_SHARE * width));
        covariance[(a, a)].sqrt() / prior
    };
    let candidates = (0..free.len()).filter(|&a| !retained.contains(&free[a]));
    let at =
        candidates.max_by(|&a, &b| vagueness(a).total_cmp(&vagueness(b))).filter(|&a| vagueness(a) > 1.0)?;
    let correlation = |b: usize| covariance[(at, b)] / (covariance[(at, at)] * covariance[(b, b)]).sqrt();
    let with = (0..free.len()).filter(|&b| b != at && correlation(b).abs() > CORRELATED);
    Some((at, with.map(|b| free[b]).collect()))
}

/// Condition number of the matrix of these columns, each scaled to length one; one without columns.
pub fn condition(columns: &[Vec<f64>]) -> f64 {
    let scaled = |column: &Vec<f64>| {
        let length = column.iter().map(|value| value * value).sum::<f64>().sqrt();
        column.iter().map(|value| value / length.max(f64::MIN_POSITIVE)).collect()
    };
    let scaled: Vec<Vec<f64>> = columns.iter().map(scaled).collect();
    let Some(triangle) = triangle(&scaled) else { return 1.0 };
    let singular = triangle.singular_values();
    singular.max() / singular.min()
}

/// Least singular value of the matrix of these columns, with its direction.
fn weakest(columns: &[Vec<f64>]) -> Option<(f64, Vec<f64>)> {
    let svd = triangle(columns)?.svd(false, true);
    let least = svd.singular_values.imin();
    let direction = svd.v_t?.row(least).iter().copied().collect();
    Some((svd.singular_values[least], direction))
}

/// R of the QR factorisation: as good as the whole Jacobian, and small.
fn triangle(columns: &[Vec<f64>]) -> Option<DMatrix<f64>> {
    let n = columns.first()?.len();
    Some(DMatrix::from_iterator(n, columns.len(), columns.iter().flatten().copied()).qr().r())
}

fn most_of(direction: &[f64], free: &[usize]) -> (usize, Vec<usize>) {
    let largest = (0..direction.len()).max_by(|&a, &b| direction[a].abs().total_cmp(&direction[b].abs()));
    let at = largest.unwrap_or(0);
    let shares = |&k: &usize| k != at && direction[k].abs() > NAMED;
    (at, (0..direction.len()).filter(shares).map(|k| free[k]).collect())
}

/// Estimates and correlation. `fitted` are the parameters off their bounds with the covariance of their
/// places, `retained` the vague ones among them, `fixed` the undetermined ones with those that they cannot be
/// distinguished from; others are on a bound.
pub fn estimates(
    parameters: &[Parameter],
    places: &[f64],
    (fitted, covariance): (&[usize], Option<&DMatrix<f64>>),
    retained: &[usize],
    fixed: &[(usize, Vec<usize>)],
) -> (Vec<IdentifiedParameter>, Vec<Vec<f64>>) {
    let position = |k: usize| fitted.iter().position(|&f| f == k);
    let entry = |a: usize, b: usize| Some(covariance?[(position(a)?, position(b)?)]);
    let estimate = |(k, parameter): (usize, &Parameter)| {
        let is_fixed = fixed.iter().find(|(h, _)| *h == k);
        let value = if is_fixed.is_some() { parameter.home() } else { parameter.value(places[k]) };
        IdentifiedParameter {
            name: parameter.name.clone(),
            start: parameter.home(),
            value,
            standard_error: entry(k, k).map(|variance| variance.sqrt() * parameter.slope(value)),
            identifiability: match (is_fixed, position(k)) {
                (Some((_, with)), _) => {
                    Identifiability::Undetermined(with.iter().map(|&w| parameters[w].name.clone()).collect())
                }
                (None, Some(_)) if retained.contains(&k) => Identifiability::Vague,
                (None, Some(_)) => Identifiability::Fitted,
                (None, None) => Identifiability::AtBound,
            },
        }
    };
    let n = parameters.len();
    let correlation = |a: usize, b: usize| {
        let scale = (entry(a, a)? * entry(b, b)?).sqrt();
        Some(entry(a, b)? / scale)
    };
    let row = |a: usize| (0..n).map(|b| correlation(a, b).unwrap_or(0.0)).collect();
    (parameters.iter().enumerate().map(estimate).collect(), (0..n).map(row).collect())
}

#[cfg(test)]
mod tests {
    use crate::condition;

    #[test]
    fn condition_is_that_of_the_angle_between_columns() {
        // Two directions at angle φ, of any length: √((1 + |cos φ|) / (1 - |cos φ|)).
        let angle: f64 = 0.3;
        let columns = [vec![2.0, 0.0, 0.0], vec![0.0, 5.0 * angle.sin(), -5.0 * angle.cos()]];
        assert!((condition(&columns) - 1.0).abs() < 1e-12);
        let columns = [vec![0.0, 0.0, 2.0], columns[1].clone()];
        let expected = ((1.0 + angle.cos()) / (1.0 - angle.cos())).sqrt();
        assert!((condition(&columns) - expected).abs() < 1e-9, "{} {expected}", condition(&columns));
    }
}

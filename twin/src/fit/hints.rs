//! Other explanations of the errors that a fit leaves: assumptions that were not fitted, tried one by one.
//!
//! Each is tried at the minimum that was found. The fitted parameters may follow it to first order: the least
//! squares of r + J δ, with the priors of the parameters as rows of their own.

use hysteron_base::{Friction, Scene};
use hysteron_fit::{
    Fit, FitProblem, Identifiability, Options, Parameter, ResidualVariance, TOLERANCE, correction, prior_rows,
};

use super::comparison::MotionComparison;
use super::quantity::{FitParameter, QUANTITIES, SceneQuantity, Selected, along_axes, select, stem};
use crate::Result;

/// An assumption that would explain errors.
#[derive(Debug, Clone, PartialEq)]
pub struct Hint {
    /// The assumption to make instead, in words.
    pub instead: String,
    /// Parameter to fit for that, as on the command line; empty where the scene has to be changed.
    pub fit: String,
    /// Root mean square of the residuals as fitted, and as it would be [m].
    pub rms: [f64; 2],
}

/// Part of the residuals that is worth a hint [-].
const WORTH: f64 = 0.05;
/// Variances that the gain must be worth: 95 % of all noise stays below.
const NOISE: f64 = 4.0;
/// Friction that a scene without any is tried with.
const RUBBING: Friction = Friction {
    points: 4,
    coefficient: 0.2,
    coulomb: 0.0,
    sheath_exponent: 0.0,
    sheath_coulomb: 0.0,
    sheath_compliance_share: 0.0,
    backlash: 0.0,
};

/// A minimum, linearised.
struct Minimum<'a> {
    on: &'a MotionComparison<'a>,
    scene: &'a Scene,
    series: Vec<Vec<f64>>,
    /// Derivatives by the places of the fitted parameters, with the rows of the priors.
    columns: Vec<Vec<f64>>,
    noise: f64,
    /// How many independent residuals there are.
    n_effective: f64,
}

/// Hints for the `scene` that `fit` has led to, the best first. An alternative that cannot be tried is none.
///
/// # Errors
/// Those of the residuals at the minimum.
pub(super) fn hints(
    on: &MotionComparison,
    scene: &Scene,
    selected: &[Selected],
    fit: &Fit,
) -> Result<Vec<Hint>> {
    let minimum = Minimum::new(on, scene, selected, fit)?;
    let mut hints = Vec::new();
    let is_selected = |name: &str| selected.iter().any(|s| s.quantity.name.starts_with(name));
    if !is_selected("gravity") {
        for (gravity, now) in minimum.other_gravities() {
            let direction = gravity.map(|c| format!("{c:.2}")).join(", ");
            hints.extend(minimum.hint(format!("gravity along ({direction}) m/s²"), "gravity", now));
        }
    }
    let is_free = |quantity: &&SceneQuantity| {
        let is_taken = selected.iter().any(|s| stem(s.quantity) == stem(quantity));
        // The parts of the tracker's frame are tried together.
        let is_part = ["common_", "gravity", "tracker"].iter().any(|part| quantity.name.starts_with(part));
        !is_taken && !is_part
    };
    let names = QUANTITIES.iter().filter(is_free).map(|quantity| quantity.name);
    for name in names.chain((!is_selected("tracker")).then_some("tracker")) {
        // What the scene lacks, or has beyond the bounds, is no alternative.
        let Ok(more) = select(scene, &[FitParameter::named(name)]) else { continue };
        let Ok((now, what)) = minimum.with(&more) else { continue };
        hints.extend(minimum.hint(what, name, now));
    }
    if scene.friction.is_none()
        && let Some(now) = minimum.instead(&Scene { friction: Some(RUBBING), ..scene.clone() })
    {
        let what =
            format!("[friction] with points = {} and coefficient = {}", RUBBING.points, RUBBING.coefficient);
        hints.extend(minimum.hint(what, "", now));
    }
    hints.sort_by(|a, b| a.rms[1].total_cmp(&b.rms[1]));
    Ok(hints)
}

/// The axis of the scene along which gravity would leave the least errors, if that is not where it is now.
///
/// # Errors
/// Those of [`hints`].
pub(super) fn steepest(
    on: &MotionComparison,
    scene: &Scene,
    selected: &[Selected],
    fit: &Fit,
) -> Result<Option<[f64; 3]>> {
    let minimum = Minimum::new(on, scene, selected, fit)?;
    let others = minimum.other_gravities();
    let best = others.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
    Ok(best.filter(|(_, cost)| minimum.gain(*cost) > NOISE).map(|(gravity, _)| gravity))
}

impl<'a> Minimum<'a> {
    fn new(
        on: &'a MotionComparison<'a>,
        scene: &'a Scene,
        selected: &'a [Selected],
        fit: &Fit,
    ) -> Result<Self> {
        // Those that lean against gravity go with it.
        let is_free = |(s, identifiability): (&Selected, &Identifiability)| {
            matches!(identifiability, Identifiability::Fitted | Identifiability::Vague)
                && s.quantity.name != "gravity"
        };
        let identifiabilities = fit.estimates.iter().map(|estimate| &estimate.identifiability);
        let free: Vec<Selected> = selected
            .iter()
            .zip(identifiabilities)
            .filter(|pair| is_free(*pair))
            .map(|pair| pair.0.clone())
            .collect();
        let series = on.residuals(scene)?;
        let spread = ResidualVariance::new(&series, free.len());
        let (noise, n_effective) = (spread.variance.sqrt(), spread.n_effective);
        let mut minimum = Self { on, scene, series, columns: Vec::new(), noise, n_effective };
        minimum.columns = minimum.derivatives(&free)?.0;
        Ok(minimum)
    }

    /// Derivatives by the places of these quantities, with the rows of the priors, and the residuals of these
    /// now.
    fn derivatives(&self, of: &[Selected]) -> Result<(Vec<Vec<f64>>, Vec<f64>)> {
        let at = |s: &Selected| Parameter {
            start: s.parameter.bounds.clamp(s.value_of(self.scene).unwrap_or(s.parameter.start)),
            ..s.parameter.clone()
        };
        let parameters: Vec<Parameter> = of.iter().map(at).collect();
        let residuals = |values: &[f64]| {
            let mut scene = self.scene.clone();
            for (s, value) in of.iter().zip(values) {
                (s.quantity.set)(&mut scene, s.component, *value);
            }
            self.on.residuals(&scene)
        };
        let options = Options {
            huber: None,
            smallest_effect: 0.0,
            n_nuisance: 0,
            tolerance: TOLERANCE,
            watch: &|_, _| true,
        };
        let (problem, first) = FitProblem::new(&parameters, &options, &residuals)?;
        let places: Vec<f64> = parameters.iter().map(|p| p.place(p.start)).collect();
        let all: Vec<usize> = (0..parameters.len()).collect();
        let columns = problem.columns(&places, &all, &first)?;
        let off = parameters
            .iter()
            .zip(&places)
            .filter_map(|(p, place)| Some(self.noise * (place - p.place(p.home())) / p.prior_width()?));
        Ok((prior_rows(&parameters, &all, &columns, self.noise), off.collect()))
    }

    /// Sum of squares of `series` after what was fitted has followed.
    fn followed(&self, series: &[Vec<f64>]) -> f64 {
        let n = self.columns.first().map_or(0, Vec::len);
        let mut residuals = series.concat();
        // The priors of the fitted ones are counted from where they are: the minimum balances both.
        let data = residuals.len();
        residuals.resize(n.max(data), 0.0);
        if let Some(change) = correction(&self.columns, &residuals) {
            for (column, change) in self.columns.iter().zip(change) {
                residuals.iter_mut().zip(column).for_each(|(r, c)| *r += change * c);
            }
        }
        residuals.iter().map(|r| r * r).sum()
    }

    /// The same with another scene; none where that cannot be.
    fn instead(&self, scene: &Scene) -> Option<f64> {
        self.on.residuals(scene).ok().map(|series| self.followed(&series))
    }

    /// The same with more quantities free, to first order, and how they would change.
    fn with(&self, more: &[Selected]) -> Result<(f64, String)> {
        let (columns, off) = self.derivatives(more)?;
        let (n_before, n_more) = (self.columns.len(), columns.len());
        let n_data: usize = self.series.iter().map(Vec::len).sum();
        // Rows: data, priors of the fitted ones, then of these.
        let zeros = |n: usize| std::iter::repeat_n(0.0, n);
        let rows_before = self.columns.first().map_or(0, |column| column.len() - n_data);
        let mut all: Vec<Vec<f64>> =
            self.columns.iter().map(|c| c.iter().copied().chain(zeros(off.len())).collect()).collect();
        all.extend(columns.iter().map(|c| {
            let (data, prior_rows) = c.split_at(n_data);
            data.iter()
                .copied()
                .chain(zeros(rows_before))
                .chain(prior_rows.iter().copied())
                .collect::<Vec<f64>>()
        }));
        let mut residuals = self.series.concat();
        residuals.extend(zeros(rows_before));
        residuals.extend(off);
        let Some(mut change) = correction(&all, &residuals) else {
            return Ok((f64::INFINITY, String::new()));
        };
        let mut words = Vec::new();
        for (s, change) in more.iter().zip(&mut change[n_before..n_before + n_more]) {
            let now = s.parameter.place(s.parameter.start);
            *change = (now + *change).clamp(0.0, 1.0) - now;
            let unit = s.quantity.unit();
            let value = s.quantity.key.1 * s.parameter.value(now + *change);
            words.push(format!("{} {value:.3} {unit}", s.parameter.name).trim_end().to_owned());
        }
        for (column, change) in all.iter().zip(&change) {
            residuals.iter_mut().zip(column).for_each(|(r, c)| *r += change * c);
        }
        Ok((residuals.iter().map(|r| r * r).sum(), words.join(", ")))
    }

    /// Other axes of the scene for gravity, with the sums of squares there.
    fn other_gravities(&self) -> Vec<([f64; 3], f64)> {
        let gravity = self.scene.gravity;
        let mut others = Vec::new();
        for axis in along_axes(self.scene) {
            let size = |g: [f64; 3]| g.iter().map(|c| c * c).sum::<f64>();
            let cosine =
                (0..3).map(|c| axis[c] * gravity[c]).sum::<f64>() / (size(axis) * size(gravity)).sqrt();
            // Within 45° of where it is now.
            if cosine > std::f64::consts::FRAC_1_SQRT_2 {
                continue;
            }
            let cost = self.instead(&Scene { gravity: axis, ..self.scene.clone() });
            others.extend(cost.map(|cost| (axis, cost)));
        }
        others
    }

    /// How much less than now a sum of squares is, in variances of an independent residual that it leaves: what an
    /// assumption explains is no noise.
    fn gain(&self, cost: f64) -> f64 {
        self.n_effective * (self.followed(&self.series) / cost - 1.0)
    }

    /// The hint, if the gain is worth one.
    fn hint(&self, instead: String, fit: &str, cost: f64) -> Option<Hint> {
        let n: usize = self.series.iter().map(Vec::len).sum();
        let [now, then] = [self.followed(&self.series), cost].map(|cost| (cost / n as f64).sqrt());
        let is_worth = self.gain(cost) > NOISE && then < (1.0 - WORTH) * now;
        is_worth.then(|| Hint { instead, fit: fit.to_owned(), rms: [now, then] })
    }
}

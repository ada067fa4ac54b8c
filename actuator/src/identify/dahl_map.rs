//! Friction that depends on the path and place of the joint: Dahl elements in parallel, by regression.
//!
//! A static curve of speed leaves half of the measured friction of a harmonic drive unexplained: after a reversal the torque
//! comes back over a hundredth of a radian, and it is larger where the gear carries more. The map is linear in its coefficients:
//! the states of Dahl elements that give way over different slips, one of them and the viscous part also times the position,
//! Coulomb friction that rises over slow speeds, and what a compensation of inertia and weight leaves. To these come waves of the
//! viscous part over the position, each direction's own, where recordings agree on one: gears ripple.
//!
//! # Reference
//! Dahl (1968); Al-Bender, Lampaert, Swevers (2005), The generalized Maxwell-slip model, for elements in parallel.

use hysteron_base::BadInput;
use nalgebra::{DMatrix, DVector};

use crate::filter::LowPass;
use crate::presliding::FrictionLaw;

/// A joint's recorded motion at a fixed rate, and the torque of its friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionRun<'a> {
    /// Time between samples [s].
    pub period: f64,
    /// Coordinate (n_samples) [rad].
    pub position: &'a [f64],
    /// Torque against the motion (n_samples) [N m].
    pub torque: &'a [f64],
}

/// Friction as a function of a joint's path.
#[derive(Debug, Clone, PartialEq)]
pub struct DahlMap {
    /// One for each of [`TERMS`], and of [`RIPPLE_TERMS`] where there is a ripple.
    pub coefficients: Vec<f64>,
    /// Weight of the ridge, relative to the spread of each term [-].
    pub ridge: f64,
    /// Position that the others are relative to [rad].
    pub center: f64,
    /// Wave number of the ripple, where it lowers the validation error [1/rad].
    pub ripple: Option<f64>,
}

/// Terms whose sum is the torque.
pub const TERMS: [&str; 10] = [
    "dahl_1_n_m",
    "dahl_2_n_m",
    "dahl_3_n_m",
    "dahl_4_n_m",
    "viscous_n_m_s_per_rad",
    "coulomb_n_m",
    "inertia_kg_m2",
    "spring_n_m_per_rad",
    "dahl_2_by_position_n_m_per_rad",
    "viscous_by_position_n_m_s_per_rad2",
];
/// Additional terms of a ripple, both ways.
pub const RIPPLE_TERMS: [&str; 4] = [
    "viscous_cosine_forward_n_m_s_per_rad",
    "viscous_sine_forward_n_m_s_per_rad",
    "viscous_cosine_reverse_n_m_s_per_rad",
    "viscous_sine_reverse_n_m_s_per_rad",
];
/// Slips over which the elements give way [rad]: half a milliradian to two degrees.
const SLIPS: [f64; 4] = [5e-4, 2e-3, 8e-3, 3e-2];
/// Speed over which Coulomb friction rises [rad/s].
const SLOW: f64 = 0.05;
/// Low pass of speed and acceleration [Hz]: what an arm does, not what an encoder's steps do.
const CUTOFF: f64 = 2.0;
/// Speed over which one direction's ripple becomes the other's [rad/s].
const TURN: f64 = 0.02;
/// Wave numbers of a ripple that are tried, first, last and step [1/rad]: above what a spring and a slope make of the position; steps are
/// below the width of a line over a path of a radian.
const WAVES: [u16; 3] = [60, 500, 4];
/// Time between the samples that choose a ripple [s].
const COARSE: f64 = 0.01;
/// Least relative fall of the residual on validation runs that makes a ripple one [-].
const MIN_GAIN: f64 = 0.01;
/// Weights of the ridge that are tried, where one is chosen.
const RIDGES: [f64; 7] = [1e-6, 1e-4, 1e-3, 1e-2, 3e-2, 0.1, 0.3];

impl DahlMap {
    /// Fits the map to `runs`, each with an offset of its own, which the sensor and the rest of the arm give
    /// it. The ridge is the one with the least validation error, each of these runs as validation once.
    ///
    /// # Errors
    /// `BadInput` for fewer than two runs, series of different lengths, numbers that are not finite, or a joint at rest.
    pub fn fit(runs: &[FrictionRun]) -> Result<Self, BadInput> {
        if runs.len() < 2 {
            return Err(BadInput::new(
                "recordings",
                "two or more, of different speeds",
                runs.len().to_string(),
            )
            .hint("one of them chooses how smooth the map is"));
        }
        let n: usize = runs.iter().map(|run| run.position.len()).sum();
        let center = runs.iter().flat_map(|run| run.position).sum::<f64>() / n as f64;
        let paths = runs.iter().map(|run| TermSignals::of_run(run, center)).collect::<Result<Vec<_>, _>>()?;
        let parts = |ripple: Option<f64>, rows: RunSamples| -> Vec<RunTerms> {
            paths.iter().zip(runs).map(|(path, run)| path.part(run, ripple, rows)).collect()
        };
        let smooth = parts(None, RunSamples::All);
        let ridge = best_ridge(&smooth);
        let ripple = best_ripple(ridge, |ripple| parts(ripple, RunSamples::Coarse));
        let parts = if ripple.is_some() { parts(ripple, RunSamples::All) } else { smooth };
        let ridge = if ripple.is_some() { best_ridge(&parts) } else { ridge };
        let all: Vec<&RunTerms> = parts.iter().collect();
        Ok(Self { coefficients: solve(&all, ridge).as_slice().to_vec(), ridge, center, ripple })
    }

    /// Torque against the motion along a path sampled every `period` [s], but for a constant (n_samples) [N m].
    ///
    /// # Errors
    /// `BadInput` for positions that are not finite, too few of them for the filter, or a joint at rest.
    pub fn torque(&self, position: &[f64], period: f64) -> Result<Vec<f64>, BadInput> {
        let path = TermSignals::new(position, period, self.center)?;
        let columns = path.columns(self.ripple, 1);
        let at = |k: usize| columns.iter().zip(&self.coefficients).map(|(column, c)| column[k] * c).sum();
        Ok((0..position.len()).map(at).collect())
    }
}

/// The terms of one run without their means, and its torque.
struct RunTerms {
    /// One row for each term.
    terms: DMatrix<f64>,
    torque: DVector<f64>,
}

/// Which samples of a run count.
#[derive(Clone, Copy)]
enum RunSamples {
    /// All.
    All,
    /// One every [`COARSE`].
    Coarse,
}

impl RunTerms {
    fn new(columns: &[Vec<f64>], torque: &[f64]) -> Self {
        let n = torque.len();
        let mean = |column: &[f64]| column.iter().sum::<f64>() / n as f64;
        let means: Vec<f64> = columns.iter().map(|column| mean(column)).collect();
        let torque_mean = mean(torque);
        Self {
            terms: DMatrix::from_fn(columns.len(), n, |term, k| columns[term][k] - means[term]),
            torque: DVector::from_iterator(n, torque.iter().map(|torque| torque - torque_mean)),
        }
    }

    /// Standard deviation of what coefficients leave [N m].
    fn spread_left(&self, coefficients: &DVector<f64>) -> f64 {
        let left = &self.torque - self.terms.tr_mul(coefficients);
        (left.norm_squared() / left.len() as f64).sqrt()
    }
}

/// Sum over the runs of the logarithm of what the others' fit leaves of each.
fn validation_error(parts: &[RunTerms], ridge: f64) -> f64 {
    let without = |k: usize| {
        let others: Vec<&RunTerms> =
            parts.iter().enumerate().filter(|(other, _)| *other != k).map(|(_, part)| part).collect();
        parts[k].spread_left(&solve(&others, ridge)).ln()
    };
    (0..parts.len()).map(without).sum()
}

fn best_ridge(parts: &[RunTerms]) -> f64 {
    let mut best = (f64::INFINITY, RIDGES[0]);
    for ridge in RIDGES {
        let left = validation_error(parts, ridge);
        if left < best.0 {
            best = (left, ridge);
        }
    }
    best.1
}

/// The wave number with the least residual on validation runs, if that is less than without.
fn best_ripple(ridge: f64, parts: impl Fn(Option<f64>) -> Vec<RunTerms>) -> Option<f64> {
    let smooth = parts(None);
    let enough = validation_error(&smooth, ridge) + smooth.len() as f64 * (1.0 - MIN_GAIN).ln();
    let [first, last, step] = WAVES;
    let mut best = (enough, None);
    for wave in (first..=last).step_by(usize::from(step)).map(f64::from) {
        let left = validation_error(&parts(Some(wave)), ridge);
        if left < best.0 {
            best = (left, Some(wave));
        }
    }
    best.1
}

/// Ridge regression, every term in units of its spread.
fn solve(parts: &[&RunTerms], ridge: f64) -> DVector<f64> {
    let p = parts.first().map_or(0, |part| part.terms.nrows());
    let (mut matrix, mut right, mut n) = (DMatrix::zeros(p, p), DVector::zeros(p), 0.0);
    for part in parts {
        matrix += &part.terms * part.terms.transpose();
        right += &part.terms * &part.torque;
        n += part.torque.len() as f64;
    }
    // A joint at rest has been refused: a term without spread can only be the position's, over a tiny range.
    let scale = DVector::from_fn(p, |k, _| (matrix[(k, k)] / n).sqrt().max(f64::MIN_POSITIVE));
    let mut scaled = DMatrix::from_fn(p, p, |a, b| matrix[(a, b)] / (scale[a] * scale[b]));
    for k in 0..p {
        scaled[(k, k)] += ridge * n;
    }
    let side = right.component_div(&scale);
    scaled.cholesky().map_or_else(|| DVector::zeros(p), |c| c.solve(&side).component_div(&scale))
}

/// Signals along a path from which the terms are made.
struct TermSignals<'a> {
    position: &'a [f64],
    period: f64,
    velocity: Vec<f64>,
    /// Those of [`TERMS`].
    columns: Vec<Vec<f64>>,
}

impl<'a> TermSignals<'a> {
    fn of_run(run: &FrictionRun<'a>, center: f64) -> Result<Self, BadInput> {
        if run.torque.len() != run.position.len() {
            let expected = format!("{} samples", run.position.len());
            return Err(BadInput::new("torque", expected, run.torque.len().to_string()));
        }
        if let Some(k) = run.torque.iter().position(|x| !x.is_finite()) {
            let place = format!("torque, sample {}", k + 1);
            return Err(BadInput::new(place, "a finite number", run.torque[k].to_string()));
        }
        Self::new(run.position, run.period, center)
    }

    fn new(position: &'a [f64], period: f64, center: f64) -> Result<Self, BadInput> {
        if let Some(k) = position.iter().position(|x| !x.is_finite()) {
            let place = format!("position, sample {}", k + 1);
            return Err(BadInput::new(place, "a finite number", position[k].to_string()));
        }
        let (low, high) = position.iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
        let fewest = (2.0 / (CUTOFF * period)).ceil() as usize;
        if position.len() < fewest.max(3) || high - low < SLIPS[0] {
            let expected = format!("{} or more samples of a joint that moves", fewest.max(3));
            let found = format!("{} from {low} to {high} rad", position.len());
            return Err(BadInput::new("position", expected, found));
        }
        let elements = SLIPS.map(|slip| dahl(position, slip));
        let smooth = LowPass::new(2, CUTOFF, 1.0 / period)?.zero_phase(position);
        let velocity = slopes(&smooth, period);
        let acceleration = slopes(&velocity, period);
        let away: Vec<f64> = position.iter().map(|q| q - center).collect();
        let coulomb = velocity.iter().map(|v| (v / SLOW).tanh()).collect();
        let times = |column: &[f64]| column.iter().zip(&away).map(|(c, x)| c * x).collect::<Vec<f64>>();
        let (dahl_by_position, viscous_by_position) = (times(&elements[1]), times(&velocity));
        let mut columns = elements.to_vec();
        let own = velocity.clone();
        columns.extend([own, coulomb, acceleration, away, dahl_by_position, viscous_by_position]);
        Ok(Self { position, period, velocity, columns })
    }

    /// Every so many rows of the columns, with those of a ripple.
    fn columns(&self, ripple: Option<f64>, stride: usize) -> Vec<Vec<f64>> {
        let thin = |column: &Vec<f64>| column.iter().copied().step_by(stride).collect();
        let mut columns: Vec<Vec<f64>> = self.columns.iter().map(thin).collect();
        if let Some(wave) = ripple {
            let mut waves = [const { Vec::new() }; RIPPLE_TERMS.len()];
            for (q, v) in self.position.iter().zip(&self.velocity).step_by(stride) {
                let (sine, cosine) = (wave * q).sin_cos();
                let forward = 0.5 * (1.0 + (v / TURN).tanh());
                let values =
                    [forward * cosine, forward * sine, (1.0 - forward) * cosine, (1.0 - forward) * sine];
                waves.iter_mut().zip(values).for_each(|(column, value)| column.push(v * value));
            }
            columns.extend(waves);
        }
        columns
    }

    fn part(&self, run: &FrictionRun, ripple: Option<f64>, rows: RunSamples) -> RunTerms {
        let stride = match rows {
            RunSamples::All => 1,
            RunSamples::Coarse => (COARSE / self.period).round().max(1.0) as usize,
        };
        let torque: Vec<f64> = run.torque.iter().copied().step_by(stride).collect();
        RunTerms::new(&self.columns(ripple, stride), &torque)
    }
}

/// State of a Dahl element along a path, from no strain.
fn dahl(position: &[f64], slip: f64) -> Vec<f64> {
    let law = FrictionLaw::Dahl(slip);
    let (mut elements, mut before) = ([0.0; 4], position[0]);
    let state = |q: &f64| {
        law.strain(&mut elements, q - before);
        before = *q;
        elements[0]
    };
    position.iter().map(state).collect()
}

fn slopes(x: &[f64], period: f64) -> Vec<f64> {
    let last = x.len() - 1;
    let at = |k: usize| {
        let (a, b) = (k.saturating_sub(1), (k + 1).min(last));
        (x[b] - x[a]) / ((b - a) as f64 * period)
    };
    (0..=last).map(at).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may stop where it stands
mod tests {
    use super::*;

    const PERIOD: f64 = 0.01;

    fn path(speed: f64) -> Vec<f64> {
        (0..3000).map(|k| 0.3 * (speed * PERIOD * f64::from(k)).sin()).collect()
    }

    /// 0.4 of an element that gives way over 2 mrad, 0.8 viscous; an offset that no other run has.
    fn torque(position: &[f64], offset: f64) -> Vec<f64> {
        let smooth = LowPass::new(2, CUTOFF, 1.0 / PERIOD).unwrap().zero_phase(position);
        let viscous = slopes(&smooth, PERIOD);
        dahl(position, 2e-3).iter().zip(viscous).map(|(z, v)| 0.4 * z + 0.8 * v + offset).collect()
    }

    #[test]
    fn coefficients_come_back_and_offsets_do_not_matter() {
        let paths = [0.5, 1.1].map(path);
        let torques = [torque(&paths[0], 0.3), torque(&paths[1], -0.2)];
        let runs: Vec<FrictionRun> = (0..2)
            .map(|k| FrictionRun { period: PERIOD, position: &paths[k], torque: &torques[k] })
            .collect();
        let map = DahlMap::fit(&runs).unwrap();
        let fast = path(1.7);
        let (found, exact) = (map.torque(&fast, PERIOD).unwrap(), torque(&fast, 0.0));
        let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
        let shift = mean(&found) - mean(&exact);
        let worst = found.iter().zip(&exact).map(|(a, b)| (a - b - shift).abs()).fold(0.0, f64::max);
        // What the smallest ridge takes off coefficients of terms that are 99 % alike.
        assert!(worst < 5e-3, "{worst}, ridge {}", map.ridge);
    }

    #[test]
    fn a_ripple_is_found_and_predicted() {
        let paths = [0.5, 1.1].map(path);
        let rippled = |position: &[f64]| -> Vec<f64> {
            let smooth = LowPass::new(2, CUTOFF, 1.0 / PERIOD).unwrap().zero_phase(position);
            let ripple = |(q, v): (&f64, f64)| if v > 0.0 { 0.5 * v * (240.0 * q + 0.3).cos() } else { 0.0 };
            let ripples = position.iter().zip(slopes(&smooth, PERIOD)).map(ripple);
            torque(position, 0.1).iter().zip(ripples).map(|(a, b)| a + b).collect()
        };
        let torques = paths.each_ref().map(|path| rippled(path));
        let runs: Vec<FrictionRun> = (0..2)
            .map(|k| FrictionRun { period: PERIOD, position: &paths[k], torque: &torques[k] })
            .collect();
        let map = DahlMap::fit(&runs).unwrap();
        assert_eq!((map.ripple, map.coefficients.len()), (Some(240.0), TERMS.len() + RIPPLE_TERMS.len()));
        let fast = path(1.7);
        let (found, exact) = (map.torque(&fast, PERIOD).unwrap(), rippled(&fast));
        let left: Vec<f64> = found.iter().zip(&exact).map(|(a, b)| a - b).collect();
        let spread = |x: &[f64]| {
            let mean = x.iter().sum::<f64>() / x.len() as f64;
            (x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / x.len() as f64).sqrt()
        };
        let smooth: Vec<f64> = torque(&fast, 0.1).iter().zip(&exact).map(|(a, b)| a - b).collect();
        // Of the ripple's torque, half an amplitude over half of the way, less than a tenth is left: the blend of the two directions.
        assert!(spread(&left) < 0.1 * spread(&smooth), "{} {}", spread(&left), spread(&smooth));
    }

    #[test]
    fn a_joint_that_stands_is_refused() {
        let (still, torque) = (vec![0.1; 500], vec![0.0; 500]);
        let run = FrictionRun { period: PERIOD, position: &still, torque: &torque };
        assert_eq!(DahlMap::fit(&[run, run]).unwrap_err().place, "position");
        assert_eq!(DahlMap::fit(&[run]).unwrap_err().place, "recordings");
    }
}

//! Baselines of a learned motor condition: thresholds on current and on identified friction, support vectors,
//! a random forest; the only user of smartcore.
//!
//! All look at windows of 64 samples that overlap by half, at the watched motor alone; what they need is fitted to training recordings.

use hysteron_base::BadInput;
use hysteron_learn::ridge::NormalEquations;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use smartcore::ensemble::random_forest_regressor::{RandomForestRegressor, RandomForestRegressorParameters};
use smartcore::linalg::basic::matrix::DenseMatrix;
use smartcore::svm::Kernels;
use smartcore::svm::svc::{SVC, SVCParameters};

use super::baselines::{gravity_at, positions_of};
use super::data::Trajectory;
use super::evaluate::area_under_curve;
use super::features::FeatureLayout;
use super::loss::watched_motor;
use super::sensing::SensedTrajectory;
use hysteron_arm_dynamics::Model;

/// Samples of a window, and from one to the next.
const WINDOW: (usize, usize) = (64, 32);
/// Speed over which friction turns its sign, and above which a motor moves [rad/s].
const SLOW: f64 = 0.05;
/// Trees of the forest.
const TREES: usize = 100;
/// Most windows that support vectors are chosen among: their cost grows with the square.
const MAX_WINDOWS: usize = 2000;

/// The detector by what is identified along a trajectory.
pub const EVIDENCE: &str = "likelihood of identified faults";

/// A detector's windows: how healthy each looks, and whether it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DetectorScores {
    /// Name of the detector.
    pub name: String,
    /// Share of windows that are classified correctly, at the threshold that does best on the training
    /// windows [-].
    pub accuracy: f64,
    /// Area under the receiver operating characteristic.
    pub area: f64,
}

/// Condition estimates of the watched motor along a trajectory, one per sample (n_samples).
#[derive(Debug, Clone, Default)]
pub struct ConditionEstimate {
    /// How healthy a network finds it; empty without one.
    pub network: Vec<f64>,
    /// Evidence for a healthy motor by the torque that the drive, the bodies and a force on the tip do not explain, as
    /// [`super::ObservedTrajectory::evidence`]; empty without an observer.
    pub evidence: Vec<f64>,
}

impl ConditionEstimate {
    /// Of a network of labels next to an observer.
    pub fn of(sensed: &SensedTrajectory) -> Self {
        Self { network: sensed.condition.clone(), evidence: sensed.evidence.clone() }
    }
}

/// Current less what a healthy motor needs, as a line over gravity, speed, sign of the motion and one.
struct CurrentLine {
    coefficients: Vec<f64>,
}

/// Four signals of the watched motor at every row: current, speed, error, position.
fn signals(features: &FeatureLayout, trajectory: &Trajectory) -> [Vec<f64>; 4] {
    let (m, watched) = (features.motors(), watched_motor(features));
    let column =
        |k: usize| trajectory.inputs.iter().skip(k).step_by(features.len()).copied().collect::<Vec<f64>>();
    let (goal, position) = (column(watched), column(m + watched));
    let error = goal.iter().zip(&position).map(|(goal, position)| goal - position).collect();
    [column(features.currents() + watched), column(3 * m + watched), error, position]
}

impl CurrentLine {
    fn regressor(model: &Model, features: &FeatureLayout, trajectory: &Trajectory) -> Vec<f64> {
        let gravity = gravity_at(model, features, &positions_of(features, trajectory));
        let (m, watched) = (features.motors(), watched_motor(features));
        let [_, speed, _, _] = signals(features, trajectory);
        let row = |(i, dq): (usize, &f64)| [gravity[i * m + watched], *dq, (dq / SLOW).tanh(), 1.0];
        speed.iter().enumerate().flat_map(row).collect()
    }

    /// From healthy trajectories.
    fn fit(model: &Model, features: &FeatureLayout, healthy: &[&Trajectory]) -> Self {
        let mut normal = NormalEquations::new(4, 1);
        for one in healthy {
            normal.add(&Self::regressor(model, features, one), &signals(features, one)[0]);
        }
        Self { coefficients: normal.solve(1e-9) }
    }

    /// Current along the motion beyond what a healthy motor needs, at every row [A]; zero at rest.
    fn excess(&self, model: &Model, features: &FeatureLayout, trajectory: &Trajectory) -> Vec<f64> {
        let rows = Self::regressor(model, features, trajectory);
        let [current, speed, _, _] = signals(features, trajectory);
        rows.chunks_exact(4)
            .zip(current.iter().zip(&speed))
            .map(|(row, (current, speed))| {
                let needed: f64 = row.iter().zip(&self.coefficients).map(|(x, w)| x * w).sum();
                if speed.abs() > SLOW { (current - needed) * speed.signum() } else { 0.0 }
            })
            .collect()
    }
}

/// First rows of the windows of a trajectory.
fn windows(trajectory: &Trajectory) -> impl Iterator<Item = usize> {
    (0..=trajectory.len().saturating_sub(WINDOW.0)).step_by(WINDOW.1).filter(|_| trajectory.len() >= WINDOW.0)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Twenty numbers of a window: mean, spread, least, largest and mean size of each signal.
fn numbers(signals: &[Vec<f64>; 4], start: usize) -> Vec<f64> {
    let of = |signal: &Vec<f64>| {
        let own = &signal[start..start + WINDOW.0];
        let middle = mean(own);
        let spread = (own.iter().map(|x| (x - middle).powi(2)).sum::<f64>() / own.len() as f64).sqrt();
        let [least, most] = [f64::min, f64::max].map(|pick| own.iter().copied().fold(own[0], pick));
        [middle, spread, least, most, own.iter().map(|x| x.abs()).sum::<f64>() / own.len() as f64]
    };
    signals.iter().flat_map(of).collect()
}

/// Windows of trajectories whose condition is known.
#[derive(Default)]
struct Windows {
    numbers: Vec<Vec<f64>>,
    /// Minus the mean size of the current, minus the friction beyond a healthy motor's.
    simple: [Vec<f64>; 2],
    network: Vec<f64>,
    evidence: Vec<f64>,
    is_healthy: Vec<bool>,
}

impl Windows {
    fn of(
        (model, features, friction): (&Model, &FeatureLayout, &CurrentLine),
        trajectories: &[Trajectory],
        estimates: &[ConditionEstimate],
    ) -> Self {
        let mut all = Self::default();
        for (k, trajectory) in trajectories.iter().enumerate() {
            let Some(is_healthy) = trajectory.is_healthy else { continue };
            let signals = signals(features, trajectory);
            let excess = friction.excess(model, features, trajectory);
            for start in windows(trajectory) {
                all.numbers.push(numbers(&signals, start));
                let size: Vec<f64> = signals[0][start..start + WINDOW.0].iter().map(|x| x.abs()).collect();
                all.simple[0].push(-mean(&size));
                all.simple[1].push(-mean(&excess[start..start + WINDOW.0]));
                if let Some(estimates) = estimates.get(k).filter(|estimates| !estimates.network.is_empty()) {
                    all.network
                        .push(mean(&estimates.network[start..estimates.network.len().min(start + WINDOW.0)]));
                }
                if let Some(evidence) =
                    estimates.get(k).and_then(|estimates| estimates.evidence.get(start + WINDOW.0 - 1))
                {
                    all.evidence.push(*evidence);
                }
                all.is_healthy.push(is_healthy);
            }
        }
        all
    }

    /// Numbers over mean and spread of `like`.
    fn scaled(&self, like: &Self) -> Vec<Vec<f64>> {
        let n = like.numbers.len() as f64;
        let width = like.numbers[0].len();
        let column = |k: usize| like.numbers.iter().map(move |row| row[k]);
        let middle: Vec<f64> = (0..width).map(|k| column(k).sum::<f64>() / n).collect();
        let spread =
            |k: usize| (column(k).map(|x| (x - middle[k]).powi(2)).sum::<f64>() / n).sqrt().max(1e-9);
        let spread: Vec<f64> = (0..width).map(spread).collect();
        let row = |row: &Vec<f64>| (0..width).map(|k| (row[k] - middle[k]) / spread[k]).collect();
        self.numbers.iter().map(row).collect()
    }
}

/// Detectors of the watched motor's condition on `test`, fitted to `training`; `estimates` are the estimates for every sample of the trajectories
/// of `training` and `test`.
///
/// # Errors
/// `BadInput` where one of both has not both conditions.
pub fn detectors(
    (model, features): (&Model, &FeatureLayout),
    [training, test]: [&[Trajectory]; 2],
    estimates: [&[ConditionEstimate]; 2],
) -> Result<Vec<DetectorScores>, BadInput> {
    for (name, part) in [("training recordings", training), ("test recordings", test)] {
        let has =
            |healthy: bool| part.iter().any(|one| one.is_healthy == Some(healthy) && one.len() >= WINDOW.0);
        if !(has(true) && has(false)) {
            return Err(BadInput::new(
                name,
                "healthy and degraded motors, `condition` in the metadata",
                "one of both",
            ));
        }
    }
    let healthy: Vec<&Trajectory> = training.iter().filter(|one| one.is_healthy == Some(true)).collect();
    let about = (model, features, &CurrentLine::fit(model, features, &healthy));
    let (known, asked) = (Windows::of(about, training, estimates[0]), Windows::of(about, test, estimates[1]));
    let [x, y] = [known.scaled(&known), asked.scaled(&known)];
    let mut all = Vec::new();
    let mut add = |name: &'static str, scores: [&[f64]; 2]| {
        let [known, asked] = [(&known, scores[0]), (&asked, scores[1])].map(|(windows, scores)| {
            scores.iter().copied().zip(windows.is_healthy.iter().copied()).collect::<Vec<(f64, bool)>>()
        });
        let threshold = best_threshold(&known);
        let right = asked.iter().filter(|(score, is)| (*score >= threshold) == *is).count();
        let area = area_under_curve(&asked).unwrap_or(f64::NAN);
        all.push(DetectorScores { name: name.to_owned(), accuracy: right as f64 / asked.len() as f64, area });
    };
    add("threshold on the current", [&known.simple[0], &asked.simple[0]]);
    add("threshold on identified friction", [&known.simple[1], &asked.simple[1]]);
    let vectors = support_vectors([&x, &y], &known.is_healthy)?;
    add("support vectors", [&vectors[0], &vectors[1]]);
    let forest = forest([&x, &y], &known.is_healthy)?;
    add("random forest", [&forest[0], &forest[1]]);
    if !known.evidence.is_empty() && !asked.evidence.is_empty() {
        add(EVIDENCE, [&known.evidence, &asked.evidence]);
    }
    if !known.network.is_empty() && !asked.network.is_empty() {
        add("network", [&known.network, &asked.network]);
    }
    Ok(all)
}

/// Threshold that classifies the most scores correctly: those from it on count as healthy.
fn best_threshold(scores: &[(f64, bool)]) -> f64 {
    let mut sorted = scores.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    // From the smallest on all count as healthy; each one passed moves to the other side.
    let mut right = scores.iter().filter(|score| score.1).count() as i64;
    let (mut best, mut at) = (right, f64::NEG_INFINITY);
    for (k, (score, is_healthy)) in sorted.iter().enumerate() {
        right += if *is_healthy { -1 } else { 1 };
        if right > best {
            best = right;
            at = sorted.get(k + 1).map_or(f64::INFINITY, |next| 0.5 * (score + next.0));
        }
    }
    at
}

fn matrix(rows: &[Vec<f64>]) -> Result<DenseMatrix<f64>, BadInput> {
    DenseMatrix::from_2d_vec(&rows.to_vec()).map_err(|e| failed("windows", &e))
}

fn failed(what: &str, error: &smartcore::error::Failed) -> BadInput {
    BadInput::new(what, "numbers that a detector can be fitted to", error.to_string())
}

/// How healthy windows look to a support vector machine with Gaussian kernel, γ one over the number of features.
fn support_vectors([x, y]: [&[Vec<f64>]; 2], is_healthy: &[bool]) -> Result<[Vec<f64>; 2], BadInput> {
    let every = x.len().div_ceil(MAX_WINDOWS);
    let some: Vec<Vec<f64>> = x.iter().step_by(every).cloned().collect();
    let labels: Vec<i32> = is_healthy.iter().step_by(every).map(|is| if *is { 1 } else { -1 }).collect();
    let gamma = 1.0 / x[0].len() as f64;
    let options =
        SVCParameters::default().with_c(1.0).with_kernel(Kernels::rbf().with_gamma(gamma)).with_seed(Some(1));
    let (some, x, y) = (matrix(&some)?, matrix(x)?, matrix(y)?);
    let bad = |e| failed("support vectors", &e);
    let machine = SVC::fit(&some, &labels, &options).map_err(bad)?;
    Ok([machine.decision_function(&x).map_err(bad)?, machine.decision_function(&y).map_err(bad)?])
}

/// Share of the trees of a random forest that find windows healthy.
fn forest([x, y]: [&[Vec<f64>]; 2], is_healthy: &[bool]) -> Result<[Vec<f64>; 2], BadInput> {
    let labels: Vec<f64> = is_healthy.iter().map(|is| f64::from(u8::from(*is))).collect();
    let options = RandomForestRegressorParameters::default()
        .with_n_trees(TREES)
        .with_m((x[0].len() as f64).sqrt() as usize)
        .with_seed(1);
    let (x, y) = (matrix(x)?, matrix(y)?);
    let bad = |e| failed("random forest", &e);
    let forest = RandomForestRegressor::fit(&x, &labels, options).map_err(bad)?;
    Ok([forest.predict(&x).map_err(bad)?, forest.predict(&y).map_err(bad)?])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::*;

    #[test]
    fn the_best_threshold_separates_separable_classes() {
        let scores = [(0.1, false), (0.4, false), (0.3, true), (0.7, true), (0.8, true)];
        let at = best_threshold(&scores);
        // One of five is wrong, in any position.
        assert!((0.1..0.3).contains(&at) || (0.4..0.7).contains(&at), "{at}");
        assert_eq!(best_threshold(&[(0.5, true)]), f64::NEG_INFINITY);
        assert_eq!(best_threshold(&[(0.5, false)]), f64::INFINITY);
    }

    #[test]
    fn both_machines_learn_a_circle() {
        let rows: Vec<Vec<f64>> =
            (0..400).map(|i| vec![(0.37 * f64::from(i)).sin(), (0.61 * f64::from(i)).cos()]).collect();
        let is: Vec<bool> = rows.iter().map(|x| x[0].hypot(x[1]) < 0.8).collect();
        let (x, y) = (&rows[..300], &rows[300..]);
        for scores in [support_vectors([x, y], &is[..300]).unwrap(), forest([x, y], &is[..300]).unwrap()] {
            let asked: Vec<(f64, bool)> = scores[1].iter().copied().zip(is[300..].iter().copied()).collect();
            assert!(area_under_curve(&asked).unwrap() > 0.95);
        }
    }
}

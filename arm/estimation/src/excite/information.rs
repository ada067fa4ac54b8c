//! Information of a motion about the parameters: the regressor of the identifiable ones, and its condition
//! number.
//!
//! Parameters are the ten of every body, armature, viscous and dry friction of every joint. Many of them act through sums alone; a
//! largest set of independent columns is found by a pivoted QR of the regressor over states drawn within the limits. Every
//! column is measured in its root mean square over these states, so that the condition number depends on no unit.
//!
//! # Reference
//! Gautier (1991), Numerical calculation of the base inertial parameters of robots.

use hysteron_base::rng;
use nalgebra::DMatrix;
use rand::RngExt as _;

use super::{Motion, MotionLimits, sign};
use hysteron_arm_dynamics::{Data, Model, regressor};

/// States that decide which columns are independent, for each joint.
const STATES_PER_JOINT: usize = 30;
/// A column whose part outside the span of the others is smaller than this depends on them [-].
const INDEPENDENT: f64 = 1e-7;

/// The parameters of a robot that torques can identify.
#[derive(Debug, Clone, PartialEq)]
pub struct Information {
    n: usize,
    /// Columns of the whole regressor that are independent.
    columns: Vec<usize>,
    /// Root mean square of each of them over the drawn states.
    scales: Vec<f64>,
}

impl Information {
    /// Those of a robot within limits; states are drawn from `seed`.
    pub fn of(model: &Model, limits: &MotionLimits, seed: u64) -> Self {
        let n = model.n_joints();
        let width = 13 * n;
        let n_states = STATES_PER_JOINT * n;
        let mut stream = rng(seed, "arm/excite/states");
        let mut rows = DMatrix::zeros(n_states * n, width);
        let (mut data, mut whole) = (Data::new(model, 0.0), Vec::new());
        for s in 0..n_states {
            let mut state = [0; 3].map(|_| vec![0.0; n]);
            for joint in 0..n {
                let [low, high] = limits.range[joint];
                let speed = limits.speed[joint];
                // Where no limit of acceleration is stated: one that reaches the speed in a tenth of a second.
                let acceleration = limits.acceleration[joint].min(10.0 * speed);
                state[0][joint] = stream.random_range(low..high);
                state[1][joint] = stream.random_range(-speed..speed);
                state[2][joint] = stream.random_range(-acceleration..acceleration);
            }
            rows_at(model, &mut data, &state, &mut whole);
            for (k, value) in whole.iter().enumerate() {
                rows[(s * n + k / width, k % width)] = *value;
            }
        }
        let scale = |column: usize| (rows.column(column).norm_squared() / n_states as f64).sqrt();
        let scales: Vec<f64> = (0..width).map(scale).collect();
        let excited: Vec<usize> = (0..width).filter(|c| scales[*c] > 0.0).collect();
        let columns = independent(&rows, &excited, &scales);
        let scales = columns.iter().map(|column| scales[*column]).collect();
        Self { n, columns, scales }
    }

    /// Number of identifiable parameters.
    pub fn n_parameters(&self) -> usize {
        self.columns.len()
    }

    /// Condition number of the regressor over `n_samples` times of a motion; infinite where it does not excite a parameter.
    pub fn condition(
        &self,
        model: &Model,
        data: &mut Data<f64>,
        motion: &impl Motion,
        n_samples: usize,
    ) -> f64 {
        let (n, m) = (self.n, self.columns.len());
        let mut gram = DMatrix::<f64>::zeros(m, m);
        let (mut whole, mut row) = (Vec::new(), vec![0.0; m]);
        let mut state = [0; 3].map(|_| vec![0.0; n]);
        for s in 0..n_samples {
            let t = motion.duration() * (s as f64 + 0.5) / n_samples as f64;
            for joint in 0..n {
                [state[0][joint], state[1][joint], state[2][joint]] = motion.at(joint, t);
            }
            rows_at(model, data, &state, &mut whole);
            for whole in whole.chunks(13 * n) {
                for ((value, column), scale) in row.iter_mut().zip(&self.columns).zip(&self.scales) {
                    *value = whole[*column] / scale;
                }
                for i in 0..m {
                    if row[i] != 0.0 {
                        for j in 0..=i {
                            gram[(i, j)] += row[i] * row[j];
                        }
                    }
                }
            }
        }
        gram.fill_upper_triangle_with_lower_triangle();
        let values = gram.symmetric_eigenvalues();
        let (least, most) = (values.min(), values.max());
        // Of squares: below rounding there is nothing.
        if least <= most * m as f64 * f64::EPSILON { f64::INFINITY } else { (most / least).sqrt() }
    }
}

/// Rows of the regressor of all parameters in one state: n × 13 n, of bodies, armature, viscous and dry friction.
fn rows_at(model: &Model, data: &mut Data<f64>, [q, dq, ddq]: &[Vec<f64>; 3], rows: &mut Vec<f64>) {
    let n = model.n_joints();
    let mut bodies = vec![0.0; 10 * n * n];
    regressor(model, data, [q, dq, ddq], &mut bodies);
    rows.clear();
    for joint in 0..n {
        rows.extend_from_slice(&bodies[10 * n * joint..10 * n * (joint + 1)]);
        for value in [ddq[joint], dq[joint], sign(dq[joint])] {
            rows.extend((0..n).map(|k| if k == joint { value } else { 0.0 }));
        }
    }
}

/// Columns that are independent, in ascending order: a Gram-Schmidt process that always takes the column of which the largest part is
/// left.
fn independent(rows: &DMatrix<f64>, excited: &[usize], scales: &[f64]) -> Vec<usize> {
    let mut left: Vec<(usize, nalgebra::DVector<f64>)> =
        excited.iter().map(|c| (*c, rows.column(*c) / (scales[*c] * (rows.nrows() as f64).sqrt()))).collect();
    let mut taken = Vec::new();
    while let Some(best) = (0..left.len()).max_by(|a, b| left[*a].1.norm().total_cmp(&left[*b].1.norm())) {
        let (column, direction) = left.swap_remove(best);
        let length = direction.norm();
        if length < INDEPENDENT {
            break;
        }
        taken.push(column);
        let direction = direction / length;
        for (_, other) in &mut left {
            // Twice is enough (Kahan).
            for _ in 0..2 {
                let along = direction.dot(other);
                other.axpy(-along, &direction, 1.0);
            }
        }
    }
    taken.sort_unstable();
    taken
}

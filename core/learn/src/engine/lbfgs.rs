//! Limited-memory BFGS over all samples at once: the last digits, which steps of Adam do not find.

use std::collections::VecDeque;

/// The optimiser and its settings.
///
/// # Reference
/// Nocedal, Wright (2006), Numerical optimization, algorithm 7.4 (two loops) with the scaling 7.20; steps satisfy the weak
/// Wolfe conditions by bisection, Lewis, Overton (2013), Nonsmooth optimization via quasi-Newton methods, algorithm 2.6.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lbfgs {
    /// Pairs of steps and changes of the gradient that are kept.
    pub memory: usize,
    /// Steps at most.
    pub iterations: usize,
    /// Ends where the largest element of the gradient is at most this.
    pub gradient_tolerance: f64,
}

/// Why it ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The gradient is as small as asked for.
    Converged,
    /// All iterations are done.
    Iterations,
    /// No step along the direction makes the value smaller: rounding is reached.
    NoProgress,
    /// The caller asked for it.
    Stopped,
}

/// Armijo's and Wolfe's constants.
const DECREASE: f64 = 1e-4;
const CURVATURE: f64 = 0.9;
/// Bisections of a line search at most.
const MAX_TRIALS: usize = 40;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A step and what it did to the gradient.
struct CurvaturePair {
    step: Vec<f64>,
    change: Vec<f64>,
    /// 1 / (step · change), positive by the Wolfe conditions.
    rho: f64,
}

impl Lbfgs {
    /// Minimises a function from `x` on, in place. `function(x, gradient)` returns the value and fills the gradient;
    /// `after(iteration, value, x)` is called at every step and ends the search where it returns false.
    pub fn minimise(
        &self,
        function: &mut dyn FnMut(&[f64], &mut [f64]) -> f64,
        x: &mut Vec<f64>,
        after: &mut dyn FnMut(usize, f64, &[f64]) -> bool,
    ) -> (f64, Ending) {
        let mut gradient = vec![0.0; x.len()];
        let mut value = function(x, &mut gradient);
        let mut pairs: VecDeque<CurvaturePair> = VecDeque::new();
        for iteration in 1..=self.iterations {
            if gradient.iter().all(|g| g.abs() <= self.gradient_tolerance) {
                return (value, Ending::Converged);
            }
            let mut direction = descent(&gradient, &pairs);
            if dot(&direction, &gradient) >= 0.0 {
                pairs.clear();
                direction = descent(&gradient, &pairs);
            }
            // Without a memory of curvature, a step of length 1 at most.
            let first =
                if pairs.is_empty() { (1.0 / dot(&direction, &direction).sqrt()).min(1.0) } else { 1.0 };
            let Some(found) =
                line_search(function, x, [value, dot(&direction, &gradient)], &direction, first)
            else {
                if pairs.is_empty() {
                    return (value, Ending::NoProgress);
                }
                pairs.clear();
                continue;
            };
            let step: Vec<f64> = found.x.iter().zip(&*x).map(|(after, before)| after - before).collect();
            let change: Vec<f64> =
                found.gradient.iter().zip(&gradient).map(|(after, before)| after - before).collect();
            let curvature = dot(&step, &change);
            if curvature > f64::EPSILON * dot(&change, &change) {
                pairs.push_back(CurvaturePair { step, change, rho: 1.0 / curvature });
            }
            if pairs.len() > self.memory {
                pairs.pop_front();
            }
            (*x, value, gradient) = (found.x, found.value, found.gradient);
            if !after(iteration, value, x) {
                return (value, Ending::Stopped);
            }
        }
        (value, Ending::Iterations)
    }
}

/// −H g by the two loops.
fn descent(gradient: &[f64], pairs: &VecDeque<CurvaturePair>) -> Vec<f64> {
    let mut r: Vec<f64> = gradient.iter().map(|g| -g).collect();
    let mut alphas = Vec::with_capacity(pairs.len());
    for pair in pairs.iter().rev() {
        let alpha = pair.rho * dot(&pair.step, &r);
        add(&mut r, -alpha, &pair.change);
        alphas.push(alpha);
    }
    if let Some(last) = pairs.back() {
        let scale = 1.0 / (last.rho * dot(&last.change, &last.change));
        r.iter_mut().for_each(|r| *r *= scale);
    }
    for (pair, alpha) in pairs.iter().zip(alphas.iter().rev()) {
        let beta = pair.rho * dot(&pair.change, &r);
        add(&mut r, alpha - beta, &pair.step);
    }
    r
}

fn add(sum: &mut [f64], factor: f64, values: &[f64]) {
    for (sum, v) in sum.iter_mut().zip(values) {
        *sum += factor * v;
    }
}

struct LineSearchTrial {
    x: Vec<f64>,
    value: f64,
    gradient: Vec<f64>,
}

/// A point that satisfies both conditions of Wolfe, or the best that decreases enough; none where nothing does.
fn line_search(
    function: &mut dyn FnMut(&[f64], &mut [f64]) -> f64,
    x: &[f64],
    [value, slope]: [f64; 2],
    direction: &[f64],
    first: f64,
) -> Option<LineSearchTrial> {
    let (mut low, mut high, mut length) = (0.0, f64::INFINITY, first);
    let mut best: Option<LineSearchTrial> = None;
    for _ in 0..MAX_TRIALS {
        let mut trial = LineSearchTrial { x: x.to_vec(), value: 0.0, gradient: vec![0.0; x.len()] };
        add(&mut trial.x, length, direction);
        trial.value = function(&trial.x, &mut trial.gradient);
        // A value that is not a number does not decrease.
        let is_less = trial.value <= value + DECREASE * length * slope && trial.value < value;
        if !is_less {
            high = length;
        } else if dot(&trial.gradient, direction) < CURVATURE * slope {
            low = length;
            best = Some(trial);
        } else {
            return Some(trial);
        }
        length = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * length };
        if high.is_finite() && high - low <= f64::EPSILON * high {
            break;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    const LBFGS: Lbfgs = Lbfgs { memory: 8, iterations: 500, gradient_tolerance: 1e-11 };

    #[test]
    fn rosenbrocks_valley_is_followed_to_its_end() {
        let mut function = |x: &[f64], g: &mut [f64]| {
            let (a, b) = (1.0 - x[0], x[1] - x[0] * x[0]);
            (g[0], g[1]) = (-2.0 * a - 400.0 * x[0] * b, 200.0 * b);
            a * a + 100.0 * b * b
        };
        let mut x = vec![-1.2, 1.0];
        let (value, ending) = LBFGS.minimise(&mut function, &mut x, &mut |_, _, _| true);
        assert_eq!(ending, Ending::Converged);
        assert!(value < 1e-20 && (x[0] - 1.0).abs() < 1e-10 && (x[1] - 1.0).abs() < 1e-10, "{x:?} {value}");
    }

    #[test]
    fn values_that_are_no_numbers_are_stepped_back_from() {
        // x − ln x: not a number for x < 0, least at 1.
        let mut function = |x: &[f64], g: &mut [f64]| {
            g[0] = 1.0 - 1.0 / x[0];
            x[0] - x[0].ln()
        };
        let mut x = vec![8.0];
        let (_, ending) = LBFGS.minimise(&mut function, &mut x, &mut |_, _, _| true);
        assert!((x[0] - 1.0).abs() < 1e-7, "{x:?} {ending:?}");
    }

    #[test]
    fn it_stops_on_request() {
        let mut function = |x: &[f64], g: &mut [f64]| {
            g[0] = x[0];
            0.5 * x[0] * x[0]
        };
        let (_, ending) = LBFGS.minimise(&mut function, &mut vec![3.0], &mut |_, _, _| false);
        assert_eq!(ending, Ending::Stopped);
    }
}

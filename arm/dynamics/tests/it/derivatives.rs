//! Analytic derivatives compared with a complex step, which has no truncation error.

use hysteron_arm_dynamics::*;

use hysteron_arm_fixtures::numbers::{Complex, STEP, stepped};
use hysteron_arm_fixtures::robots::{State, assert_close, each};

/// Required accuracy [-]; forward dynamics of the lightest grippers lose six digits to the condition of M.
const TOLERANCE: f64 = 1e-10;

/// A push and a twist at the last frame, as numbers of the kind that `number` makes.
fn push<T: Copy>(model: &Model, number: impl Fn(f64) -> T) -> [ExternalForce<T>; 1] {
    let frame = model.frames().len() - 1;
    [ExternalForce { frame, force: [1.0, -2.0, 3.0].map(&number), torque: [0.1, 0.2, -0.3].map(&number) }]
}

/// n × n numbers: column j is the imaginary part of `f` with a step in coordinate j.
fn columns(n: usize, f: impl Fn(Option<usize>) -> Vec<Complex>) -> Vec<f64> {
    let mut rows = vec![0.0; n * n];
    for j in 0..n {
        for (i, y) in f(Some(j)).iter().enumerate() {
            rows[n * i + j] = y.y / STEP;
        }
    }
    rows
}

fn real(x: f64) -> Complex {
    Complex { x, y: 0.0 }
}

#[test]
fn inverse_dynamics() {
    each(|name, model, _, s: &State| {
        let n = model.n_joints();
        let torque = |q, v| {
            let (mut data, mut tau) = (Data::new(model, real(0.0)), vec![real(0.0); n]);
            let (q, v, a) = (stepped(&s.q, q), stepped(&s.v, v), stepped(&s.a, None));
            hysteron_arm_dynamics::inverse_dynamics(
                model,
                &mut data,
                [&q, &v, &a],
                &push(model, real),
                &mut tau,
            );
            tau
        };
        let [mut a, mut b, mut c] = [0; 3].map(|_| vec![0.0; n * n]);
        let mut data = Data::new(model, 0.0);
        let by = [&mut a[..], &mut b, &mut c];
        inverse_dynamics_derivatives(model, &mut data, [&s.q, &s.v, &s.a], &push(model, |x| x), by);
        assert_close(&format!("{name}: ∂τ/∂q"), &a, &columns(n, |j| torque(j, None)), TOLERANCE);
        if n > 2 {
            assert_close(&format!("{name}: ∂τ/∂q̇"), &b, &columns(n, |j| torque(None, j)), TOLERANCE);
        }
    });
}

#[test]
fn forward_dynamics() {
    each(|name, model, _, s: &State| {
        let n = model.n_joints();
        let acceleration = |q, tau| {
            let (mut data, mut ddq) = (Data::new(model, real(0.0)), vec![real(0.0); n]);
            let (q, v, tau) = (stepped(&s.q, q), stepped(&s.v, None), stepped(&s.tau, tau));
            hysteron_arm_dynamics::forward_dynamics(
                model,
                &mut data,
                [&q, &v, &tau],
                &push(model, real),
                &mut ddq,
            );
            ddq
        };
        let [mut a, mut b, mut c] = [0; 3].map(|_| vec![0.0; n * n]);
        let (mut data, mut ddq) = (Data::new(model, 0.0), vec![0.0; n]);
        let by = [&mut a[..], &mut b, &mut c];
        forward_dynamics_derivatives(
            model,
            &mut data,
            [&s.q, &s.v, &s.tau],
            &push(model, |x| x),
            &mut ddq,
            by,
        );
        assert_close(&format!("{name}: ∂q̈/∂q"), &a, &columns(n, |j| acceleration(j, None)), TOLERANCE);
        assert_close(&format!("{name}: ∂q̈/∂τ"), &c, &columns(n, |j| acceleration(None, j)), TOLERANCE);
    });
}

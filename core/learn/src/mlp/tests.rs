//! Streams of a perceptron against differences, and its reverse pass against candle's automatic differentiation.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

use candle_core::{Device, Tensor, Var};

use super::derivatives::ByParameters;
use super::tape::MlpTape;
use crate::{Activation, Mlp};

fn network(activation: Activation) -> (Mlp, Vec<f64>) {
    let mlp = Mlp { inputs: 3, hidden: vec![7, 5], outputs: 2, activation, skip: true };
    let mut parameters = mlp.initial_parameters(5, "test", 1.0);
    // Biases too.
    for (i, p) in parameters.iter_mut().enumerate() {
        *p += 0.1 * (i as f64).sin();
    }
    (mlp, parameters)
}

fn numbers(n: usize, seed: f64) -> Vec<f64> {
    (0..n).map(|i| ((i as f64 + seed) * 1.7).sin()).collect()
}

fn moved(x: &[f64], along: &[f64], h: f64) -> Vec<f64> {
    x.iter().zip(along).map(|(x, d)| x + h * d).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn assert_near(found: &[f64], expected: &[f64], tol: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    assert!(expected.iter().any(|e| e.abs() > 100.0 * tol), "{what}: all of {expected:?} are small");
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < tol, "{what}: {found} {expected}");
    }
}

#[test]
fn tangents_and_mixed_derivatives_are_those_of_differences() {
    // Central differences: rounding 1e-16/h and h² times a third derivative of order 1.
    let (h, tol) = (1e-5, 1e-8);
    for activation in [Activation::Tanh, Activation::Softplus] {
        let (mlp, p) = network(activation);
        let (x, a, b) = (numbers(12, 0.0), numbers(12, 0.3), numbers(12, 0.9));
        let mut tape = MlpTape::new(&mlp);
        tape.forward(&p, &x);
        tape.push_tangent(&p, &a);
        tape.push_tangent(&p, &b);
        tape.push_mixed(&p, 1, 2);
        let mut other = MlpTape::new(&mlp);
        let mut at = |t: f64| {
            other.forward(&p, &moved(&x, &a, t));
            other.push_tangent(&p, &b);
            [other.outputs(0).to_vec(), other.outputs(1).to_vec()]
        };
        let (before, after) = (at(-h), at(h));
        for (k, stream) in [(0, 1), (1, 3)] {
            let slopes: Vec<f64> =
                after[k].iter().zip(&before[k]).map(|(a, b)| (a - b) / (2.0 * h)).collect();
            assert_near(tape.outputs(stream), &slopes, tol, &format!("{activation:?}, stream {stream}"));
        }
    }
}

#[test]
fn prepared_passes_and_tangents_equal_single_ones() {
    // Sums of some tens of products of order 1 in another order.
    let tol = 1e-13;
    for (n_rows, skip) in [(1, false), (1, true), (3, true), (7, true)] {
        let (mut mlp, _) = network(Activation::Softplus);
        mlp.skip = skip;
        let p = numbers(mlp.n_parameters(), 0.2);
        let (x, a) = (numbers(n_rows * mlp.inputs, 0.0), numbers(n_rows * mlp.inputs, 0.3));
        let w = numbers(n_rows * mlp.outputs, 0.5);
        let (mut single, mut both) = (MlpTape::new(&mlp), MlpTape::new(&mlp));
        single.forward(&p, &x);
        single.push_tangent(&p, &a);
        both.prepare(&p);
        both.forward_along(&p, &x, &a);
        for stream in 0..2 {
            assert_near(
                both.outputs(stream),
                single.outputs(stream),
                tol,
                &format!("{n_rows} rows, stream {stream}"),
            );
        }
        let by_inputs = single.reverse_inputs(&p, &w).to_vec();
        assert_near(both.reverse_inputs(&p, &w), &by_inputs, tol, &format!("{n_rows} rows, by inputs"));
    }
}

/// wᵀ of all streams' outputs for these parameters and inputs.
fn weighted(mlp: &Mlp, p: &[f64], x: &[f64], [a, b]: [&[f64]; 2], w: &[f64]) -> f64 {
    let mut tape = MlpTape::new(mlp);
    tape.forward(p, x);
    tape.push_tangent(p, a);
    tape.push_tangent(p, b);
    tape.push_mixed(p, 1, 2);
    let len = w.len() / 4;
    (0..4).map(|s| dot(tape.outputs(s), &w[s * len..(s + 1) * len])).sum()
}

#[test]
fn the_reverse_pass_is_the_derivative_of_every_stream() {
    let (h, tol) = (1e-5, 1e-7);
    for activation in [Activation::Tanh, Activation::Softplus] {
        let (mlp, p) = network(activation);
        let (x, a, b) = (numbers(12, 0.0), numbers(12, 0.3), numbers(12, 0.9));
        let w = numbers(4 * 8, 0.5);
        let mut tape = MlpTape::new(&mlp);
        tape.forward(&p, &x);
        tape.push_tangent(&p, &a);
        tape.push_tangent(&p, &b);
        tape.push_mixed(&p, 1, 2);
        let mut gradient = vec![0.0; p.len()];
        tape.reverse_parameters(&p, &w, ByParameters::Sum(&mut gradient));
        let slope = |dp: &[f64], dx: &[f64]| {
            let at = |t: f64| weighted(&mlp, &moved(&p, dp, t), &moved(&x, dx, t), [&a, &b], &w);
            (at(h) - at(-h)) / (2.0 * h)
        };
        for k in 0..3 {
            let (dp, dx) = (numbers(p.len(), 0.1 * f64::from(k)), numbers(12, 0.7 * f64::from(k)));
            let (none_p, none_x) = (vec![0.0; p.len()], vec![0.0; 12]);
            assert_near(&[dot(&gradient, &dp)], &[slope(&dp, &none_x)], tol, "by parameters");
            let by_inputs = tape.reverse_inputs(&p, &w).to_vec();
            assert_near(&[dot(&by_inputs, &dx)], &[slope(&none_p, &dx)], tol, "by inputs");
        }
    }
}

/// Outputs, and derivatives by parameters and inputs, of values and one tangent over two rows.
fn of_two_rows(tape: &mut MlpTape<f64>, p: &[f64]) -> [Vec<f64>; 4] {
    let (x, a, w) = (numbers(6, 0.2), numbers(6, 0.6), numbers(2 * 4, 0.8));
    tape.forward(p, &x);
    tape.push_tangent(p, &a);
    let outputs = [0, 1].map(|s| tape.outputs(s).to_vec());
    let mut by_parameters = vec![0.0; p.len()];
    tape.reverse_parameters(p, &w, ByParameters::Sum(&mut by_parameters));
    let by_inputs = tape.reverse_inputs(p, &w).to_vec();
    let [values, tangents] = outputs;
    [values, tangents, by_parameters, by_inputs]
}

#[test]
fn what_a_larger_pass_left_on_a_tape_changes_nothing() {
    for activation in [Activation::Relu, Activation::Softplus] {
        let (mlp, p) = network(activation);
        let fresh = of_two_rows(&mut MlpTape::new(&mlp), &p);
        let mut tape = MlpTape::new(&mlp);
        // Nine rows and four streams, which go through other products than two rows do.
        tape.forward(&p, &numbers(27, 0.0));
        tape.push_tangent(&p, &numbers(27, 0.3));
        tape.push_tangent(&p, &numbers(27, 0.9));
        tape.push_mixed(&p, 1, 2);
        tape.reverse_inputs(&p, &numbers(4 * 18, 0.5));
        assert_eq!(of_two_rows(&mut tape, &p), fresh);
    }
}

/// The derivatives by parameters of w · values + w_a · tangents + D_b (c · values), the last by repeating the
/// backward pass of c · values, where `repeats`, or else by a second one.
fn with_a_gradient_along(
    mlp: &Mlp,
    p: &[f64],
    (n_rows, given): (usize, &[f64]),
    (row_by_row, repeats): (bool, bool),
) -> Vec<f64> {
    let [x, a, b] = [0.2, 0.6, 0.4].map(|seed| numbers(n_rows * mlp.inputs, seed));
    let c = numbers(n_rows * mlp.outputs, 0.9);
    let mut tape = MlpTape::new(mlp);
    tape.forward_along(p, &x, &a);
    tape.reverse_inputs(p, &c);
    // Where only values are given, the direction after them is the one of the gradient.
    if given.len() == c.len() {
        tape.keep(1);
    }
    tape.push_tangent(p, &b);
    let width = p.len();
    let is_first = repeats && !row_by_row;
    // The values there do not count if they are the first.
    let mut found =
        vec![if is_first { f64::NAN } else { 0.0 }; if row_by_row { n_rows * width } else { width }];
    let into = match (row_by_row, is_first) {
        (true, _) => ByParameters::Rows { values: &mut found, width, start: 0 },
        (_, true) => ByParameters::First(&mut found),
        _ => ByParameters::Sum(&mut found),
    };
    if repeats {
        tape.reverse_parameters_repeating(p, given, into);
    } else {
        tape.reverse_parameters(p, &[given, &c].concat(), into);
    }
    found
}

#[test]
fn a_gradient_whose_way_back_is_known_has_the_same_derivatives() {
    // Sums of some tens of products of order 1 in another order.
    let tol = 1e-13;
    for activation in [Activation::Relu, Activation::Tanh, Activation::Softplus] {
        for (n_rows, skip) in [(2, false), (2, true), (9, false), (9, true)] {
            let (mut mlp, _) = network(activation);
            mlp.skip = skip;
            let p = numbers(mlp.n_parameters(), 0.2);
            let len = n_rows * mlp.outputs;
            for given in [numbers(2 * len, 0.8), numbers(len, 0.8), vec![0.0; len], vec![0.0; 2 * len]] {
                for row_by_row in [false, true] {
                    let find =
                        |repeats| with_a_gradient_along(&mlp, &p, (n_rows, &given), (row_by_row, repeats));
                    let what = format!("{activation:?}, {n_rows} rows, {} given", given.len());
                    assert_near(&find(true), &find(false), tol, &what);
                }
            }
        }
    }
}

#[test]
fn values_without_cotangents_are_left_out_and_change_nothing() {
    // Derivatives are linear in the cotangents: those without any are the mean of those with some and with their negatives.
    for activation in [Activation::Relu, Activation::Softplus] {
        let (mlp, p) = network(activation);
        let given = numbers(9 * mlp.outputs, 0.8);
        let find = |factor: f64| {
            let given: Vec<f64> = given.iter().map(|g| factor * g).collect();
            with_a_gradient_along(&mlp, &p, (9, &given), (false, true))
        };
        let mean: Vec<f64> = find(1.0).iter().zip(find(-1.0)).map(|(a, b)| 0.5 * (a + b)).collect();
        assert!(mean.iter().any(|g| g.abs() > 0.1));
        assert_near(&find(0.0), &mean, 1e-13, &format!("{activation:?}"));
    }
}

#[test]
#[should_panic(expected = "no gradient of values to repeat")]
fn what_a_pass_before_left_is_not_repeated() {
    let (mlp, p) = network(Activation::Tanh);
    let mut tape = MlpTape::new(&mlp);
    tape.forward(&p, &numbers(6, 0.2));
    tape.reverse_inputs(&p, &numbers(4, 0.9));
    tape.forward_along(&p, &numbers(6, 0.3), &numbers(6, 0.6));
    tape.reverse_parameters_repeating(&p, &numbers(4, 0.8), ByParameters::Sum(&mut vec![0.0; p.len()]));
}

/// The same streams as a graph of candle, whose derivatives it finds itself.
fn candle_gradient(mlp: &Mlp, p: &[f64], x: &[f64], a: &[f64], w: &[f64]) -> Vec<f64> {
    let n_rows = x.len() / mlp.inputs;
    let tensor = |values: &[f64], width: usize| {
        Tensor::from_slice(values, (values.len() / width, width), &Device::Cpu).unwrap()
    };
    let (mut value, mut tangent) = (tensor(x, mlp.inputs), tensor(a, mlp.inputs));
    let layers = mlp.layers();
    let mut variables = Vec::new();
    for (l, layer) in layers.iter().enumerate() {
        let (weights, biases) = layer.split(p);
        let weights = Var::from_tensor(&tensor(weights, layer.inputs)).unwrap();
        let biases = Var::from_tensor(&tensor(biases, layer.outputs)).unwrap();
        let transposed = weights.as_tensor().t().unwrap();
        value = value.matmul(&transposed).unwrap().broadcast_add(biases.as_tensor()).unwrap();
        tangent = tangent.matmul(&transposed).unwrap();
        variables.extend([weights, biases]);
        if l + 1 < layers.len() {
            let slope;
            (value, slope) = match mlp.activation {
                Activation::Relu => {
                    (value.relu().unwrap(), value.gt(0.0).unwrap().to_dtype(candle_core::DType::F64).unwrap())
                }
                Activation::Tanh => {
                    let y = value.tanh().unwrap();
                    (y.clone(), (1.0 - y.sqr().unwrap()).unwrap())
                }
                Activation::Softplus => {
                    let e = value.exp().unwrap();
                    let slope = (&e / (&e + 1.0).unwrap()).unwrap();
                    ((e + 1.0).unwrap().log().unwrap(), slope)
                }
            };
            tangent = (tangent * slope).unwrap();
        }
    }
    if mlp.skip {
        let past = Var::from_tensor(&tensor(&p[mlp.skip_start()..], mlp.inputs)).unwrap();
        let transposed = past.as_tensor().t().unwrap();
        let add = |y: Tensor, x: &[f64]| (y + tensor(x, mlp.inputs).matmul(&transposed).unwrap()).unwrap();
        (value, tangent) = (add(value, x), add(tangent, a));
        variables.push(past);
    }
    let weigh = |y: Tensor, w: &[f64]| (y * tensor(w, mlp.outputs)).unwrap().sum_all().unwrap();
    let (first, second) = w.split_at(n_rows * mlp.outputs);
    let loss = (weigh(value, first) + weigh(tangent, second)).unwrap();
    let found = loss.backward().unwrap();
    variables
        .iter()
        .flat_map(|v| found.get(v.as_tensor()).unwrap().flatten_all().unwrap().to_vec1::<f64>().unwrap())
        .collect()
}

#[test]
fn gradients_are_those_of_candle() {
    for activation in [Activation::Relu, Activation::Tanh, Activation::Softplus] {
        let (mlp, p) = network(activation);
        let (x, a, w) = (numbers(12, 0.0), numbers(12, 0.3), numbers(16, 0.5));
        let expected = candle_gradient(&mlp, &p, &x, &a, &w);
        let mut tape = MlpTape::new(&mlp);
        tape.forward(&p, &x);
        tape.push_tangent(&p, &a);
        let mut gradient = vec![0.0; p.len()];
        tape.reverse_parameters(&p, &w, ByParameters::Sum(&mut gradient));
        // Sums of some hundred products of order 1.
        assert_near(&gradient, &expected, 1e-13, &format!("{activation:?}"));
        let singles = |values: &[f64]| values.iter().map(|v| *v as f32).collect::<Vec<_>>();
        let mut tape = MlpTape::<f32>::new(&mlp);
        tape.forward(&singles(&p), &singles(&x));
        tape.push_tangent(&singles(&p), &singles(&a));
        let mut gradient = vec![0.0f32; p.len()];
        tape.reverse_parameters(&singles(&p), &singles(&w), ByParameters::Sum(&mut gradient));
        let gradient: Vec<f64> = gradient.into_iter().map(f64::from).collect();
        assert_near(&gradient, &expected, 2e-5, &format!("{activation:?} in f32"));
    }
}

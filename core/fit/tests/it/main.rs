//! Uncertainty of fits: coverage of standard errors, outliers, undetermined parameters, priors; and global
//! searches.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

mod qp;

use hysteron_base::{BadInput, Bounds, rng};
use hysteron_fit::{
    Failure, Fit, GlobalMethod, GlobalOptions, Identifiability, Options, Parameter, ParameterScale, Prior,
    TOLERANCE, least_squares, polished, search_globally,
};
use rand::RngExt;

const WATCH: &(dyn Fn(usize, f64) -> bool + Sync) = &|_, _| true;

fn parameter(name: &str, start: f64, min: f64, max: f64, scale: ParameterScale) -> Parameter {
    Parameter { name: name.into(), start, bounds: Bounds { min, max }, scale, prior: None }
}

fn curve(
    parameters: &[Parameter],
    huber: Option<f64>,
    at: &[f64],
    data: &[f64],
    of: fn(&[f64], f64) -> f64,
) -> Fit {
    let options = Options { huber, smallest_effect: 1e-6, n_nuisance: 0, tolerance: TOLERANCE, watch: WATCH };
    let residuals = |p: &[f64]| {
        Ok::<_, BadInput>(vec![at.iter().zip(data).map(|(t, y)| of(p, *t) - y).collect::<Vec<f64>>()])
    };
    least_squares(parameters, &options, residuals).unwrap()
}

/// Sum of twelve even numbers less six: nearly normal, with variance one.
fn normal(rng: &mut impl RngExt) -> f64 {
    (0..12).map(|_| rng.random_range(0.0..1.0)).sum::<f64>() - 6.0
}

const DECAY: fn(&[f64], f64) -> f64 = |p, t| p[0] * (-t / p[1]).exp();

#[test]
fn standard_errors_cover_the_truth_as_often_as_they_say() {
    let parameters = [
        parameter("height", 1.0, 0.1, 20.0, ParameterScale::Logarithmic),
        parameter("time", 1.0, 0.1, 9.0, ParameterScale::Linear),
    ];
    let at: Vec<f64> = (0..60).map(|i| 0.1 * f64::from(i)).collect();
    let (mut rng, truth, n) = (rng(1, "fit/coverage"), [3.0, 2.0], 200);
    let mut inside = [0; 2];
    for _ in 0..n {
        let data: Vec<f64> = at.iter().map(|t| DECAY(&truth, *t) + 0.1 * normal(&mut rng)).collect();
        let fit = curve(&parameters, None, &at, &data, DECAY);
        for (k, estimate) in fit.estimates.iter().enumerate() {
            inside[k] += i32::from((estimate.value - truth[k]).abs() < estimate.standard_error.unwrap());
        }
    }
    // One standard error: 68.3 % of 200, ± 3 √(200 × 0.68 × 0.32) = 20; chance correlation of white residuals widens
    // the errors by some 5 %, which adds 2.5 % of the cases.
    for count in inside {
        assert!((117..=162).contains(&count), "{count} of {n} within one standard error");
    }
}

#[test]
fn huber_forgives_outliers() {
    let parameters = [
        parameter("height", 1.0, 0.1, 20.0, ParameterScale::Logarithmic),
        parameter("time", 1.0, 0.1, 9.0, ParameterScale::Linear),
    ];
    let at: Vec<f64> = (0..60).map(|i| 0.1 * f64::from(i)).collect();
    let outlier = |i: usize| if i % 10 == 3 { 2.0 } else { 0.0 };
    let data: Vec<f64> = at.iter().enumerate().map(|(i, t)| DECAY(&[3.0, 2.0], *t) + outlier(i)).collect();
    let error =
        |huber: Option<f64>| (curve(&parameters, huber, &at, &data, DECAY).estimates[0].value - 3.0).abs();
    // A tenth of the rows pulls by at most its threshold: bias of the order 0.1 × 0.01 / 0.9, over the lever of the fit.
    assert!(error(Some(0.01)) < 0.01 && error(None) > 0.05, "{} {}", error(Some(0.01)), error(None));
}

#[test]
fn what_the_data_does_not_see_is_held_and_named() {
    let three = |start: [f64; 3]| ["a", "b", "c"].map(str::to_owned).into_iter().zip(start);
    let parameters: Vec<Parameter> = three([0.5, 0.4, 0.3])
        .map(|(name, start)| parameter(&name, start, 0.0, 1.0, ParameterScale::Linear))
        .collect();
    let at = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
    // Only a + b is observable, and c not at all.
    let fit = curve(&parameters, None, &at, &[1.2; 6], |p, _| p[0] + p[1]);
    let identifiability = |k: usize| &fit.estimates[k].identifiability;
    assert_eq!(*identifiability(2), Identifiability::Undetermined(vec![]));
    assert_eq!(fit.estimates[2].value, 0.3);
    let held = if *identifiability(0) == Identifiability::Fitted { 1 } else { 0 };
    assert_eq!(
        *identifiability(held),
        Identifiability::Undetermined(vec![fit.estimates[1 - held].name.clone()])
    );
    // Linear: exact but for the search's tolerance.
    assert!((fit.estimates[0].value + fit.estimates[1].value - 1.2).abs() < 1e-4);
}

#[test]
fn parameter_beyond_its_bound_is_reported_on_it() {
    let parameters = [parameter("height", 1.0, 0.1, 2.0, ParameterScale::Linear)];
    let at = [0.0, 1.0, 2.0, 3.0];
    let fit = curve(&parameters, None, &at, &[3.0; 4], |p, _| p[0]);
    assert_eq!(fit.estimates[0].identifiability, Identifiability::AtBound);
    assert_eq!(fit.estimates[0].standard_error, None);
    assert_eq!(fit.estimates[0].value.to_bits(), 2.0_f64.to_bits());
}

#[test]
fn a_minimum_on_a_bound_is_on_it_exactly_and_one_just_inside_is_not() {
    // A line through data whose slope is at the lower bound, or beyond it, or off it by a thousandth of the range.
    let parameters = [
        parameter("slope", 0.4, 0.0, 1.0, ParameterScale::Linear),
        parameter("height", 0.3, -9.0, 9.0, ParameterScale::Linear),
    ];
    let at: Vec<f64> = (0..40).map(|i| 0.1 * f64::from(i)).collect();
    let of: fn(&[f64], f64) -> f64 = |p, t| p[0] * t + p[1];
    let noise = |i: usize| if i.is_multiple_of(2) { 1e-5 } else { -1e-5 };
    let fitted = |slope: f64| {
        let data: Vec<f64> = at.iter().enumerate().map(|(i, t)| of(&[slope, 0.7], *t) + noise(i)).collect();
        curve(&parameters, None, &at, &data, of)
    };
    for slope in [-0.2, -1e-3, 1.001, 1.2] {
        let fit = fitted(slope);
        let [found, height] = [0, 1].map(|k| &fit.estimates[k]);
        let bound: f64 = if slope < 0.5 { 0.0 } else { 1.0 };
        assert_eq!(
            (&found.identifiability, found.standard_error),
            (&Identifiability::AtBound, None),
            "{slope}: {found:?}"
        );
        assert_eq!(found.value.to_bits(), bound.to_bits(), "{slope}");
        // The height that is best with the slope on its bound: what the slope cannot take at the middle of the times.
        let best = 0.7 + (slope - bound) * at.iter().sum::<f64>() / at.len() as f64;
        // A search that ends at a relative change τ of the cost of n residuals is off by √(n τ) standard errors.
        let off = (40.0 * TOLERANCE).sqrt() * height.standard_error.unwrap();
        assert!((height.value - best).abs() < off, "{slope}: {height:?}, {best}");
    }
    let inside = &fitted(1e-3).estimates[0];
    assert_eq!(inside.identifiability, Identifiability::Fitted, "{inside:?}");
    assert!((inside.value - 1e-3).abs() < 1e-5 && inside.standard_error.is_some(), "{inside:?}");
}

#[test]
fn a_correction_that_ends_on_a_bound_is_on_it_without_a_standard_error() {
    // Coarse data give .05, all data a negative value.
    let parameters = [
        parameter("slope", 0.4, 0.0, 1.0, ParameterScale::Linear),
        parameter("height", 0.3, -9.0, 9.0, ParameterScale::Linear),
    ];
    let at: Vec<f64> = (0..40).map(|i| 0.1 * f64::from(i)).collect();
    let of: fn(&[f64], f64) -> f64 = |p, t| p[0] * t + p[1];
    let noise = |i: usize| if i.is_multiple_of(2) { 1e-5 } else { -1e-5 };
    let data = |slope: f64| -> Vec<f64> {
        at.iter().enumerate().map(|(i, t)| of(&[slope, 0.7], *t) + noise(i)).collect()
    };
    let mut fit = curve(&parameters, None, &at, &data(0.05), of);
    assert_eq!(fit.estimates[0].identifiability, Identifiability::Fitted);
    let starts: Vec<Parameter> = parameters
        .iter()
        .zip(fit.values())
        .map(|(parameter, start)| Parameter { start, ..parameter.clone() })
        .collect();
    let options =
        Options { huber: None, smallest_effect: 1e-6, n_nuisance: 0, tolerance: TOLERANCE, watch: WATCH };
    let all = data(-0.02);
    let residuals = |p: &[f64]| {
        Ok::<_, BadInput>(vec![at.iter().zip(&all).map(|(t, y)| of(p, *t) - y).collect::<Vec<f64>>()])
    };
    polished(&starts, &options, residuals, &mut fit).unwrap();
    let [slope, height] = [0, 1].map(|k| &fit.estimates[k]);
    assert_eq!(
        (&slope.identifiability, slope.standard_error, slope.value),
        (&Identifiability::AtBound, None, 0.0)
    );
    assert_eq!(slope.start, 0.4, "where the first search began");
    let best = 0.7 - 0.02 * at.iter().sum::<f64>() / at.len() as f64;
    assert!((height.value - best).abs() < 1e-4 && height.standard_error.is_some(), "{height:?}, {best}");
}

#[test]
fn start_out_of_bounds_is_refused() {
    let parameters = [parameter("height", 3.0, 0.1, 2.0, ParameterScale::Linear)];
    let options =
        Options { huber: None, smallest_effect: 0.0, n_nuisance: 0, tolerance: TOLERANCE, watch: WATCH };
    let error = least_squares(&parameters, &options, |_| Ok::<_, BadInput>(vec![vec![0.0; 9]])).unwrap_err();
    assert_eq!(error.place, "start of height");
}

#[test]
fn the_prior_remains_where_the_data_has_little_information() {
    let believed = |start: f64| Some(Prior { center: start, width: 0.2 });
    let at: Vec<f64> = (0..40).map(|i| 0.1 * f64::from(i)).collect();
    let mut rng = rng(1, "fit/prior");
    // The second parameter moves the data by a tenth of the noise.
    let of: fn(&[f64], f64) -> f64 = |p, t| p[0] * t + 0.01 * p[1] * (7.0 * t).sin();
    let data: Vec<f64> = at.iter().map(|t| of(&[0.4, 0.9], *t) + 0.1 * normal(&mut rng)).collect();
    let mut parameters = [
        parameter("slope", 0.3, 0.0, 1.0, ParameterScale::Linear),
        parameter("wave", 0.1, 0.0, 1.0, ParameterScale::Linear),
    ];
    for parameter in &mut parameters {
        parameter.prior = believed(parameter.start);
    }
    let fit = curve(&parameters, None, &at, &data, of);
    assert_eq!(fit.estimates[0].identifiability, Identifiability::Fitted);
    assert_eq!(
        (&fit.estimates[1].identifiability, fit.estimates[1].value),
        (&Identifiability::Undetermined(vec![]), 0.1)
    );
}

#[test]
fn vague_parameter_stays_where_its_return_would_cost() {
    let at: Vec<f64> = (0..40).map(|i| 0.1 * f64::from(i)).collect();
    let of: fn(&[f64], f64) -> f64 = |p, t| 0.1 * p[0] * (7.0 * t).sin();
    let fit = |truth: f64| {
        let parameters = [parameter("wave", 0.05, 0.0, 1.3, ParameterScale::Linear)];
        // Noise of 0.2 that no wave explains: a standard error of 0.2 / √20 / 0.1 = 0.45, more than the 0.29 of the range
        // that a number drawn evenly from it has.
        let noise = |i: usize| if i.is_multiple_of(2) { 0.2 } else { -0.2 };
        let data: Vec<f64> = at.iter().enumerate().map(|(i, t)| of(&[truth], *t) + noise(i)).collect();
        curve(&parameters, None, &at, &data, of).estimates[0].clone()
    };
    // (1.1 / 0.45)² = 6 variances, and (0.25 / 0.45)² = 0.3.
    let (large, small) = (fit(1.15), fit(0.3));
    assert_eq!(large.identifiability, Identifiability::Vague, "{large:?}");
    assert!((large.value - 1.15).abs() < 0.1, "{large:?}");
    assert_eq!(
        (small.identifiability.clone(), small.value),
        (Identifiability::Undetermined(vec![]), 0.05),
        "{small:?}"
    );
}

/// Residuals that have no value beyond a wall.
#[derive(Debug)]
enum Refusal {
    Bad(BadInput),
    Wall,
}

impl From<BadInput> for Refusal {
    fn from(bad: BadInput) -> Self {
        Self::Bad(bad)
    }
}

impl Failure for Refusal {
    fn is_local(&self) -> bool {
        matches!(self, Self::Wall)
    }
}

#[test]
fn search_turns_back_where_the_residuals_have_no_value() {
    let parameters = [parameter("height", 0.5, 0.0, 10.0, ParameterScale::Linear)];
    let options =
        Options { huber: None, smallest_effect: 1e-9, n_nuisance: 0, tolerance: TOLERANCE, watch: WATCH };
    let residuals = |p: &[f64]| match p[0] < 3.0 {
        true => Ok(vec![vec![(p[0] * p[0] - 4.0).atan(); 4]]),
        false => Err(Refusal::Wall),
    };
    let fit = least_squares(&parameters, &options, residuals).unwrap();
    assert!((fit.estimates[0].value - 2.0).abs() < 1e-4, "{fit:?}");
    let error = least_squares(&parameters, &options, |_| Ok(vec![vec![0.0]]) as Result<_, Refusal>);
    assert!(matches!(error, Err(Refusal::Bad(bad)) if bad.place == "residuals"));
    // The caller's own error comes back: that of a start without a value, and what ended a search that had met the wall.
    let error = least_squares(&parameters, &options, |_| Err(Refusal::Wall));
    assert!(matches!(error, Err(Refusal::Wall)), "{error:?}");
}

/// Rastrigin's function about (0.3, -0.2): 121 minima in ±5, one of them 0.
fn many_minima(p: &[f64]) -> f64 {
    let of = |x: f64| x * x + 10.0 * (1.0 - (std::f64::consts::TAU * x).cos());
    of(p[0] - 0.3) + of(p[1] + 0.2)
}

fn global(method: GlobalMethod, seed: u64) -> GlobalOptions<'static> {
    GlobalOptions {
        method,
        members_per_parameter: 40,
        generations: 400,
        spread: 1e-9,
        seed,
        watch: &|_, _| true,
    }
}

#[test]
fn global_searches_find_the_one_minimum_among_hundreds() {
    let parameters = ["x", "y"].map(|name| parameter(name, 4.0, -5.0, 5.0, ParameterScale::Linear));
    for method in [GlobalMethod::EVOLUTION, GlobalMethod::SWARM, GlobalMethod::SWARMS] {
        // By luck of the draw a population may end elsewhere: most must not.
        let found = (1..=10)
            .map(|seed| {
                search_globally(&parameters, &global(method, seed), |p| Ok::<_, BadInput>(many_minima(p)))
                    .unwrap()
            })
            .filter(|found| found.cost < 1e-6)
            .count();
        assert!(found >= 7, "{method:?}: {found} of 10");
    }
}

#[test]
fn same_seed_gives_the_same_search_on_any_number_of_threads() {
    let parameters = [
        parameter("x", 1.0, 0.1, 10.0, ParameterScale::Logarithmic),
        parameter("y", 0.0, -1.0, 1.0, ParameterScale::Linear),
    ];
    let search = |threads: usize, method| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let options = global(method, 3);
        pool.install(|| {
            search_globally(&parameters, &options, |p| Ok::<_, BadInput>(many_minima(p))).unwrap()
        })
    };
    for method in [GlobalMethod::EVOLUTION, GlobalMethod::SWARMS] {
        assert_eq!(search(1, method), search(2, method));
    }
}

#[test]
fn cost_without_value_is_passed_over_and_an_error_ends_the_search() {
    let parameters = [parameter("x", 1.0, -10.0, 10.0, ParameterScale::Linear)];
    let options = global(GlobalMethod::EVOLUTION, 1);
    let walled = |p: &[f64]| if p[0] < 1.0 { Err(Refusal::Wall) } else { Ok(p[0]) };
    let found = search_globally(&parameters, &options, walled).unwrap();
    assert!((found.values[0] - 1.0).abs() < 1e-3, "{found:?}");
    let broken = |p: &[f64]| {
        if p[0] < 1.0 { Err(Refusal::Wall) } else { Err(Refusal::Bad(BadInput::new("x", "a", "b"))) }
    };
    assert!(
        matches!(search_globally(&parameters, &options, broken), Err(Refusal::Bad(bad)) if bad.place == "x")
    );
}

#[test]
fn a_cost_without_a_value_anywhere_is_infinite() {
    let parameters = [parameter("x", 0.5, 0.0, 1.0, ParameterScale::Linear)];
    for method in [GlobalMethod::EVOLUTION, GlobalMethod::SWARM, GlobalMethod::SWARMS] {
        for nowhere in [f64::INFINITY, f64::NAN] {
            let found =
                search_globally(&parameters, &global(method, 1), |_| Ok::<_, BadInput>(nowhere)).unwrap();
            assert_eq!((found.cost, found.is_converged), (f64::INFINITY, false), "{method:?}");
        }
    }
}

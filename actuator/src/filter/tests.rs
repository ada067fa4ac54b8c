//! Against scipy 1.17.1: `butter(n, 8, fs=100, output="sos")` with `sosfiltfilt` and `sosfilt`, `savgol_filter(x, 7, 3, deriv=1,
//! delta=0.01)`, `savgol_filter(x, 9, 2)`, `medfilt(x, 5)`, `buttord`, of x = sin(0.3 k) + 0.1 k + 0.05 (k mod 7), k = 0..40.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use super::*;

const AT: [usize; 6] = [0, 1, 7, 20, 38, 39];
const ZERO_PHASE_4: [f64; 6] = [
    -0.006237553048535377,
    0.4365272885040996,
    1.7235090503110304,
    1.8763562544059738,
    3.153856481503549,
    3.3430518212512377,
];
const ZERO_PHASE_5: [f64; 6] = [
    -0.007788757418151229,
    0.44200261306438177,
    1.733612068656077,
    1.8705577305893775,
    3.152857239649527,
    3.3466725989454025,
];
const CAUSAL_5: [f64; 6] = [
    0.0,
    0.00021805366624223524,
    0.3838074530191841,
    0.7769617585621136,
    3.352904767640139,
    3.1613263529408555,
];
const SLOPE: [f64; 6] = [
    46.12568645888645,
    43.54842852183092,
    -14.426107353893556,
    29.45232614787789,
    28.681724963568875,
    42.30433129479913,
];
const SMOOTH: [f64; 6] = [
    -0.06995057776083403,
    0.48172438911723425,
    1.685061809728812,
    1.893016873974244,
    3.025913707028656,
    3.2696949963328095,
];
const MEDIAN: [f64; 4] = [0.8646424733950354, 1.5632093666488738, 2.020584501801074, 2.805447411796011];

fn signal() -> Vec<f64> {
    (0..40).map(|k| (0.3 * f64::from(k)).sin() + 0.1 * f64::from(k) + 0.05 * f64::from(k % 7)).collect()
}

/// Rounding of some tens of additions of numbers of that size.
fn assert_equal(found: &[f64], at: &[usize], expected: &[f64]) {
    for (k, expected) in at.iter().zip(expected) {
        assert!(
            (found[*k] - expected).abs() < 1e-11 * (1.0 + expected.abs()),
            "{k}: {} {expected}",
            found[*k]
        );
    }
}

#[test]
fn zero_phase_is_that_of_scipy() {
    assert_equal(&LowPass::new(4, 8.0, 100.0).unwrap().zero_phase(&signal()), &AT, &ZERO_PHASE_4);
    assert_equal(&LowPass::new(5, 8.0, 100.0).unwrap().zero_phase(&signal()), &AT, &ZERO_PHASE_5);
}

#[test]
fn streaming_is_that_of_scipy() {
    let mut state = LowPass::new(5, 8.0, 100.0).unwrap().start(signal()[0]);
    let found: Vec<f64> = signal().iter().map(|x| state.next(*x)).collect();
    assert_equal(&found, &AT, &CAUSAL_5);
}

#[test]
fn local_polynomials_and_medians_are_those_of_scipy() {
    assert_equal(&SavitzkyGolay::new(3, 3, 1, 100.0).unwrap().apply(&signal()), &AT, &SLOPE);
    assert_equal(&SavitzkyGolay::new(4, 2, 0, 100.0).unwrap().apply(&signal()), &AT, &SMOOTH);
    let at = [2, 7, 20, 37];
    assert_equal(&median_of(&signal(), 2), &at, &MEDIAN);
    // The causal one gives the same, half a window later.
    let mut median = Median::new(5, signal()[0]);
    let found: Vec<f64> = signal().iter().map(|x| median.next(*x)).collect();
    assert_equal(&found[2..], &at[..3], &MEDIAN[..3]);
}

#[test]
fn specification_is_met_with_the_order_of_scipy() {
    let specification = Specification { pass: 20.0, pass_db: -1.0, stop: 60.0, stop_db: -40.0 };
    let filter = LowPass::meeting(specification, 400.0).unwrap();
    assert_eq!(filter.order, 5);
    assert!((filter.cutoff - 22.835645407869638).abs() < 1e-9);
    let db = |f: f64| 20.0 * filter.gain(f).log10();
    assert!((db(20.0) + 1.0).abs() < 1e-9 && db(60.0) < -40.0 && (db(filter.cutoff) + 3.0103).abs() < 1e-3);
    assert!((filter.gain(0.0) - 1.0).abs() < 1e-12);
    let narrow = Specification { pass: 59.9, ..specification };
    assert_eq!(LowPass::meeting(narrow, 400.0).unwrap_err().place, "specification of the filter");
}

#[test]
fn polynomials_of_the_degree_are_differentiated_exactly() {
    let cubic: Vec<f64> = (0..30).map(|k| (0.01 * f64::from(k)).powi(3)).collect();
    let slope = SavitzkyGolay::new(5, 3, 1, 100.0).unwrap().apply(&cubic);
    for (k, slope) in slope.iter().enumerate() {
        assert!((slope - 3.0 * (0.01 * k as f64).powi(2)).abs() < 1e-12);
    }
}

#[test]
fn filters_that_cannot_be_are_refused() {
    assert_eq!(LowPass::new(0, 8.0, 100.0).unwrap_err().place, "order of the filter");
    assert_eq!(LowPass::new(2, 50.0, 100.0).unwrap_err().place, "cutoff");
    assert_eq!(LowPass::new(2, f64::NAN, 100.0).unwrap_err().place, "cutoff");
    for [degree, derivative] in [[5, 1], [3, 4]] {
        let bad = SavitzkyGolay::new(2, degree, derivative, 100.0).unwrap_err();
        assert!(bad.expected.contains("derivative <= degree < samples of the window"), "{bad}");
    }
}

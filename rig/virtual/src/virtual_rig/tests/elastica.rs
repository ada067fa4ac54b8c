//! A cantilever under a tip load against the elastica.

use super::{body, spec};

/// Deflection and height of an inextensible cantilever of length 1 under the transverse tip load P L²/(E I) =
/// `load`, by shooting with a fine fourth-order integration: θ'' = -load cos θ, θ(0) = 0, θ'(1) = 0.
fn elastica(load: f64) -> [f64; 2] {
    let shoot = |curvature: f64| {
        let f = |y: [f64; 4]| [y[1], -load * y[0].cos(), y[0].sin(), y[0].cos()];
        let n = 4000;
        let h = 1.0 / f64::from(n);
        let mut y = [0.0, curvature, 0.0, 0.0];
        for _ in 0..n {
            let at = |y: [f64; 4], k: [f64; 4], s: f64| std::array::from_fn(|i| y[i] + s * k[i]);
            let k1 = f(y);
            let k2 = f(at(y, k1, 0.5 * h));
            let k3 = f(at(y, k2, 0.5 * h));
            let k4 = f(at(y, k3, h));
            y = std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        }
        y
    };
    let (mut low, mut high) = (0.0, load);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if shoot(middle)[1] > 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    let end = shoot(low);
    [end[2], end[3]]
}

fn cantilever(load: f64, n_sections: usize) -> [f64; 2] {
    let mut spec = spec();
    (spec.n_sections, spec.section_factors) = (n_sections, vec![1.0; n_sections]);
    spec.stiffness[3] = 1e7;
    spec.guides.clear();
    let force = load * spec.stiffness[0] / spec.length.powi(2);
    spec.tip_load = [force, 0.0, 0.0];
    let length = spec.length;
    let mut body = body(spec, 0.0, 0.01);
    let report = body.step(&[], 1.0);
    assert_eq!(report.failures, 0);
    let (_, tip) = body.tip();
    assert!(tip[1].abs() < 1e-12);
    [tip[0] / length, tip[2] / length]
}

#[test]
fn reference_is_the_published_elastica() {
    // Mattiasson (1981): load 1, 2, 5.
    for (load, deflection, shortening) in
        [(1.0, 0.30172, 0.05643), (2.0, 0.49346, 0.16064), (5.0, 0.71379, 0.38763)]
    {
        let [w, z] = elastica(load);
        assert!((w - deflection).abs() < 1e-5 && (1.0 - z - shortening).abs() < 1e-5, "{load}: {w} {z}");
    }
}

#[test]
fn tip_of_a_cantilever_converges_second_order() {
    for load in [1.0, 2.0, 5.0] {
        let exact = elastica(load);
        let error = |n| {
            let tip = cantilever(load, n);
            (tip[0] - exact[0]).hypot(tip[1] - exact[1])
        };
        let errors = [4, 8, 16, 32].map(error);
        println!("elastica, load {load}: errors over length {errors:?}");
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((order - 2.0).abs() < 0.3, "{load}: {errors:?}");
        }
        assert!(errors[1] < 0.01, "{load}: {errors:?}");
    }
}

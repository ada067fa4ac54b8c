//! The Delassus operator is the compliance of the whole nonlinear model.

use hysteron_twin::{Twin, TwinState};

use super::{scenes, tolerance};

/// Change of tension in central differences [N]. Their error is of second order: a tendon of 1 N bends
/// the body by 0.1 rad, so the relative error is about (0.1 × 1e-3)².
const STEP: f64 = 1e-3;
/// Relative to the largest entry; a step's residual of 1e-12 of 2 N over `STEP` adds 2e-9.
const COMPLIANCE_ERROR: f64 = 1e-6;

fn twin() -> Twin {
    let (mut scene, mesh) = scenes::robot();
    scene.solver.relative_residual = 1e-12;
    for tendon in &mut scene.tendons {
        tendon.tension.min = -100.0;
    }
    Twin::new(&scene, &mesh).expect("a good scene")
}

fn equilibrium(twin: &Twin, tensions: &[f64]) -> TwinState {
    super::after(twin, &twin.rest(), &super::tensions(tensions))
}

fn delassus(twin: &Twin, state: &TwinState) -> Vec<f64> {
    super::stepper_at(twin, state).delassus(twin).expect("a factor")
}

fn check_against_differences(tensions: [f64; 4]) {
    let twin = twin();
    let w = delassus(&twin, &equilibrium(&twin, &tensions));
    let size = w.iter().fold(0.0f64, |max, w| max.max(w.abs()));
    let mut largest = 0.0f64;
    for j in 0..4 {
        let strokes = |step: f64| {
            let mut tensions = tensions;
            tensions[j] += step;
            twin.strokes_of(&equilibrium(&twin, &tensions))
        };
        let (ahead, behind) = (strokes(STEP), strokes(-STEP));
        for i in 0..4 {
            let difference = (ahead[i] - behind[i]) / (2.0 * STEP);
            largest = largest.max((difference - w[4 * i + j]).abs() / size);
        }
    }
    println!("Delassus at {tensions:?}: relative error {largest:.1e}");
    assert!(largest < tolerance(COMPLIANCE_ERROR), "{largest}");
    assert!(largest > 0.0, "a difference that tests nothing");
}

#[test]
fn delassus_is_compliance_at_rest() {
    check_against_differences([0.0; 4]);
}

#[test]
fn delassus_is_compliance_of_bent_body() {
    check_against_differences([3.0, 1.0, 0.2, 0.5]);
}

#[test]
fn delassus_is_symmetric_and_semidefinite() {
    let twin = twin();
    for tensions in [[0.0; 4], [3.0, 1.0, 0.2, 0.5]] {
        let w = nalgebra::DMatrix::from_row_slice(4, 4, &delassus(&twin, &equilibrium(&twin, &tensions)));
        assert_eq!(w, w.transpose());
        let eigenvalues = w.symmetric_eigenvalues();
        assert!(eigenvalues.min() > 0.0, "{eigenvalues}");
        // Pulling two opposite tendons only shortens the body, which is far stiffer than bending it.
        assert!(eigenvalues.max() > 5.0 * eigenvalues.min(), "{eigenvalues}");
    }
}

#[test]
fn delassus_of_parallel_tendons_is_singular() {
    let (mut scene, mesh) = scenes::robot();
    scene.tendons[1] = hysteron_base::Tendon { name: "twice".into(), ..scene.tendons[0].clone() };
    let twin = Twin::new(&scene, &mesh).expect("a good scene");
    let w = nalgebra::DMatrix::from_row_slice(4, 4, &delassus(&twin, &twin.rest()));
    let eigenvalues = w.symmetric_eigenvalues();
    // Round-off of the factor, relative.
    assert!(eigenvalues.min().abs() < 1e-10 * eigenvalues.max(), "{eigenvalues}");
}

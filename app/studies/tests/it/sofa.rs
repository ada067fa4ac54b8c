//! The twin compared with SOFA on the same mesh and cables (`tests/reference/sofa`).
//!
//! `TOL_SCALE` multiplies the tolerances; 0 prints every residual and fails.
use super::repository;
use hysteron_base::MaterialLaw;
use hysteron_studies::tendon::columns::read_columns;
use hysteron_studies::tendon::scenes::{
    MAY_PUSH, N_PRIMARY, N_TENDONS, Setting, one_sided, sofa_folder, sofa_mesh, sofa_scene,
};
use hysteron_studies::tendon::sofa::{Curve, Difference, compare, solve};
use hysteron_twin::{Stepper, Target};

/// Residuals that must stay below tolerances, all evaluated at the end.
#[derive(Default)]
struct Limits(Vec<String>);

impl Limits {
    fn check(&mut self, what: &str, residual: f64, tolerance: f64) {
        let scale: f64 = std::env::var("TOL_SCALE").map_or(1.0, |text| text.parse().unwrap());
        // NaN must not pass.
        if residual > scale * tolerance || residual.is_nan() {
            self.0.push(format!("{what}: {residual:.3e}, tolerance {:.3e}", scale * tolerance));
        }
    }
}

impl Drop for Limits {
    fn drop(&mut self) {
        assert!(std::thread::panicking() || self.0.is_empty(), "\n{}\n", self.0.join("\n"));
    }
}

fn worst(differences: &[Difference], of: impl Fn(&Difference) -> f64) -> f64 {
    differences.iter().map(of).fold(0.0, f64::max)
}

/// Last row up to 7 mm; row k is at 0.2 k mm.
const TO_7_MM: usize = 35;
const TO_10_MM: usize = 50;

#[test]
fn edge_rotation_reproduces_sofa_polar_to_7_mm() {
    let curve = Curve::read(repository(), "ref_A_qs_aux0_polar_one.csv").unwrap();
    let differences = compare(
        repository(),
        &sofa_mesh(repository()).unwrap(),
        (MaterialLaw::CorotationalEdges, &curve, TO_7_MM),
    )
    .unwrap();
    let mut limits = Limits::default();
    // The file gives tips with twelve digits and tensions with six.
    limits.check("tip", worst(&differences, |d| d.tip), 1e-8);
    limits.check("tension", worst(&differences, |d| d.tension), 1e-5);
}

#[test]
fn polar_rotation_deflects_as_sofa_polar_and_large() {
    let mesh = sofa_mesh(repository()).unwrap();
    let mut limits = Limits::default();
    // Another rotation of the same elements: the difference is a property of this coarse mesh. SOFA's polar
    // depends on the order of an element's nodes and drifts sideways, which the length of the deflection
    // leaves out and the distance of the tips does not.
    let cases = [
        ("polar", "ref_A_qs_aux0_polar_one.csv", TO_7_MM, 0.006, 0.035),
        ("large", "ref_A_qs_aux0_one.csv", TO_10_MM, 0.015, 0.035),
    ];
    for (name, file, last, deflection, tip) in cases {
        let curve = Curve::read(repository(), file).unwrap();
        let differences = compare(repository(), &mesh, (MaterialLaw::Corotational, &curve, last)).unwrap();
        limits.check(&format!("{name}: deflection"), worst(&differences, |d| d.deflection), deflection);
        limits.check(&format!("{name}: tip"), worst(&differences, |d| d.tip), tip);
    }
}

#[test]
fn delassus_at_rest_is_that_of_sofa() {
    let path = sofa_folder(repository()).join("delassus_W_rest_meshA.csv");
    let text = std::fs::read_to_string(path).unwrap();
    let rows = text.lines().filter(|line| !line.starts_with('#'));
    // mm/N to m/N.
    let reference: Vec<f64> =
        rows.flat_map(|row| row.split(',')).map(|entry| 1e-3 * entry.parse::<f64>().unwrap()).collect();
    for law in [MaterialLaw::Corotational, MaterialLaw::CorotationalEdges] {
        let twin =
            sofa_scene(repository(), Setting::exact(law), &sofa_mesh(repository()).unwrap(), N_PRIMARY)
                .unwrap();
        let delassus = Stepper::new(&twin).delassus(&twin).unwrap();
        assert_eq!(delassus.len(), reference.len());
        let mut limits = Limits::default();
        for (k, (w, reference)) in delassus.iter().zip(&reference).enumerate() {
            limits.check(&format!("{law:?} W[{k}]"), (w / reference - 1.0).abs(), 1e-6);
        }
    }
}

/// p0 pulled and p2 released by the same length, p1 and p3 held.
fn antagonistic(stroke: f64) -> Vec<Target> {
    [stroke, 0.0, -stroke, 0.0].map(Target::Stroke).to_vec()
}

#[test]
fn cables_that_only_pull_go_slack_opposite_the_pulled_one() {
    let curve = Curve::read(repository(), "ref_A_qs_aux0_minF_ant.csv").unwrap();
    let strokes: Vec<f64> = curve.strokes.iter().copied().step_by(5).collect();
    let twin = sofa_scene(
        repository(),
        Setting::exact(MaterialLaw::Corotational),
        &sofa_mesh(repository()).unwrap(),
        N_PRIMARY,
    )
    .unwrap();
    let both = solve(&twin, &strokes, antagonistic).unwrap();
    let one = solve(&twin, &strokes, |stroke| one_sided(N_PRIMARY, stroke)).unwrap();
    let mut limits = Limits::default();
    for k in 1..strokes.len() {
        assert_eq!(both[k].tensions[1..], [0.0; 3], "at {} mm", 1e3 * strokes[k]);
        let here = twin.tip_of(&both[k]);
        let difference = curve.difference(5 * k, here, both[k].tensions[0]);
        let name = |what: &str| format!("{what} at {:.0} mm", 1e3 * strokes[k]);
        limits.check(&name("deflection"), difference.deflection, 0.015);
        let alone = twin.tip_of(&one[k]);
        let apart = (0..3).map(|c| (here[c] - alone[c]).abs()).fold(0.0, f64::max);
        // Both equilibria have a relative residual of 1e-10.
        limits.check(&name("tip off the axis of the one-sided drive [m]"), apart, 1e-9);
    }
}

#[test]
fn cables_that_may_push_follow_sofa() {
    let curve = Curve::read(repository(), "ref_A_qs_aux0_ant.csv").unwrap();
    let strokes: Vec<f64> = curve.strokes.iter().copied().step_by(5).collect();
    let mut twin = sofa_scene(
        repository(),
        Setting::exact(MaterialLaw::Corotational),
        &sofa_mesh(repository()).unwrap(),
        N_PRIMARY,
    )
    .unwrap();
    twin.tendons.iter_mut().for_each(|tendon| tendon.tension = MAY_PUSH);
    let states = solve(&twin, &strokes, antagonistic).unwrap();
    let mut limits = Limits::default();
    for k in 1..strokes.len() {
        let difference = curve.difference(5 * k, twin.tip_of(&states[k]), states[k].tensions[0]);
        assert!(states[k].tensions[2] < 0.0, "the paid-out cable pushes");
        // As `large` next to the polar rotation.
        let name = |what: &str| format!("{what} at {:.0} mm", 1e3 * strokes[k]);
        limits.check(&name("deflection"), difference.deflection, 0.015);
        // The rotations differ in tension by 0.5 % a millimetre.
        limits.check(&name("tension"), difference.tension, 5.0 * strokes[k]);
    }
}

#[test]
fn auxiliary_cables_at_half_a_newton_have_sofa_lengths() {
    let file = "ref_A_qs_aux36_f05_one.csv";
    let names: Vec<String> = (0..N_TENDONS - N_PRIMARY).map(|j| format!("len_a{j}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let lengths = read_columns(&sofa_folder(repository()).join(file), &names).unwrap();
    let curve = Curve::read(repository(), file).unwrap();
    let mut twin = sofa_scene(
        repository(),
        Setting::exact(MaterialLaw::Corotational),
        &sofa_mesh(repository()).unwrap(),
        N_TENDONS,
    )
    .unwrap();
    // Without stroke p0 must push against the auxiliaries.
    twin.tendons[0].tension = MAY_PUSH;
    let command = |stroke: f64| {
        let mut targets = one_sided(N_TENDONS, stroke);
        targets[N_PRIMARY..].fill(Target::Tension(0.5));
        targets
    };
    // The reference starts loaded: a row before it is rest.
    let strokes: Vec<f64> = std::iter::once(0.0).chain(curve.strokes.iter().copied()).collect();
    let states = solve(&twin, &strokes, command).unwrap();
    let mut limits = Limits::default();
    for (row, state) in states[1..].iter().enumerate() {
        let taken = twin.strokes_of(state);
        for (j, column) in lengths.iter().enumerate() {
            let length = twin.cables.rest_lengths[N_PRIMARY + j] - taken[N_PRIMARY + j];
            // The points lie outside the facets, where the programs choose other tetrahedra; beyond 7 mm
            // the difference of the rotations adds to it.
            let tolerance = if row <= 7 { 0.02 } else { 0.03 };
            limits.check(&format!("a{j} at {row} mm [mm]"), (1e3 * length - column[row]).abs(), tolerance);
        }
    }
}

//! Cantilevers along z against beam theory.

use hysteron_base::MaterialLaw;
use hysteron_fem::FemModel;

use super::*;

/// A square beam.
struct Beam {
    side: f64,
    length: f64,
}

impl Beam {
    fn bending_stiffness(&self) -> f64 {
        YOUNG * self.side.powi(4) / 12.0
    }

    /// Tip deflection per tip force (Timoshenko, with Cowper's shear coefficient of a rectangle).
    fn compliance(&self, nu: f64) -> f64 {
        let shear = 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu);
        let shear_modulus = YOUNG / (2.0 * (1.0 + nu));
        self.length.powi(3) / (3.0 * self.bending_stiffness())
            + self.length / (shear * shear_modulus * self.side * self.side)
    }

    fn model(&self, law: MaterialLaw, nu: f64, order: Order, across: usize, along: usize) -> FemModel {
        let size = [self.side, self.side, self.length];
        let mesh = box_mesh([across, across, along], size, 0.0, order);
        let base = nodes_where(&mesh, |x| x[2] == 0.0);
        FemModel::new(&mesh, material(law, nu), &base).unwrap()
    }

    /// Share of each free node in a uniform load on the end face; they add up to one.
    fn end_shares(&self, model: &FemModel) -> Vec<f64> {
        let at_end = |i: &u32| model.rest[*i as usize][2] > (1.0 - 1e-9) * self.length;
        let mut shares = vec![0.0; model.n_free];
        for e in 0..model.cells.len() {
            let corners: Vec<u32> = model.cells.corners(e).into_iter().filter(at_end).collect();
            let [a, b, c] = corners[..] else { continue };
            let at = |i: u32| Vector3::new(model.rest[i as usize][0], model.rest[i as usize][1], 0.0);
            let area = (at(b) - at(a)).cross(&(at(c) - at(a))).norm() / 2.0;
            // ∫ N_a over a triangle: a third for the corners of a linear one, for the middles of a
            // quadratic one.
            let nodes = model.cells.nodes(e);
            let carrying = if nodes.len() == 4 { nodes } else { &nodes[4..] };
            for node in carrying.iter().filter(|i| at_end(i)) {
                shares[*node as usize] += area / 3.0 / self.side.powi(2);
            }
        }
        let sum: f64 = shares.iter().sum();
        assert_close("shares", sum, 1.0, 1e-12, 1.0);
        shares
    }

    /// Mean displacement of the end face under the end force `p` along x, in `steps` load steps of
    /// `iterations` each.
    fn end_displacement(&self, model: &FemModel, p: f64, steps: usize, iterations: usize) -> [f64; 3] {
        let shares = self.end_shares(model);
        let mut x = model.rest.clone();
        for step in 1..=steps {
            let p = p * step as f64 / steps as f64;
            let load: Vec<f64> = shares.iter().flat_map(|share| [p * share, 0.0, 0.0]).collect();
            let left = solve_equilibrium(model, &load, &mut x, iterations);
            assert!(left < 1e-9 * p, "residual {left} of {p}");
        }
        let mean = |c: usize| (0..model.n_free).map(|i| shares[i] * (x[i][c] - model.rest[i][c])).sum();
        [0, 1, 2].map(mean)
    }

    /// Computed deflection over that of beam theory, for small loads.
    fn ratio(&self, nu: f64, order: Order, across: usize, along: usize) -> f64 {
        let model = self.model(MaterialLaw::SmallStrain, nu, order, across, along);
        let p = 1e-3;
        self.end_displacement(&model, p, 1, 1)[0] / (p * self.compliance(nu))
    }
}

#[test]
fn parts_of_another_stiffness_stretch_as_springs_in_series() {
    let (side, length, ratio, force) = (0.01, 0.04, 50.0, 0.3);
    for order in ORDERS {
        // Without Poisson's ratio the state is uniform in either half, which every mesh has exactly.
        let mesh = box_mesh([2, 2, 4], [side, side, length], 0.0, order);
        let base = nodes_where(&mesh, |x| x[2] == 0.0);
        let model = FemModel::new(&mesh, material(MaterialLaw::SmallStrain, 0.0), &base).unwrap();
        let upper = |e: usize| {
            let corners = model.cells.corners(e);
            corners.iter().all(|node| model.rest[*node as usize][2] > 0.49 * length)
        };
        let ratios = (0..model.cells.len()).map(|e| if upper(e) { ratio } else { 1.0 }).collect();
        let volumes = model.nodal_volumes.clone();
        let model = model.with_modulus_ratios(ratios);
        assert_eq!(model.nodal_volumes, volumes);
        let beam = Beam { side, length };
        let load: Vec<f64> =
            beam.end_shares(&model).iter().flat_map(|share| [0.0, 0.0, force * share]).collect();
        let mut x = model.rest.clone();
        let left = solve_equilibrium(&model, &load, &mut x, 1);
        assert!(left < 1e-9 * force, "{left}");
        let expected = force / (YOUNG * side * side) * 0.5 * length * (1.0 + 1.0 / ratio);
        for (node, rest) in x.iter().zip(&model.rest).filter(|(_, rest)| rest[2] > 0.99 * length) {
            assert_close("stretch", node[2] - rest[2], expected, 1e-9, expected);
        }
    }
}

const BEAM: Beam = Beam { side: 0.01, length: 0.15 };

#[test]
fn cantilever_bends_as_by_timoshenko() {
    // The clamp hinders the section from widening, which beam theory does not know: half a per cent here.
    let ratio = BEAM.ratio(0.3, Order::Quadratic, 3, 30);
    assert!((0.99..1.0).contains(&ratio), "{ratio}");
}

#[test]
fn linear_elements_lock_near_incompressibility_and_quadratic_do_not() {
    // Same cubes, same beam; a linear tetrahedron can only bend by changing volume. The clamp counts for
    // more than at 0.3: about 2 %.
    let linear = BEAM.ratio(0.49, Order::Linear, 2, 30);
    let quadratic = BEAM.ratio(0.49, Order::Quadratic, 2, 30);
    assert!((0.05..0.15).contains(&linear), "{linear}");
    assert!((0.96..1.0).contains(&quadratic), "{quadratic}");
    // Away from incompressibility the linear one bends a few times as far, still too little.
    let compressible = BEAM.ratio(0.3, Order::Linear, 2, 30);
    assert!((0.4..0.6).contains(&compressible), "{compressible}");
}

#[test]
fn large_deflection_follows_the_elastica() {
    // Deflection and shortening over length at P L² / EI = 2: Mattiasson (1981), Int. J. Numer. Meth.
    // Eng. 17, 145-153, table I. The beam is not infinitely thin: shear adds 0.2 %, strain of 4 % as much
    // again, the clamp takes some away.
    const ACC: f64 = 0.01;
    let (deflection, shortening) = (0.49346, 0.16064);
    let beam = Beam { side: 0.005, length: 0.1 };
    let p = 2.0 * beam.bending_stiffness() / beam.length.powi(2);
    for law in [MaterialLaw::Corotational, MaterialLaw::NeoHookean] {
        let model = beam.model(law, 0.3, Order::Quadratic, 1, 24);
        let [x, y, z] = beam.end_displacement(&model, p, 10, 7);
        assert_close(&format!("{law:?} deflection"), x / beam.length, deflection, ACC, deflection);
        assert_close(&format!("{law:?} shortening"), -z / beam.length, shortening, ACC, deflection);
        // The cut into tetrahedra is not symmetric, but nearly.
        assert_close(&format!("{law:?} sideways"), y / beam.length, 0.0, ACC, deflection);
    }
}

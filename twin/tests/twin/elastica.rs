//! Large bending against Euler's elastica.

use hysteron_base::MaterialLaw;
use hysteron_fem::{Layers, Order, Tube};
use hysteron_twin::{Couple, Twin};

use super::{Robot, assert_close, distance, scenes};

const LENGTH: f64 = 0.1;
const RADIUS: f64 = 0.002;
const SIDES: u32 = 8;

/// A solid beam, 25 times as long as thick, without Poisson effect.
fn beam(order: Order, layers: u32) -> Robot {
    let mesh = Tube {
        profile: vec![[0.0, RADIUS], [LENGTH, RADIUS]],
        bore_radius: 0.0,
        channels: Vec::new(),
        outer_divisions: SIDES,
        bore_divisions: SIDES,
        channel_divisions: SIDES,
        layers: Layers::Count(layers),
        order,
    };
    let mut scene = scenes::scene("beam", MaterialLaw::Corotational);
    scene.material.poisson_ratio = 0.0;
    Robot::of(Twin::new(&scene, &mesh.mesh().unwrap()).unwrap())
}

/// E I of the polygon about x [N m²].
fn bending_stiffness(twin: &Twin) -> f64 {
    let corner = |k: u32| {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(SIDES);
        (RADIUS * angle.cos(), RADIUS * angle.sin())
    };
    let second_moment: f64 = (0..SIDES)
        .map(|k| {
            let ((x0, y0), (x1, y1)) = (corner(k), corner(k + 1));
            (x0 * y1 - x1 * y0) * (y0 * y0 + y0 * y1 + y1 * y1) / 12.0
        })
        .sum();
    twin.body.material.youngs_modulus * second_moment
}

/// Nodes of the free end, weighted by their volume.
fn end_nodes(twin: &Twin) -> Vec<(u32, f64)> {
    let nodes = (0..).zip(&twin.body.rest).filter(|(_, node)| node[2] > (1.0 - 1e-9) * LENGTH);
    let volumes: Vec<(u32, f64)> = nodes.map(|(i, _)| (i, twin.body.nodal_volumes[i as usize])).collect();
    // The corners of a quadratic element have negative volumes.
    volumes.into_iter().filter(|(_, volume)| *volume > 0.0).collect()
}

/// Tip of a cantilever of unit length and stiffness under a dead transverse force `p`: (sideways, along).
/// θ'' = -p cos θ with θ(0) = 0 and θ'(1) = 0, by shooting for θ'(0) with Runge-Kutta steps.
fn elastica(p: f64) -> (f64, f64) {
    const STEPS: usize = 2000;
    let h = 1.0 / STEPS as f64;
    let end = |curvature: f64| {
        let slope = |[theta, kappa, _, _]: [f64; 4]| [kappa, -p * theta.cos(), theta.sin(), theta.cos()];
        let mut y = [0.0, curvature, 0.0, 0.0];
        let moved = |y: [f64; 4], k: [f64; 4], t: f64| std::array::from_fn(|i| y[i] + t * k[i]);
        for _ in 0..STEPS {
            let k1 = slope(y);
            let k2 = slope(moved(y, k1, 0.5 * h));
            let k3 = slope(moved(y, k2, 0.5 * h));
            let k4 = slope(moved(y, k3, h));
            y = std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        }
        y
    };
    let (mut low, mut high) = (0.0, p);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if end(middle)[1] < 0.0 { low = middle } else { high = middle }
    }
    let [_, _, sideways, along] = end(low);
    (sideways, along)
}

/// Tip displacement (sideways, along) over the length, for P L² / E I = `p`.
fn deflection(order: Order, layers: u32, p: f64) -> (f64, f64) {
    let mut robot = beam(order, layers);
    let force = p * bending_stiffness(&robot.twin) / (LENGTH * LENGTH);
    let nodes = end_nodes(&robot.twin);
    let total: f64 = nodes.iter().map(|(_, weight)| weight).sum();
    for (node, weight) in nodes {
        robot.twin.loads[node as usize][1] += force * weight / total;
    }
    robot.go(&[]);
    let tip = robot.tip();
    (tip[1] / LENGTH, 1.0 - tip[2] / LENGTH)
}

#[test]
fn reference_is_that_of_bisshopp_and_drucker() {
    // K. E. Bisshopp, D. C. Drucker (1945), Large deflection of cantilever beams; five digits.
    for (p, sideways, shortened) in
        [(1.0, 0.30172, 0.05643), (2.0, 0.49346, 0.16064), (5.0, 0.71379, 0.38763)]
    {
        let (y, z) = elastica(p);
        assert_close("sideways", y, sideways, 6e-6);
        assert_close("along", 1.0 - z, shortened, 6e-6);
    }
}

#[test]
fn cantilever_under_dead_load_is_elastica() {
    for p in [1.0, 2.0, 5.0, 10.0] {
        let (y, z) = elastica(p);
        let found = deflection(Order::Quadratic, 40, p);
        let error = (found.0 - y).hypot(found.1 - (1.0 - z)) / y.hypot(1.0 - z);
        println!("elastica P L²/EI = {p}: relative error of the tip {error:.2e}");
        // Shear, which the elastica leaves out, adds 3 EI / (κ G A L²) = 1e-3 of the deflection.
        assert!(error < super::tolerance(5e-3), "P L²/EI = {p}: {error}");
    }
}

#[test]
fn deflection_converges_with_refinement() {
    let (y, z) = elastica(3.0);
    let tips = [5, 10, 20, 40].map(|layers| deflection(Order::Quadratic, layers, 3.0));
    let apart = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).hypot(a.1 - b.1);
    let changes = [apart(tips[0], tips[1]), apart(tips[1], tips[2]), apart(tips[2], tips[3])];
    let errors = tips.map(|tip| apart(tip, (y, 1.0 - z)) / y.hypot(1.0 - z));
    println!("elastica P L²/EI = 3, 5 to 40 layers: changes {changes:?}, relative errors {errors:?}");
    for pair in changes.windows(2) {
        assert!(pair[1] < 0.25 * pair[0], "{changes:?}");
    }
    // What remains is shear, as above.
    assert!(errors[0] > 10.0 * errors[3] && errors[3] < 2e-3, "{errors:?}");
}

#[test]
fn linear_elements_converge_from_the_stiff_side() {
    let (y, _) = elastica(1.0);
    let tips: Vec<f64> = [20, 40, 80].into_iter().map(|n| deflection(Order::Linear, n, 1.0).0).collect();
    println!("elastica P L²/EI = 1, linear elements: {tips:.4?} of {y:.4}");
    assert!(tips[0] < tips[1] && tips[1] < tips[2] && tips[2] < y, "{tips:?}");
}

#[test]
fn couple_bends_beam_to_circular_arc() {
    for angle in [0.5, 1.0, std::f64::consts::FRAC_PI_2] {
        let mut robot = beam(Order::Quadratic, 30);
        let curvature = angle / LENGTH;
        // Positive about x: bends towards -y. A moment fixed in space has no symmetric tangent: it is
        // applied little by little.
        let moment = [curvature * bending_stiffness(&robot.twin), 0.0, 0.0];
        let nodes = end_nodes(&robot.twin);
        for k in 1..=20 {
            let part = f64::from(k) / 20.0;
            robot.twin.couples = vec![Couple { nodes: nodes.clone(), moment: moment.map(|m| part * m) }];
            robot.go(&[]);
        }
        let expected = [0.0, -(1.0 - angle.cos()) / curvature, angle.sin() / curvature];
        let error = distance(robot.tip(), expected) / LENGTH;
        println!("couple turning the end by {angle:.3}: relative error of the tip {error:.2e}");
        // Curved by this much, a layer's straight-edged elements spend part of the moment on membrane
        // strain; the end faces warp over about one radius, 2 % of the length.
        assert!(error < super::tolerance(1e-2), "{angle}: {error}");
    }
}

#[test]
fn couple_forces_are_pure_moment_on_any_shape() {
    // With a couple alone the clamp must answer with the same moment and no force: its nodes' internal
    // forces show that.
    let mut robot = beam(Order::Linear, 20);
    let moment = [0.4 * bending_stiffness(&robot.twin) / LENGTH, 1e-4, 2e-4];
    robot.twin.couples.push(Couple { nodes: end_nodes(&robot.twin), moment });
    robot.go(&[]);
    let body = &robot.twin.body;
    let mut forces = vec![[0.0; 4]; body.n_nodes()];
    body.internal_force_into(&robot.state.positions, &mut forces);
    let clamp = body.n_free..body.n_nodes();
    let mut sum = [0.0; 3];
    let mut turn = [0.0; 3];
    let size: f64 = forces.iter().flatten().map(|f| f * f).sum::<f64>().sqrt();
    for i in clamp {
        let ([x, y, z, _], [fx, fy, fz, _]) = (robot.state.positions[i], forces[i]);
        for (c, f) in [fx, fy, fz].into_iter().enumerate() {
            sum[c] += f;
        }
        turn[0] += y * fz - z * fy;
        turn[1] += z * fx - x * fz;
        turn[2] += x * fy - y * fx;
    }
    for c in 0..3 {
        // The residual asked for is 1e-8 of the applied forces.
        assert_close("force of the clamp", sum[c], 0.0, 1e-6 * size);
        assert_close("moment of the clamp", turn[c], -moment[c], 1e-6 * size * LENGTH);
    }
}

#[test]
fn beam_volume_is_that_of_polygon() {
    let robot = beam(Order::Quadratic, 10);
    let volume: f64 = robot.twin.body.nodal_volumes.iter().sum();
    let angle = std::f64::consts::TAU / f64::from(SIDES);
    let area = 0.5 * f64::from(SIDES) * RADIUS * RADIUS * angle.sin();
    assert_close("volume", volume, area * LENGTH, 1e-12 * area * LENGTH);
}

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{FRAC_PI_2, TAU};

use hysteron_fem::{Cells, Layers, Mesh, Order, TendonChannel, Tube, check_mesh};
use proptest::prelude::*;

use super::{MM, bad_input, volume};

fn tube(n_channels: u32) -> Tube {
    let channel =
        |k| TendonChannel { angle: f64::from(k) * FRAC_PI_2, center_radius: 4.5 * MM, radius: 0.75 * MM };
    Tube {
        profile: vec![[0.0, 6.0 * MM], [80.0 * MM, 6.0 * MM]],
        bore_radius: 3.0 * MM,
        channels: (0..n_channels).map(channel).collect(),
        outer_divisions: 24,
        bore_divisions: 12,
        channel_divisions: 6,
        layers: Layers::Count(20),
        order: Order::Linear,
    }
}

fn cone() -> Tube {
    Tube {
        profile: vec![[0.0, 15.0 * MM], [0.3, 6.0 * MM], [0.36, 5.0 * MM]],
        bore_radius: 0.0,
        layers: Layers::Count(60),
        ..tube(0)
    }
}

/// Area of the section at the base, polygon by polygon [m²].
fn base_area(tube: &Tube) -> f64 {
    let polygon = |n: u32, r: f64| 0.5 * f64::from(n) * r * r * (TAU / f64::from(n)).sin();
    let bore = if tube.bore_radius > 0.0 { polygon(tube.bore_divisions, tube.bore_radius) } else { 0.0 };
    let channels: f64 = tube.channels.iter().map(|c| polygon(tube.channel_divisions, c.radius)).sum();
    polygon(tube.outer_divisions, tube.profile[0][1]) - bore - channels
}

/// Sum of the frusta between neighbouring corners of the profile [m³]: exact, the sections being similar.
fn exact_volume(tube: &Tube) -> f64 {
    let r0 = tube.profile[0][1];
    let frustum = |a: f64, b: f64| (a * a + a * b + b * b) / (3.0 * r0 * r0);
    tube.profile.windows(2).map(|w| (w[1][0] - w[0][0]) * frustum(w[0][1], w[1][1])).sum::<f64>()
        * base_area(tube)
}

/// Boundary triangles, after checking that no face has more than two tetrahedra.
fn boundary(mesh: &Mesh) -> Vec<[u32; 3]> {
    let mut count: BTreeMap<[u32; 3], u32> = BTreeMap::new();
    for e in 0..mesh.cells.len() {
        let c = mesh.cells.corners(e);
        for skip in 0..4 {
            let mut face: Vec<u32> = (0..4).filter(|i| *i != skip).map(|i| c[i]).collect();
            face.sort_unstable();
            *count.entry([face[0], face[1], face[2]]).or_default() += 1;
        }
    }
    assert!(count.values().all(|n| *n <= 2));
    count.into_iter().filter(|(_, n)| *n == 1).map(|(face, _)| face).collect()
}

/// Euler characteristic of the closed surface, after checking that it is closed.
fn euler(faces: &[[u32; 3]]) -> i64 {
    let mut edges: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for [a, b, c] in faces {
        for edge in [[*a, *b], [*b, *c], [*a, *c]] {
            *edges.entry(edge).or_default() += 1;
        }
    }
    assert!(edges.values().all(|n| *n == 2), "an edge of the surface without exactly two triangles");
    let nodes: BTreeSet<u32> = faces.iter().flatten().copied().collect();
    nodes.len() as i64 - edges.len() as i64 + faces.len() as i64
}

#[test]
fn volume_is_that_of_the_polygons() {
    let tilted = Tube { profile: vec![[0.0, 6.0 * MM], [0.05, 4.0 * MM], [0.08, 5.0 * MM]], ..tube(4) };
    for tube in [tube(0), tube(4), cone(), tilted] {
        let quality = check_mesh(&tube.mesh().expect("good"), "tube").expect("good");
        let exact = exact_volume(&tube);
        // Rounding of some thousand volumes.
        assert!((quality.volume.sum - exact).abs() < 1e-12 * exact, "{} {exact}", quality.volume.sum);
    }
}

#[test]
fn surface_is_closed_and_has_a_hole_for_every_passage() {
    for (tube, n_holes) in [(tube(4), 5), (tube(1), 2), (tube(0), 1), (cone(), 0)] {
        let mesh = tube.mesh().expect("good");
        assert_eq!(euler(&boundary(&mesh)), 2 - 2 * n_holes);
    }
}

#[test]
fn groups_are_the_ends_and_the_body() {
    for order in [Order::Linear, Order::Quadratic] {
        let mesh = Tube { order, ..tube(4) }.mesh().expect("good");
        let at = |z: f64| -> Vec<u32> {
            (0..mesh.nodes.len() as u32).filter(|n| mesh.nodes[*n as usize][2] == z).collect()
        };
        assert_eq!(mesh.groups["base"], at(0.0));
        assert_eq!(mesh.groups["tip"], at(80.0 * MM));
        assert_eq!(mesh.groups["body"].len(), mesh.nodes.len());
    }
}

#[test]
fn quadratic_mesh_keeps_the_corners_and_volume() {
    let linear = cone().mesh().expect("good");
    let quadratic = Tube { order: Order::Quadratic, ..cone() }.mesh().expect("good");
    assert_eq!(quadratic.nodes[..linear.nodes.len()], linear.nodes);
    let Cells::Tet10(_) = quadratic.cells else { panic!("expected ten nodes") };
    for e in 0..linear.cells.len() {
        assert_eq!(quadratic.cells.corners(e), linear.cells.corners(e));
    }
    let quality = check_mesh(&quadratic, "").expect("good");
    assert!((quality.volume.sum - exact_volume(&cone())).abs() < 1e-12 * exact_volume(&cone()));
    assert_eq!(quadratic.to_quadratic(), quadratic);
}

#[test]
fn tetrahedra_are_well_shaped() {
    let worst = |tube: Tube| {
        let quality = check_mesh(&tube.mesh().expect("good"), "").expect("good");
        (quality.radius_ratio.min, quality.smallest_angle.min.to_degrees())
    };
    // Layers of 80/40 = 2 mm suit sides of 1.6 mm.
    let (ratio, angle) = worst(Tube { layers: Layers::Count(40), ..tube(4) });
    assert!(ratio > 0.4 && angle > 15.0, "{ratio} {angle}");
    let (ratio, angle) = worst(Tube { layers: Layers::Count(120), ..cone() });
    assert!(ratio > 0.5 && angle > 25.0, "{ratio} {angle}");
}

#[test]
fn layers_follow_the_profile() {
    let levels = |tube: Tube| -> Vec<f64> {
        let mesh = tube.mesh().expect("good");
        let mut z: Vec<f64> = mesh.nodes.iter().map(|x| x[2]).collect();
        z.dedup();
        z
    };
    let z = levels(cone());
    assert_eq!(z.len(), 61);
    assert!(z.contains(&0.3) && z[60] == 0.36);
    // Every layer as high as its radius asks: the first is 15/5 times as high as the last, about.
    let ratio = (z[1] - z[0]) / (z[60] - z[59]);
    assert!((2.5..3.3).contains(&ratio), "{ratio}");

    let z = levels(Tube { layers: Layers::Height(10.0 * MM), ..cone() });
    assert_eq!(z.len(), 1 + 30 + 6);
    let z = levels(Tube { layers: Layers::Count(2), ..cone() });
    assert_eq!(z, [0.0, 0.3, 0.36]);
}

#[test]
fn graded_layers_are_fine_where_links_end() {
    let (height, end) = (8.0 * MM, 0.5 * MM);
    let tube = Tube { layers: Layers::Graded { height, end }, ..cone() };
    let mesh = tube.mesh().expect("good");
    assert!((volume(&mesh) - exact_volume(&tube)).abs() < 1e-12 * exact_volume(&tube));
    let mut z: Vec<f64> = mesh.nodes.iter().map(|x| x[2]).collect();
    z.dedup();
    let heights: Vec<f64> = z.windows(2).map(|w| w[1] - w[0]).collect();
    assert!(z.contains(&0.3) && z[z.len() - 1] == 0.36);
    assert!(heights.iter().all(|h| *h <= height * (1.0 + 1e-9)), "{heights:?}");
    for corner in [0.3, 0.36] {
        let next = z.iter().position(|z| *z == corner).expect("a section at every corner");
        assert!(heights[next - 3..next].iter().all(|h| *h <= end * (1.0 + 1e-9)), "{heights:?}");
    }
    // Away from both ends a layer of the full height; no jump from one layer to the next.
    assert!(heights.iter().any(|h| *h > 0.9 * height), "{heights:?}");
    assert!(heights.windows(2).all(|w| w[1] / w[0] < 1.5 && w[0] / w[1] < 1.5), "{heights:?}");
}

#[test]
fn layers_of_no_height_at_the_ends_are_refused() {
    for end in [0.0, f64::NAN, 9.0 * MM] {
        let tube = Tube { layers: Layers::Graded { height: 8.0 * MM, end }, ..cone() };
        let error = bad_input(tube.mesh());
        assert!(error.to_string().contains("tube: layers at the ends"), "{error}");
    }
}

#[test]
fn polygons_of_the_circles_areas() {
    let tube = tube(4);
    let circle = |r: f64| std::f64::consts::PI * r * r;
    let area = circle(6.0 * MM) - circle(3.0 * MM) - 4.0 * circle(0.75 * MM);
    let made = tube.with_circle_areas();
    assert!((base_area(&made) - area).abs() < 1e-12 * area);
    let volume = volume(&made.mesh().expect("good"));
    assert!((volume - area * 80.0 * MM).abs() < 1e-10 * volume);
}

#[test]
fn same_numbers_give_the_same_mesh() {
    assert_eq!(tube(4).mesh().expect("good"), tube(4).mesh().expect("good"));
}

#[test]
fn sixty_thousand_unknowns_are_meshed() {
    let large = Tube {
        outer_divisions: 64,
        bore_divisions: 32,
        channel_divisions: 16,
        layers: Layers::Count(70),
        ..tube(4)
    };
    let mesh = large.mesh().expect("good");
    assert!(3 * mesh.nodes.len() > 60_000);
    check_mesh(&mesh, "").expect("good");
}

#[test]
fn nonsense_is_refused() {
    let refused = |change: fn(&mut Tube), place: &str| {
        let mut tube = tube(4);
        change(&mut tube);
        let bad = bad_input(tube.mesh());
        assert!(bad.place.contains(place), "{place}: {bad}");
    };
    refused(|t| t.profile.truncate(1), "profile");
    refused(|t| t.profile[0][0] = 1.0, "profile 0: z");
    refused(|t| t.profile[1][0] = 0.0, "profile 1: z");
    refused(|t| t.profile[1][1] = 0.0, "profile 1: radius");
    refused(|t| t.profile[0][1] = f64::NAN, "profile 0: radius");
    refused(|t| t.bore_radius = -1.0, "bore_radius");
    refused(|t| t.bore_radius = 5.99 * MM, "bore_radius");
    refused(|t| t.bore_radius = f64::INFINITY, "bore_radius");
    refused(|t| t.outer_divisions = 2, "outer_divisions");
    refused(|t| t.outer_divisions = 513, "outer_divisions");
    refused(|t| t.bore_divisions = 0, "bore_divisions");
    refused(|t| t.channel_divisions = 1, "channel_divisions");
    refused(|t| t.channels[2].radius = 0.0, "channel 2: radius");
    refused(|t| t.channels[2].radius = 1.45 * MM, "channel 2: to the surface");
    refused(|t| t.channels[1].center_radius = 3.7 * MM, "channel 1: to the bore");
    refused(|t| t.channels[1].center_radius = -1.0, "channel 1: center_radius");
    refused(|t| t.channels[1].center_radius = f64::NAN, "channel 1: center_radius");
    refused(|t| t.channels[3].angle = f64::NAN, "channel 3: angle");
    refused(|t| t.channels[3].angle = 0.1, "channel 3: to channel 0");
    refused(|t| t.layers = Layers::Count(0), "layers");
    refused(|t| t.layers = Layers::Height(0.0), "layers");
    refused(|t| t.layers = Layers::Height(-1.0), "layers");
    refused(|t| t.layers = Layers::Height(f64::NAN), "layers");
    refused(|t| t.layers = Layers::Height(1e-12), "layers");
    refused(|t| t.layers = Layers::Count(15_000_000), "tube");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever passes the checks becomes a closed mesh of exactly the polygons' volume.
    #[test]
    fn any_accepted_tube_is_meshed(
        radius in 1e-3..0.05, bore in 0.0..0.9, center in 0.0..1.0, hole in 0.01..0.3, turn in 0.0..6.3,
        outer in 3_u32..70, inner in 3_u32..40, sides in 3_u32..20, n_channels in 0_u32..5,
    ) {
        let channel = |k| TendonChannel {
            angle: turn + f64::from(k) * TAU / f64::from(n_channels),
            center_radius: center * radius,
            radius: hole * radius,
        };
        let tube = Tube {
            profile: vec![[0.0, radius], [5.0 * radius, 0.7 * radius]],
            bore_radius: if bore < 0.2 { 0.0 } else { bore * radius },
            channels: (0..n_channels).map(channel).collect(),
            outer_divisions: outer,
            bore_divisions: inner,
            channel_divisions: sides,
            layers: Layers::Count(4),
            order: Order::Linear,
        };
        if let Ok(mesh) = tube.mesh() {
            let n_holes = i64::from(n_channels) + i64::from(tube.bore_radius > 0.0);
            prop_assert_eq!(euler(&boundary(&mesh)), 2 - 2 * n_holes);
            let exact = exact_volume(&tube);
            prop_assert!((super::volume(&mesh) - exact).abs() < 1e-9 * exact);
        }
    }
}

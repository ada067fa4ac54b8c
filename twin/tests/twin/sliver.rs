//! A mesh with a sliver is computed, and its robot does what the robot without it does.

use hysteron_fem::{Cells, Mesh, check_mesh};
use hysteron_twin::Twin;
use nalgebra::Vector3;

use super::{distance, scenes};

/// Puts a node just inside tetrahedron `e` behind the face opposite to its last corner: three good tetrahedra and one of
/// height `h` [m], the same body.
fn with_sliver(mesh: &Mesh, e: usize, h: f64) -> Mesh {
    let mut mesh = mesh.clone();
    let [a, b, c, d] = mesh.cells.corners(e);
    let at = |node: u32| Vector3::from(mesh.nodes[node as usize]);
    let centre = (at(a) + at(b) + at(c)) / 3.0;
    let inwards = (at(d) - centre).normalize();
    let m = mesh.nodes.len() as u32;
    mesh.nodes.push((centre + h * inwards).into());
    let Cells::Tet4(cells) = &mut mesh.cells else { panic!("four nodes") };
    cells[e] = [a, b, c, m];
    cells.extend([[a, b, m, d], [b, c, m, d], [c, a, m, d]]);
    mesh
}

#[test]
fn a_sliver_changes_little() {
    let (scene, mesh) = scenes::robot();
    let targets = super::strokes(&[2e-3, -0.01, -0.01, -0.01]);
    let tip = |mesh: &Mesh| {
        let twin = Twin::new(&scene, mesh).expect("a good scene");
        let state = super::after(&twin, &twin.rest(), &targets);
        (twin.tip_of(&state), twin.tip_of(&twin.rest()), state.tensions[0])
    };
    let (plain, rest, tension) = tip(&mesh);
    let middle = mesh.cells.len() / 2;
    for h in [1e-6, 1e-7] {
        let bad = with_sliver(&mesh, middle, h);
        let quality = check_mesh(&bad, "").expect("a sliver is no error");
        assert_eq!((quality.slivers, quality.radius_ratio.min_cell), (1, middle), "{h}");
        let (found, _, found_tension) = tip(&bad);
        // One node more among 240 gives one tetrahedron of some 700 more ways to deform: at most its share of the motion,
        // thrice, as it may lie where the bend is largest.
        let share = 3.0 / mesh.cells.len() as f64;
        let moved = distance(plain, rest);
        assert!(distance(found, plain) < share * moved, "{h}: {} of {moved}", distance(found, plain));
        assert!((found_tension / tension - 1.0).abs() < 3.0 * share, "{found_tension} {tension}");
        assert!(found != plain, "a sliver that does nothing");
    }
}

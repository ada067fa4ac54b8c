use hysteron_fem::{Cells, Mesh, check_mesh};

use super::{bad_input, read_sample, volume};

fn single(nodes: [[f64; 3]; 4]) -> Mesh {
    Mesh { nodes: nodes.to_vec(), cells: Cells::Tet4(vec![[0, 1, 2, 3]]), groups: Default::default() }
}

const REGULAR: [[f64; 3]; 4] = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];

fn positive(mut nodes: [[f64; 3]; 4]) -> Mesh {
    if volume(&single(nodes)) < 0.0 {
        nodes.swap(0, 1);
    }
    single(nodes)
}

#[test]
fn regular_tetrahedron_has_ratio_one() {
    let quality = check_mesh(&positive(REGULAR), "").expect("good");
    // Edge 2 sqrt 2: volume 8/3, dihedral angle acos(1/3).
    let tol = 4.0 * f64::EPSILON;
    assert!((quality.volume.sum - 8.0 / 3.0).abs() < tol * 8.0 / 3.0);
    assert!((quality.radius_ratio.min - 1.0).abs() < tol, "{}", quality.radius_ratio.min);
    assert!((quality.smallest_angle.min - (1.0_f64 / 3.0).acos()).abs() < tol);
    assert_eq!(quality.radius_ratio.counts.iter().sum::<usize>(), 1);
    assert_eq!(quality.smallest_angle.counts, [0, 0, 0, 0, 0, 0, 0, 1]);
}

#[test]
fn corner_tetrahedron_has_its_known_ratio() {
    let quality = check_mesh(&positive([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), "")
        .expect("good");
    // r = 3V/A = 1/(3 + sqrt 3), R = sqrt 3 / 2.
    let ratio = 3.0 / (3.0 + 3.0_f64.sqrt()) / (3.0_f64.sqrt() / 2.0);
    assert!((quality.radius_ratio.min - ratio).abs() < 1e-15);
    assert!((quality.smallest_angle.min - (1.0 / 3.0_f64.sqrt()).acos()).abs() < 1e-15);
}

#[test]
fn distributions_add_up() {
    let mesh = read_sample("cylinder.msh");
    let quality = check_mesh(&mesh, "cylinder").expect("good");
    for d in [&quality.volume, &quality.radius_ratio, &quality.smallest_angle] {
        assert_eq!(d.counts.iter().sum::<usize>(), 102);
        assert_eq!(d.limits.len(), d.counts.len() + 1);
        assert!(d.min <= d.percentile_1 && d.percentile_1 <= d.percentile_5 && d.percentile_5 <= d.median);
        assert!(d.median <= d.max && d.min <= d.mean && d.mean <= d.max);
    }
    assert!((quality.volume.sum - volume(&mesh)).abs() < 1e-14 * volume(&mesh));
}

#[test]
fn curved_volume_of_straight_edges_is_that_of_the_corners() {
    let mesh = read_sample("cylinder-quadratic.msh");
    let quality = check_mesh(&mesh, "").expect("good");
    assert!((quality.volume.sum - volume(&mesh)).abs() < 1e-12 * volume(&mesh));
}

#[test]
fn curved_volume_is_exact() {
    // One middle moved along x by h: the face bulges, and its volume is linear in h. By hand from the
    // integral of the shape function 4 l0 l1 over the two faces of the edge.
    let mut mesh = positive([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]).to_quadratic();
    let Cells::Tet10(cells) = &mesh.cells else { panic!("expected ten nodes") };
    // Edge 12: it bulges the face x + y + z = 1 (normal (1,1,1)/sqrt 3, area sqrt 3 / 2) and z = 0.
    let middle = cells[0][5] as usize;
    let before = volume(&mesh);
    mesh.nodes[middle][0] += 0.01;
    // The mean of 4 l_i l_j over a triangle is 1/3; face 123 has vector area (1,1,1)/2, face 012 (0,0,-1/2).
    let expected = before + 0.01 * 0.5 / 3.0;
    let quality = check_mesh(&mesh, "").expect("good");
    assert!((quality.volume.sum - expected).abs() < 1e-15, "{} {expected}", quality.volume.sum);
}

#[test]
fn inverted_and_flat_tetrahedra_are_refused_by_number() {
    let mut mesh = read_sample("cylinder.msh");
    let Cells::Tet4(cells) = &mut mesh.cells else { panic!("expected four nodes") };
    cells[7].swap(0, 1);
    let bad = bad_input(check_mesh(&mesh, "part.msh"));
    assert_eq!((bad.place.as_str(), bad.expected.as_str()), ("part.msh: tetrahedron 7", "a positive volume"));
    assert!(bad.found.starts_with('-') && bad.found.ends_with("mm³"), "{bad}");

    let flat = single([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]);
    assert_eq!(bad_input(check_mesh(&flat, "")).expected, "a volume");
    let point = single([[0.0; 3]; 4]);
    assert_eq!(bad_input(check_mesh(&point, "")).expected, "a volume");
}

#[test]
fn slivers_are_reported_with_number_and_effect() {
    let sliver = |h: f64| positive([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, h], [0.0, -1.0, h]]);
    let quality = check_mesh(&sliver(1e-3), "").expect("a sliver is no error");
    assert_eq!(quality.slivers, 1);
    let warnings = quality.warnings();
    assert!(warnings.len() == 1 && warnings[0].contains("tetrahedron 0 is a sliver"), "{warnings:?}");
    let thin = check_mesh(&sliver(0.1), "").expect("thin, but not a sliver");
    assert_eq!((thin.slivers, thin.warnings().len()), (0, 0));
    assert_eq!(bad_input(check_mesh(&sliver(1e-13), "")).expected, "a volume");
}

#[test]
fn folded_ten_node_tetrahedron_is_refused() {
    let mut mesh = positive(REGULAR).to_quadratic();
    let Cells::Tet10(cells) = &mesh.cells else { panic!("expected ten nodes") };
    let [corner, middle] = [cells[0][1], cells[0][4]].map(|n| n as usize);
    mesh.nodes[middle] = mesh.nodes[corner];
    let bad = bad_input(check_mesh(&mesh, ""));
    assert_eq!(bad.place, "tetrahedron 0");
    assert!(bad.expected.contains("positive Jacobian"), "{bad}");
}

#[test]
fn separate_parts_are_refused() {
    let mut mesh = positive(REGULAR);
    mesh.nodes.extend(mesh.nodes.clone());
    mesh.cells = Cells::Tet4(vec![mesh.cells.corners(0), mesh.cells.corners(0).map(|n| n + 4)]);
    let bad = bad_input(check_mesh(&mesh, ""));
    assert_eq!(bad.found, "2 parts of 1, 1 tetrahedra (tetrahedron 1 is not in the largest)");
}

#[test]
fn doubled_tetrahedra_are_refused() {
    let mut mesh = read_sample("cylinder.msh");
    let Cells::Tet4(cells) = &mut mesh.cells else { panic!("expected four nodes") };
    cells.push(cells[0]);
    let bad = bad_input(check_mesh(&mesh, ""));
    assert!(bad.place.starts_with("face of nodes"), "{bad}");
}

#[test]
fn indices_and_coordinates_are_checked() {
    let good = read_sample("cylinder.msh");
    let mut mesh = good.clone();
    mesh.nodes[4][2] = f64::NAN;
    assert_eq!(bad_input(check_mesh(&mesh, "")).place, "node 4");
    let mut mesh = good.clone();
    mesh.groups.insert("far".into(), vec![50]);
    assert_eq!(bad_input(check_mesh(&mesh, "")).place, "group far");
    let mut mesh = good.clone();
    mesh.nodes.push([0.0; 3]);
    assert_eq!(bad_input(check_mesh(&mesh, "")).expected, "a tetrahedron that uses it");
    let mut mesh = good.clone();
    mesh.nodes.pop();
    assert_eq!(bad_input(check_mesh(&mesh, "")).found, "49");
    let mut mesh = good;
    mesh.cells = Cells::Tet4(Vec::new());
    assert_eq!(bad_input(check_mesh(&mesh, "")).found, "none");
}

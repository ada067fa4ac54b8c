use hysteron_fem::{Cells, Error, Mesh, MshEncoding, read_mesh, write_mesh};
use proptest::prelude::*;

use super::{MM, bad_input, read_sample, sample, volume};

/// Volume of the cylinder, as `make_samples.py` printed it [mm³].
const CYLINDER_MM3: f64 = 1415.1764201217047;

#[test]
fn every_encoding_of_gmsh_gives_the_same_mesh() {
    let text = read_sample("cylinder.msh");
    assert_eq!((text.nodes.len(), text.cells.len()), (50, 102));
    let sizes: Vec<(&str, usize)> = text.groups.iter().map(|(k, v)| (k.as_str(), v.len())).collect();
    assert_eq!(sizes, [("body", 50), ("clamped end", 8), ("tip", 8)]);
    // Summation of 102 volumes.
    let tol = 1e-13 * CYLINDER_MM3;
    assert!((volume(&text) * 1e9 - CYLINDER_MM3).abs() < tol, "{}", volume(&text) * 1e9);
    for &n in &text.groups["clamped end"] {
        assert_eq!(text.nodes[n as usize][2], 0.0);
    }
    for other in ["cylinder-binary.msh", "cylinder-parametric.msh"] {
        let other = read_sample(other);
        assert_eq!(other.cells, text.cells);
        assert_eq!(other.groups, text.groups);
        for (a, b) in other.nodes.iter().flatten().zip(text.nodes.iter().flatten()) {
            // Gmsh's text has 16 digits.
            assert!((a - b).abs() <= 1e-15 * 0.02, "{a} {b}");
        }
    }
}

#[test]
fn middles_of_ten_node_samples_lie_between_their_corners() {
    for name in ["cylinder-quadratic.msh", "cylinder-quadratic-binary.msh"] {
        let mesh = read_sample(name);
        assert_eq!((mesh.nodes.len(), mesh.cells.len()), (247, 102));
        assert_eq!(mesh.groups["tip"].len(), 22);
        let Cells::Tet10(cells) = &mesh.cells else { panic!("expected ten nodes") };
        for n in cells {
            for (k, [i, j]) in [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]].into_iter().enumerate() {
                for d in 0..3 {
                    let [a, b, m] = [n[i], n[j], n[4 + k]].map(|v| mesh.nodes[v as usize][d]);
                    assert!((0.5 * (a + b) - m).abs() < 1e-12, "edge {i}{j}: {a} {b} {m}");
                }
            }
        }
    }
}

#[test]
fn unnamed_groups_are_called_by_their_tags() {
    let mesh = read_sample("cylinder-unnamed.msh");
    let names: Vec<&str> = mesh.groups.keys().map(String::as_str).collect();
    // Tag 1 is a surface and a volume, tag 2 only a surface.
    assert_eq!(names, ["2", "surface 1", "volume 1"]);
    assert_eq!(mesh.groups["surface 1"], read_sample("cylinder.msh").groups["clamped end"]);
}

#[test]
fn second_reader_agrees() {
    for name in ["cylinder.msh", "cylinder-binary.msh", "cylinder-quadratic.msh"] {
        let bytes = std::fs::read(sample(name)).expect("a sample");
        let other = mshio::parse_msh_bytes(&bytes).expect("a sample");
        let points: Vec<[f64; 3]> = other
            .data
            .nodes
            .iter()
            .flat_map(|n| &n.node_blocks)
            .flat_map(|b| &b.nodes)
            .map(|n| [n.x * MM, n.y * MM, n.z * MM])
            .collect();
        let mesh = read_sample(name);
        assert_eq!(mesh.nodes, points);
        let tets: Vec<Vec<u64>> = other
            .data
            .elements
            .iter()
            .flat_map(|e| &e.element_blocks)
            .filter(|b| b.entity_dim == 3)
            .flat_map(|b| &b.elements)
            .map(|e| e.nodes[..4].iter().map(|n| n - 1).collect())
            .collect();
        for (e, tet) in tets.iter().enumerate() {
            assert_eq!(mesh.cells.corners(e).map(u64::from), tet[..]);
        }
        assert_eq!(mesh.cells.len(), tets.len());
    }
}

/// A tetrahedron and a loose node whose contiguous tags are in another order than 1, 2, …
const SHUFFLED: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Comments\nby hand\n$EndComments\n\
    $Nodes\n2 5 1 5\n3 1 0 2\n5\n1\n7 7 7\n0 0 0\n3 1 0 3\n4\n2\n3\n0 0 3\n1 0 0\n0 2 0\n$EndNodes\n\
    $Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n";

#[test]
fn node_tags_are_read_and_loose_nodes_dropped() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("shuffled.msh");
    std::fs::write(&path, SHUFFLED).expect("written");
    let mesh = read_mesh(&path, 1.0).expect("a good mesh");
    assert_eq!(mesh.nodes, [[0.0; 3], [0.0, 0.0, 3.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
    assert_eq!(mesh.cells, Cells::Tet4(vec![[0, 2, 3, 1]]));
    assert_eq!(volume(&mesh), 1.0);
}

#[test]
fn written_meshes_read_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("copy.msh");
    for name in ["cylinder.msh", "cylinder-quadratic.msh"] {
        let mut mesh = read_sample(name);
        // A set that neither faces nor tetrahedra carry: written as points.
        mesh.groups.insert("odd ones".into(), vec![1, 17, 31]);
        for encoding in [MshEncoding::Ascii, MshEncoding::Binary] {
            write_mesh(&path, &mesh, MM, encoding).expect("written");
            let back = read_mesh(&path, MM).expect("read");
            assert_same(&back, &mesh);
        }
    }
    // Nothing but the file is left behind.
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1);
}

fn assert_same(a: &Mesh, b: &Mesh) {
    assert_eq!(a.cells, b.cells);
    assert_eq!(a.groups, b.groups);
    assert_eq!(a.nodes.len(), b.nodes.len());
    for (x, y) in a.nodes.iter().flatten().zip(b.nodes.iter().flatten()) {
        // Not every metre is a multiple of a millimetre in binary: the last digit may differ.
        assert!((x - y).abs() <= f64::EPSILON * y.abs(), "{x} {y}");
    }
}

#[test]
fn writer_refuses_what_cannot_be_read_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bad.msh");
    let good = read_sample("cylinder.msh");
    let refusal =
        |mesh: &Mesh, unit: f64| bad_input(write_mesh(&path, mesh, unit, MshEncoding::Ascii)).to_string();

    let mut mesh = good.clone();
    mesh.groups.insert("two\nlines".into(), vec![0]);
    assert!(refusal(&mesh, MM).contains("a name of one line"));
    let mut mesh = good.clone();
    mesh.groups.insert("far".into(), vec![50]);
    assert!(refusal(&mesh, MM).contains("group far: expected nodes below 50, got 50"));
    let mut mesh = good.clone();
    mesh.nodes[3][1] = f64::NAN;
    assert!(refusal(&mesh, MM).contains("node 3: expected finite coordinates"));
    let mut mesh = good.clone();
    mesh.cells = Cells::Tet4(vec![[0, 1, 2, 99]]);
    assert!(refusal(&mesh, MM).contains("tetrahedron 0: expected nodes below 50, got 99"));
    let mut mesh = good.clone();
    mesh.cells = Cells::Tet4(Vec::new());
    assert!(refusal(&mesh, MM).contains("expected tetrahedra, got none"));
    assert!(refusal(&good, 0.0).contains("a positive number of metres"));
    assert!(!path.exists());

    std::fs::create_dir(&path).expect("a folder in the way");
    let refusal = write_mesh(&path, &good, MM, MshEncoding::Ascii);
    assert!(matches!(refusal, Err(Error::File(_))), "{refusal:?}");
}

fn reads_without_panic(bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("odd.msh");
    std::fs::write(&path, bytes).expect("written");
    if let Ok(mesh) = read_mesh(&path, MM) {
        // The next steps check what the reader accepts.
        let _ = hysteron_fem::check_mesh(&mesh, "odd.msh");
        let _ = write_mesh(&path, &mesh, MM, MshEncoding::Binary);
        let _ = mesh.to_quadratic();
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn arbitrary_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        reads_without_panic(&bytes);
        let mut headed = b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n".to_vec();
        headed.extend(&bytes);
        reads_without_panic(&headed);
        let mut headed = b"$MeshFormat\n4.1 1 8\n\x01\0\0\0\n$EndMeshFormat\n$Elements\n".to_vec();
        headed.extend(&bytes);
        reads_without_panic(&headed);
    }

    #[test]
    fn damaged_files_never_panic(
        which in 0_usize..5,
        damage in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in proptest::option::of(any::<prop::sample::Index>()),
    ) {
        let name = ["cylinder.msh", "cylinder-binary.msh", "cylinder-parametric.msh",
            "cylinder-quadratic-binary.msh", "cylinder-format22.msh"][which];
        let mut bytes = std::fs::read(sample(name)).expect("a sample");
        for (at, value) in damage {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        reads_without_panic(&bytes);
    }

    #[test]
    fn exchanged_numbers_never_panic(at in any::<prop::sample::Index>(), number in any::<i128>(), small in -2_i128..200) {
        let text = std::fs::read_to_string(sample("cylinder.msh")).expect("a sample");
        let words: Vec<&str> = text.split(' ').collect();
        for number in [number, small, i128::from(u64::MAX), i128::from(i64::MIN)] {
            let number = number.to_string();
            let mut words = words.clone();
            let at = at.index(words.len());
            words[at] = &number;
            reads_without_panic(words.join(" ").as_bytes());
        }
    }
}

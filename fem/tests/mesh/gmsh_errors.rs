use hysteron_base::BadInput;
use hysteron_fem::read_mesh;

use super::{MM, bad_input, sample};

const GOOD: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n\
    $Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n\
    $Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n";

fn refusal(bytes: &[u8]) -> BadInput {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("part.msh");
    std::fs::write(&path, bytes).expect("written");
    let bad = bad_input(read_mesh(&path, MM));
    assert!(bad.place.contains("part.msh: "), "{bad}");
    bad
}

/// The error of the good file with one piece exchanged.
fn refusal_with(piece: &str, other: &str) -> BadInput {
    assert!(GOOD.contains(piece), "{piece}");
    refusal(GOOD.replacen(piece, other, 1).as_bytes())
}

#[test]
fn missing_file_is_bad_input() {
    let bad = bad_input(read_mesh("no/such.msh".as_ref(), MM));
    assert_eq!((bad.expected.as_str(), bad.found.as_str()), ("a file", "nothing there"));
}

#[test]
fn empty_and_cut_files_are_refused() {
    assert_eq!(refusal(b"").found, "an empty file");
    assert_eq!(refusal(b" \n\n").found, "an empty file");
    for name in ["cylinder.msh", "cylinder-binary.msh", "cylinder-quadratic-binary.msh"] {
        let whole = std::fs::read(sample(name)).expect("a sample");
        for share in 1..20 {
            let bad = refusal(&whole[..whole.len() * share / 20]);
            assert!(!bad.hint.is_empty(), "{bad}");
        }
    }
}

#[test]
fn other_files_are_refused() {
    let bad = refusal(b"solid part\n facet normal 0 0 1\n");
    assert_eq!((bad.expected.as_str(), bad.found.as_str()), ("a Gmsh mesh (.msh)", "an STL surface"));
    assert_eq!(refusal(b"some text\n").found, "`some text`");
    assert!(refusal(&[0, 159, 146, 150]).hint.contains("not a Gmsh mesh"));
}

#[test]
fn unknown_versions_are_refused_with_the_command_that_converts() {
    for version in ["3", "2.3", "4.2", "5"] {
        let bad = refusal_with("4.1 0 8", &format!("{version} 0 8"));
        assert_eq!(bad.found, format!("version {version}"));
        assert!(bad.hint.contains("gmsh old.msh -save -format msh41 -o new.msh"), "{bad}");
    }
}

#[test]
fn texts_in_utf_16_are_refused() {
    let wide: Vec<u8> = [0xfeff].into_iter().chain(GOOD.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    assert_eq!(refusal(&wide).found, "text in UTF-16");
}

#[test]
fn odd_headers_are_refused() {
    assert_eq!(refusal_with("4.1 0 8", "4.1 2 8").found, "`2`");
    assert_eq!(refusal_with("4.1 0 8", "4.1 0 3").found, "`3`");
    assert_eq!(
        refusal_with("4.1 0 8", "4.1 1 8\n12345678").expected,
        "the number 1 that marks the byte order"
    );
    assert!(refusal_with("$EndMeshFormat\n", "").expected.contains("$EndMeshFormat"));
}

#[test]
fn cells_that_are_no_tetrahedra_are_refused() {
    let bad = bad_input(read_mesh(&sample("prisms.msh"), MM));
    assert_eq!(bad.found, "a prism");
    assert!(bad.place.contains("$Elements: element"), "{bad}");
    assert_eq!(refusal_with("3 1 4 1\n1 1 2 3 4", "3 1 5 1\n1 1 2 3 4 1 2 3 4").found, "a hexahedron");
    assert_eq!(refusal_with("3 1 4 1", "3 1 29 1").found, "`$EndElements`");
    assert_eq!(refusal_with("3 1 4 1", "3 1 777 1").found, "type 777");
    assert_eq!(refusal_with("3 1 4 1", "3 1 35 1").found, "type 35, a polyhedron");
}

#[test]
fn two_kinds_of_tetrahedra_are_refused() {
    let bad = refusal_with(
        "1 1 1 1\n3 1 4 1\n1 1 2 3 4\n",
        "2 2 1 2\n3 1 4 1\n1 1 2 3 4\n3 1 11 1\n2 1 2 3 4 1 2 3 4 1 2\n",
    );
    assert_eq!(bad.found, "four-node and ten-node tetrahedra together");
}

#[test]
fn mesh_without_tetrahedra_is_refused() {
    let bad = refusal_with("3 1 4 1\n1 1 2 3 4", "2 1 2 1\n1 1 2 3");
    assert_eq!((bad.expected.as_str(), bad.found.as_str()), ("tetrahedra", "none"));
}

#[test]
fn nodes_out_of_range_twice_or_not_a_number_are_refused() {
    let bad = refusal_with("1 1 2 3 4", "1 1 2 3 9");
    assert_eq!(bad.found, "node 9");
    assert!(bad.place.ends_with("line 19"), "{bad}");
    assert_eq!(refusal_with("1\n2\n3\n4\n0", "1\n2\n2\n4\n0").found, "node 2 twice");
    let bad = refusal_with("1 0 0", "1 nan 0");
    assert_eq!((bad.expected.as_str(), bad.found.as_str()), ("finite coordinates of node 2", "NaN"));
    assert_eq!(refusal_with("1 0 0", "1 inf 0").found, "inf");
    assert_eq!(refusal_with("1 0 0", "1 O 0").found, "`O`");
}

#[test]
fn counts_that_lie_are_refused() {
    assert_eq!(refusal_with("1 4 1 4", "1 5 1 4").expected, "5 nodes");
    assert_eq!(refusal_with("1 1 1 1", "1 7 1 1").expected, "7 elements");
    let huge = u64::MAX.to_string();
    assert!(!refusal_with("3 1 0 4", &format!("3 1 0 {huge}")).found.is_empty());
    assert!(!refusal_with("1 4 1 4", &format!("{huge} 4 1 4")).found.is_empty());
    assert!(!refusal_with("1 4 1 4", "-1 4 1 4").found.is_empty());
}

#[test]
fn missing_and_doubled_sections_are_refused() {
    let nodes = &GOOD[GOOD.find("$Nodes").expect("nodes")..GOOD.find("$Elements").expect("elements")];
    let elements = &GOOD[GOOD.find("$Elements").expect("elements")..];
    assert_eq!(refusal_with(nodes, "").found, "`$Elements` before `$Nodes`");
    assert_eq!(refusal_with(elements, "").expected, "a section `$Elements`");
    assert_eq!(refusal_with(nodes, &nodes.repeat(2)).found, "a second `$Nodes`");
    assert_eq!(refusal_with(elements, &elements.repeat(2)).found, "a second `$Elements`");
}

#[test]
fn units_that_are_none_are_refused() {
    for unit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let bad = bad_input(read_mesh(&sample("cylinder.msh"), unit));
        assert_eq!(bad.expected, "a positive number of metres");
    }
    assert!(bad_input(read_mesh(&sample("cylinder.msh"), 1e308)).expected.contains("finite coordinates"));
}

//! The same mesh in every version, encoding and partitioning that Gmsh writes, and in those that it only reads.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use std::collections::{BTreeMap, BTreeSet};

use hysteron_fem::{Mesh, check_mesh, read_mesh};

use super::msh_writer::{Endian, Msh, VERSIONS, write};
use super::{MM, bad_input, read_sample, volume};

/// A point in whole picometres: text has 16 digits, of centimetres.
type Place = [i64; 3];

/// Tetrahedra and groups as sets of positions, in any order of the file.
fn canonical(mesh: &Mesh) -> (BTreeSet<Vec<Place>>, BTreeMap<String, BTreeSet<Place>>) {
    let place = |node: &u32| mesh.nodes[*node as usize].map(|x| (x * 1e12).round() as i64);
    let cells = (0..mesh.cells.len()).map(|e| mesh.cells.nodes(e).iter().map(place).collect()).collect();
    let groups = mesh.groups.iter().map(|(name, set)| (name.clone(), set.iter().map(place).collect()));
    (cells, groups.collect())
}

#[test]
fn every_version_of_gmsh_gives_the_same_mesh() {
    let rod = read_sample("rod-41.msh");
    assert_eq!((rod.nodes.len(), rod.cells.len()), (99, 229));
    let groups: Vec<(&str, usize)> = rod.groups.iter().map(|(k, v)| (k.as_str(), v.len())).collect();
    assert_eq!(groups, [("base", 8), ("body", 99), ("tip", 8)]);
    let expected = canonical(&rod);
    for name in [
        "rod-22.msh",
        "rod-22-binary.msh",
        "rod-22-ghosts.msh",
        "rod-22-binary-ghosts.msh",
        "rod-40.msh",
        "rod-40-ghosts.msh",
        "rod-41-binary.msh",
        "rod-41-bom.msh",
        "rod-41-comments.msh",
        "rod-41-partitioned.msh",
        "rod-41-binary-ghosts.msh",
    ] {
        let mesh = read_sample(name);
        check_mesh(&mesh, name).unwrap();
        assert_eq!(mesh.cells.len(), rod.cells.len(), "{name}");
        assert!(canonical(&mesh) == expected, "{name}");
    }
}

#[test]
fn version_1_has_tags_for_names() {
    let (cells, named) = canonical(&read_sample("rod-41.msh"));
    let (cells_1, tagged) = canonical(&read_sample("rod-1.msh"));
    assert!(cells_1 == cells);
    for (name, tag) in [("base", "1"), ("tip", "2"), ("body", "3")] {
        assert!(tagged[tag] == named[name]);
    }
}

#[test]
fn a_tetrahedron_in_two_groups_is_one() {
    // Version 2 writes it once for each group; version 4 once, on an entity with two groups.
    let expected = read_sample("groups-41.msh");
    assert_eq!(
        (expected.cells.len(), expected.groups["all"].len(), expected.groups["body"].len()),
        (95, 45, 45)
    );
    for name in ["groups-22-parametric.msh", "groups-22-parametric-binary.msh"] {
        let mesh = read_sample(name);
        assert_eq!(mesh.cells.len(), 95);
        assert!(canonical(&mesh) == canonical(&expected), "{name}");
    }
}

#[test]
fn every_version_and_byte_order_is_read() {
    // Gmsh 4.15 writes neither 4.0 in bytes nor big-endian files; both are in its reader.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.msh");
    let msh = Msh::example();
    let mut meshes = Vec::new();
    for version in VERSIONS {
        for endian in [None, Some(Endian::Little), Some(Endian::Big)] {
            let Some(bytes) = write(&msh, version, endian) else { continue };
            std::fs::write(&path, bytes).unwrap();
            let mesh = read_mesh(&path, MM).unwrap_or_else(|e| panic!("{version} {endian:?}: {e}"));
            assert!((volume(&mesh) - 1e-9).abs() < 1e-23, "{}", volume(&mesh));
            meshes.push((version, mesh));
        }
    }
    assert_eq!(meshes.len(), 16);
    for (version, mesh) in &meshes {
        assert_eq!((&mesh.nodes, &mesh.cells), (&meshes[0].1.nodes, &meshes[0].1.cells), "{version}");
        if *version != "1" {
            assert_eq!(mesh.groups, meshes[15].1.groups, "{version}");
        }
    }
}

#[test]
fn version_1_has_the_parameters_of_a_node_on_its_line() {
    // As Gmsh 4.15 writes them, under the name of a section without.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.msh");
    let text = String::from_utf8(write(&Msh::example(), "1", None).unwrap()).unwrap();
    let with = |tails: [&str; 8]| {
        let tail = |k: usize| if (2..10).contains(&k) { tails[k - 2] } else { "" };
        let lines = text.lines().enumerate().map(|(k, line)| format!("{line}{}\n", tail(k)));
        std::fs::write(&path, lines.collect::<String>()).unwrap();
        read_mesh(&path, MM)
    };
    let plain = with([""; 8]).unwrap();
    assert_eq!(plain.nodes.len(), 8);
    let parameters = ["0 1", "1 7 0.5", "2 3 -1.2e-15 0.25", "3 1", "", "2 1 1 2", "1 1 1e3", "0 9 "];
    assert_eq!(with(parameters).unwrap(), plain);
    let end = "the end of the line of node";
    for (wrong, expected) in [("0", end), ("1 7", end), ("0 1 2", end), ("x 1", "the dimension of an entity")]
    {
        let bad = bad_input(with(["", wrong, "", "", "", "", "", ""]));
        assert!(bad.expected.contains(expected), "{wrong}: {bad}");
    }
}

#[test]
fn a_node_that_two_partitions_list_is_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.msh");
    let mut msh = Msh::example();
    msh.nodes.push(msh.nodes[2]);
    std::fs::write(&path, write(&msh, "4.1", None).unwrap()).unwrap();
    assert_eq!(read_mesh(&path, MM).unwrap(), {
        std::fs::write(&path, write(&Msh::example(), "4.1", None).unwrap()).unwrap();
        read_mesh(&path, MM).unwrap()
    });
    if let Some((_, x)) = msh.nodes.last_mut() {
        x[0] += 1e-3;
    }
    std::fs::write(&path, write(&msh, "4.1", None).unwrap()).unwrap();
    assert_eq!(bad_input(read_mesh(&path, MM)).found, "node 3 twice");
}

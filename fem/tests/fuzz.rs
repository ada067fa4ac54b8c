//! The reader of meshes on damaged files: every version and encoding, with inconsistent structure, damage to its
//! bytes and slips in its text. `HYSTERON_FUZZ_CASES=1000000` draws so many.

#![allow(clippy::unwrap_used, reason = "a test may stop where it stands")]

#[path = "mesh/msh_writer.rs"]
mod msh_writer;

use std::time::{Duration, Instant};

use hysteron_fem::{Error, check_mesh, read_mesh};
use hysteron_fuzz::text::{slipped, slips};
use hysteron_fuzz::{assert_in_house_form, damaged, damages, drive};
use msh_writer::{Endian, Msh, VERSIONS, write};
use proptest::prelude::*;
use proptest::sample::Index;

/// Most memory of this process [bytes], and most time of a case.
const MEMORY_MAX: u64 = 256 << 20;
const TIME_MAX: Duration = Duration::from_secs(1);

/// One lie in the structure of a mesh.
#[derive(Debug, Clone)]
enum Lie {
    NodeTag(Index, u64),
    Coordinate(Index, usize, f64),
    RepeatedNode(Index),
    ElementNumber(Index, u64),
    ElementType(Index, i64),
    Group(Index, i64),
    ElementNode(Index, Index, u64),
    ElementNodes(Index, usize),
    RepeatedElement(Index),
    Name(Index, i64, String),
    Counts(i64),
    NoNodes,
    NoElements,
}

fn lie() -> impl Strategy<Value = Lie> {
    let at = any::<Index>;
    let tag = || prop_oneof![0..20_u64, Just(u64::MAX), Just(1 << 31), any::<u64>()];
    let float = prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(1e300), Just(0.0), any::<f64>()];
    let signed = || prop_oneof![-2..150_i64, any::<i32>().prop_map(i64::from)];
    prop_oneof![
        (at(), tag()).prop_map(|(at, tag)| Lie::NodeTag(at, tag)),
        (at(), 0..3_usize, float).prop_map(|(at, c, x)| Lie::Coordinate(at, c, x)),
        at().prop_map(Lie::RepeatedNode),
        (at(), tag()).prop_map(|(at, tag)| Lie::ElementNumber(at, tag)),
        (at(), signed()).prop_map(|(at, kind)| Lie::ElementType(at, kind)),
        (at(), signed()).prop_map(|(at, group)| Lie::Group(at, group)),
        (at(), at(), tag()).prop_map(|(at, node, tag)| Lie::ElementNode(at, node, tag)),
        (at(), 0..30_usize).prop_map(|(at, n)| Lie::ElementNodes(at, n)),
        at().prop_map(Lie::RepeatedElement),
        (at(), signed(), "[ -~\n\"]{0,9}").prop_map(|(at, tag, name)| Lie::Name(at, tag, name)),
        any::<i64>().prop_map(Lie::Counts),
        (-3..4_i64).prop_map(Lie::Counts),
        Just(Lie::NoNodes),
        Just(Lie::NoElements),
    ]
}

fn apply(msh: &mut Msh, lie: &Lie) {
    let (nodes, elements) = (msh.nodes.len(), msh.elements.len());
    match lie {
        Lie::NoNodes => msh.nodes.clear(),
        Lie::NoElements => msh.elements.clear(),
        Lie::Counts(by) => msh.count_error = *by,
        Lie::Name(at, tag, name) => {
            let at = at.index(msh.names.len());
            msh.names[at] = (msh.names[at].0, *tag, name.clone());
        }
        Lie::NodeTag(at, tag) if nodes > 0 => msh.nodes[at.index(nodes)].0 = *tag,
        Lie::Coordinate(at, c, x) if nodes > 0 => msh.nodes[at.index(nodes)].1[*c] = *x,
        Lie::RepeatedNode(at) if nodes > 0 => msh.nodes.push(msh.nodes[at.index(nodes)]),
        Lie::ElementNumber(at, tag) if elements > 0 => msh.elements[at.index(elements)].0 = *tag,
        Lie::ElementType(at, kind) if elements > 0 => msh.elements[at.index(elements)].1 = *kind,
        Lie::Group(at, group) if elements > 0 => msh.elements[at.index(elements)].2 = *group,
        Lie::ElementNode(at, node, tag) if elements > 0 => {
            let own = &mut msh.elements[at.index(elements)].3;
            if !own.is_empty() {
                let node = node.index(own.len());
                own[node] = *tag;
            }
        }
        Lie::ElementNodes(at, n) if elements > 0 => {
            msh.elements[at.index(elements)].3.resize(*n, 1);
        }
        Lie::RepeatedElement(at) if elements > 0 => {
            msh.elements.push(msh.elements[at.index(elements)].clone())
        }
        _ => {}
    }
}

/// Reads, and checks what was read.
fn read(path: &std::path::Path, bytes: &[u8]) {
    std::fs::write(path, bytes).unwrap();
    let start = Instant::now();
    let refusal = match read_mesh(path, 1e-3) {
        Ok(mesh) => {
            assert!(mesh.nodes.len() <= bytes.len() && mesh.cells.len() <= bytes.len());
            check_mesh(&mesh, "a.msh").err()
        }
        Err(error) => Some(error),
    };
    if let Some(error) = refusal {
        let bad = match &error {
            Error::BadInput(bad) => Some(bad),
            _ => None,
        };
        assert_in_house_form(bad, &error);
    }
    assert!(start.elapsed() < TIME_MAX, "{:?}", start.elapsed());
}

/// Version and byte order of a file, and its bytes with these lies.
fn file(which: Index, lies: &[Lie]) -> (Option<Endian>, Vec<u8>) {
    let kinds: Vec<_> = VERSIONS
        .into_iter()
        .flat_map(|version| [None, Some(Endian::Little), Some(Endian::Big)].map(|endian| (version, endian)))
        .filter(|kind| *kind != ("1", Some(Endian::Little)) && *kind != ("1", Some(Endian::Big)))
        .collect();
    let (version, endian) = kinds[which.index(kinds.len())];
    let mut msh = Msh::example();
    lies.iter().for_each(|lie| apply(&mut msh, lie));
    (endian, write(&msh, version, endian).unwrap())
}

#[test]
fn no_lie_in_a_mesh_does_harm() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.msh");
    let lies = || prop::collection::vec(lie(), 0..4);
    drive("mesh, structure", 3000, MEMORY_MAX, (any::<Index>(), lies()), |(which, lies)| {
        read(&path, &file(which, &lies).1);
    });
    drive(
        "mesh, structure and bytes",
        3000,
        MEMORY_MAX,
        (any::<Index>(), lies(), damages()),
        |(which, lies, damages)| {
            read(&path, &damaged(&file(which, &lies).1, &damages));
        },
    );
    drive("mesh, slips", 2000, MEMORY_MAX, (any::<Index>(), slips()), |(which, slips)| {
        let (endian, bytes) = file(which, &[]);
        if endian.is_none() {
            read(&path, slipped(&String::from_utf8(bytes).unwrap(), &slips).as_bytes());
        }
    });
}

#[test]
fn reading_is_linear_in_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.msh");
    // Many of each thing that a reader might look through again for every other one.
    let head = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
    let files: [fn(usize) -> String; 5] = [
        |n| "$Comments\n$EndComments\n".repeat(n),
        |n| (0..n).map(|k| format!("$A{k}\n$EndA{k}\n")).collect(),
        |n| format!("$A\n{}", "$EndB\n".repeat(n)),
        |n| format!("$Entities\n0 0 0 {n}\n{}", "1 0 0 0 0 0 0 2 1 2 0\n".repeat(n)),
        |n| {
            format!(
                "$Nodes\n{n} {n} 1 {n}\n{}",
                (1..=n).map(|k| format!("3 1 0 1\n{k}\n0 0 {k}\n")).collect::<String>()
            )
        },
    ];
    for make in files {
        for n in [1000, 100_000] {
            read(&path, format!("{head}{}", make(n)).as_bytes());
        }
    }
    // Groups that share all elements.
    let tags: String = (1..=100).map(|tag| format!("{tag} ")).collect();
    let n = 20_000;
    let elements: String = (1..=n).map(|k| format!("{k} 1 2 3 4\n")).collect();
    let many = format!(
        "{head}$Entities\n0 0 0 1\n1 0 0 0 0 0 0 100 {tags} 0\n$EndEntities\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n\
         1 0 0\n0 1 0\n0 0 1\n$EndNodes\n$Elements\n1 {n} 1 {n}\n3 1 4 {n}\n{elements}$EndElements\n",
    );
    read(&path, many.as_bytes());
}

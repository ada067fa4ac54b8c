use std::path::PathBuf;

use hysteron_fem::{check_mesh, read_mesh};
use sha2::{Digest, Sha256};

use super::MM;

fn folder(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../meshes").join(name)
}

/// Size limits of every committed mesh: nodes, and worst radius ratio.
const MESHES: [(&str, &str, usize, f64); 7] = [
    ("tpu80", "tpu80.msh", 1000, 0.25),
    ("tpu80", "tpu80-fine.msh", 5000, 0.4),
    ("tpu80", "tpu80-quadratic.msh", 6000, 0.25),
    ("tpu80", "tpu80-anchored.msh", 11000, 0.19),
    ("tentacle", "tentacle.msh", 4000, 0.6),
    ("tentacle", "tentacle-quadratic.msh", 5000, 0.5),
    ("ftdcr-v4", "ftdcr-v4.msh", 1000, 0.5),
];

#[test]
fn committed_meshes_are_good_and_listed_with_their_hash() {
    for (name, file, most_nodes, worst) in MESHES {
        let path = folder(name).join(file);
        let bytes = std::fs::read(&path).expect("a mesh");
        assert!(bytes.len() < 800_000, "{file}: {}", bytes.len());
        let hash: String = Sha256::digest(&bytes).iter().map(|b| format!("{b:02x}")).collect();
        let readme = std::fs::read_to_string(folder(name).join("README.md")).expect("a README");
        let row = readme.lines().find(|l| l.starts_with(&format!("| `{file}`"))).expect("a row");
        assert!(row.contains(&hash), "{file}: {hash}");

        let mesh = read_mesh(&path, MM).expect("good");
        let quality = check_mesh(&mesh, file).expect("good");
        assert!(mesh.nodes.len() <= most_nodes, "{file}: {}", mesh.nodes.len());
        assert!(quality.radius_ratio.min > worst, "{file}: {}", quality.radius_ratio.min);
        assert!(row.contains(&format!("| {} | {} |", quality.n_nodes, quality.n_cells)), "{row}");
        let names: Vec<&str> = mesh.groups.keys().map(String::as_str).collect();
        assert_eq!(names, ["base", "body", "tip"]);
        let top = mesh.nodes.iter().map(|x| x[2]).fold(0.0, f64::max);
        for (group, z) in [("base", 0.0), ("tip", top)] {
            let at = mesh.nodes.iter().filter(|x| x[2] == z).count();
            assert_eq!(mesh.groups[group].len(), at, "{file}: {group}");
        }
    }
}

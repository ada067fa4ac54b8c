//! Meshes, and states of a twin on one.

use hysteron_base::Scene;
use hysteron_fem::{Layers, MshEncoding, Order, Tube, check_mesh, read_mesh, write_mesh};
use hysteron_fuzz::text::{slipped, slips};
use hysteron_fuzz::{damaged, damages, drive};
use hysteron_tests::root;
use hysteron_twin::{Twin, TwinState};

use super::{Case, MEMORY_MAX, refused};

/// The bytes of a small mesh.
fn mesh(order: Order, encoding: MshEncoding) -> Vec<u8> {
    let tube = Tube {
        profile: vec![[0.0, 5e-3], [10e-3, 5e-3]],
        bore_radius: 0.0,
        channels: Vec::new(),
        outer_divisions: 4,
        bore_divisions: 4,
        channel_divisions: 4,
        layers: Layers::Count(2),
        order,
    };
    let case = Case::new("a.msh");
    write_mesh(&case.path, &tube.mesh().unwrap(), 1e-3, encoding).unwrap();
    std::fs::read(&case.path).unwrap()
}

fn read(case: &Case, bytes: &[u8]) {
    let path = case.write(bytes);
    match read_mesh(path, 1e-3) {
        Ok(mesh) => {
            assert!(mesh.nodes.len() <= bytes.len() && mesh.cells.len() <= bytes.len());
            if let Err(error) = check_mesh(&mesh, "a.msh") {
                refused(error.bad_input(), &error);
            }
        }
        Err(error) => refused(error.bad_input(), &error),
    }
}

#[test]
fn no_slip_in_a_mesh_does_harm() {
    let (case, bytes) = (Case::new("a.msh"), mesh(Order::Linear, MshEncoding::Ascii));
    let text = String::from_utf8(bytes).unwrap();
    drive("mesh, text", 2000, MEMORY_MAX, slips(), |slips| read(&case, slipped(&text, &slips).as_bytes()));
}

#[test]
fn no_damage_to_a_mesh_does_harm() {
    for order in [Order::Linear, Order::Quadratic] {
        let (case, bytes) = (Case::new("a.msh"), mesh(order, MshEncoding::Binary));
        let name = format!("mesh, binary, {order:?}");
        drive(&name, 1000, MEMORY_MAX, damages(), |damages| read(&case, &damaged(&bytes, &damages)));
    }
}

#[test]
fn no_damage_to_a_state_does_harm() {
    let scene = Scene::read(root().join("meshes/tpu80/scene-friction.toml")).unwrap();
    let twin = Twin::from_scene(&scene).unwrap();
    let case = Case::new("a.state");
    twin.rest().write(&case.path, &twin, &scene.hash, "hysteron").unwrap();
    let bytes = std::fs::read(&case.path).unwrap();
    drive("state", 1000, MEMORY_MAX, damages(), |damages| {
        let path = case.write(damaged(&bytes, &damages));
        match TwinState::read(path, &twin, &scene.hash) {
            Ok(state) => assert!(state.positions.iter().flatten().all(|x| x.is_finite())),
            Err(error) => refused(error.bad_input(), &error),
        }
    });
}

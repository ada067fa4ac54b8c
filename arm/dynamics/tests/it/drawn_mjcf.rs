//! Files of MJCF that are drawn: trees of bodies, frames and replicas with joints, shapes, meshes and constraints of all numbers,
//! and mesh files with damages. Each is read or refused in the one form of an error, soon and in little memory.

use std::path::Path;

use hysteron_arm_dynamics::*;
use hysteron_fuzz::text::{slipped, slips};
use hysteron_fuzz::{assert_in_house_form, damaged, damages, drive};
use proptest::prelude::*;
use proptest::sample::Index;
use proptest::strategy::ValueTree;

use crate::drawn_robots::MEMORY_MAX;

const NUMBERS: [&str; 14] =
    ["0", "1", "-1", "0.1", "0.3", "2", "1e-9", "1e-35", "1e9", "1e300", "nan", "-0.0", "90", ""];

/// Elements around others; A, B and C are numbers, K is that of the element.
const AROUND: [&str; 8] = [
    "<body name=\"bK\" pos=\"A 0 0.1\" gravcomp=\"B\">",
    "<body pos=\"0.1 B 0\" quat=\"1 A B C\">",
    "<body name=\"bK\" euler=\"A B C\" childclass=\"c\"><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/>",
    "<body name=\"bK\"><joint name=\"jK\" axis=\"0 1 0\"/><geom size=\"0.1\"/>",
    "<body name=\"bK\"><joint name=\"jK\" type=\"slide\" axis=\"A B 1\" range=\"A C\"/><geom type=\"box\" size=\"0.1 0.2 0.3\"/>",
    "<frame pos=\"A B C\" axisangle=\"0 0 1 A\">",
    "<frame childclass=\"c\" xyaxes=\"1 A 0 0 1 B\">",
    "<replicate count=\"A\" offset=\"B 0 0\" euler=\"0 0 C\" sep=\"_\">",
];

/// Elements with nothing within.
const ALONE: [&str; 16] = [
    "<joint name=\"jK\" type=\"hinge\" pos=\"A 0 0\" ref=\"B\" stiffness=\"C\"/>",
    "<joint name=\"jK\" springdamper=\"A B\" armature=\"C\"/>",
    "<joint name=\"jK\" class=\"c\" range=\"A B\" frictionloss=\"C\" damping=\"A\"/>",
    "<joint type=\"ball\"/>",
    "<freejoint/>",
    "<inertial pos=\"A 0 0\" mass=\"B\" diaginertia=\"1 1 C\"/>",
    "<inertial pos=\"0 0 0\" mass=\"A\" fullinertia=\"1 1 1 B C 0\"/>",
    "<geom type=\"capsule\" fromto=\"0 0 0 A B C\" size=\"A\"/>",
    "<geom type=\"cylinder\" size=\"A B\" mass=\"C\" shellinertia=\"true\"/>",
    "<geom type=\"ellipsoid\" size=\"A B C\" density=\"A\"/>",
    "<geom type=\"mesh\" mesh=\"m\" density=\"A\" pos=\"B C 0\"/>",
    "<geom type=\"mesh\" mesh=\"n\" mass=\"A\"/>",
    "<site name=\"bK\" pos=\"A B C\"/>",
    "<site name=\"sK\" zaxis=\"A B C\"/>",
    "<attach model=\"other\" prefix=\"p\"/>",
    "<wings/>",
];

/// Elements of the document.
const SECTIONS: [&str; 15] = [
    "<compiler angle=\"radian\" eulerseq=\"zyx\"/>",
    "<compiler boundmass=\"A\" boundinertia=\"B\" balanceinertia=\"true\"/>",
    "<compiler inertiafromgeom=\"true\" settotalmass=\"A\"/>",
    "<compiler inertiagrouprange=\"0 A\" autolimits=\"false\"/>",
    "<option gravity=\"A B C\"/>",
    "<option density=\"A\"/>",
    "<option><flag gravity=\"disable\" spring=\"disable\"/></option>",
    "<default><joint damping=\"A\"/><default class=\"d\"><geom density=\"B\"/></default></default>",
    "<asset><mesh name=\"n\" vertex=\"0 0 0 A 0 0 0 B 0 0 0 C\" face=\"0 2 1 0 1 3 1 2 3 0 3 2\" inertia=\"shell\"/></asset>",
    "<asset><mesh name=\"n\" vertex=\"0 0 0 1 0 0 0 1 0\" face=\"0 1 A\"/></asset>",
    "<equality><joint joint1=\"j1\" joint2=\"j2\" polycoef=\"A B 0 0 0\"/><joint joint1=\"j2\" joint2=\"j3\"/></equality>",
    "<equality><joint joint1=\"j3\" joint2=\"j1\"/><weld body1=\"b1\" active=\"false\"/></equality>",
    "<tendon><fixed name=\"t\"><joint joint=\"j1\" coef=\"A\"/><joint joint=\"j2\" coef=\"B\"/></fixed></tendon>\
     <equality><tendon tendon1=\"t\" polycoef=\"C 1 0 0 0\"/></equality>",
    "<tendon><spatial stiffness=\"A\"><site site=\"s1\"/></spatial></tendon>",
    "<actuator><position joint=\"j1\" kp=\"A\"/></actuator>",
];

/// An element in the tree: its kind, its parent element, and its numbers.
type Node = (usize, Index, [usize; 3]);

fn numbered(template: &str, k: usize, numbers: [usize; 3]) -> String {
    let mut text = String::new();
    for (at, letter) in template.char_indices() {
        let is_alone = template[at + 1..].starts_with(['"', ' ']);
        match letter {
            'A' | 'B' | 'C' if is_alone => text.push_str(NUMBERS[numbers[usize::from(letter as u8 - b'A')]]),
            'K' => text.push_str(&k.to_string()),
            _ => text.push(letter),
        }
    }
    text
}

/// The text of a tree in which each node of `around` may hold others.
fn document(sections: &[(usize, [usize; 3])], around: &[Node], alone: &[Node], nest: usize) -> String {
    let mut inner = vec![Vec::new(); around.len() + 1];
    for (k, (_, within, _)) in around.iter().enumerate() {
        // In an earlier one, or in the world.
        inner[within.index(k + 1)].push(k + 1);
    }
    let mut leaves = vec![String::new(); around.len() + 1];
    for (k, (kind, within, numbers)) in alone.iter().enumerate() {
        leaves[within.index(around.len() + 1)].push_str(&numbered(ALONE[*kind], 20 + k, *numbers));
    }
    let mut text = String::from(
        "<mujoco>\n<default><default class=\"c\"><geom type=\"box\" size=\"0.1 0.1 0.1\"/></default></default>\n<asset><mesh name=\"m\" \
         vertex=\"0 0 0 1 0 0 0 1 0 0 0 1\" face=\"0 2 1 0 1 3 1 2 3 0 3 2\"/></asset>\n",
    );
    for (kind, numbers) in sections {
        text.push_str(&numbered(SECTIONS[*kind], 0, *numbers));
        text.push('\n');
    }
    text.push_str("<worldbody>\n");
    text.push_str(&"<frame>".repeat(nest));
    // Depth first; what is `None` ends an element.
    let mut waiting = vec![Some(0_usize)];
    let mut open: Vec<&str> = Vec::new();
    while let Some(next) = waiting.pop() {
        let Some(k) = next else {
            text.push_str(open.pop().unwrap_or_default());
            continue;
        };
        if let Some((kind, _, numbers)) = k.checked_sub(1).map(|k| &around[k]) {
            text.push_str(&numbered(AROUND[*kind], k, *numbers));
            let name = AROUND[*kind];
            open.push(if name.starts_with("<body") {
                "</body>\n"
            } else if name.starts_with("<frame") {
                "</frame>\n"
            } else {
                "</replicate>\n"
            });
            waiting.push(None);
        }
        text.push_str(&leaves[k]);
        text.push('\n');
        waiting.extend(inner[k].iter().rev().map(|k| Some(*k)));
    }
    text.push_str(&"</frame>".repeat(nest));
    text + "</worldbody>\n</mujoco>\n"
}

fn drawn() -> impl Strategy<Value = String> {
    let numbers = || prop::array::uniform3(0..NUMBERS.len());
    // Most numbers are some that a robot has.
    let numbers = move || prop_oneof![5 => prop::array::uniform3(3..6_usize), 1 => numbers()];
    (
        prop::collection::vec((0..SECTIONS.len(), numbers()), 0..4),
        prop::collection::vec((0..AROUND.len(), any::<Index>(), numbers()), 1..9),
        prop::collection::vec((0..ALONE.len(), any::<Index>(), numbers()), 0..6),
        prop_oneof![19 => Just(0_usize), 1 => 0..300_usize],
    )
        .prop_map(|(sections, around, alone, nest)| document(&sections, &around, &alone, nest))
}

/// Reads a text or file and moves the robot; true where there is one.
fn moved(read: impl FnOnce(&ReadOptions) -> Result<Model, hysteron_base::BadInput>) -> bool {
    let options = ReadOptions { base: Base::Fixed, masses: Masses::Definite, arguments: Arguments::new() };
    let model = read(&options);
    match &model {
        Ok(model) => {
            let n = model.n_joints();
            let (mut data, mut ddq, still) = (Data::new(model, 0.0), vec![0.0; n], vec![0.0; n]);
            forward_dynamics(model, &mut data, [&still, &still, &still], &[], &mut ddq);
            let bodies = model.joints().iter();
            assert!(bodies.flat_map(|joint| joint.inertia.parameters()).all(f64::is_finite));
        }
        Err(bad) => assert_in_house_form(Some(bad), bad),
    }
    model.is_ok()
}

#[test]
fn no_drawn_mjcf_does_harm() {
    drive("drawn MJCF", 800, MEMORY_MAX, (drawn(), prop::option::of(slips())), |(text, slips)| {
        let text = slips.map_or(text.clone(), |slips| slipped(&text, &slips));
        moved(|options| Model::from_text_with(&text, "r.xml", None, options));
    });
}

#[test]
fn drawn_mjcf_is_often_a_robot() {
    let n_read = std::cell::Cell::new(0);
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    for _ in 0..400 {
        let text = drawn().new_tree(&mut runner).unwrap().current();
        n_read.set(n_read.get() + usize::from(moved(|o| Model::from_text_with(&text, "r.xml", None, o))));
    }
    assert!(n_read.get() > 10, "{} of 400", n_read.get());
}

/// A cube with edges of 0.2 m as binary STL, OBJ and MSH.
pub fn cube() -> [(&'static str, Vec<u8>); 3] {
    let corner = |k: usize| [k & 1, (k >> 1) & 1, (k >> 2) & 1].map(|bit| 0.2 * bit as f32);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[usize; 3]> =
        faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    let bytes = |k: usize| corner(k).map(f32::to_le_bytes).concat();
    let mut stl = vec![0; 80];
    stl.extend(12_u32.to_le_bytes());
    for triangle in &triangles {
        stl.extend([0; 12]);
        stl.extend(triangle.iter().flat_map(|k| bytes(*k)));
        stl.extend([0; 2]);
    }
    let mut obj: String = (0..8)
        .map(|k| {
            let [x, y, z] = corner(k);
            format!("v {x} {y} {z}\n")
        })
        .collect();
    obj.extend(faces.map(|face| {
        let [a, b, c, d] = face.map(|k| k + 1);
        format!("f {a}/1 {b}//2 {c}/1/2 {d}\n")
    }));
    let mut msh: Vec<u8> = [8_u32, 0, 0, 12].into_iter().flat_map(u32::to_le_bytes).collect();
    msh.extend((0..8).flat_map(bytes));
    msh.extend(triangles.iter().flatten().flat_map(|k| u32::to_le_bytes(*k as u32)));
    [("m.stl", stl), ("m.obj", obj.into_bytes()), ("m.msh", msh)]
}

/// A robot of one body, which is the mesh `file` next to it.
pub fn of_mesh(file: &str, inertia: &str) -> String {
    format!(
        "<mujoco><asset><mesh name=\"m\" file=\"{file}\" inertia=\"{inertia}\"/></asset><worldbody><body><joint/>\
         <geom type=\"mesh\" mesh=\"m\" density=\"1000\"/></body></worldbody></mujoco>"
    )
}

#[test]
fn no_damage_to_a_mesh_does_harm() {
    let (folder, files) = (tempfile::tempdir().unwrap(), cube());
    let place: &Path = folder.path();
    let fillings = ["legacy", "exact", "shell"];
    let case = (damages(), 0..files.len(), 0..fillings.len());
    drive("mesh of MJCF", 600, MEMORY_MAX, case, |(damages, file, filling)| {
        let (name, bytes) = &files[file];
        std::fs::write(place.join(name), damaged(bytes, &damages)).unwrap();
        let text = of_mesh(name, fillings[filling]);
        moved(|options| Model::from_text_with(&text, "r.xml", Some(place), options));
    });
}

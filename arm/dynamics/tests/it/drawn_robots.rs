//! Robot files that are drawn: trees, loops and chains of links with numbers of all sizes, deep nests, xacro that multiplies
//! itself. Each is read or refused in the one form of an error, soon and in little memory.

use hysteron_arm_dynamics::*;
use hysteron_fuzz::text::{slipped, slips};
use hysteron_fuzz::{assert_in_house_form, drive};
use proptest::prelude::*;
use proptest::sample::Index;

/// Most memory of this process, other tests included [bytes].
pub const MEMORY_MAX: u64 = 1_000_000_000;

const NUMBERS: [&str; 14] = [
    "0",
    "1",
    "-1",
    "0.1",
    "1e-9",
    "1e-35",
    "1e9",
    "1e300",
    "nan",
    "-0.0",
    "90",
    "",
    "${pi/2}",
    "$(arg size)",
];
const TYPES: [&str; 8] =
    ["revolute", "revolute", "continuous", "prismatic", "fixed", "floating", "planar", "hinge"];
const PARTS: [&str; 14] = [
    "<mimic joint=\"j0\" multiplier=\"2\"/>",
    "<dynamics damping=\"1\" friction=\"0.1\"/>",
    "<gazebo/>",
    "<wings/>",
    "<xacro:if value=\"${k > 2}\"><axis xyz=\"0 0 1\"/></xacro:if>",
    "<xacro:unless value=\"true\"><origin/></xacro:unless>",
    "<xacro:insert_block name=\"b\"/>",
    "<xacro:twice/>",
    "<xacro:twice n=\"${k}\"/>",
    "<xacro:property name=\"k\" value=\"${k*2}\"/>",
    "<xacro:property name=\"k\" value=\"${k + k}\" scope=\"global\"/>",
    "<xacro:include filename=\"none.xacro\"/>",
    "<xacro:property name=\"b\"><origin xyz=\"${k} 0 0\"/></xacro:property>",
    "<xacro:macro name=\"twice\" params=\"n:=${k}\"><xacro:twice/><xacro:twice/></xacro:macro>",
];

#[derive(Debug, Clone)]
struct Drawn {
    /// Of each joint: its type, parent, child and the numbers of its parts.
    joints: Vec<(usize, Index, Index, [usize; 6])>,
    /// Parts put into the joints, and into the robot.
    parts: Vec<(Index, usize)>,
    /// How a link's inertia is made of numbers.
    inertias: Vec<[usize; 4]>,
    /// Elements around everything.
    nest: usize,
}

fn robots() -> impl Strategy<Value = Drawn> {
    let n = NUMBERS.len();
    let joint = (0..TYPES.len(), any::<Index>(), any::<Index>(), prop::array::uniform6(0..n));
    (
        prop::collection::vec(joint, 0..10),
        prop::collection::vec((any::<Index>(), 0..PARTS.len()), 0..5),
        prop::collection::vec(prop::array::uniform4(0..n), 1..11),
        prop_oneof![9 => Just(0_usize), 1 => 0..300_usize],
    )
        .prop_map(|(joints, parts, inertias, nest)| Drawn { joints, parts, inertias, nest })
}

impl Drawn {
    fn text(&self) -> String {
        let n_links = self.inertias.len();
        let mut inner = vec![String::new(); self.joints.len() + 1];
        for (at, part) in &self.parts {
            let at = at.index(inner.len());
            inner[at].push_str(PARTS[*part]);
        }
        let mut text = String::from(
            "<robot name=\"r\" xmlns:xacro=\"http://ros.org/wiki/xacro\">\n<xacro:arg name=\"size\" default=\"0.5\"/>\n\
             <xacro:property name=\"k\" value=\"3\"/>\n",
        );
        text.push_str(&"<xacro:if value=\"1\">".repeat(self.nest));
        text.push_str(&inner[self.joints.len()]);
        for (k, [mass, x, i, cross]) in self.inertias.iter().enumerate() {
            let [mass, x, i, cross] = [mass, x, i, cross].map(|at| NUMBERS[*at]);
            text.push_str(&format!(
                "<link name=\"l{k}\"><inertial><origin xyz=\"{x} 0 0\"/><mass value=\"{mass}\"/><inertia ixx=\"{i}\" iyy=\"{i}\" \
                 izz=\"{i}\" ixy=\"{cross}\" ixz=\"0\" iyz=\"0\"/></inertial></link>\n"
            ));
        }
        for (k, (of, parent, child, numbers)) in self.joints.iter().enumerate() {
            let [a, b, c, d, e, f] = numbers.map(|at| NUMBERS[at]);
            // Mostly a tree.
            let child = if k + 1 < n_links { k + 1 } else { child.index(n_links) };
            let parent = parent.index(child.max(1));
            text.push_str(&format!(
                "<joint name=\"j{k}\" type=\"{}\"><parent link=\"l{parent}\"/><child link=\"l{child}\"/>{}<axis xyz=\"{a} {b} 1\"/>\
                 <origin xyz=\"{c} 0 0\" rpy=\"{d} 0 0\"/><limit lower=\"{e}\" upper=\"{f}\" effort=\"1\" velocity=\"1\"/></joint>\n",
                TYPES[*of], inner[k]
            ));
        }
        text.push_str(&"</xacro:if>".repeat(self.nest));
        text + "</robot>\n"
    }
}

fn read(text: &str) {
    let options = ReadOptions { base: Base::Fixed, masses: Masses::Definite, arguments: Arguments::new() };
    match Model::from_text_with(text, "r.urdf", None, &options) {
        Ok(model) => {
            let n = model.n_joints();
            let (mut data, mut ddq) = (Data::new(&model, 0.0), vec![0.0; n]);
            let still = vec![0.0; n];
            forward_dynamics(&model, &mut data, [&still, &still, &still], &[], &mut ddq);
            assert!(
                model.joints().iter().all(|joint| joint.inertia.parameters().iter().all(|p| p.is_finite()))
            );
        }
        Err(bad) => assert_in_house_form(Some(&bad), &bad),
    }
}

#[test]
fn no_drawn_robot_does_harm() {
    drive("drawn robot", 600, MEMORY_MAX, (robots(), prop::option::of(slips())), |(drawn, slips)| {
        let text = drawn.text();
        read(&slips.map_or(text.clone(), |slips| slipped(&text, &slips)));
    });
}

//! Models made in different ways are the same robot.

use hysteron_arm_dynamics::*;

use hysteron_arm_fixtures::robots::{assert_close, model};

#[test]
fn locked_joints_are_joints_that_do_not_move() {
    let whole = model("panda");
    let (left, right) = ("panda_finger_joint1", "panda_finger_joint2");
    let locked = whole.with_locked(&[(left, 0.02), (right, 0.03), ("panda_joint3", 0.7)]).unwrap();
    assert_eq!(locked.n_joints(), 6);
    let q = [0.1, -0.4, 0.7, -1.5, 0.3, 1.2, -0.6, 0.02, 0.03];
    let v = [0.5, 0.2, 0.0, -0.7, 1.1, -0.3, 0.9, 0.0, 0.0];
    let kept = [0, 1, 3, 4, 5, 6];
    let (q6, v6) = (kept.map(|i| q[i]), kept.map(|i| v[i]));
    let (mut data, mut tau) = (Data::new(&whole, 0.0), [0.0; 9]);
    inverse_dynamics(&whole, &mut data, [&q, &v, &[0.0; 9]], &[], &mut tau);
    let (mut data6, mut tau6) = (Data::new(&locked, 0.0), [0.0; 6]);
    inverse_dynamics(&locked, &mut data6, [&q6, &v6, &[0.0; 6]], &[], &mut tau6);
    assert_close("torques", &tau6, &kept.map(|i| tau[i]), 1e-12);
    let frame = "panda_hand_tcp";
    let there = frame_pose(&whole, &data, whole.frame(frame).unwrap());
    let here = frame_pose(&locked, &data6, locked.frame(frame).unwrap());
    assert_close("position", &here.position, &there.position, 1e-14);
    assert_close("rotation", &here.rotation.concat(), &there.rotation.concat(), 1e-14);
    assert_eq!(whole.with_locked(&[("elbow", 0.0)]).unwrap_err().found, "\"elbow\"");
    assert_eq!(whole.with_locked(&[(left, f64::NAN)]).unwrap_err().expected, "a finite coordinate");
    let all: Vec<(&str, f64)> = whole.joints().iter().map(|joint| (joint.name.as_str(), 0.0)).collect();
    assert_eq!(whole.with_locked(&all).unwrap_err().place, "locked joints");
}

#[test]
fn a_payload_is_a_force_at_its_centre_and_a_rotor_is_on_the_diagonal() {
    let bare = model("panda");
    let centre = [0.01, -0.02, 0.05];
    let loaded = bare.with_payload("panda_hand_tcp", 1.5, centre, [0.0; 6]).unwrap();
    let q = [0.1, -0.4, 0.7, -1.5, 0.3, 1.2, -0.6, 0.02, 0.03];
    let (mut data, mut weight, mut expected) = (Data::new(&bare, 0.0), [0.0; 9], [0.0; 9]);
    forward_kinematics(&bare, &mut data, &q);
    let frame = bare.frame("panda_hand_tcp").unwrap();
    let rotation = frame_pose(&bare, &data, frame).rotation;
    let arm: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| rotation[i][j] * centre[j]).sum());
    let force = [0.0, 0.0, -1.5 * 9.81];
    let torque = [arm[1] * force[2], -arm[0] * force[2], 0.0];
    let external = [ExternalForce { frame, force, torque }];
    bias_torque(&bare, &mut data, [&q, &[0.0; 9]], &external, &mut expected);
    gravity_torque(&loaded, &mut Data::new(&loaded, 0.0), &q, &mut weight);
    assert_close("weight", &weight, &expected, 1e-12);
    assert_eq!(bare.with_payload("hook", 1.0, centre, [0.0; 6]).unwrap_err().place, "frame");
    let bad = bare.with_payload("panda_hand_tcp", -1.0, centre, [0.0; 6]).unwrap_err();
    assert_eq!(bad.expected, "a mass >= 0 and finite numbers");
    let second = [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let bad = bare.with_payload("panda_hand_tcp", 1.0, centre, second).unwrap_err();
    assert_eq!(bad.expected, "an inertia without negative principal value");
    let geared = bare.with_rotor("panda_joint4", 2e-5, 100.0).unwrap();
    let (mut before, mut after) = ([0.0; 81], [0.0; 81]);
    mass_matrix(&bare, &mut data, &q, &mut before);
    mass_matrix(&geared, &mut Data::new(&geared, 0.0), &q, &mut after);
    before[9 * 3 + 3] += 0.2;
    assert_close("mass", &after, &before, 1e-14);
    assert_eq!(bare.with_rotor("panda_joint4", -1.0, 1.0).unwrap_err().place, "rotor of panda_joint4");
}

#[test]
fn built_in_robots_are_read_and_look_right() {
    for name in Model::builtin_names() {
        let model = Model::builtin(name).unwrap();
        let suspicions = model.suspicions();
        // Published as such: the hand of the Panda, and the fingers of the OpenManipulator-X without width.
        assert!(suspicions.len() <= 2, "{name}: {suspicions:?}");
    }
    let error = Model::builtin("r2d2").unwrap_err().to_string();
    assert!(error.contains("panda") && error.contains("r2d2"), "{error}");
}

#[test]
fn wrist_has_the_published_potential() {
    // Saadatzi et al. (2019), eq. 30: V = g [−m₁ c1x cos θ₁ + (m₁ c1z + m₂ c2z) sin θ₁ + m₂ cos θ₁ (c2x sin θ₂ − c2y cos θ₂)].
    let model = Model::builtin("wrist").unwrap();
    let (m1, m2, [c1x, c1z], [c2x, c2y, c2z]) =
        (2.176, 0.216, [-1.6e-3, -5.9e-3], [-48.7e-3, -4.3e-3, 53.3e-3]);
    for (a, b) in [(0.0, 0.0), (0.3, -0.4), (-0.9, 0.7), (1.2, 1.1)] {
        let (a, b): (f64, f64) = (a, b);
        let expected = 9.81
            * (-m1 * c1x * a.cos()
                + (m1 * c1z + m2 * c2z) * a.sin()
                + m2 * a.cos() * (c2x * b.sin() - c2y * b.cos()));
        let got = potential_energy(&model, &mut Data::new(&model, 0.0), &[a, b]);
        assert!((got - expected).abs() < 1e-12, "{a}, {b}: {got}, {expected}");
    }
}

/// The three-link arm as MJCF, with elements that URDF lacks.
pub const MJCF: &str = r#"<?xml version="1.0"?>
<!-- an arm -->
<mujoco model="three_link">
  <compiler angle="degree" autolimits="true"/>
  <option gravity="0 0 -9.81"/>
  <default>
    <joint axis="0 1 0" armature="0.01"/>
    <default class="far"><joint damping="0.3" frictionloss="0.2" range="-143.2394487827058 143.2394487827058"/></default>
  </default>
  <worldbody>
    <geom type="plane"/>
    <body name="link_1" childclass="far">
      <joint name="joint_1" type="hinge"/>
      <inertial pos="0 0 0.15" mass="1" diaginertia="0.0075 0.0075 0"/>
      <body name="link_2" pos="0 0 0.3">
        <joint name="joint_2" damping="0.5"/>
        <inertial pos="0 0 0.15" mass="0.8" fullinertia="0.006 0.006 0 0 0 0"/>
        <body name="link_3" pos="0 0 0.2" euler="0 0 90">
          <joint name="joint_3" axis="1 0 0" pos="0 0 0.1"/>
          <inertial pos="0 0 0.2" quat="0.7071067811865476 0 0 0.7071067811865476" mass="0.5"
            diaginertia="0.0016666666666666668 0.0016666666666666668 0"/>
          <site name="tip" pos="0 0 0.3"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>"#;

#[test]
fn mjcf_is_the_same_robot_as_urdf() {
    let (mjcf, urdf) = (Model::from_text(MJCF, "arm.xml").unwrap(), Model::builtin("three-link").unwrap());
    assert_eq!((mjcf.n_joints(), mjcf.name()), (3, "three_link"));
    let (q, v, a) = ([0.3, -0.5, 0.8], [1.0, 0.4, -0.6], [2.0, -3.0, 1.0]);
    let [mut one, mut two] = [[0.0; 3]; 2];
    let (mut with, mut without) = (Data::new(&mjcf, 0.0), Data::new(&urdf, 0.0));
    inverse_dynamics(&mjcf, &mut with, [&q, &v, &a], &[], &mut one);
    inverse_dynamics(&urdf, &mut without, [&q, &v, &a], &[], &mut two);
    // The third joint of the MJCF points along the same axis: its body is turned by 90° about z.
    let expected: Vec<f64> = two.iter().zip(&a).map(|(t, a)| t + 0.01 * a).collect();
    let third = mjcf.joints()[2].placement.rotation;
    assert!(third.iter().flatten().all(|x| x.is_finite()));
    assert_close("torques", &one, &expected, 1e-12);
    let (a, b) = (mjcf.frame("tip").unwrap(), urdf.frame("tip").unwrap());
    let there = frame_pose(&urdf, &without, b).position;
    assert_close("tip", &frame_pose(&mjcf, &with, a).position, &there, 1e-12);
    let drive = &mjcf.joints()[1].drive;
    assert_eq!((drive.armature, drive.damping, drive.dry_friction), (0.01, 0.5, 0.2));
    let [low, high] = drive.range.unwrap();
    assert!((low + 2.5).abs() < 1e-9 && (high - 2.5).abs() < 1e-9);
}

#[test]
fn mjcf_that_is_not_understood_is_refused() {
    for (from, to, place, expected) in [
        ("type=\"hinge\"", "type=\"ball\"", "line 13: joint[joint_1]", "type hinge or slide"),
        ("type=\"hinge\"", "springyield=\"3\"", "joint[joint_1]", "springyield 0"),
        ("type=\"hinge\"", "class=\"near\"", "joint[joint_1]", "a class of <default>"),
        ("type=\"hinge\"", "range=\"1 2 3\"", "joint[joint_1]", "2 finite numbers in range"),
        ("type=\"hinge\"", "range=\"2 1\"", "joint[joint_1]", "a range that ascends"),
        ("damping=\"0.5\"", "damping=\"-0.5\"", "joint[joint_2]", "damping >= 0"),
        ("mass=\"0.8\"", "mass=\"-0.8\"", "inertial", "a mass >= 0 kg"),
        ("fullinertia=\"0.006 0.006 0 0 0 0\"", "", "inertial", "diaginertia or fullinertia"),
        ("angle=\"degree\"", "angle=\"turn\"", "compiler", "angle degree or radian"),
        ("<geom type=\"plane\"/>", "<body><freejoint/></body>", "freejoint", "a base that does not move"),
        ("<worldbody>", "<include file=\"a.xml\"/><worldbody>", "include", "a robot in one text"),
        ("</worldbody>", "</worldbody><equality><weld/></equality>", "weld", "no <weld>"),
        ("joint_3", "joint_2", "joint[joint_2]", "names of joints that differ"),
        (
            "<inertial pos=\"0 0 0.15\" mass=\"1\" diaginertia=\"0.0075 0.0075 0\"/>",
            "<geom/>",
            "geom",
            "1 sizes > 0 of a sphere",
        ),
    ] {
        assert!(MJCF.contains(from), "{from}");
        let error = Model::from_text(&MJCF.replacen(from, to, 1), "arm.xml").expect_err(to).to_string();
        assert!(error.contains(place) && error.contains(expected), "{to}: {error}");
    }
    let joined = "</worldbody><equality><joint joint1=\"joint_3\" joint2=\"joint_2\" polycoef=\"0.1 2 0 0 0\"/></equality>";
    let model = Model::from_text(&MJCF.replace("</worldbody>", joined), "arm.xml").unwrap();
    let follower = model.joints()[2].follows.unwrap();
    assert_eq!((follower.joint, follower.ratio, follower.offset), (1, 2.0, 0.1));
}

#[test]
fn impossible_numbers_are_reported() {
    let text = |mass: &str, inertia: &str| {
        format!(
            r#"<robot name="r"><link name="b"/><link name="a"><inertial><mass value="{mass}"/>{inertia}</inertial></link>
            <joint name="j" type="continuous"><parent link="b"/><child link="a"/><limit effort="0"/></joint></robot>"#
        )
    };
    let inertia = |x: f64, y: f64, z: f64| {
        format!("<inertia ixx=\"{x}\" iyy=\"{y}\" izz=\"{z}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>")
    };
    for (mass, inertia, expected) in [
        ("1", inertia(1e-3, 1e-3, 5e-3), "triangle inequality"),
        ("1", inertia(0.0, 0.0, 0.0), "point mass"),
        ("1", inertia(5e3, 5e3, 5e3), "kg mm²"),
        ("1500", inertia(5.0, 5.0, 5.0), "mass in g?"),
        ("1", inertia(1e-3, 1e-3, 1e-3), "limit of torque is zero"),
    ] {
        let any = ReadOptions { masses: Masses::Any, ..ReadOptions::default() };
        let model = Model::from_text_with(&text(mass, &inertia), "r.urdf", None, &any).unwrap();
        let warnings = model.suspicions().join("\n");
        assert!(warnings.contains(expected), "{expected}: {warnings}");
    }
}

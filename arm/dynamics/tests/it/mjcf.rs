//! MJCF as MuJoCo reads it, and what is refused by name.

use std::collections::BTreeMap;
use std::path::PathBuf;

use hysteron_arm_dynamics::*;
use serde_json::Value;

use hysteron_arm_fixtures::robots::assert_close;

/// Numbers of both programs differ by rounding only.
const TOLERANCE: f64 = 1e-12;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/mjcf")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// Torques of drives: inverse dynamics and viscous damping, as MuJoCo's inverse dynamics has both.
fn torques(model: &Model, q: &[f64], dq: &[f64], ddq: &[f64]) -> Vec<f64> {
    let mut tau = vec![0.0; model.n_joints()];
    inverse_dynamics(model, &mut Data::new(model, 0.0), [q, dq, ddq], &[], &mut tau);
    for ((tau, dq), joint) in tau.iter_mut().zip(dq).zip(model.joints()) {
        *tau += joint.drive.damping * dq;
    }
    tau
}

/// One body on one hinge, with more in the document, in the body and in the joint.
fn document(around: &str, body: &str, joint: &str) -> String {
    format!(
        "<mujoco>\n{around}\n<worldbody><body name=\"l1\"><joint name=\"j1\" axis=\"0 1 0\" {joint}/>\
         <inertial pos=\"0.04 0.01 0.12\" mass=\"0.9\" diaginertia=\"0.011 0.013 0.007\"/>\n{body}</body></worldbody></mujoco>"
    )
}

fn read(around: &str, body: &str, joint: &str) -> Model {
    Model::from_mjcf(&document(around, body, joint), "r.xml").unwrap()
}

fn refusal(around: &str, body: &str, joint: &str) -> String {
    Model::from_mjcf(&document(around, body, joint), "r.xml").unwrap_err().to_string()
}

#[test]
fn files_give_the_torques_of_mujoco() {
    let text = std::fs::read_to_string(folder().join("expected.json")).unwrap();
    let expected: BTreeMap<String, Value> = serde_json::from_str(&text).unwrap();
    assert!(expected.len() >= 9, "{} files", expected.len());
    for (file, known) in &expected {
        let model = Model::read(&folder().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
        let names: Vec<&str> = model.joints().iter().map(|joint| joint.name.as_str()).collect();
        assert_eq!(Value::from(names), known["joints"], "{file}");
        for row in known["rows"].as_array().unwrap() {
            let [q, dq, ddq, tau] =
                ["q_rad", "dq_rad_s", "ddq_rad_s2", "tau_n_m"].map(|name| numbers(&row[name]));
            assert_close(file, &torques(&model, &q, &dq, &ddq), &tau, TOLERANCE);
        }
    }
}

#[test]
fn an_equality_that_is_switched_off_couples_nothing() {
    let model = Model::read(&folder().join("inactive_equality.xml")).unwrap();
    assert!(model.joints().iter().all(|joint| joint.follows.is_none()));
    let text = std::fs::read_to_string(folder().join("inactive_equality.xml")).unwrap();
    let active = Model::from_mjcf(&text.replace("active=\"false\"", ""), "r.xml").unwrap();
    assert_eq!(active.joints()[1].follows, Some(Follower { joint: 0, ratio: 1.0, offset: 0.0 }));
    for off in
        ["<option><flag equality=\"disable\"/></option>", "<option><flag constraint=\"disable\"/></option>"]
    {
        let switched =
            text.replace("active=\"false\"", "").replace("<worldbody>", &format!("{off}<worldbody>"));
        let model = Model::from_mjcf(&switched, "r.xml").unwrap();
        assert!(model.joints().iter().all(|joint| joint.follows.is_none()), "{off}");
    }
    let by_class = text.replace("active=\"false\"", "class=\"off\"").replace(
        "<worldbody>",
        "<default><default class=\"off\"><equality active=\"false\"/></default></default><worldbody>",
    );
    assert!(Model::from_mjcf(&by_class, "r.xml").unwrap().joints()[1].follows.is_none());
}

#[test]
fn what_is_not_in_the_schema_is_named_with_its_line_and_the_nearest_name() {
    for (around, body, joint, parts) in [
        ("", "", "stifness=\"1\"", &["line 3", "joint[j1]", "stifness", "\"stiffness\""][..]),
        ("<compiler angel=\"radian\"/>", "", "", &["line 2", "angel", "\"angle\""]),
        ("", "<gem size=\".1\"/>", "", &["line 4", "gem", "\"geom\""]),
        ("<actuators/>", "", "", &["line 2", "actuators", "\"actuator\""]),
        ("<default><joint damping=\"1\" colour=\"red\"/></default>", "", "", &["line 2", "colour"]),
        ("", "<composite type=\"cable\"/>", "", &["line 4", "composite", "flexcomp"]),
        ("<sensor><jointpos joint=\"j1\" what=\"3\"/></sensor>", "", "", &["line 2", "what"]),
    ] {
        let error = refusal(around, body, joint);
        assert!(parts.iter().all(|part| error.contains(part)), "{parts:?}: {error}");
    }
}

#[test]
fn what_would_change_the_robot_is_refused_by_name_and_accepted_where_it_changes_nothing() {
    for (around, body, joint, parts) in [
        ("<option density=\"1.2\"/>", "", "", &["line 2", "density"][..]),
        ("<option viscosity=\"1e-5\"/>", "", "", &["line 2", "viscosity"]),
        ("<option><flag invdiscrete=\"enable\"/></option>", "", "", &["line 2", "invdiscrete"]),
        ("<compiler coordinate=\"global\"/>", "", "", &["line 2", "coordinate"]),
        ("", "", "springyield=\"0.1\"", &["line 3", "springyield"]),
        ("", "", "stiffness=\"1 2 0\"", &["line 3", "stiffness"]),
        ("", "", "damping=\"1 0 2\"", &["line 3", "damping"]),
        ("", "", "type=\"ball\"", &["line 3", "ball", "three hinges"]),
        ("", "<body><freejoint/></body>", "", &["line 4", "free", "--fix-base"]),
        ("", "<flexcomp name=\"f\"/>", "", &["line 4", "flexcomp"]),
        ("", "<plugin plugin=\"p\"/>", "", &["line 4", "plugin"]),
        ("<actuator><motor joint=\"j1\" armature=\"1\"/></actuator>", "", "", &["line 2", "armature"]),
        (
            "<tendon><fixed stiffness=\"1\"><joint joint=\"j1\" coef=\"1\"/></fixed></tendon>",
            "",
            "",
            &["stiffness"],
        ),
        ("<equality><weld body1=\"l1\"/></equality>", "", "", &["line 2", "weld"]),
        ("<include file=\"other.xml\"/>", "", "", &["line 2", "other.xml"]),
    ] {
        let error = refusal(around, body, joint);
        assert!(parts.iter().all(|part| error.contains(part)), "{parts:?}: {error}");
    }
    let plain = read("", "", "");
    for (around, body, joint) in [
        ("<option density=\"0\" viscosity=\"0.0\" wind=\"1 2 3\" timestep=\"1\"/>", "", ""),
        ("<option><flag invdiscrete=\"disable\" contact=\"disable\" energy=\"enable\"/></option>", "", ""),
        ("<compiler coordinate=\"local\"/>", "", ""),
        ("<size njmax=\"3\"/><statistic extent=\"1\"/><visual><map zfar=\"9\"/></visual>", "", ""),
        (
            "",
            "<geom size=\".1\"/><camera/><light/>",
            "springyield=\"0\" stiffness=\"0 0 0\" solreflimit=\"1 1\"",
        ),
        ("<actuator><position joint=\"j1\" kp=\"40\" armature=\"0\"/></actuator>", "", ""),
        ("<tendon><fixed stiffness=\"0\"><joint joint=\"j1\" coef=\"1\"/></fixed></tendon>", "", ""),
        ("<equality><weld body1=\"l1\" active=\"false\"/></equality>", "", ""),
        ("<keyframe><key qpos=\"1\"/></keyframe><sensor><jointpos joint=\"j1\"/></sensor>", "", ""),
    ] {
        assert_eq!(read(around, body, joint).joints(), plain.joints(), "{around} {body} {joint}");
    }
}

#[test]
fn later_settings_win_and_classes_nest() {
    let settings = "<option gravity=\"0 0 -1\"/><option gravity=\"0 0 -2\" timestep=\"1\"/>";
    assert_eq!(read(settings, "", "").gravity(), [0.0, 0.0, -2.0]);
    let flags = "<option><flag damper=\"disable\"/></option><option><flag damper=\"enable\" spring=\"disable\"/></option>";
    let drive = read(flags, "", "damping=\"2\" stiffness=\"3\"").joints()[0].drive.clone();
    assert_eq!((drive.damping, drive.stiffness), (2.0, 0.0));
    let classes = "<default><joint damping=\"1\" armature=\"2\"/><default class=\"a\"><joint damping=\"3\"/>\
                   <default class=\"b\"><joint frictionloss=\"4\"/></default></default></default>\
                   <default><joint armature=\"5\"/></default>";
    let of = |joint: &str| {
        let drive = read(classes, "", joint).joints()[0].drive.clone();
        [drive.damping, drive.armature, drive.dry_friction]
    };
    assert_eq!(of(""), [1.0, 5.0, 0.0]);
    // What a class had from the outermost one when it was defined, as in MuJoCo.
    assert_eq!(of("class=\"a\""), [3.0, 2.0, 0.0]);
    assert_eq!(of("class=\"b\""), [3.0, 2.0, 4.0]);
    assert_eq!(of("class=\"b\" damping=\"0.5\""), [0.5, 2.0, 4.0]);
    assert!(refusal(classes, "", "class=\"c\"").contains("class"));
}

#[test]
fn replicas_are_what_their_copies_would_be() {
    let part = "<body name=\"k\"><joint name=\"r\" axis=\"1 0 0\"/><inertial pos=\".1 0 0\" mass=\".3\" \
                diaginertia=\".01 .01 .01\"/><site name=\"s\"/></body>";
    let replicas =
        format!("<replicate count=\"2\" sep=\"_\" offset=\"0 0.1 .1\" euler=\"30 20 0\">{part}</replicate>");
    let model = read("", &replicas, "");
    let names: Vec<&str> = model.joints().iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!(names, ["j1", "r_0", "r_1"]);
    assert!(model.frame("s_1").is_ok());
    let by_hand = format!(
        "{}<frame pos=\"0 0.1 .1\" euler=\"30 20 0\">{}</frame>",
        part.replace("\"k\"", "\"k_0\"").replace("\"r\"", "\"r_0\"").replace("\"s\"", "\"s_0\""),
        part.replace("\"k\"", "\"k_1\"").replace("\"r\"", "\"r_1\"").replace("\"s\"", "\"s_1\"")
    );
    assert_eq!(model, read("", &by_hand, ""));
    let nested = "<replicate count=\"2\" offset=\"0 .1 0\"><replicate count=\"10\" sep=\"-\" offset=\"1 0 0\"><site name=\"t\"/></replicate></replicate>";
    let model = read("", nested, "");
    let at = &model.frames()[model.frame("t-091").unwrap()].pose.position;
    assert_close("place", &[at[0].abs().max(at[2].abs()), 0.0], &[9.0, 0.0], 1e-12);
    for (count, part) in [("0", "count"), ("-1", "count"), ("1000000000", "at most")] {
        let error = refusal("", &format!("<replicate count=\"{count}\"/>"), "");
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn the_page_has_the_table_of_the_reader() {
    let page = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs/robot-files.md");
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.contains(&Model::mjcf_table()), "cargo run --release --example robot_torques -- --table");
}

#[test]
fn springs_and_weightless_bodies_have_the_right_gradients() {
    let tool = "<body pos=\"0 .1 .25\" gravcomp=\".7\"><joint name=\"j2\" axis=\"1 0 .3\" stiffness=\".8\" ref=\"12\" springref=\"-20\"/>\
                <geom type=\"capsule\" size=\".03 .1\" pos=\".05 0 .1\"/></body>";
    let model = read("", tool, "stiffness=\"1.5\" springref=\"10\"");
    let (q, dq, ddq) = ([0.3, -0.4], [0.7, 0.5], [-0.6, 0.9]);
    let mut data = Data::new(&model, 0.0);
    let (mut by_q, mut by_dq, mut mass) = ([0.0; 4], [0.0; 4], [0.0; 4]);
    inverse_dynamics_derivatives(&model, &mut data, [&q, &dq, &ddq], &[], [&mut by_q, &mut by_dq, &mut mass]);
    let tau = |q: &[f64]| {
        let mut tau = [0.0; 2];
        inverse_dynamics(&model, &mut Data::new(&model, 0.0), [q, &dq, &ddq], &[], &mut tau);
        tau
    };
    let accelerate = |q: &[f64]| {
        let mut found = [0.0; 2];
        forward_dynamics(&model, &mut Data::new(&model, 0.0), [q, &dq, &[0.2, -0.1]], &[], &mut found);
        found
    };
    let weights = [0.8, -1.3];
    let (mut found, mut gradient) = ([0.0; 2], Cotangent::new(&model, 0, 0.0));
    forward_dynamics(&model, &mut data, [&q, &dq, &[0.2, -0.1]], &[], &mut found);
    forward_dynamics_adjoint(&model, &mut data, &[], &weights, &mut gradient);
    // Central differences of step h err by h² and by rounding over h.
    let h = 1e-5;
    for k in 0..2 {
        let (mut more, mut less) = (q, q);
        more[k] += h;
        less[k] -= h;
        let rise = |f: &dyn Fn(&[f64]) -> [f64; 2]| {
            let (a, b) = (f(&more), f(&less));
            [(a[0] - b[0]) / (2.0 * h), (a[1] - b[1]) / (2.0 * h)]
        };
        assert_close("derivative", &[by_q[k], by_q[2 + k]], &rise(&tau), 1e-8);
        let [a, b] = rise(&accelerate);
        assert_close("adjoint", &[gradient.q[k]], &[a * weights[0] + b * weights[1]], 1e-7);
        // Torques that hold the arm still are the rise of the potential energy.
        let energy = |q: &[f64]| [potential_energy(&model, &mut Data::new(&model, 0.0), q), 0.0];
        let mut held = [0.0; 2];
        gravity_torque(&model, &mut data, &q, &mut held);
        assert_close("gravity", &[held[k]], &[rise(&energy)[0]], 1e-8);
    }
    let (mut momentum, mut rate, mut bias) = ([0.0; 2], [0.0; 2], [0.0; 2]);
    let still = [0.0; 2];
    generalized_momentum(&model, &mut data, [&q, &still], &mut momentum, &mut rate);
    bias_torque(&model, &mut data, [&q, &still], &[], &mut bias);
    assert_close("momentum", &rate, &bias.map(|x| -x), 1e-12);
    let written = Model::from_mjcf(&model.to_mjcf(), "written.xml").unwrap();
    let mut again = [0.0; 2];
    inverse_dynamics(&written, &mut Data::new(&written, 0.0), [&q, &dq, &ddq], &[], &mut again);
    assert_close("written", &again, &tau(&q), 1e-12);
}

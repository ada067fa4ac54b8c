//! Masses of MJCF by closed forms, models within others, and joints that follow.

use std::path::Path;

use hysteron_arm_dynamics::*;

use crate::drawn_mjcf::{cube, of_mesh};
use hysteron_arm_fixtures::robots::assert_close;

/// Rounding of sums over a dozen triangles; lengths of meshes are single precision, those here are exact in it or compared with it.
const TOLERANCE: f64 = 1e-12;

fn read(text: &str) -> Model {
    Model::from_mjcf(text, "r.xml").unwrap()
}

fn refusal(text: &str) -> String {
    Model::from_mjcf(text, "r.xml").unwrap_err().to_string()
}

/// Mass, first and second moments about the only joint, which turns about z: xx, xy, yy, xz, yz, zz.
fn parameters(model: &Model) -> [f64; 10] {
    model.joints()[0].inertia.parameters()
}

/// One body on a hinge about z.
fn body(settings: &str, inertial: &str) -> String {
    format!(
        "<mujoco>{settings}<worldbody><body><joint/><inertial pos=\"0 0 0\" {inertial}/></body></worldbody></mujoco>"
    )
}

#[test]
fn a_cube_weighs_the_same_in_every_file_of_a_mesh() {
    let folder = tempfile::tempdir().unwrap();
    // Its edges are single precision.
    let a = f64::from(0.2_f32);
    let m = 1000.0 * a * a * a;
    let (along, across) = (2.0 / 3.0 * m * a * a, -0.25 * m * a * a);
    let expected = [m, m * a / 2.0, m * a / 2.0, m * a / 2.0, along, across, along, across, across, along];
    for (name, bytes) in cube() {
        std::fs::write(folder.path().join(name), bytes).unwrap();
        for filling in ["legacy", "exact"] {
            let text = of_mesh(name, filling);
            let options = ReadOptions::default();
            let model = Model::from_text_with(&text, "r.xml", Some(folder.path()), &options).unwrap();
            assert_close(&format!("{name} {filling}"), &parameters(&model), &expected, TOLERANCE);
        }
        // Six faces of a²; of the moments about the corner ∫y² is 2 (a⁴/3) + a⁴ + 0 + … over the faces.
        let text = of_mesh(name, "shell");
        let model =
            Model::from_text_with(&text, "r.xml", Some(folder.path()), &ReadOptions::default()).unwrap();
        let (shell, square) = (6000.0 * a * a, 1000.0 * (4.0 / 3.0 + 1.0) * a.powi(4));
        let found = parameters(&model);
        assert_close(
            name,
            &found[..4],
            &[shell, 0.5 * shell * a, 0.5 * shell * a, 0.5 * shell * a],
            TOLERANCE,
        );
        assert_close(name, &[found[4], found[6], found[9]], &[2.0 * square; 3], TOLERANCE);
    }
}

#[test]
fn a_tetrahedron_has_the_moments_of_its_integrals() {
    let (a, b, c) = (0.25, 0.5, 1.0);
    let m = 1000.0 * a * b * c / 6.0;
    let [xx, yy, zz] = [a, b, c].map(|edge| m * edge * edge / 10.0);
    let [xy, xz, yz] = [a * b, a * c, b * c].map(|product| -m * product / 20.0);
    let expected = [m, m * a / 4.0, m * b / 4.0, m * c / 4.0, yy + zz, xy, xx + zz, xz, yz, xx + yy];
    let text = "<mujoco><asset><mesh name=\"m\" vertex=\"0 0 0 .25 0 0 0 .5 0 0 0 1\" face=\"0 2 1 0 1 3 1 2 3 0 3 2\"/></asset>\
                <worldbody><body><joint/><geom type=\"mesh\" mesh=\"m\"/></body></worldbody></mujoco>";
    assert_close("tetrahedron", &parameters(&read(text)), &expected, TOLERANCE);
}

#[test]
fn least_mass_least_inertia_and_balance_are_applied() {
    let light = "mass=\".001\" diaginertia=\".01 .02 .025\"";
    let found = parameters(&read(&body("<compiler boundmass=\".5\"/>", light)));
    assert_close("boundmass", &found, &[0.5, 0.0, 0.0, 0.0, 0.01, 0.0, 0.02, 0.0, 0.0, 0.025], TOLERANCE);
    let heavy = "mass=\"2\" diaginertia=\".01 .02 .025\"";
    assert_eq!(parameters(&read(&body("<compiler boundmass=\".5\"/>", heavy)))[0], 2.0);

    let found = parameters(&read(&body("<compiler boundinertia=\".015\"/>", heavy)));
    assert_close("boundinertia", &found[4..], &[0.015, 0.0, 0.02, 0.0, 0.0, 0.025], TOLERANCE);

    // No body has a moment that is greater than the other two together.
    let impossible = "mass=\"2\" diaginertia=\"1 1 5\"";
    let found = parameters(&read(&body("<compiler balanceinertia=\"true\"/>", impossible)));
    assert_close("balance", &found[4..], &[7.0 / 3.0, 0.0, 7.0 / 3.0, 0.0, 0.0, 7.0 / 3.0], TOLERANCE);
    let found = parameters(&read(&body("<compiler balanceinertia=\"true\"/>", heavy)));
    assert_close("balanced", &found[4..], &[0.01, 0.0, 0.02, 0.0, 0.0, 0.025], TOLERANCE);
}

const FINGERS: &str = "<body name=\"hand\" pos=\".1 0 0\"><geom size=\".05\"/>\
    <body name=\"left\" pos=\"0 .1 0\"><joint name=\"pLEFT\" type=\"slide\" axis=\"0 1 0\" ref=\".01\"/><geom size=\".02\"/></body>\
    <body name=\"right\" pos=\"0 -.1 0\"><joint name=\"pRIGHT\" type=\"slide\" axis=\"0 1 0\"/><geom size=\".02\"/></body></body>";
const FOLLOWS: &str =
    "<equality><joint joint1=\"pRIGHT\" joint2=\"pLEFT\" polycoef=\".03 -1 0 0 0\"/></equality>";

/// A hand at the end of an arm: within the file, and attached from a file of its own.
fn hands(folder: &Path) -> [Model; 2] {
    let within = FINGERS.replace("\"hand\"", "\"a_hand\"").replace("\"p", "\"a_");
    let within = within.replace("\"left\"", "\"a_left\"").replace("\"right\"", "\"a_right\"");
    let equality = FOLLOWS.replace("\"p", "\"a_");
    let arm = "<body name=\"l1\"><joint name=\"j1\" axis=\"0 1 0\"/><geom size=\".1\"/><frame pos=\"0 0 .3\" euler=\"0 30 0\">";
    let one = format!("<mujoco><worldbody>{arm}{within}</frame></body></worldbody>{equality}</mujoco>");
    let other = "<body name=\"not\"><joint name=\"lost\"/><joint name=\"gone\" type=\"slide\"/><geom size=\".1\"/></body>";
    let lost = "<equality><joint joint1=\"lost\" joint2=\"gone\"/></equality>";
    let part = format!("<mujoco><worldbody>{FINGERS}{other}</worldbody>{FOLLOWS}{lost}</mujoco>");
    std::fs::write(folder.join("part.xml"), part.replace("\"p", "\"")).unwrap();
    let two = format!(
        "<mujoco><asset><model name=\"gripper\" file=\"part.xml\"/></asset><worldbody>{arm}\
         <attach model=\"gripper\" body=\"hand\" prefix=\"a_\"/></frame></body></worldbody></mujoco>"
    );
    [one, two]
        .map(|text| Model::from_text_with(&text, "r.xml", Some(folder), &ReadOptions::default()).unwrap())
}

#[test]
fn an_attached_body_is_the_same_body_with_its_equality() {
    let folder = tempfile::tempdir().unwrap();
    let [within, attached] = hands(folder.path());
    assert_eq!(within.joints(), attached.joints());
    assert_eq!(within.frames(), attached.frames());
    let names: Vec<&str> = attached.joints().iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!(names, ["j1", "a_LEFT", "a_RIGHT"]);
    let follows = attached.joints()[2].follows.unwrap();
    // q₂ = 0.03 − (q₁ − 0.01), as its reference coordinate is 0.01.
    assert_eq!((follows.joint, follows.ratio), (1, -1.0));
    assert_close("offset", &[follows.offset], &[0.04], TOLERANCE);
}

/// Three hinges j1 to j3 in a chain, with sections of constraints.
fn chain(sections: &str) -> String {
    let link = |k: usize| {
        format!(
            "<body name=\"l{k}\" pos=\"0 0 .2\"><joint name=\"j{k}\" axis=\"0 1 0\" ref=\"{k}0\"/><geom size=\".05\"/>"
        )
    };
    let [one, two, three] = [1, 2, 3].map(link);
    format!("<mujoco><worldbody>{one}{two}{three}</body></body></body></worldbody>{sections}</mujoco>")
}

fn tendon(name: &str, [a, b]: [(&str, f64); 2]) -> String {
    let part = |(joint, coef): (&str, f64)| format!("<joint joint=\"{joint}\" coef=\"{coef}\"/>");
    format!("<fixed name=\"{name}\">{}{}</fixed>", part(a), part(b))
}

#[test]
fn equality_of_a_tendon_over_two_joints_couples_them() {
    let tendons = [
        tendon("t12", [("j1", -0.5), ("j2", 0.25)]),
        tendon("t23", [("j3", 1.0), ("j2", 3.0)]),
        tendon("t13", [("j1", 1.0), ("j3", 1.0)]),
    ]
    .concat();
    let with = |equality: &str| chain(&format!("<tendon>{tendons}</tendon><equality>{equality}</equality>"));
    let degrees = |x: f64| x.to_radians();
    let model = read(&with("<tendon tendon1=\"t12\" polycoef=\".1 1 0 0 0\"/>"));
    // −½ (q₁ − 10°) + ¼ (q₂ − 20°) = 0.1.
    let follows = model.joints()[1].follows.unwrap();
    assert_eq!((follows.joint, follows.ratio), (0, 2.0));
    assert_close("offset", &[follows.offset], &[degrees(20.0) - 2.0 * degrees(10.0) + 0.4], TOLERANCE);
    // A chain is put through to the joint that leads.
    let model = read(&with("<tendon tendon1=\"t12\"/><tendon tendon1=\"t23\"/>"));
    let follows = model.joints()[2].follows.unwrap();
    assert_eq!((follows.joint, follows.ratio), (0, -6.0));
    // Two tendons: −½ (q₁ − 10°) + ¼ (q₂ − 20°) = 2 ((q₁ − 10°) + (q₃ − 30°)) has three joints.
    let error = refusal(&with("<tendon tendon1=\"t12\" tendon2=\"t13\" polycoef=\"0 2 0 0 0\"/>"));
    assert!(error.contains("over two joints") && error.contains("active=\"false\""), "{error}");
    let error = refusal(&with("<tendon tendon1=\"t12\"/><tendon tendon1=\"t23\"/><tendon tendon1=\"t13\"/>"));
    assert!(error.contains("follow"), "{error}");
    let error = refusal(&with("<joint joint1=\"j2\" joint2=\"j1\"/><joint joint1=\"j2\" joint2=\"j3\"/>"));
    assert!(error.contains("follows one other") && error.contains("\"j2\""), "{error}");
    let error = refusal(&with("<joint joint1=\"j2\" joint2=\"j1\"/><joint joint1=\"j1\" joint2=\"j2\"/>"));
    assert!(error.contains("does not follow itself"), "{error}");
    let error = refusal(&with("<tendon tendon1=\"none\"/>"));
    assert!(error.contains("a tendon of this robot"), "{error}");
}

#[test]
fn a_weld_to_a_mocap_body_is_refused_with_a_way_out_that_works() {
    let with = |active: &str| {
        format!(
            "<mujoco><worldbody><body name=\"l1\"><joint/><geom size=\".1\"/></body><body name=\"mocap\" mocap=\"true\"/></worldbody>\
             <equality><weld body1=\"mocap\" body2=\"l1\" {active}/></equality></mujoco>"
        )
    };
    let error = refusal(&with(""));
    assert!(error.contains("mocap body drags") && error.contains("active=\"false\""), "{error}");
    assert_eq!(read(&with("active=\"false\"")).n_joints(), 1);
}

#[test]
fn a_body_and_its_site_may_have_one_name() {
    let model = read(
        "<mujoco><worldbody><body name=\"tip\"><joint/><geom size=\".1\"/><site name=\"tip\" pos=\"0 0 .1\"/></body></worldbody></mujoco>",
    );
    assert_eq!(model.frames()[model.frame("tip").unwrap()].pose.position, [0.0; 3]);
    assert_eq!(model.frames()[model.frame("tip/site").unwrap()].pose.position, [0.0, 0.0, 0.1]);
    assert!(model.notes().warnings.iter().any(|warning| warning.contains("\"tip/site\"")));
}

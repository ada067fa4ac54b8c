//! A robot that is written and read again is the same robot.

use hysteron_arm_dynamics::*;
use hysteron_base::Table;

use hysteron_arm_fixtures::robots::{assert_close, model};

/// Rounding of some twenty operations on numbers of size one, and their angles, per joint of a chain.
const ROUNDED: f64 = 1e-13;

/// A robot whose joints have armature, friction, a follower and an axis that is no axis of the file.
fn with_everything() -> Model {
    let mjcf = r#"<mujoco model="everything"><compiler angle="radian"/><option gravity="0 1 -9"/><worldbody>
        <body name="foot" pos="0 0 .1" euler=".1 .2 .3"><inertial mass="2" pos="0 0 .1" diaginertia=".1 .2 .25"/>
        <body name="a" pos=".1 0 .2" quat=".5 .5 .5 .5"><inertial mass="1" pos=".1 .2 .3" fullinertia=".1 .2 .25 .01 -.02 .03"/>
        <joint name="turn" axis="1 2 3" pos=".05 0 .02" range="-1 2" armature=".3" damping=".2" frictionloss=".1"/>
        <site name="tip" pos="0 .3 0" euler="0 1.5707963267948966 .4"/>
        <body name="b" pos="0 0 .4" euler="0 1.5707963267948966 0"><inertial mass=".5" pos="0 0 .1" diaginertia=".01 .02 .025"/>
        <joint name="slide" type="slide" axis="0 1 0" range="-.1 .1" actuatorfrcrange="-5 5"/></body>
        <body name="c" pos="0 0 -.4"><inertial mass=".5" pos="0 .1 0" diaginertia=".01 .02 .025"/>
        <joint name="finger" type="slide" axis="0 -1 0" range="-.1 .1" armature=".1"/></body>
        </body></body></worldbody><equality><joint joint1="finger" joint2="slide" polycoef=".01 -1 0 0 0"/></equality></mujoco>"#;
    Model::from_mjcf(mjcf, "everything.xml").unwrap()
}

fn assert_same_motion(a: &Model, b: &Model, armature: bool) {
    let n = a.n_joints();
    assert_eq!(n, b.n_joints());
    let state = |k: usize| -> Vec<f64> { (0..n).map(|i| (1.3 * (i + k) as f64).sin()).collect() };
    let (q, dq, ddq) = (state(1), state(2), state(3));
    let tau = |model: &Model| {
        let (mut data, mut tau) = (Data::new(model, 0.0), vec![0.0; n]);
        inverse_dynamics(model, &mut data, [&q, &dq, &ddq], &[], &mut tau);
        if !armature {
            tau.iter_mut().zip(model.joints()).zip(&ddq).for_each(|((t, j), a)| *t -= j.drive.armature * a);
        }
        tau
    };
    assert_close("torque", &tau(b), &tau(a), ROUNDED);
    let poses = |model: &Model, name: &str| {
        let mut data = Data::new(model, 0.0);
        forward_kinematics(model, &mut data, &q);
        frame_pose(model, &data, model.frame(name).unwrap())
    };
    for frame in a.frames().iter().filter(|frame| !frame.name.ends_with("/pivot") && frame.name != "world") {
        let (x, y) = (poses(a, &frame.name), poses(b, &frame.name));
        let numbers = |p: spatial::Pose<f64>| [&p.position[..], p.rotation.as_flattened()].concat();
        assert_close(&frame.name, &numbers(y), &numbers(x), ROUNDED);
    }
    for (x, y) in a.joints().iter().zip(b.joints()) {
        let drive = |joint: &Joint| {
            (joint.drive.range, joint.drive.damping, joint.drive.dry_friction, joint.drive.effort_limit)
        };
        assert_eq!(
            (&x.name, x.kind, x.parent, x.follows, drive(x)),
            (&y.name, y.kind, y.parent, y.follows, drive(y))
        );
    }
}

#[test]
fn urdf_and_mjcf_come_back_as_the_same_robot() {
    let built_in = Model::builtin_names().map(|name| Model::builtin(name).unwrap());
    for robot in built_in.chain([model("ur5"), with_everything()]) {
        let mjcf = Model::from_mjcf(&robot.to_mjcf(), "written.xml").unwrap();
        assert_same_motion(&robot, &mjcf, true);
        assert_eq!(mjcf.gravity(), robot.gravity());
        for (x, y) in robot.joints().iter().zip(mjcf.joints()) {
            assert_eq!(x.drive.armature, y.drive.armature);
        }
        // URDF has neither armature nor gravity.
        let urdf = Model::from_urdf(&robot.to_urdf().unwrap(), "written.urdf").unwrap();
        assert_same_motion(&robot, &urdf.with_gravity(robot.gravity()), false);
    }
}

#[test]
fn a_joint_that_slides_for_ever_is_no_urdf() {
    let mjcf = with_everything().to_mjcf().replacen(" limited=\"true\" range=\"-0.1 0.1\"", "", 1);
    let robot = Model::from_mjcf(&mjcf, "written.xml").unwrap();
    assert!(robot.to_urdf().unwrap_err().to_string().contains("joint slide: expected a range"));
}

fn table(text: &str) -> Table {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("parameters.csv");
    std::fs::write(&path, text).unwrap();
    Table::read(&path, None).unwrap()
}

#[test]
fn identified_parameters_replace_those_of_the_file() {
    let robot = with_everything();
    let text = robot.parameters_csv();
    assert_same_motion(&robot, &robot.with_parameters(&table(&text)).unwrap(), true);
    let heavier =
        robot.with_parameters(&table("joint,mass_kg,armature\nturn,2,0.5\nslide,1,0\nfinger,1,0\n")).unwrap();
    assert_eq!((heavier.joints()[0].inertia.mass, heavier.joints()[0].drive.armature), (2.0, 0.5));
    assert_eq!(heavier.joints()[0].drive.damping, 0.2);
    assert_eq!(heavier.joints()[0].inertia.centre(), robot.joints()[0].inertia.centre());
    for (text, part) in [
        ("joint,mass_kg\nturn,1\n", "rows: expected 3, one for each joint"),
        ("joint,mass_g\nturn,1\nslide,1\nfinger,1\n", "columns: expected joint or one of mass_kg"),
        (
            "joint,mass_kg\nturn,1\nslide,-1\nfinger,1\n",
            "line 3: mass_kg of slide: expected a finite number >= 0",
        ),
        ("joint,mass_kg\nturn,1\nslide,x\nfinger,1\n", "line 3: mass_kg of slide"),
        (
            "joint,ixx_kg_m2\nturn,-1\nslide,1\nfinger,1\n",
            "line 2: inertia of turn: expected an inertia without negative",
        ),
    ] {
        let error = robot.with_parameters(&table(text)).unwrap_err().to_string();
        assert!(error.contains(part), "{part:?} in {error}");
    }
}

#[test]
fn joints_of_mjcf_stand_alone() {
    let text = with_everything().to_mjcf_joints();
    assert_eq!(text.lines().count(), 3);
    assert!(text.starts_with("<joint name=\"turn\" type=\"hinge\" limited=\"true\" range=\"-1 2\" armature=\"0.3\" damping=\"0.2\" frictionloss=\"0.1\"/>"), "{text}");
}

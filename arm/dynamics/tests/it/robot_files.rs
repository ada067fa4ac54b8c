//! Robot files as people have them: what is read compared with the values of Pinocchio, what is held, ignored
//! or refused.

use hysteron_arm_dynamics::*;

use hysteron_arm_fixtures::robots::robot_file;

fn read(text: &str, options: &ReadOptions) -> Model {
    Model::from_text_with(text, "r.urdf", None, options).unwrap()
}

fn refusal(text: &str) -> String {
    Model::from_urdf(text, "r.urdf").expect_err("accepted").to_string()
}

const FIXED: ReadOptions =
    ReadOptions { base: Base::Fixed, masses: Masses::Definite, arguments: Arguments::new() };
const ANY: ReadOptions =
    ReadOptions { base: Base::AsInFile, masses: Masses::Any, arguments: Arguments::new() };

#[test]
fn a_robot_that_floats_is_held_where_that_is_asked_for() {
    let floating = robot_file("floating_base.urdf");
    let error = refusal(&floating);
    assert!(error.contains("joint[f]") && error.contains("which is floating"), "{error}");
    assert!(error.contains("--fix-base"), "{error}");
    let model = read(&floating, &FIXED);
    assert_eq!((model.n_joints(), model.notes().welded.len()), (1, 1));
    assert_eq!((&*model.notes().welded[0].name, &*model.notes().welded[0].kind), ("f", "floating"));
    let fixed = Model::from_urdf(&floating.replace("floating", "fixed"), "r.urdf").unwrap();
    assert_eq!((fixed.joints(), fixed.frames()), (model.joints(), model.frames()));
    let planar = floating.replace("floating", "planar");
    assert!(refusal(&planar).contains("which is planar") && read(&planar, &FIXED).n_joints() == 1);
    // A robot that does not float is the same.
    assert_eq!(
        read(&robot_file("hinge_slide.urdf"), &FIXED),
        read(&robot_file("hinge_slide.urdf"), &ReadOptions::default())
    );
}

#[test]
fn only_what_determines_no_acceleration_needs_mass() {
    let between = robot_file("massless_between.urdf");
    // Both axes the same: nothing resists the first joint.
    let parallel =
        between.replace("0 0 1\"/><limit", "0 1 0\"/><limit").replace("xyz=\"0 0 0.1\"", "xyz=\"0 0 0\"");
    let error = refusal(&parallel);
    assert!(error.contains("link[l") && error.contains("no mass on it that resists"), "{error}");
    let model = read(&parallel, &ANY);
    let (mut data, mut tau) = (Data::new(&model, 0.0), [0.0_f64; 2]);
    inverse_dynamics(&model, &mut data, [&[0.1, 0.2], &[0.0; 2], &[1.0, 1.0]], &[], &mut tau);
    assert!(tau.iter().all(|tau| tau.is_finite()) && tau[1] != 0.0);
    // A point mass on the axis of the last joint.
    let point = between.replace("xyz=\"0 1 0\"", "xyz=\"0 0 1\"").replace(
        "ixx=\"0.002\" ixy=\"0\" ixz=\"0\" iyy=\"0.002\" iyz=\"0\" izz=\"0.001\"",
        "ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"",
    );
    assert!(refusal(&point).contains("masses on its axis alone"), "{}", refusal(&point));
}

#[test]
fn a_tensor_is_measured_against_what_its_mass_can_have() {
    let hinge = robot_file("hinge_slide.urdf");
    let tensor = "ixx=\"0.002\" ixy=\"0\" ixz=\"0\" iyy=\"0.002\" iyz=\"0\" izz=\"0.001\"";
    let with = |link: usize, other: &str| {
        let parts: Vec<&str> = hinge.split(tensor).collect();
        let mut all = String::new();
        for (k, part) in parts.iter().enumerate() {
            all.push_str(part);
            if k + 1 < parts.len() {
                all.push_str(if k == link { other } else { tensor });
            }
        }
        all
    };
    let rounded = "ixx=\"0\" ixy=\"0\" ixz=\"2.4e-35\" iyy=\"0\" iyz=\"0\" izz=\"0\"";
    let wrong = "ixx=\"1e-5\" ixy=\"3e-5\" ixz=\"0\" iyy=\"1e-5\" iyz=\"0\" izz=\"1e-5\"";
    assert_eq!(read(&with(2, rounded), &ReadOptions::default()).n_joints(), 2);
    assert!(refusal(&with(2, wrong)).contains("inertia of link[l2]"));
    // The base does not move: its tensor has no effect.
    let model = read(&with(0, wrong), &ReadOptions::default());
    assert!(
        model.notes().warnings[0].contains("link[b]") && model.notes().warnings[0].contains("does not move")
    );
}

#[test]
fn limits_that_are_degrees_are_suspected() {
    let hinge = robot_file("hinge_slide.urdf");
    let model = read(
        &hinge.replace("lower=\"-1.5\" upper=\"1.5\"", "lower=\"-90\" upper=\"90\""),
        &ReadOptions::default(),
    );
    let warning = &model.notes().warnings[0];
    assert!(warning.contains("j1: limits -90 and 90 rad") && warning.contains("1.5708"), "{warning}");
    assert!(read(&hinge, &ReadOptions::default()).notes().warnings.is_empty());
    let turns = hinge.replace("lower=\"-1.5\" upper=\"1.5\"", "lower=\"-6.2832\" upper=\"6.2832\"");
    assert!(read(&turns, &ReadOptions::default()).notes().warnings.is_empty());
}

#[test]
fn what_is_no_urdf_is_named_once_and_slips_are_refused() {
    let hinge = robot_file("hinge_slide.urdf");
    let with = |more: &str| hinge.replace("</robot>", &format!("{more}</robot>"));
    let silent = "<gazebo reference=\"l1\"><x/></gazebo><transmission/><material name=\"m\"/>";
    assert!(read(&with(silent), &ReadOptions::default()).notes().warnings.is_empty());
    let unknown = read(&with("\n<wings/><wings/><wheel/>"), &ReadOptions::default());
    assert_eq!(unknown.notes().warnings.len(), 2);
    assert_eq!(unknown.notes().warnings[0], "r.urdf: line 8: <wings> within <robot> is not in URDF: ignored");
    for (from, to, named) in [
        (
            "<inertial><origin xyz=\"0 0 0\"/>",
            "<inertal><origin xyz=\"0 0 0\"/></inertal><inertial>",
            "inertal",
        ),
        ("lower=\"-1.5\"", "lowr=\"-1.5\"", "attribute lower"),
        ("<axis xyz=\"1 0 0\"/>", "<Axis xyz=\"1 0 0\"/>", "<axis>"),
        ("</robot>", "<macro name=\"m\"/></robot>", "<xacro:macro>"),
        ("</robot>", "<include filename=\"m\"/></robot>", "<xacro:include>"),
    ] {
        let error = refusal(&hinge.replacen(from, to, 1));
        assert!(error.contains(named), "{error}");
    }
}

/// The time grows with the file, not with its square: minutes, were it otherwise.
#[test]
fn large_files_are_read_or_refused_at_once() {
    let start = std::time::Instant::now();
    let mut text = robot_file("hinge_slide.urdf").replace("</robot>", "");
    for k in 0..20_000 {
        text.push_str(&format!(
            "<link name=\"x{k}\"/>\n<joint name=\"x{k}\" type=\"fixed\"><parent link=\"l2\"/><child link=\"x{k}\"/></joint>\n"
        ));
    }
    text.push_str("</robot>");
    let model = read(&text, &ReadOptions::default());
    assert_eq!(model.frames().len(), 20_003);
    assert!(model.frame("none").unwrap_err().to_string().len() < 5000);
    let chain = text.replace("type=\"fixed\"", "type=\"continuous\"");
    assert!(refusal(&chain).contains("1 to 64 joints that move, got 20002"));
    let attributes: String = (0..40_000).map(|k| format!(" a{k}=\"\"")).collect();
    assert!(refusal(&format!("<robot{attributes}/>")).contains("at most 128 attributes"));
    let spaces: String = (0..2000).map(|k| format!("<a xmlns:a{k}=\"{k}\">")).collect();
    assert!(refusal(&format!("<robot>{spaces}</robot>")).contains("expected at most"));
    assert!(start.elapsed().as_secs_f64() < 20.0, "{:?}", start.elapsed());
}

#[test]
fn the_page_on_robot_files_describes_the_reader_of_urdf() {
    let page =
        std::fs::read_to_string(format!("{}/../../docs/robot-files.md", env!("CARGO_MANIFEST_DIR"))).unwrap();
    for row in Model::urdf_table().lines() {
        assert!(page.contains(row), "{row}");
    }
}

/// An implausible number is refused with its place and the range.
#[test]
fn numbers_beyond_belief_are_refused() {
    let hinge = robot_file("hinge_slide.urdf");
    for (from, to, range) in [
        ("<origin xyz=\"0 0 0.1\"/>", "<origin xyz=\"0 0 1e300\"/>", "at most 1000 m"),
        ("<origin xyz=\"0 0 0.05\"/>", "<origin xyz=\"0 0 1e300\"/>", "at most 1000 m"),
        ("<mass value=\"0.5\"/>", "<mass value=\"1e9\"/>", "at most 1000000 kg"),
        ("izz=\"0.001\"", "izz=\"1e12\"", "at most 10000000 kg m²"),
        ("lower=\"-0.2\"", "lower=\"-1e300\"", "at most 1000 m"),
        (
            "<axis xyz=\"1 0 0\"/>",
            "<axis xyz=\"1 0 0\"/><dynamics damping=\"1e200\"/>",
            "at most 10000000 N m s/rad",
        ),
    ] {
        let error = refusal(&hinge.replacen(from, to, 1));
        assert!(error.contains(range) && error.contains("line "), "{error}");
    }
}

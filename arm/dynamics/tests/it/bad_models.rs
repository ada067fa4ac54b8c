//! Files that describe no arm.

use hysteron_arm_dynamics::Model;
use proptest::prelude::*;

use hysteron_arm_fixtures::robots::file;

/// Two links, a revolute joint; every part can be replaced.
fn robot(link: &str, joint: &str) -> String {
    format!(
        r#"<robot name="r"><link name="base"/><link name="arm">{link}</link>
        <joint name="j" type="revolute"><parent link="base"/><child link="arm"/>{joint}</joint></robot>"#
    )
}

const BODY: &str =
    r#"<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>"#;
const LIMIT: &str = r#"<limit lower="-1" upper="1" effort="1" velocity="1"/>"#;

fn refused(text: &str, place: &str, expected: &str) {
    let error = Model::from_urdf(text, "r.urdf").expect_err("accepted").to_string();
    assert!(error.contains(place) && error.contains(expected), "{error}");
}

#[test]
fn a_whole_robot_is_read() {
    let model = Model::from_urdf(&robot(BODY, LIMIT), "r.urdf").unwrap();
    assert_eq!((model.n_joints(), model.frames().len(), model.name()), (1, 2, "r"));
}

#[test]
fn what_is_no_xml_is_refused_with_its_line() {
    refused("", "r.urdf: line 1", "XML");
    refused("hello", "r.urdf: line 1", "XML");
    refused("<robot>\n<link name=\"a\">\n</robot>", "line 3", "XML");
    refused("<mujoco/>", "r.urdf: line 1: mujoco", "<robot>");
    refused("<!DOCTYPE x [<!ENTITY a \"b\">]><robot/>", "r.urdf", "XML");
    refused(&"<a>".repeat(100_000), "r.urdf", "within each other");
    refused(&"x".repeat(10 << 20), "r.urdf: line 1", "XML");
    refused(&"<a/>".repeat(1 << 20), "r.urdf", "XML");
    refused(&" ".repeat(17 << 20), "r.urdf", "at most 16 MB");
}

#[test]
fn masses_and_inertias_are_checked() {
    refused(&robot("", LIMIT), "link[arm]", "an <inertial> with a mass, because joint \"j\"");
    let zero = BODY.replace("=\"1\"", "=\"0\"");
    refused(&robot(&zero, LIMIT), "link[arm]", "no mass on it");
    for (from, to, place, expected) in [
        ("mass value=\"1\"", "mass value=\"-1\"", "mass of link[arm]", "a mass >= 0 kg"),
        ("mass value=\"1\"", "mass value=\"one\"", "line 1: mass", "finite numbers in value"),
        ("mass value=\"1\"", "mass value=\"NaN\"", "line 1: mass", "finite numbers in value"),
        ("mass value=\"1\"", "mass", "line 1: mass", "an attribute value"),
        ("<mass value=\"1\"/>", "", "line 1: inertial", "a <mass>"),
        ("izz=\"1\" ", "", "line 1: inertia", "an attribute izz"),
        ("izz=\"1\"", "izz=\"-1\"", "inertia of link[arm]", "without negative principal value"),
        ("ixy=\"0\"", "ixy=\"5\"", "inertia of link[arm]", "without negative principal value"),
        ("<mass", "<mass value=\"1\"/><mass", "line 1: inertial", "one <mass>"),
    ] {
        refused(&robot(&BODY.replace(from, to), LIMIT), place, expected);
    }
}

#[test]
fn joints_are_checked() {
    refused(&robot(BODY, ""), "joint[j]", "a <limit> with lower");
    for (from, to, place, expected) in [
        ("revolute", "floating", "r.urdf", "1 to 64 joints that move"),
        ("revolute", "hinge", "joint[j]", "type fixed, revolute, continuous or prismatic"),
        ("revolute", "fixed", "r.urdf", "1 to 64 joints that move"),
        ("type=\"revolute\"", "", "joint[j]", "an attribute type"),
        ("lower=\"-1\"", "lower=\"2\"", "joint[j]", "lower <= upper"),
        ("velocity=\"1\"", "velocity=\"-1\"", "limit", "velocity >= 0"),
        ("child link=\"arm\"", "child link=\"leg\"", "child", "a link of this robot"),
        ("<parent link=\"base\"/>", "", "joint[j]", "a <parent link=…>"),
        ("<limit", "<axis xyz=\"0 0 0\"/><limit", "axis", "an axis longer than zero"),
        ("<limit", "<axis xyz=\"0 1\"/><limit", "axis", "3 numbers in xyz"),
        ("<limit", "<mimic joint=\"k\"/><limit", "joint[j]", "mimic of a joint that moves"),
        ("<limit", "<mimic joint=\"j\"/><limit", "joint[j]", "follows none itself"),
        ("<limit", "<dynamics damping=\"-1\"/><limit", "dynamics", "damping >= 0"),
    ] {
        refused(&robot(BODY, LIMIT).replace(from, to), place, expected);
    }
}

/// As in the KUKA LWR4+'s file that comes with its recordings: a joint with two origins.
#[test]
fn elements_that_stand_twice_are_named_with_both_lines() {
    let twice = "<origin xyz=\"0 0 1\"/>\n<origin xyz=\"0 0 2\"/>\n<limit";
    let error = Model::from_urdf(&robot(BODY, LIMIT).replace("<limit", twice), "r.urdf").unwrap_err();
    let text = error.to_string();
    assert!(text.contains("joint[j]") && text.contains("one <origin>"), "{text}");
    assert!(text.contains("a second one in line") && text.contains("take the first"), "{text}");
    refused(&robot(BODY, &format!("{LIMIT}{LIMIT}")), "joint[j]", "one <limit>");
}

#[test]
fn trees_are_checked() {
    let fixed = |name: &str, from: &str, to: &str| {
        format!(
            "<joint name=\"{name}\" type=\"fixed\"><parent link=\"{from}\"/><child link=\"{to}\"/></joint></robot>"
        )
    };
    let with = |more: &str| robot(BODY, LIMIT).replace("</robot>", more);
    refused(&with(&fixed("k", "arm", "base")), "link[base]", "closed loop");
    refused(&with(&fixed("k", "base", "arm")), "joint[k]", "a link has one parent");
    refused(&with("<link name=\"arm\"/></robot>"), "link[arm]", "\"arm\" twice");
    refused(&with("<link name=\"tool\"/></robot>"), "r.urdf", "one link without parent");
    let tool = format!("<link name=\"tool\"/>{}", fixed("j", "arm", "tool"));
    refused(&with(&tool), "joint[j]", "\"j\" twice");
    let ring = format!(
        "<link name=\"a\"/><link name=\"b\"/>{}",
        fixed("k", "a", "b").replace("</robot>", "") + &fixed("l", "b", "a")
    );
    refused(&with(&ring), "link[a]", "closed loop");
    refused("<robot/>", "r.urdf", "links");
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let error = Model::read(std::path::Path::new("none.urdf")).unwrap_err().to_string();
    assert!(error.contains("none.urdf"), "{error}");
}

proptest! {
    /// A robot with a part of its text cut out, doubled or replaced is read or refused, and nothing else.
    #[test]
    fn no_text_makes_the_reader_panic(from in 0_usize..4000, length in 0_usize..60, with in "[ -~]{0,12}") {
        let mut text = std::fs::read_to_string(file("so101")).unwrap();
        let from = from.min(text.len());
        let to = (from + length).min(text.len());
        prop_assume!(text.is_char_boundary(from) && text.is_char_boundary(to));
        text.replace_range(from..to, &with);
        let _ = Model::from_urdf(&text, "r.urdf");
    }

    /// The same of MJCF.
    #[test]
    fn no_text_makes_the_reader_of_mjcf_panic(from in 0_usize..4000, length in 0_usize..60, with in "[ -~]{0,12}") {
        let mut text = crate::models::MJCF.to_owned();
        let from = from % text.len();
        let to = (from + length).min(text.len());
        prop_assume!(text.is_char_boundary(from) && text.is_char_boundary(to));
        text.replace_range(from..to, &with);
        let _ = Model::from_text(&text, "r.xml");
    }
}

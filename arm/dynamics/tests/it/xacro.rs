//! xacro: what it expands to, what is refused, and that nothing of it runs for ever.

use hysteron_arm_dynamics::*;

const HEAD: &str = "<robot name=\"r\" xmlns:xacro=\"http://ros.org/wiki/xacro\">\n";

fn expand(text: &str, arguments: &[(&str, &str)]) -> Result<Model, String> {
    let arguments = arguments.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
    let options = ReadOptions { arguments, ..ReadOptions::default() };
    Model::from_text_with(&format!("{HEAD}{text}</robot>"), "r.xacro", None, &options)
        .map_err(|bad| bad.to_string())
}

const ARM: &str = r#"
<xacro:property name="length" value="0.4"/>
<xacro:property name="mass" value="${2 * length + base_mass}"/>
<xacro:property name="base_mass" value="1.2"/>
<xacro:arg name="sides" default="left right"/>
<xacro:arg name="tool" default="false"/>
<xacro:property name="still"><origin xyz="0 0 ${length/2}"/></xacro:property>
<xacro:macro name="body" params="name m:=${mass} *place"><link name="${name}"><inertial>
  <xacro:insert_block name="place"/><mass value="${m}"/>
  <inertia ixx="${m*length**2/12}" iyy="${m*length**2/12}" izz="1e-3" ixy="0" ixz="0" iyz="0"/>
</inertial></link></xacro:macro>
<xacro:macro name="hinge" params="name parent child axis:='0 1 0' **more">
  <joint name="${name}_joint" type="revolute"><parent link="${parent}"/><child link="${child}"/>
  <axis xyz="${axis}"/><limit lower="${-pi/2}" upper="${radians(90)}" effort="1" velocity="1"/>
  <xacro:insert_block name="more"/></joint></xacro:macro>
<link name="base"/>
<xacro:macro name="side" params="side y">
  <xacro:body name="${side}_1"><xacro:insert_block name="still"/></xacro:body>
  <xacro:hinge name="${side}" parent="base" child="${side}_1" axis="0 0 1"><more><origin xyz="0 ${y} 0"/></more></xacro:hinge>
</xacro:macro>
<xacro:side side="left" y="0.1"/><xacro:side side="right" y="${-0.1}"/>
<xacro:if value="$(arg tool)"><link name="tool"/><joint name="t" type="fixed"><parent link="left_1"/><child link="tool"/></joint></xacro:if>
<xacro:unless value="${length > 1}"><link name="short"/><joint name="s" type="fixed"><parent link="base"/><child link="short"/></joint></xacro:unless>
"#;

#[test]
fn a_robot_of_macros_is_that_robot() {
    // A block property is inserted with its content, a block parameter as it is given.
    let text = ARM.replace("<xacro:insert_block name=\"still\"/>", "<origin xyz=\"0 0 ${length/2}\"/>");
    let model = expand(&text, &[]).unwrap();
    assert_eq!(model.n_joints(), 2);
    let [left, right] = ["left_joint", "right_joint"].map(|name| &model.joints()[model.joint(name).unwrap()]);
    assert_eq!(left.drive.range, Some([-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2]));
    assert_eq!((left.placement.position, right.placement.position), ([0.0, 0.1, 0.0], [0.0, -0.1, 0.0]));
    assert!((left.inertia.mass - 2.0).abs() < 1e-15);
    assert!((left.inertia.centre()[2] - 0.2).abs() < 1e-15);
    assert_eq!(model.frame("tool").unwrap_err().found, "\"tool\"");
    assert!(model.frame("short").is_ok());
    assert!(expand(&text, &[("tool", "true")]).unwrap().frame("tool").is_ok());
    let error = expand(&text, &[("tol", "true")]).unwrap_err();
    assert!(error.contains("--arg") && error.contains("sides, tool"), "{error}");
}

const BODY: &str = r#"<link name="a"/><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="continuous"><parent link="a"/><child link="b"/><origin xyz="0 0 X"/></joint>"#;

#[test]
fn what_cannot_be_expanded_is_refused_with_its_line() {
    for (text, named) in [
        ("<xacro:part/>", "<xacro:part>"),
        ("<link name=\"${missing}\"/>", "missing"),
        ("<link name=\"$(arg side)\"/>", "--arg side=VALUE"),
        ("<link name=\"$(env HOME)\"/>", "$(env HOME)"),
        ("<link name=\"${load_yaml('x')}\"/>", "load_yaml"),
        ("<xacro:include filename=\"$(find other)/a.xacro\"/>", "$(find other)"),
        ("<xacro:include filename=\"a.xacro\"/>", "without a folder"),
        ("<xacro:call macro=\"m\"/>", "<xacro:call>"),
        (
            "<xacro:property name=\"a\" value=\"${b}\"/><xacro:property name=\"b\" value=\"${a}\"/><link name=\"${a}\"/>",
            "defined by itself",
        ),
        ("<xacro:macro name=\"m\" params=\"a\"/><xacro:m/>", "the parameter a"),
        ("<xacro:macro name=\"m\" params=\"a\"/><xacro:m a=\"1\" b=\"2\"/>", "\"b\""),
        ("<xacro:if value=\"perhaps\"><link name=\"a\"/></xacro:if>", "true, false or a number"),
        ("<xacro:insert_block name=\"none\"/>", "a block of this name"),
        ("<link name=\"${1\"/>", "without its \"}\""),
    ] {
        let error = expand(&format!("{BODY}\n\n{text}").replace("0 0 X", "0 0 1"), &[]).expect_err(text);
        assert!(error.contains("r.xacro: line 5") && error.contains(named), "{text}: {error}");
    }
    // Nothing depends on what a robot looks like.
    let visual = "<link name=\"c\"><visual><geometry><mesh filename=\"$(find other)/x.stl\"/></geometry></visual></link>\
        <joint name=\"f\" type=\"fixed\"><parent link=\"b\"/><child link=\"c\"/></joint>";
    let model = expand(&format!("{BODY}{visual}").replace("0 0 X", "0 0 ${1/4}"), &[]).unwrap();
    assert_eq!(model.joints()[0].placement.position, [0.0, 0.0, 0.25]);
}

#[test]
fn files_are_included_from_their_folder() {
    let folder = tempfile::tempdir().unwrap();
    let package = folder.path().join("my_arm");
    std::fs::create_dir_all(package.join("urdf")).unwrap();
    let macros = format!("{HEAD}<xacro:property name=\"height\" value=\"0.5\"/></robot>");
    std::fs::write(package.join("macros.xacro"), macros).unwrap();
    for include in ["../macros.xacro", "$(find my_arm)/macros.xacro"] {
        let path = package.join("urdf/arm.urdf.xacro");
        let text = format!(
            "{HEAD}<xacro:include filename=\"{include}\"/>{}</robot>",
            BODY.replace('X', "${height}")
        );
        std::fs::write(&path, text).unwrap();
        assert_eq!(Model::read(&path).unwrap().joints()[0].placement.position, [0.0, 0.0, 0.5]);
    }
    let path = package.join("itself.xacro");
    std::fs::write(&path, format!("{HEAD}<xacro:include filename=\"itself.xacro\"/></robot>")).unwrap();
    let error = Model::read(&path).unwrap_err().to_string();
    assert!(error.contains("levels"), "{error}");
}

#[test]
fn nothing_runs_for_ever() {
    let start = std::time::Instant::now();
    let mut doubles = String::from("<xacro:property name=\"p0\" value=\"xxxxxxxxxxxxxxxx\"/>");
    for k in 1..60 {
        let before = k - 1;
        doubles.push_str(&format!("<xacro:property name=\"p{k}\" value=\"${{p{before}}}${{p{before}}}\"/>"));
    }
    let mut calls = String::from("<xacro:macro name=\"m0\" params=\"\"><link name=\"l\"/></xacro:macro>");
    for k in 1..60 {
        let before = format!("<xacro:m{}/>", k - 1);
        calls.push_str(&format!("<xacro:macro name=\"m{k}\" params=\"\">{before}{before}</xacro:macro>"));
    }
    let nested = format!("{}1{}", "(1 if ".repeat(60), " else 2)".repeat(60));
    for text in [
        format!("{doubles}<link name=\"${{p59}}\"/>"),
        format!("{calls}<xacro:m59/>"),
        "<xacro:macro name=\"m\" params=\"\"><xacro:m/></xacro:macro><xacro:m/>".to_owned(),
        format!("<link name=\"${{{nested}}}\"/>"),
        format!("<link name=\"${{{}}}\"/>", "1+".repeat(100_000)),
        format!("<link name=\"${{{}}}\"/>", "[1]+".repeat(20_000) + "[1]"),
    ] {
        expand(&text, &[]).expect_err(&text[..60]);
    }
    assert!(start.elapsed().as_secs_f64() < 30.0, "{:?}", start.elapsed());
}

//! Robot files: every bound rejects.

use super::super::VirtualRobot;

fn rejected(from: &str, to: &str) -> String {
    let text = include_str!("../../../presets/typical.toml");
    assert!(text.contains(from), "{from}");
    let error = VirtualRobot::from_toml(&text.replacen(from, to, 1), "robot.toml").unwrap_err();
    error.bad_input().unwrap().place.clone()
}

#[test]
fn file_rejects_what_cannot_be() {
    for (from, to, place) in [
        ("hysteron-virtual-rig", "hysteron-scene", "format"),
        ("version = 1", "version = 2", "version"),
        ("name = \"typical\"", "name = \" \"", "name"),
        ("length_mm = 80.0", "length_mm = 0.0", "body.length_mm"),
        ("sections = 8", "sections = 0", "body.sections"),
        (
            "bending_stiffness_n_m2 = [0.0202",
            "bending_stiffness_n_m2 = [-0.0202",
            "body.bending_stiffness_n_m2[0]",
        ),
        (
            "torsional_stiffness_n_m2 = 0.0132",
            "torsional_stiffness_n_m2 = nan",
            "body.torsional_stiffness_n_m2",
        ),
        ("creep_times_s = [0.6, 25.0]", "creep_times_s = [0.6]", "body.creep_weights"),
        ("creep_times_s = [0.6", "creep_times_s = [0.0", "body.creep_times_s[0]"),
        ("mass_kg = 0.0095", "mass_kg = -1.0", "body.mass_kg"),
        ("friction_coefficient = 0.22", "friction_coefficient = -0.1", "tendons.friction_coefficient"),
        ("friction_force_n = 0.10", "friction_force_n = 0.0", "tendons.friction_force_n"),
        ("slack_mm = [0.05, 0.10, 0.0, 0.08]", "slack_mm = [0.05]", "tendons.slack_mm"),
        ("angles_deg = [0.0, 90.0, 180.0, 270.0]", "angles_deg = []", "tendons.angles_deg"),
        ("directions = [1, -1", "directions = [1, 0", "servos.directions[1]"),
        ("play_mm = 0.10", "play_mm = 0.10\nzero_errors_mm = [0.0]", "tendons.zero_errors_mm"),
        ("play_mm = 0.10", "play_mm = 0.10\noffsets_mm = [[0.0, 0.0]]", "tendons.offsets_mm"),
        ("play_mm = 0.10", "play_mm = 0.10\npresliding_mm = 0.1", "tendons.presliding_mm"),
        ("play_mm = 0.10", "play_mm = 0.10\nfriction_law = \"dahl\"", "tendons.presliding_mm"),
        (
            "play_mm = 0.10",
            "play_mm = 0.10\nfriction_law = \"prandtl\"\npresliding_mm = 0.0",
            "tendons.presliding_mm",
        ),
        ("sections = 8", "sections = 8\nsection_stiffness = [1.0]", "body.section_stiffness"),
        (
            "sections = 8",
            "sections = 8\nsection_stiffness = [1, 1, 0, 1, 1, 1, 1, 1]",
            "body.section_stiffness[2]",
        ),
        ("directions = [1,", "true_radii_mm = [1.0]\ndirections = [1,", "servos.true_radii_mm"),
        ("directions = [1,", "true_radii_mm = [9, 9, -9, 9]\ndirections = [1,", "servos.true_radii_mm[2]"),
        ("breakaway_friction_n_m = 0.065", "breakaway_friction_n_m = 0.01", "servos.breakaway_friction_n_m"),
        ("rate_hz = 80.0", "rate_hz = 0.0", "tracker.rate_hz"),
        ("dropout_probability = 0.001", "dropout_probability = 1.0", "tracker.dropout_probability"),
        ("robot_rotation_deg = [12.0", "robot_rotation_deg = [inf", "tracker.robot_rotation_deg[0]"),
        ("creep_relative = 0.15", "creep_relative = -0.15", "spread.creep_relative"),
        ("length_mm = 80.0", "length_mm = 1e6", "body.length_mm"),
        ("mass_kg = 0.0095", "mass_kg = 1e6", "body.mass_kg"),
        ("pulley_radius_mm = 10.0", "pulley_radius_mm = 1e5", "servos.pulley_radius_mm"),
        ("supply_v = 12.0", "supply_v = 400.0", "servos.supply_v"),
        (
            "ambient_temperature_degc = 24.0",
            "ambient_temperature_degc = 500.0",
            "servos.ambient_temperature_degc",
        ),
        ("latency_ms = 12.0", "latency_ms = 1e6", "tracker.latency_ms"),
        ("robot_position_mm = [152.0", "robot_position_mm = [1e9", "tracker.robot_position_mm[0]"),
        ("gravity_m_s2 = [0.0, 0.0, -9.81]", "gravity_m_s2 = [0.0, 0.0, -981.0]", "body.gravity_m_s2[2]"),
        ("friction_relative = 0.2", "friction_relative = 50.0", "spread.friction_relative"),
    ] {
        assert_eq!(rejected(from, to), format!("robot.toml: {place}"));
    }
}

#[test]
fn file_rejects_keys_it_does_not_know_and_misses_those_it_needs() {
    assert!(rejected("mass_kg", "weight_kg").starts_with("robot.toml: line"));
    assert!(rejected("rate_hz = 80.0\n", "").starts_with("robot.toml: "));
    assert_eq!(VirtualRobot::preset("gentle").unwrap_err().bad_input().unwrap().place, "virtual robot");
}

#[test]
fn numbers_leave_the_file_as_si() {
    let robot = VirtualRobot::preset("typical").unwrap();
    assert_eq!(robot.body.length, 0.08);
    assert_eq!(robot.tendons.angles[1], std::f64::consts::FRAC_PI_2);
    assert_eq!(robot.tracker.latency, 0.012);
    assert_eq!(robot.servos.pulley_radius, 0.01);
}

#[test]
fn ranges_of_a_population_are_in_order_and_instead_of_a_spread() {
    let text = VirtualRobot::preset_text("wide").unwrap();
    let place = |text: String| {
        VirtualRobot::from_toml(&text, "robot.toml").unwrap_err().bad_input().unwrap().place.clone()
    };
    for (from, to, key) in [
        ("play_mm = [0.0, 0.4]", "play_mm = [0.4, 0.0]", "ranges.play_mm"),
        ("play_mm = [0.0, 0.4]", "play_mm = [-0.1, 0.4]", "ranges.play_mm"),
        ("bending_ratio = [0.833, 1.2]", "bending_ratio = [0.0, 1.2]", "ranges.bending_ratio"),
        ("zero_error_mm = [-1.0, 1.0]", "zero_error_mm = [-1.0, inf]", "ranges.zero_error_mm"),
    ] {
        assert!(text.contains(from), "{from}");
        assert_eq!(place(text.replacen(from, to, 1)), format!("robot.toml: {key}"));
    }
    let (before, _) = text.split_once("[ranges]").unwrap();
    assert_eq!(place(before.to_owned()), "robot.toml: spread");
    let (_, spread) = VirtualRobot::preset_text("typical").unwrap().split_once("[spread]").unwrap();
    assert_eq!(place(format!("{text}\n[spread]{spread}")), "robot.toml: spread");
}

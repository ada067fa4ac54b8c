//! Files of virtual arms, and bad ones.

use crate::virtual_arm::VirtualArm;

fn refusal(from: &str, to: &str) -> String {
    let text = VirtualArm::preset_text("open-manipulator-x").unwrap();
    assert!(text.contains(from), "{from}");
    let text = text.replacen(from, to, 1);
    VirtualArm::from_toml(&text, "arm.toml").unwrap_err().to_string()
}

#[test]
fn a_bad_key_is_named_with_its_place() {
    for (from, to, named) in [
        ("mass_kg = 0.098406837", "mass_kg = -1.0", "links[1].mass_kg"),
        ("mass_kg = 0.098406837", "mass_kg = nan", "links[1].mass_kg"),
        ("mass_kg = 0.098406837", "mass_g = 98.0", "mass_g"),
        ("axis = [0.0, 0.0, 1.0]", "axis = [0.0, 0.0, 0.0]", "links[1].axis"),
        ("axis = [0.0, 0.0, 1.0]", "axis = [1.0, 0.0, 1.0]", "links[1].axis"),
        ("origin_mm = [24.0, 0.0, 128.0]", "origin_mm = [0.0, 0.0, 0.0]", "links[3].origin_mm"),
        ("origin_mm = [124.0, 0.0, 0.0]", "origin_mm = [-124.0, 0.0, 0.0]", "links[4].origin_mm"),
        ("origin_mm = [124.0, 0.0, 0.0]", "origin_mm = [124.0, 5.0, 0.0]", "links[4].origin_mm"),
        ("[3.4543422e-05, 3.2689329e-05,", "[3.4543422e-04, 3.2689329e-05,", "inertia_kg_m2"),
        ("range_deg = [-180.0, 180.0]", "range_deg = [180.0, -180.0]", "range_deg"),
        ("step_ms = 0.5", "step_ms = 0.0", "step_ms"),
        ("p_gain_count = 800", "p_gain_count = 70000", "p_gain_count"),
        ("jitter_ms = 0.25", "jitter_ms = 9.0", "telemetry.jitter_ms"),
        ("late_probability = 0.01", "late_probability = 2.0", "late_probability"),
        ("resistance_ohm = 4.9", "resistance_ohm = inf", "resistance_ohm"),
        ("mass_relative = 0.05", "mass_relative = 5.0", "spread.mass_relative"),
        ("version = 1", "version = 2", "version"),
        ("hysteron-virtual-arm", "hysteron-virtual-rig", "format"),
        ("[[links]]\norigin_mm = [12.0", "[[other]]\norigin_mm = [12.0", "other"),
    ] {
        let message = refusal(from, to);
        assert!(message.contains("arm.toml") && message.contains(named), "{to}: {message}");
    }
}

#[test]
fn individuals_differ_as_stated_and_are_the_same_again() {
    let arm = VirtualArm::preset("open-manipulator-x").unwrap();
    assert_eq!(arm.individual(4), arm.individual(4));
    assert_ne!(arm.individual(4), arm.individual(5));
    let logs: Vec<f64> = (0..200)
        .flat_map(|seed| {
            let one = arm.individual(seed);
            std::array::from_fn::<f64, 4, _>(|k| {
                (one.chain.links[k].body.mass / arm.chain.links[k].body.mass).ln()
            })
        })
        .collect();
    let deviation = (logs.iter().map(|x| x * x).sum::<f64>() / logs.len() as f64).sqrt();
    // 800 draws: three standard errors of a deviation are 3/√1600.
    assert!((deviation / arm.spread.mass - 1.0).abs() < 3.0 / 40.0, "{deviation}");
}

#![allow(clippy::unwrap_used)] // a test may stop where it stands
use super::*;

const EXAMPLE: &str = RIG_FILE;

fn rejected(change: (&str, &str)) -> BadInput {
    assert!(EXAMPLE.contains(change.0), "{}", change.0);
    RigConfig::from_toml(&EXAMPLE.replacen(change.0, change.1, 1), Path::new("folder")).unwrap_err()
}

#[test]
fn the_example_is_valid_and_in_si() {
    let rig = RigConfig::from_toml(EXAMPLE, Path::new("folder")).unwrap();
    assert_eq!(rig.ids(), [1, 2, 3, 4]);
    assert_eq!(rig.tendons[1].pulley_radius, 0.01);
    assert_eq!(rig.tendons[1].angle, 90_f64.to_radians());
    assert_eq!((rig.limits.load_max, rig.limits.load_limiting), (0.7, Some(0.68)));
    assert_eq!(rig.servos.bus_watchdog, 0.2);
    assert_eq!(rig.servos.port, Path::new("folder/servos"));
    assert_eq!(rig.calibration.file, Path::new("folder/calibration.toml"));
}

#[test]
fn every_bound_rejects() {
    let cases = [
        (("hysteron-rig", "hysteron-scene"), "format"),
        (("version = 1", "version = 2"), "version"),
        (("baud = 1000000", "baud = 31250"), "servos.baud"),
        (("position_p_gain = 1600", "position_p_gain = 16384"), "servos.position_p_gain"),
        (("bus_watchdog_ms = 200.0", "bus_watchdog_ms = 50.0"), "servos.bus_watchdog_ms"),
        (("reply_timeout_ms = 4.0", "reply_timeout_ms = 0.0"), "servos.reply_timeout_ms"),
        (("retries = 2", "retries = -1"), "servos.retries"),
        (("servo_id = 2", "servo_id = 1"), "tendon[2].servo_id"),
        (("servo_id = 2", "servo_id = 253"), "tendon[2].servo_id"),
        (("pulley_radius_mm = 10.0", "pulley_radius_mm = nan"), "tendon[1].pulley_radius_mm"),
        (("pulley_radius_mm = 10.0", "pulley_radius_mm = 10000.0"), "tendon[1].pulley_radius_mm"),
        (("pulley_radius_mm = 10.0", "pulley_radius_mm = 0.5"), "tendon[1].pulley_radius_mm"),
        (("angle_deg = 90.0", "angle_deg = 1e6"), "tendon[2].angle_deg"),
        (("127.0.0.1:18944", "127.0.0.1:99999"), "tracker.address"),
        (("127.0.0.1:18944", "127.0.0.1:0"), "tracker.address"),
        (("127.0.0.1:18944", "127.0.0.1"), "tracker.address"),
        (("127.0.0.1:18944", ":18944"), "tracker.address"),
        (("127.0.0.1:18944", "127.0.0.1:+80"), "tracker.address"),
        (("127.0.0.1:18944", "http://tracker:80/x"), "tracker.address"),
        (("127.0.0.1:18944", "replay:"), "tracker.address"),
        (("device = \"Tip\"", "device = \"TipToTrackerOfTheRobot\""), "tracker.device"),
        (("device = \"Tip\"", "device = \"T\\u001bip\""), "tracker.device"),
        (("rate_hz = 80.0", "rate_hz = inf"), "tracker.rate_hz"),
        (("rate_hz = 80.0", "rate_hz = 1e5"), "tracker.rate_hz"),
        (("latency_ms = 10.0", "latency_ms = 1e4"), "tracker.latency_ms"),
        (("stale_ms = 300.0", "stale_ms = 1e7"), "tracker.stale_ms"),
        (("stale_ms = 300.0", "stale_ms = 5.0"), "tracker.stale_ms"),
        (("speed_max_mm_s = 500.0", "speed_max_mm_s = 1e9"), "tracker.speed_max_mm_s"),
        (("tip_rest_mm = [0.0, 0.0, 80.0]", "tip_rest_mm = [0.0, 0.0, 800.0]"), "tracker.tip_rest_mm[2]"),
        (("tip_rest_mm = [0.0, 0.0, 80.0]", "tip_rest_mm = [0.0, 1e9, 80.0]"), "tracker.tip_rest_mm[1]"),
        (("stroke_max_mm = 16.0", "stroke_max_mm = -1.0"), "limits.stroke_max_mm"),
        (("stroke_max_mm = 16.0", "stroke_max_mm = 1e5"), "limits.stroke_max_mm"),
        (("stroke_min_mm = -16.0", "stroke_min_mm = 1.0"), "limits.stroke_min_mm"),
        (("stroke_rate_max_mm_s = 12.0", "stroke_rate_max_mm_s = 1e6"), "limits.stroke_rate_max_mm_s"),
        (("lag_max_mm = 3.0", "lag_max_mm = 1e6"), "limits.lag_max_mm"),
        (("temperature_max_degc = 65.0", "temperature_max_degc = 500.0"), "limits.temperature_max_degc"),
        (("temperature_max_degc = 65.0", "temperature_max_degc = -300.0"), "limits.temperature_max_degc"),
        (("voltage_max_v = 14.0", "voltage_max_v = 400.0"), "limits.voltage_max_v"),
        (("tip_max_mm = [60.0", "tip_max_mm = [1e9"), "limits.tip_max_mm[0]"),
        (("slack_load_percent = 4.0", "slack_load_percent = 80.0"), "calibration.slack_load_percent"),
        (("search_max_mm = 20.0", "search_max_mm = 1e6"), "calibration.search_max_mm"),
        (("probe_mm = 3.0", "probe_mm = 1e6"), "calibration.probe_mm"),
        (("stroke_min_mm = -16.0", "stroke_min_mm = 16.0"), "limits.stroke_min_mm"),
        (("lag_max_mm = 3.0", "lag_max_mm = 0.0"), "limits.lag_max_mm"),
        (("load_max_percent = 70.0", "load_max_percent = 101.0"), "limits.load_max_percent"),
        (("load_limit_percent = 68.0", "load_limit_percent = 71.0"), "limits.load_limit_percent"),
        (("voltage_min_v = 9.5", "voltage_min_v = 15.0"), "limits.voltage_min_v"),
        (("10.0]\ntip_max", "95.0]\ntip_max"), "limits.tip_min_mm[2]"),
        (("slew_mm_s = 3.0", "slew_mm_s = 13.0"), "motion.slew_mm_s"),
        (
            ("pretension_load_percent = 2.0", "pretension_load_percent = 0.0"),
            "calibration.pretension_load_percent",
        ),
        (("search_max_mm = 20.0", "search_max_mm = -1.0"), "calibration.search_max_mm"),
    ];
    for (change, place) in cases {
        let bad = rejected(change);
        assert!(bad.place.ends_with(place), "{bad} for {change:?}");
    }
}

#[test]
fn a_tracker_is_a_server_or_a_recording() {
    let source =
        |text: &str| RigConfig::from_toml(text, Path::new("folder")).unwrap().tracker.unwrap().source;
    assert_eq!(source(EXAMPLE), TrackerSource::OpenIgtLink("127.0.0.1:18944".into()));
    let replay = EXAMPLE.replace("\"127.0.0.1:18944\"", "\"replay:tip.parquet\"");
    assert_eq!(source(&replay), TrackerSource::Replay("folder/tip.parquet".into()));
}

#[test]
fn a_turn_must_hold_all_strokes_in_position_mode() {
    let text = EXAMPLE.replace("\"extended\"", "\"position\"").replacen(
        "pulley_radius_mm = 10.0",
        "pulley_radius_mm = 3.0",
        1,
    );
    let bad = RigConfig::from_toml(&text, Path::new("")).unwrap_err();
    assert_eq!(bad.place, "tendon[1].pulley_radius_mm");
    assert!(bad.hint.contains("extended"));
}

#[test]
fn unknown_and_missing_keys_are_named() {
    assert!(rejected(("baud = ", "bauds = ")).hint.contains("baud"));
    assert!(rejected(("retries = 2\n", "")).place.contains("retries"));
}

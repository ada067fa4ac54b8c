//! Damaged files of JSON: sensors and baselines.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use std::path::Path;

use hysteron_actuator::health::Baseline;
use hysteron_base::json;
use hysteron_fuzz::drive;
use hysteron_fuzz::text::{slipped_json, slips};

use crate::is_bad_input;
use crate::tendon::sense::file::{self, SensedRobot};

/// Most memory of this process, the other tests in it included [bytes].
const MEMORY_MAX: u64 = 500_000_000;

/// Tries a reader on the text and on slips of it; what it refuses is bad input in the form of all.
fn tried(name: &str, text: &str, read: impl Fn(&Path) -> anyhow::Result<()> + std::panic::RefUnwindSafe) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.json");
    std::fs::write(&path, text).unwrap();
    read(&path).unwrap();
    drive(name, 2000, MEMORY_MAX, slips(), |slips| {
        std::fs::write(&path, slipped_json(text, &slips)).unwrap();
        if let Err(error) = read(&path) {
            let message = format!("{error:#}");
            assert!(is_bad_input(&error), "{message}");
            assert!(message.contains(": expected ") && message.len() < 3000, "{message}");
        }
    });
}

#[test]
fn no_slip_in_a_sensor_does_harm() {
    let sensor = json!({
        "format": "hysteron-force-sensor", "version": 2, "scene_sha256": "a", "residual_sha256": null,
        "sensor": {
            "period_s": 0.01, "stiffness_scale": 1.1,
            "servo": {
                "stall_torque_n_m": 1.4, "radius_m": 0.01, "coulomb_n_m": 0.1, "breakaway_n_m": 0.12,
                "stribeck_velocity_rad_s": 0.1, "viscous_n_m_s_per_rad": 0.01,
            },
            "tension": { "force_scale": 0.1, "walk_sqrt_n": 0.1, "model_n": 0.2, "load_n": 0.3 },
            "tip": {
                "noise_m": [1e-4, 1e-4, 1e-4], "model_m": [1e-3, 1e-3, 1e-3], "offset_m": [1e-3, 1e-3, 1e-3],
                "length_m": 0.08, "walk_along_sqrt_m": 0.01, "walk_across_sqrt_m": 0.01,
                "creep_m_per_sqrt_s": [1e-5, 1e-5, 1e-5], "response": 0.1, "thresholds": [3.0, 4.0, 5.0, 6.0],
            },
        },
    });
    let robot = SensedRobot { scene: "a", network: None };
    tried("sensor", &json::to_text(&sensor).unwrap(), |path| file::read(path, &robot).map(drop));
}

#[test]
fn no_slip_in_a_baseline_does_harm() {
    let number = json!({ "value": 12.5, "standard_error": 0.5 });
    let servo =
        json!({ "servo": 1, "friction_pulling_percent": number, "lost_motion_mm": number, "windows": [] });
    let recorded = json!({ "format": "hysteron-metrics", "health": { "servos": [servo] } });
    let row = |name: &str| json!({ "name": name, "value": 0.1, "standard_error": 0.01, "bound": null });
    let estimates = [row("coulomb_n_m"), row("load_scale_n_m")];
    let identified = json!({ "servos": [{ "servo": 1, "estimates": estimates }] });
    for (name, value) in [("baseline, recorded", recorded), ("baseline, identified", identified)] {
        tried(name, &json::to_text(&value).unwrap(), |path| Ok(Baseline::read(path, 1).map(drop)?));
    }
}

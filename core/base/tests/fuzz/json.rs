//! Damaged JSON.

use hysteron_base::json;
use hysteron_base::json::Value;
use hysteron_fuzz::text::{slipped_json, slips};
use hysteron_fuzz::{damaged, damages, drive};

use super::MEMORY_MAX;

/// Checks that accepted text is written and comes back.
fn read(bytes: &[u8]) {
    if let Ok(value) = json::from_text::<Value>(bytes) {
        json::from_text::<Value>(json::to_text(&value).unwrap()).unwrap();
    }
}

#[test]
fn no_damage_to_json_does_harm() {
    let value = json!({
        "format": "hysteron-metrics", "version": 1, "numbers": [1.5, -2e300, 1e-320, 0.0], "names": ["a", "µ\n\"", ""],
        "rows": [{ "value": 0.1, "bound": null }, { "value": f64::NAN, "bound": [[], {}] }], "is_true": true,
    });
    let text = json::to_text(&value).unwrap();
    drive("JSON, slips", 2000, MEMORY_MAX, slips(), |slips| read(slipped_json(&text, &slips).as_bytes()));
    drive("JSON, bytes", 2000, MEMORY_MAX, damages(), |damages| read(&damaged(text.as_bytes(), &damages)));
    for open in ["[", "{\"a\":"] {
        read(open.repeat(1_000_000).as_bytes());
    }
}

//! Comparisons with data that is not part of the project: each says by name when it is skipped for want of it.
//! Where to get the originals: `bench/README.md`.

// A failed expectation is how a test fails; the skip is a line a person should see.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

use std::path::Path;

use hysteron_base::json;
use hysteron_bench::study::{data_folder, sorosim, tentacle};
use serde_json::Value;

/// The metrics that a study wrote, or nothing where its data is absent.
fn metrics(name: &str, data: &str, run: impl FnOnce(&Path)) -> Option<Value> {
    if !data_folder().join(data).exists() {
        eprintln!("{name}: skipped, no {data} in {} (set HYSTERON_DATA)", data_folder().display());
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    run(folder.path());
    let text = std::fs::read(folder.path().join("metrics.json")).unwrap();
    Some(json::from_text::<Value>(&text).unwrap()["metrics"].clone())
}

#[test]
fn rod_shapes_agree_with_sorosim_within_one_per_cent_of_length() {
    let data = "../reference/sorosim/TPURodMuJoCo_dataStatics.csv";
    let run = |folder: &Path| sorosim::run(folder, true).unwrap();
    let Some(metrics) = metrics("sorosim", data, run) else { return };
    let rods = &metrics[0]["error_percent_of_length"];
    assert!(metrics[0]["shapes"].as_u64().unwrap() >= 20, "{metrics}");
    // Rounding of the reference to four decimals alone is 0.03 % of the length.
    let median = rods["tip"]["median"].as_f64().unwrap();
    assert!(median > 0.03 && median < 1.0, "median tip error {median} %");
    assert!(rods["tip"]["max"].as_f64().unwrap() < 1.0, "{rods}");
}

#[test]
fn tentacle_with_nominal_parameters_is_as_far_off_as_the_rod_model() {
    let run = |folder: &Path| tentacle::run(folder, true).unwrap();
    let Some(metrics) = metrics("tentacle", "tentacle/static_markers.csv", run) else { return };
    let row =
        metrics["summary"].as_array().unwrap().iter().find(|row| !row["published_rod_mm"].is_null()).unwrap();
    let (twin, rod) = (row["rmse_mm"].as_f64().unwrap(), row["published_rod_mm"].as_f64().unwrap());
    // Same body, same parameters: what differs is the strain measure, at strains up to 16 % of the bending
    // stiffness's own scale.
    assert!((twin - rod).abs() < 0.16 * rod, "RMSE {twin} mm beside the rod model's {rod} mm");
}

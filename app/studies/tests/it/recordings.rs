//! Comparisons with data that is not part of the project: each reports by name if it is skipped without it.
//! Where to get the originals: `bench/README.md`.

use std::path::Path;

use hysteron_fuzz::{data_folder, recorded};
use hysteron_studies::tendon::{DataOptions, Options, sorosim, tentacle};
use hysteron_workflow::Context;

use super::repository;

fn quick(out: &Path) -> DataOptions {
    let shared = Options { out: out.to_owned(), quick: true, repository: repository().to_owned() };
    DataOptions { data: Some(data_folder()), shared }
}

#[test]
fn rod_shapes_agree_with_sorosim_within_one_per_cent_of_length() {
    if recorded("sorosim", "../reference/sorosim/TPURodMuJoCo_dataStatics.csv").is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let outcome = sorosim::run(&quick(folder.path()), &Context::silent("a test")).unwrap();
    let found = &outcome.metrics[0];
    let tip = found.error_percent_of_length.tip;
    assert!(found.shapes >= 20, "{found:?}");
    // Rounding of the reference to four decimals alone is 0.03 % of the length.
    assert!(tip.median > 0.03 && tip.median < 1.0, "median tip error {} %", tip.median);
    assert!(tip.max < 1.0, "{tip:?}");
}

#[test]
fn tentacle_with_nominal_parameters_is_as_far_off_as_the_rod_model() {
    if recorded("tentacle", "tentacle/static_markers.csv").is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let outcome = tentacle::run(&quick(folder.path()), &Context::silent("a test")).unwrap();
    let published = outcome.metrics.summary.iter().find_map(|row| Some((row.rmse_mm, row.published_rod_mm?)));
    let (twin, rod) = published.unwrap();
    // Same body, same parameters: what differs is the strain measure, at strains up to 16 % of the bending
    // stiffness's own scale.
    assert!((twin - rod).abs() < 0.16 * rod, "RMSE {twin} mm, of the rod model {rod} mm");
}

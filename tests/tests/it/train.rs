//! `hysteron train`: what an interruption leaves.

use hysteron_tests::run;

const RECORD: [&str; 7] = ["record", "--rig", "virtual:typical", "--plan", "quick", "--out", "data"];
const TRAIN: [&str; 10] = [
    "train",
    "data",
    "--out",
    "inverse.safetensors",
    "--held-out",
    "circle",
    "--epochs",
    "12",
    "--hidden",
    "64",
];

#[test]
fn an_interrupted_training_fails_keeps_its_best_weights_and_goes_on() {
    let place = tempfile::tempdir().unwrap();
    run(place.path(), &RECORD).succeeded();
    let [checkpoint, beside] =
        ["inverse.safetensors", "inverse.training"].map(|name| place.path().join(name));
    run(place.path(), &TRAIN).succeeded();
    let whole = std::fs::read(&checkpoint).unwrap();
    std::fs::remove_file(&checkpoint).unwrap();

    // The file is there once the first epoch is done.
    let stopped = hysteron_tests::interrupt(place.path(), &TRAIN, "inverse.training");
    let error = stopped.error(1);
    assert!(error.starts_with("error: interrupted") && error.contains("inverse.training"), "{error}");
    assert!(beside.exists() && std::fs::read(&checkpoint).unwrap() != whole);
    run(place.path(), &TRAIN).succeeded();
    assert!(!beside.exists() && std::fs::read(&checkpoint).unwrap() == whole);
}

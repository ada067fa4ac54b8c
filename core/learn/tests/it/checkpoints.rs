//! A checkpoint comes back as it was, or not at all.

use std::path::{Path, PathBuf};

use hysteron_base::json;
use hysteron_learn::{ChannelRange, Checkpoint, Error, Network, Normaliser, Trainer};
use proptest::prelude::*;

use super::architecture;

fn normaliser(names: &[&str]) -> Normaliser {
    let range = |name: &&str| ChannelRange { name: (*name).to_owned(), min: -0.1, max: 1.0 / 3.0 };
    Normaliser::new(names.iter().map(range).collect()).unwrap()
}

fn checkpoint() -> Checkpoint<json::Value> {
    Checkpoint {
        kind: "controller".to_owned(),
        network: Network::new(&architecture(2, 1, 0.25), 4).unwrap(),
        inputs: normaliser(&["a", "b", "c"]),
        outputs: normaliser(&["x", "y"]),
        // What the search for the checksum could stumble over.
        details: json!({ "note": "\"sha256\":\"0000\"", "number": 0.1 }),
    }
}

/// A written checkpoint, its bytes, and the folder that goes when dropped.
fn written() -> (tempfile::TempDir, PathBuf, Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("net.safetensors");
    checkpoint().write(&path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    (folder, path, bytes)
}

fn refusal(path: &Path, kind: &str) -> String {
    match Checkpoint::<json::Value>::read(path, kind) {
        Err(Error::BadInput(bad)) => bad.to_string(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn comes_back_as_it_was() {
    let (_folder, path, bytes) = written();
    assert_eq!(Checkpoint::read(&path, "controller").unwrap(), checkpoint());
    checkpoint().write(&path).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), bytes, "same content, same bytes");
}

#[test]
fn cut_short_anywhere_it_is_refused() {
    let (_folder, path, bytes) = written();
    for length in 0..bytes.len() {
        std::fs::write(&path, &bytes[..length]).unwrap();
        refusal(&path, "controller");
    }
}

#[test]
fn with_any_byte_changed_it_is_refused() {
    let (_folder, path, bytes) = written();
    for place in 0..bytes.len() {
        for change in [0x01, 0x20, 0x80, 0xff] {
            let mut bytes = bytes.clone();
            bytes[place] ^= change;
            std::fs::write(&path, &bytes).unwrap();
            refusal(&path, "controller");
        }
    }
}

proptest! {
    #[test]
    fn no_bytes_make_it_panic(noise in prop::collection::vec(any::<u8>(), 0..200), header in 0u64..300) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("noise");
        let framed = [&header.to_le_bytes()[..], &noise].concat();
        for bytes in [noise, framed] {
            std::fs::write(&path, bytes).unwrap();
            prop_assert!(matches!(Checkpoint::<json::Value>::read(&path, "controller"), Err(Error::BadInput(_))));
            prop_assert!(matches!(Trainer::load::<()>(&path, &checkpoint().network), Err(Error::BadInput(_))));
        }
    }
}

#[test]
fn refusals_say_what_is_wrong() {
    let (folder, path, _) = written();
    let found = refusal(&path, "residual");
    assert!(found.contains("net.safetensors: kind: expected residual, got controller"), "{found}");

    let other = folder.path().join("training");
    let training = Trainer::new(checkpoint().network, hysteron_learn::Adam::default(), 0).unwrap();
    training.save(&other, &json!(null)).unwrap();
    let found = refusal(&other, "controller");
    assert!(found.contains("format: expected hysteron-checkpoint, got hysteron-training"), "{found}");
    assert!(matches!(Trainer::load::<()>(&path, training.network()), Err(Error::BadInput(_))));

    std::fs::write(&other, "kind,controller\n1,2\n").unwrap();
    assert!(refusal(&other, "controller").contains("a whole safetensors file"));
    assert!(refusal(&folder.path().join("absent"), "controller").contains("nothing there"));
}

#[test]
fn channels_must_be_those_of_the_network() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = Checkpoint { inputs: normaliser(&["a"]), ..checkpoint() };
    match wrong.write(&folder.path().join("net")) {
        Err(Error::BadInput(bad)) => assert_eq!(bad.to_string(), "inputs: expected 3 channels, got 1"),
        other => panic!("{other:?}"),
    }
}

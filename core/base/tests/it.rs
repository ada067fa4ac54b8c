//! Facts that hold for any input: files give back what was written, and no bytes make a reader panic.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use hysteron_base::{Channel, Error, Metadata, Recording, Scene, file};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;

fn value() -> impl Strategy<Value = f64> {
    prop_oneof![-1.0..1.0, any::<f64>().prop_filter("finite", |x| x.is_finite())]
}

fn metadata() -> impl Strategy<Value = Metadata> {
    let extra = prop::collection::btree_map("[a-z0-9_.]{1,6}x", any::<String>(), 0..3);
    (any::<[String; 4]>(), any::<Option<u64>>(), extra).prop_map(|(text, seed, extra)| {
        let [scene_hash, commit, source, command] = text;
        Metadata { scene_hash, seed, commit, source, command, extra }
    })
}

fn recording() -> impl Strategy<Value = Recording> {
    const NAMES: [&str; 7] =
        ["stroke_1_m", "stroke_2_m", "tip_x_m", "tip_qw", "load_3", "tension_1_n", "angle_rad"];
    (1_usize..40, 0..=NAMES.len(), metadata()).prop_flat_map(|(n, n_channels, meta)| {
        let steps = prop::collection::vec(1e-4..1.0, n);
        let values = prop::collection::vec(prop::collection::vec(value(), n), n_channels);
        let gap = prop::collection::vec(any::<bool>(), n);
        (steps, values, gap).prop_map(move |(steps, values, gap)| {
            let mut t = -0.3;
            let time = steps.iter().map(|step| {
                t += step;
                t
            });
            let channels = NAMES.iter().zip(values).map(|(name, values)| Channel::new(*name, values));
            Recording::new(time.collect(), channels.collect(), gap, meta.clone()).unwrap()
        })
    })
}

/// The bits of all numbers, since `==` takes -0 for 0.
fn bits(recording: &Recording) -> Vec<u64> {
    let channels = recording.channels().iter().flat_map(|channel| &channel.values);
    recording.time().iter().chain(channels).map(|x| x.to_bits()).collect()
}

/// Reads these bytes as `name`: bad input or a recording, never a panic.
fn read_bytes_as(folder: &Path, name: &str, bytes: &[u8]) {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    let error = match name {
        "scene.toml" => Scene::read(&path).err(),
        _ => Recording::read(&path).err(),
    };
    if let Some(error) = error {
        assert!(matches!(error, Error::BadInput(_)), "{error}");
        assert!(error.to_string().starts_with(&path.display().to_string()), "{error}");
    }
}

proptest! {
    #[test]
    fn csv_and_parquet_return_what_was_written(recording in recording()) {
        let folder = tempfile::tempdir().unwrap();
        let (csv, parquet) = (folder.path().join("a.csv"), folder.path().join("a.parquet"));
        recording.write(&csv).unwrap();
        let from_csv = Recording::read(&csv).unwrap();
        from_csv.write(&parquet).unwrap();
        let from_parquet = Recording::read(&parquet).unwrap();
        prop_assert_eq!(bits(&from_parquet), bits(&recording));
        prop_assert_eq!(&from_parquet, &recording);
        let first = file::read_bytes(&csv).unwrap();
        from_parquet.write(&csv).unwrap();
        prop_assert_eq!(file::read_bytes(&csv).unwrap(), first);
    }

    #[test]
    fn no_bytes_make_a_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.csv", "a.parquet", "a.journal", "scene.toml"] {
            read_bytes_as(folder.path(), name, &bytes);
        }
        // The frame of a parquet file around nothing of the kind.
        let length = (bytes.len() as u32).to_le_bytes();
        let framed = [b"PAR1", &bytes[..], &length, b"PAR1"].concat();
        read_bytes_as(folder.path(), "a.parquet", &framed);
    }

    #[test]
    fn no_text_makes_a_reader_panic(
        csv in "(# [a-z]{0,3}: ?[\"a]{0,2}\n){0,2}(time_s|gap|tip_x_mm|,|\"|\n|[0-9]{1,3}|-|e|\\.){0,30}",
        toml in "(\\[|\\]|\\[\\[tendon\\]\\]|name|tip|=|\"|\n|[0-9]|\\.|,|#|µ|\\{|\\}){0,30}",
    ) {
        let folder = tempfile::tempdir().unwrap();
        read_bytes_as(folder.path(), "a.csv", csv.as_bytes());
        read_bytes_as(folder.path(), "scene.toml", toml.as_bytes());
    }

    #[test]
    fn damaged_parquet_makes_no_reader_panic(
        recording in recording(),
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("whole.parquet");
        recording.write(&path).unwrap();
        let mut bytes = file::read_bytes(&path).unwrap();
        for (at, byte) in damage {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        read_bytes_as(folder.path(), "a.parquet", &bytes);
    }
}

#[test]
fn extra_metadata_survives_both_files() {
    let extra = BTreeMap::from([("plan.amplitude_mm".to_owned(), "4.0".to_owned())]);
    let meta = Metadata { extra, ..Metadata::default() };
    let recording = Recording::new(vec![0.0], vec![], vec![], meta).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.csv", "a.parquet"] {
        let path = folder.path().join(name);
        recording.write(&path).unwrap();
        assert_eq!(Recording::read(&path).unwrap(), recording);
    }
}

//! Recordings in their three kinds of file: damaged in places, or whole and absurd.

use super::text::{slipped, slips};
use super::{assert_in_house_form, assert_memory_is_bounded, cases, corpus};
use hysteron_base::{Channel, Error, Journal, JournalWriter, Metadata, Recording};
use hysteron_rig::session::recover;
use proptest::prelude::*;
use std::path::Path;

const NAMES: [&str; 6] = ["stroke_1_m", "tick_goal_1", "tip_qw", "tip_qx", "tip_qy", "tip_qz"];

fn example() -> Recording {
    let time: Vec<f64> = (0..200).map(|i| 0.01 * f64::from(i)).collect();
    let channels = NAMES
        .iter()
        .zip(1..)
        .map(|(name, k)| Channel::new(*name, time.iter().map(|t| f64::from(k) * t.sin()).collect()));
    let gap = (0..200).map(|i| i % 7 == 0).collect();
    Recording::new(time.clone(), channels.collect(), gap, Metadata::default()).unwrap()
}

/// The file as a recording; what is accepted has as many values as times, all finite.
fn read(path: &Path, bytes: &[u8]) {
    std::fs::write(path, bytes).unwrap();
    let recording = match path.extension().is_some_and(|ending| ending == "journal") {
        true => Journal::read(path).map(|journal| journal.recording),
        false => Recording::read(path),
    };
    match recording {
        Ok(recording) => {
            let n = recording.n_samples();
            assert!(recording.channels().iter().all(|channel| channel.values.len() == n));
            let values = recording.channels().iter().flat_map(|channel| &channel.values);
            assert!(recording.time().iter().chain(values).all(|x| x.is_finite()));
            // No more than could be in the file, but for values that repeat.
            assert!(n <= 200 + bytes.len(), "{n} rows in {} bytes", bytes.len());
        }
        Err(Error::BadInput(bad)) => assert_in_house_form(Some(&bad), &bad),
        Err(error) => panic!("{error}"),
    }
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc: u32, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg()))
    })
}

/// A journal of these payloads, their checksums right.
fn journal(payloads: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = b"hystjrnl".to_vec();
    for payload in payloads {
        bytes.extend((payload.len() as u32).to_le_bytes());
        bytes.extend(crc32(payload).to_le_bytes());
        bytes.extend(payload);
    }
    bytes
}

fn header() -> impl Strategy<Value = Vec<u8>> {
    let valid = r#"H{"format":"hysteron-journal","version":1,"channels":["stroke_1_m","tip_qw"],"metadata":[["seed","1"]]}"#;
    let slip = prop_oneof![
        4 => Just(("", "")),
        1 => Just(("tip_qw", "stroke_1_m")),
        1 => Just(("tip_qw", "time_s")),
        1 => Just(("tip_qw", "gap")),
        1 => Just(("tip_qw", "\u{202e}\\n")),
        1 => Just(("\"stroke_1_m\",\"tip_qw\"", "")),
        1 => Just(("[\"seed\",\"1\"]", "[\"seed\",\"-1\"]")),
        1 => Just(("[\"seed\",\"1\"]", "[\"seed\",\"1\"],[\"seed\",\"1\"]")),
        1 => Just(("[\"seed\",\"1\"]", "[\"Ünfug\",\"\"]")),
        1 => Just((":1,", ":1e999,")),
        1 => Just(("}", "")),
        1 => Just(("[", "[[[[[[[[")),
    ];
    slip.prop_map(move |(from, to)| if from.is_empty() { valid.into() } else { valid.replacen(from, to, 1) })
        .prop_map(String::into_bytes)
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -1.0..1.0, 1 => Just(f64::NAN), 1 => Just(f64::INFINITY), 1 => Just(1e308), 1 => Just(-1e308)]
}

/// Rows and notes, most of them in order of time.
fn frames() -> impl Strategy<Value = Vec<Vec<u8>>> {
    let row = (0.0..0.1, prop::collection::vec(number(), 2), 0_u32..20);
    prop::collection::vec(row, 0..40).prop_map(|rows| {
        let mut time = 0.0;
        let frame = |(step, values, kind): (f64, Vec<f64>, u32)| {
            time += step;
            let numbers = |list: &[f64]| list.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
            match kind {
                0 => [b"N", &numbers(&[time])[..], &[0xff, 0xfe]].concat(),
                1 => [b"N", &numbers(&[time])[..], b"{\"kind\":\"run\"}"].concat(),
                2 => [b"R", &numbers(&[f64::NAN])[..], &numbers(&values)].concat(),
                3 => [b"R", &numbers(&[-time])[..], &numbers(&values)].concat(),
                4 => [b"R", &numbers(&values)[..]].concat(),
                5 => b"R".to_vec(),
                _ => [b"R", &numbers(&[time])[..], &numbers(&values)].concat(),
            }
        };
        rows.into_iter().map(frame).collect()
    })
}

#[test]
fn corpus_of_recordings_is_refused_in_the_house_form() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in corpus("recordings") {
        let ending = Path::new(&name).extension().unwrap();
        read(&folder.path().join("case").with_extension(ending), &bytes);
    }
    assert_memory_is_bounded();
}

#[test]
fn journal_with_every_length_of_its_first_row_is_survived() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.journal");
    let mut writer = JournalWriter::create(&path, &["stroke_1_m".to_owned()], &Metadata::default()).unwrap();
    (0..3).for_each(|i| writer.append(f64::from(i), &[1.0]).unwrap());
    let whole = std::fs::read(&path).unwrap();
    let row = whole.len() - 3 * (8 + 1 + 16);
    for length in [0, 1, 8, 9, 16, 18, 0xffff, 0x7fff_ffff, u32::MAX] {
        let mut bytes = whole.clone();
        bytes[row..row + 4].copy_from_slice(&length.to_le_bytes());
        read(&path, &bytes);
    }
    assert_memory_is_bounded();
}

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn no_slip_in_a_csv_file_does_harm(slips in slips()) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        example().write(&path).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        read(&path, slipped(&text, &slips).as_bytes());
    }

    #[test]
    fn no_damage_to_a_parquet_file_does_harm(
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..3), 1..5),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.parquet");
        example().write(&path).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        for (at, value, kind) in damage {
            let at = at.index(bytes.len());
            match kind {
                0 => bytes[at] = value,
                1 => bytes.insert(at, value),
                _ => drop(bytes.remove(at)),
            }
        }
        read(&path, &bytes);
        assert_memory_is_bounded();
    }

    #[test]
    fn no_content_of_a_journal_does_harm(header in header(), frames in frames(), cut in 0_usize..30) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.journal");
        let bytes = journal(&[vec![header], frames].concat());
        let bytes = &bytes[..bytes.len() - cut.min(bytes.len())];
        read(&path, bytes);
        let out = folder.path().join("a.parquet");
        if let Ok((n_rows, _)) = recover(&path, &out) {
            prop_assert_eq!(Recording::read(&out).unwrap().n_samples(), n_rows);
        }
    }
}

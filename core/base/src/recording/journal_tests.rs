//! Journals that were killed, torn and damaged.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use super::*;
use proptest::prelude::*;
use std::path::PathBuf;
use std::sync::OnceLock;

const NAN: f64 = f64::NAN;

fn names() -> Vec<String> {
    ["stroke_1_m", "tip_x_m", "tension_1_n"].map(str::to_owned).to_vec()
}

fn meta() -> Metadata {
    let extra = [("rate_hz".to_owned(), "100".to_owned())].into();
    Metadata { source: "a rig".into(), seed: Some(7), extra, ..Metadata::default() }
}

/// Four rows and a note: the first lacks the tip, the third the stroke, no row has a tension.
fn write_example(folder: &Path, name: &str) -> PathBuf {
    let path = folder.join(name);
    let mut journal = JournalWriter::create(&path, &names(), &meta()).unwrap();
    journal.append(0.0, &[0.0, NAN, NAN]).unwrap();
    journal.append(0.01, &[1e-3, 0.5, NAN]).unwrap();
    journal.note(0.015, "tracker: no pose for 20 ms").unwrap();
    journal.append(0.02, &[NAN, 0.25, NAN]).unwrap();
    journal.sync().unwrap();
    journal.append(0.03, &[3e-3, -0.0, NAN]).unwrap();
    path
}

fn example_bytes() -> Vec<u8> {
    static EXAMPLE: OnceLock<Vec<u8>> = OnceLock::new();
    let written = || {
        let folder = tempfile::tempdir().unwrap();
        file::read_bytes(&write_example(folder.path(), "a.journal")).unwrap()
    };
    EXAMPLE.get_or_init(written).clone()
}

/// Where each frame ends in the example: header, 2 rows, note, 2 rows.
fn ends(bytes: &[u8]) -> Vec<usize> {
    let mut rest = &bytes[MAGIC.len()..];
    let mut ends = Vec::new();
    while frame(&mut rest).is_some() {
        ends.push(bytes.len() - rest.len());
    }
    ends
}

#[test]
fn a_journal_reads_as_the_recording_with_its_gaps_filled() {
    let folder = tempfile::tempdir().unwrap();
    let path = write_example(folder.path(), "new/a.journal");
    let journal = Journal::read(&path).unwrap();
    let recording = &journal.recording;
    assert_eq!(recording, &Recording::read(&path).unwrap());
    assert_eq!(recording.time(), [0.0, 0.01, 0.02, 0.03]);
    let stroke = recording.channel("stroke_1_m").unwrap();
    assert_eq!([stroke[0], stroke[1], stroke[3]], [0.0, 1e-3, 3e-3]);
    assert!((stroke[2] - 2e-3).abs() < 1e-15);
    assert_eq!(recording.channel("tip_x_m").unwrap(), [0.5, 0.5, 0.25, 0.0]);
    assert_eq!(recording.gap(), [true, false, true, false]);
    assert_eq!(recording.channel("tension_1_n"), None);
    let mut expected = meta();
    expected.extra.insert("journal.empty_channels".into(), "tension_1_n".into());
    assert_eq!(recording.meta(), &expected);
    assert_eq!(journal.notes, [(0.015, "tracker: no pose for 20 ms".to_owned())]);
    assert_eq!(journal.lost_bytes, 0);
    assert_eq!(file::read_bytes(&path).unwrap(), example_bytes());
    // What was read can be kept as any other recording.
    let kept = folder.path().join("kept.parquet");
    recording.write(&kept).unwrap();
    assert_eq!(&Recording::read(&kept).unwrap(), recording);
}

#[test]
fn a_journal_killed_at_any_byte_keeps_every_whole_row() {
    let bytes = example_bytes();
    let ends = ends(&bytes);
    assert_eq!(ends.len(), 6);
    for n in 0..bytes.len() {
        let whole = ends.iter().filter(|end| **end <= n).count();
        let rows = [0, 0, 1, 2, 2, 3][whole];
        match parse(&bytes[..n]) {
            Ok(journal) => {
                assert_eq!(journal.recording.n_samples(), rows, "{n} bytes");
                assert_eq!(journal.lost_bytes, n - ends[whole - 1]);
                let lost = journal.recording.meta().extra.get(LOST_BYTES).map(String::as_str);
                assert_eq!(lost.unwrap_or("0"), journal.lost_bytes.to_string());
            }
            Err(bad) => {
                assert_eq!(rows, 0, "{n} bytes: {bad}");
                let place = if whole == 0 { "start of the file" } else { "rows" };
                assert_eq!(bad.place, place, "{n} bytes: {bad}");
            }
        }
    }
}

#[test]
fn zeros_after_the_end_are_lost_bytes() {
    let mut bytes = example_bytes();
    bytes.extend([0; 100]);
    let journal = parse(&bytes).unwrap();
    assert_eq!((journal.recording.n_samples(), journal.lost_bytes), (4, 100));
}

#[test]
fn damage_in_the_middle_ends_the_data_there() {
    let bytes = example_bytes();
    let ends = ends(&bytes);
    for at in ends[1]..ends[2] {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x10;
        let journal = parse(&damaged).unwrap();
        assert_eq!(journal.recording.n_samples(), 1, "byte {at}");
        assert_eq!(journal.lost_bytes, bytes.len() - ends[1]);
    }
}

#[test]
fn frames_that_no_writer_makes_end_the_data() {
    let bytes = example_bytes();
    let row = |time: f64, values: &[f64]| {
        let body = [time].iter().chain(values).flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        [&[ROW], &body[..]].concat()
    };
    let frames = [
        row(0.03, &[0.0; 3]),                  // not later
        row(NAN, &[0.0; 3]),                   // no time
        row(0.04, &[0.0, f64::INFINITY, 0.0]), // infinite
        row(0.04, &[0.0; 2]),                  // another width
        vec![NOTE, 0, 0, 0, 0, 0, 0, 0, 0, 0xff],
        vec![NOTE, 1],
        vec![b'?', 0, 0, 0, 0, 0, 0, 0, 0],
        vec![],
    ];
    for payload in frames {
        let mut longer = bytes.clone();
        framed_into(&mut longer, |out| out.extend_from_slice(&payload));
        let journal = parse(&longer).unwrap();
        assert_eq!(journal.recording.n_samples(), 4, "{payload:?}");
        assert_eq!(journal.lost_bytes, FRAME + payload.len());
    }
}

#[test]
fn other_headers_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let whole = String::from_utf8(header(&names(), &meta()).unwrap()).unwrap();
    let reject = |header: &str, place: &str| {
        let mut bytes = MAGIC.to_vec();
        framed_into(&mut bytes, |out| out.extend_from_slice(header.as_bytes()));
        framed_into(&mut bytes, |out| {
            out.push(ROW);
            out.extend([0; 32]);
        });
        let path = folder.path().join("x.journal");
        std::fs::write(&path, bytes).unwrap();
        match Journal::read(&path) {
            Err(Error::BadInput(bad)) => assert_eq!(bad.place, format!("{}: {place}", path.display())),
            other => panic!("{header}: {other:?}"),
        }
    };
    reject(&whole.replace("\"version\":1", "\"version\":2"), "header");
    reject(&whole.replace(FORMAT, "other"), "header");
    reject(&whole.replace("\"seed\"", "\"SEED\""), "metadata");
    reject(&whole.replace("tip_x_m", "tip_x"), "tip_x");
    reject(&whole.replace("\"channels\"", "\"colours\""), "start of the file");
    reject("H", "start of the file");
    reject("R", "start of the file");
    // A hole in the strokes, since the second never had a value.
    let path = folder.path().join("strokes.journal");
    let names = ["stroke_1_m", "stroke_2_m", "stroke_3_m"].map(str::to_owned);
    let mut journal = JournalWriter::create(&path, &names, &meta()).unwrap();
    journal.append(0.0, &[0.0, NAN, 0.0]).unwrap();
    assert!(Journal::read(&path).unwrap_err().to_string().contains("stroke number 2 next"));
}

#[test]
fn what_cannot_be_read_back_is_not_appended() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.journal");
    let mut journal = JournalWriter::create(&path, &names(), &meta()).unwrap();
    journal.append(1.0, &[0.0; 3]).unwrap();
    let before = file::read_bytes(&path).unwrap();
    let reject = |result: io::Result<()>| {
        assert_eq!(result.unwrap_err().kind(), io::ErrorKind::InvalidInput);
        assert_eq!(file::read_bytes(&path).unwrap(), before);
    };
    reject(journal.append(1.0, &[0.0; 3]));
    reject(journal.append(NAN, &[0.0; 3]));
    reject(journal.append(f64::INFINITY, &[0.0; 3]));
    reject(journal.append(2.0, &[0.0; 2]));
    reject(journal.append(2.0, &[0.0, f64::NEG_INFINITY, 0.0]));
    reject(journal.note(NAN, "x"));
    reject(journal.note(2.0, &"x".repeat(LONGEST_NOTE + 1)));
}

#[test]
fn create_refuses_other_names_and_files_that_exist() {
    let folder = tempfile::tempdir().unwrap();
    let path = write_example(folder.path(), "a.journal");
    let bytes = file::read_bytes(&path).unwrap();
    let reject =
        |path: &Path, names: &[String], expected: &str| match JournalWriter::create(path, names, &meta()) {
            Err(Error::BadInput(bad)) => assert_eq!(bad.expected, expected),
            other => panic!("{other:?}"),
        };
    reject(&path, &names(), "a new file");
    assert_eq!(file::read_bytes(&path).unwrap(), bytes);
    reject(&folder.path().join("a.csv"), &names(), "a name ending in .journal");
    reject(&folder.path().join("b.journal"), &["tip_x_mm".to_owned()], "a name ending in an SI unit");
    assert!(!folder.path().join("b.journal").exists());
    assert!(matches!(
        JournalWriter::create(path.join("b.journal"), &names(), &meta()),
        Err(Error::Io { .. }) // a file where a folder should be
    ));
}

#[test]
fn a_recording_is_not_written_as_a_journal() {
    let folder = tempfile::tempdir().unwrap();
    let recording = Recording::read(write_example(folder.path(), "a.journal")).unwrap();
    let path = folder.path().join("b.journal");
    assert!(matches!(recording.write(&path), Err(Error::BadInput(_))));
    assert!(!path.exists());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_of_the_file_system() {
    let full = || Arc::new(OpenOptions::new().append(true).open("/dev/full").unwrap());
    let kind = |result: io::Result<()>| result.unwrap_err().kind();
    let header = header(&names(), &meta()).unwrap();
    assert_eq!(kind(JournalWriter::begin(full(), &header, 3).map(|_| ())), io::ErrorKind::StorageFull);
    let output = Output { file: full(), length: 0, is_broken: false };
    let mut journal = JournalWriter { frames: Frames::new(1), output };
    assert_eq!(kind(journal.append(0.0, &[0.0])), io::ErrorKind::StorageFull);
    assert!(journal.output.is_broken); // a device has no length to return to
    // A device cannot be truncated: the operating system reports it, not the check of the row.
    let error = journal.append(0.0, &[0.0]).unwrap_err();
    assert!(error.kind() == io::ErrorKind::InvalidInput && error.raw_os_error().is_some(), "{error}");
}

#[test]
fn a_torn_frame_is_cut_before_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.journal");
    let mut journal = JournalWriter::create(&path, &names(), &meta()).unwrap();
    journal.append(0.0, &[0.0; 3]).unwrap();
    journal.output.file.append_all(b"torn").unwrap();
    journal.output.is_broken = true;
    journal.append(1.0, &[0.0; 3]).unwrap();
    let read = Journal::read(&path).unwrap();
    assert_eq!((read.recording.n_samples(), read.lost_bytes), (2, 0));
}

#[test]
fn appending_a_row_does_not_grow_the_buffer() {
    let folder = tempfile::tempdir().unwrap();
    let mut journal = JournalWriter::create(folder.path().join("a.journal"), &names(), &meta()).unwrap();
    let before = (journal.frames.frame.as_ptr(), journal.frames.frame.capacity());
    for row in 0..100 {
        journal.append(f64::from(row), &[0.0; 3]).unwrap();
    }
    assert_eq!((journal.frames.frame.as_ptr(), journal.frames.frame.capacity()), before);
}

proptest! {
    #[test]
    fn damaged_bytes_give_the_rows_before_them_and_no_panic(
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..5),
        cut in any::<prop::sample::Index>(),
        is_cut in any::<bool>(),
    ) {
        let whole = example_bytes();
        let mut bytes = whole.clone();
        let mut first = bytes.len();
        for (at, byte) in damage {
            let at = at.index(bytes.len());
            if bytes[at] != byte {
                first = first.min(at);
            }
            bytes[at] = byte;
        }
        if is_cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        let before = parse(&whole[..first.min(bytes.len())]);
        if let (Ok(before), Ok(found)) = (before, parse(&bytes)) {
            prop_assert!(found.recording.time().starts_with(before.recording.time()));
        }
    }

    #[test]
    fn frames_of_any_content_make_no_reader_panic(
        payloads in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..40), 0..6),
        is_after_header in any::<bool>(),
    ) {
        let mut bytes = MAGIC.to_vec();
        if is_after_header {
            framed_into(&mut bytes, |out| out.extend(header(&names(), &meta()).unwrap()));
        }
        for payload in payloads {
            framed_into(&mut bytes, |out| out.extend_from_slice(&payload));
        }
        let _ = parse(&bytes);
    }
}

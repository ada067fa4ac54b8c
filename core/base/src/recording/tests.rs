//! Both kinds of file, and every way in which they can be wrong.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use super::*;
use crate::Error;
use std::collections::BTreeMap;

fn meta() -> Metadata {
    Metadata {
        scene_hash: file::sha256_hex(b"scene"),
        seed: Some(u64::MAX),
        commit: "0123abc".into(),
        source: "simulate, two\nlines: \"quoted\" ".into(),
        command: "\"hysteron\" simulate scene.toml".into(),
        extra: BTreeMap::from([("plan.family".into(), "circle".into()), ("note".into(), String::new())]),
    }
}

fn example() -> Recording {
    let channels = vec![
        Channel::new("stroke_2_m", vec![0.1 + 0.2, 5e-324, -1e300]),
        Channel::new("stroke_1_m", vec![0.0045, -0.0, 1.0 / 3.0]),
        Channel::new("tip_x_m", vec![1e-9, 2.5, -0.08]),
        Channel::new("tip_qw", vec![1.0, 0.999, 0.998]),
        Channel::new("tick_goal_1", vec![2048.0, 2049.0, 2050.0]),
        Channel::new("load_1", vec![0.5, -0.5, 1e-20]),
        Channel::new("aux_01_m", vec![0.0, 1e-5, 2e-5]),
        Channel::new("tension_1_n", vec![0.0, 3.5, 100.0]),
    ];
    Recording::new(vec![0.0, 0.01, 0.02], channels, vec![false, true, false], meta()).unwrap()
}

fn bad<T: std::fmt::Debug>(result: Result<T>) -> BadInput {
    match result {
        Err(Error::BadInput(bad)) => bad,
        other => panic!("{other:?}"),
    }
}

fn read_csv(text: &str) -> Check<Recording> {
    csv::read(text)
}

/// The text is rejected at this place, showing this.
fn csv_rejects(text: &str, place: &str, found: &str) -> BadInput {
    let bad = read_csv(text).unwrap_err();
    assert_eq!((bad.place.as_str(), bad.found.as_str()), (place, found), "{bad}");
    bad
}

#[test]
fn both_files_return_the_same_recording_and_bytes() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.csv", "a.parquet"] {
        let path = folder.path().join(name);
        example().write(&path).unwrap();
        let bytes = file::read_bytes(&path).unwrap();
        let back = Recording::read(&path).unwrap();
        assert_eq!(back, example(), "{name}");
        assert!(back.channel("stroke_1_m").unwrap()[1].is_sign_negative());
        back.write(&path).unwrap();
        assert_eq!(file::read_bytes(&path).unwrap(), bytes, "{name}");
    }
}

/// A number in newtons for a millimetre is a thousandth of that for a metre, in every kind of file.
#[test]
fn units_under_a_fraction_line_come_back_from_every_file() {
    let folder = tempfile::tempdir().unwrap();
    let names =
        ["a_n_m_per_m", "b_m_per_n", "c_m_s2_per_m", "d_per_m", "e_rad_s2_per_n_m", "f_n_m_s_per_rad"];
    let channels = names.map(|name| Channel::new(name, vec![-9.81, 1.0 / 3.0]));
    let written = Recording::new(vec![0.0, 0.1], channels.to_vec(), Vec::new(), meta()).unwrap();
    for ending in ["csv", "parquet"] {
        let path = folder.path().join(format!("r.{ending}"));
        written.write(&path).unwrap();
        assert_eq!(Recording::read(&path).unwrap(), written, "{ending}");
    }
    let mut text = Vec::new();
    csv::write(&written, &mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    let header = "time_s,a_n_m_per_mm,b_mm_per_n,c_m_s2_per_mm,d_per_mm,e_rad_s2_per_n_m,f_n_m_s_per_rad,gap";
    let row = "0,-0.00981,-9810,-0.00981,-0.00981,-9.81,-9.81,0";
    assert!(text.contains(header) && text.contains(row), "{text}");
    for (column, si) in [("a_n_m_per_mm", 2000.0), ("a_n_m_per_deg", 2.0 * 180.0 / std::f64::consts::PI)] {
        let read = read_csv(&format!("time_s,{column}\n0,2\n")).unwrap();
        assert_eq!(read.channels()[0].values, [si]);
    }
}

#[test]
fn csv_is_written_for_people() {
    let channels = vec![Channel::new("stroke_1_m", vec![0.0045]), Channel::new("tension_1_n", vec![1.5])];
    let meta = Metadata { seed: Some(7), source: "rig".into(), ..Metadata::default() };
    let recording = Recording::new(vec![0.25], channels, vec![], meta).unwrap();
    let mut out = Vec::new();
    csv::write(&recording, &mut out).unwrap();
    let expected = "# format: hysteron-recording\n# version: 1\n# scene_hash:\n# seed: 7\n# commit:\n\
                    # source: rig\n# command:\ntime_s,stroke_1_mm,tension_1_n,gap\n0.25,4.5,1.5,0\n";
    assert_eq!(String::from_utf8(out).unwrap(), expected);
}

#[test]
fn csv_by_hand_needs_only_header_and_rows() {
    let text = "\u{feff}# by hand\r\n# source: me\r\ntime_ms, stroke_1_mm ,tip_x_m,angle_deg\r\n0,1,2,180\r\n10,1.5,2,0\r\n";
    let recording = read_csv(text).unwrap();
    assert_eq!(recording.time(), [0.0, 0.01]);
    assert_eq!(recording.channel("stroke_1_m").unwrap(), [0.001, 0.0015]);
    assert_eq!(recording.channel("tip_x_m").unwrap(), [2.0, 2.0]);
    assert_eq!(recording.channel("angle_rad").unwrap(), [std::f64::consts::PI, 0.0]);
    assert_eq!(recording.gap(), [false, false]);
    assert_eq!((recording.meta().source.as_str(), recording.meta().seed), ("me", None));
}

#[test]
fn accessors_find_vectors_in_order() {
    let recording = example();
    assert_eq!(recording.n_samples(), 3);
    assert_eq!(recording.strokes(), [&[0.0045, -0.0, 1.0 / 3.0][..], &[0.1 + 0.2, 5e-324, -1e300]]);
    assert_eq!(recording.aux().len(), 1);
    assert_eq!(recording.numbered("tension", "n").len(), 1);
    assert_eq!(recording.numbered("tick_goal", "").len(), 1);
    assert!(recording.tip().is_none() && recording.tip_orientation().is_none());
    assert_eq!(recording.require("tip_x_m").unwrap()[1], 2.5);
    let missing = recording.require("tip_y_m").unwrap_err();
    assert_eq!(missing.expected, "a channel tip_y_m");
    assert!(missing.found.starts_with("stroke_2_m, stroke_1_m, tip_x_m"), "{missing}");
    let xyz = ["tip_z_m", "tip_x_m", "tip_y_m"].map(|name| Channel::new(name, vec![name.len() as f64]));
    let recording = Recording::new(vec![0.0], xyz.to_vec(), vec![], meta()).unwrap();
    assert_eq!(recording.tip().unwrap(), [&[7.0][..]; 3]);
}

#[test]
fn rate_is_known_when_uniform_within_one_percent() {
    let rate = |time: &[f64]| Recording::new(time.to_vec(), vec![], vec![], meta()).unwrap().rate_hz();
    assert!((rate(&[1.0, 1.01, 1.02, 1.03]).unwrap() - 100.0).abs() < 1e-9);
    assert!(rate(&[0.0, 1.0, 2.009]).is_some());
    assert_eq!(rate(&[0.0, 1.0, 2.03]), None);
    assert_eq!(rate(&[0.0]), None);
}

#[test]
fn recording_rejects_what_is_not_one() {
    let reject = |time: &[f64], channels: &[(&str, &[f64])], gap: &[bool], place: &str, found: &str| {
        let channels = channels.iter().map(|(name, values)| Channel::new(*name, values.to_vec())).collect();
        let bad = Recording::new(time.to_vec(), channels, gap.to_vec(), meta()).unwrap_err();
        assert_eq!((bad.place.as_str(), bad.found.as_str()), (place, found), "{bad}");
    };
    reject(&[], &[], &[], "time_s", "none");
    reject(&[0.0, f64::NAN], &[], &[], "row 2: time_s", "NaN");
    reject(&[0.0, 1.0, 1.0], &[], &[], "row 3: time_s", "1 s");
    reject(&[0.0], &[], &[true, false], "gap", "2");
    reject(&[0.0], &[("tip_x_m", &[])], &[], "tip_x_m", "0");
    reject(&[0.0], &[("tip_x_m", &[f64::INFINITY])], &[], "row 1: tip_x_m", "inf");
    reject(&[0.0], &[("tip_x_m", &[0.0]), ("tip_x_m", &[0.0])], &[], "tip_x_m", "tip_x_m twice");
    reject(&[0.0], &[("tip_x_mm", &[0.0])], &[], "tip_x_mm", "tip_x_mm");
    reject(&[0.0], &[("stroke_1", &[0.0])], &[], "stroke_1", "`stroke_1`");
    reject(&[0.0], &[("a,b_m", &[0.0])], &[], "a,b_m", "`a,b_m`");
    reject(&[0.0], &[("", &[0.0])], &[], "an empty name", "``");
    reject(&[0.0], &[("time_s", &[0.0])], &[], "time_s", "time_s twice");
    reject(&[0.0], &[("stroke_2_m", &[0.0])], &[], "stroke_2_m", "number 2");
    reject(&[0.0], &[("aux_1_m", &[0.0]), ("aux_01_m", &[0.0])], &[], "aux_01_m", "number 1");
    for key in ["seed", "Upper", ""] {
        let meta = Metadata { extra: BTreeMap::from([(key.into(), "x".into())]), ..Metadata::default() };
        let bad = Recording::new(vec![0.0], vec![], vec![], meta).unwrap_err();
        assert_eq!((bad.place.as_str(), bad.found), ("metadata", format!("{key:?}")));
    }
}

#[test]
fn csv_errors_name_line_and_column() {
    csv_rejects("# source: x\ntime_s,tip_x_mm\n0,1\n1,nan\n", "line 4: tip_x_mm", "nan");
    csv_rejects("time_s,tip_x_mm\n0,1e999\n", "line 2: tip_x_mm", "1e999");
    csv_rejects("time_s,tip_x_mm\n0,\n", "line 2: tip_x_mm", "an empty cell");
    csv_rejects("time_s,tip_x_mm\n0,1\n\n1,abc\n", "line 4: tip_x_mm", "\"abc\"");
    csv_rejects("time_s,tip_qw\n0,abc\n", "line 2: tip_qw", "\"abc\"");
    let bad = csv_rejects("time_s,tip_x_mm\n0,1\n2,1\n1.5,1\n", "line 4: time_s", "1.5 s");
    assert_eq!(bad.expected, "a time after 2 s");
    csv_rejects("time_s,gap\n0,2\n", "line 2: gap", "\"2\"");
    csv_rejects("time_s,tip_x_mm\n0\n", "line 2", "1");
}

#[test]
fn csv_errors_name_the_header() {
    csv_rejects("stroke_1_mm\n0\n", "line 1: header", "stroke_1_mm");
    csv_rejects("", "line 1: header", "none");
    csv_rejects("time_s,tip_x_mm\n", "line 2", "none");
    let bad = csv_rejects("# a\ntime_s,stroke_1\n0,1\n", "line 2: stroke_1", "`stroke_1`");
    assert_eq!(bad.hint, "stroke_1_mm");
    assert_eq!(csv_rejects("time,tip_x_mm\n", "line 1: time", "`time`").hint, "time_s");
    assert_eq!(csv_rejects("time_s,tip_x_inch\n", "line 1: tip_x_inch", "`tip_x_inch`").hint, "tip_x_mm");
    assert_eq!(csv_rejects("time_s,tension_1\n", "line 1: tension_1", "`tension_1`").hint, "tension_1_n");
    csv_rejects("time_s,tip_x_mm,tip_x_m\n0,1,1\n", "line 1: tip_x_m", "tip_x_m twice");
    csv_rejects("time_s,time_ms\n0,1\n", "line 1: time_ms", "time_s twice");
    csv_rejects("time_s,gap,gap\n0,1,1\n", "line 1: gap", "gap twice");
    csv_rejects("time_s;tip_x_mm\n0;1\n", "line 1: header", "`time_s;tip_x_mm`");
    csv_rejects("time_s,Tip_mm\n0,1\n", "line 1: Tip_mm", "`Tip_mm`");
}

#[test]
fn csv_errors_name_the_metadata() {
    csv_rejects("# format: other\ntime_s\n0\n", "metadata format", "other");
    csv_rejects("# version: 2\ntime_s\n0\n", "metadata version", "2");
    csv_rejects("# seed: -1\ntime_s\n0\n", "metadata seed", "-1");
    csv_rejects("# source: a\n# source: b\ntime_s\n0\n", "metadata source", "a second one");
    csv_rejects("# source: \"a\ntime_s\n0\n", "line 1: source", "\"a");
}

/// Writes a parquet file of another make: columns of doubles, optional if marked so, and these pairs.
fn foreign_parquet(path: &Path, columns: &str, pairs: &[(&str, &str)]) {
    use ::parquet::data_type::DoubleType;
    use ::parquet::file::{metadata::KeyValue, properties::WriterProperties, writer::SerializedFileWriter};
    let schema = ::parquet::schema::parser::parse_message_type(columns).unwrap();
    let pairs = pairs.iter().map(|(k, v)| KeyValue::new((*k).to_owned(), (*v).to_owned())).collect();
    let properties = WriterProperties::builder().set_key_value_metadata(Some(pairs)).build();
    let mut writer = SerializedFileWriter::new(Vec::new(), schema.into(), properties.into()).unwrap();
    let mut group = writer.next_row_group().unwrap();
    while let Some(mut column) = group.next_column().unwrap() {
        column.typed::<DoubleType>().write_batch(&[1.0], Some(&[1]), None).unwrap();
        column.close().unwrap();
    }
    group.close().unwrap();
    file::write_bytes(path, writer.into_inner().unwrap()).unwrap();
}

#[test]
fn parquet_of_another_make_is_read_as_csv_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.parquet");
    // As pandas writes it: every column may have missing values, and there is a key of its own.
    let columns = "message m { optional double time_ms; optional double tip_x_mm; optional double gap; }";
    foreign_parquet(&path, columns, &[("pandas", "{}")]);
    let read = Recording::read(&path).unwrap();
    assert_eq!(
        (read.time(), read.channel("tip_x_m").unwrap(), read.gap()),
        (&[1e-3][..], &[1e-3][..], &[true][..])
    );
    assert_eq!(*read.meta(), Metadata::default());
    assert_eq!(Recording::read_metadata(&path).unwrap(), Metadata::default());
}

#[test]
fn more_rows_than_a_recording_may_have_are_refused_before_they_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.parquet");
    foreign_parquet(&path, "message m { required double time_s; }", &[]);
    let mut bytes = std::fs::read(&path).unwrap();
    let many = [0x80, 0x90, 0xdf, 0xc0, 0x4a]; // 10^10 in zigzag: 2 * 10^10 as a varint
    let footer =
        bytes.len() - 8 - u32::from_le_bytes(*bytes[bytes.len() - 8..].first_chunk().unwrap()) as usize;
    let name = bytes[footer..].windows(6).position(|window| window == b"time_s").unwrap();
    // Behind the schema: a field i64 whose number is one more, and 2 in zigzag.
    let rows = footer
        + name
        + 6
        + bytes[footer + name + 6..].windows(2).position(|two| two == [0x16, 0x02]).unwrap();
    bytes.splice(rows + 1..rows + 2, many);
    let end = bytes.len();
    let length = (end - 8 - footer) as u32;
    bytes[end - 8..end - 4].copy_from_slice(&length.to_le_bytes());
    file::write_bytes(&path, bytes).unwrap();
    let bad = bad(Recording::read(&path));
    assert_eq!(bad.found, "10000000000 rows of 1 columns", "{bad}");
}

#[test]
fn parquet_of_another_make_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.parquet");
    let ours = [("format", "hysteron-recording"), ("version", "1")];
    let reject = |columns: &str, pairs: &[(&str, &str)], place: &str, found: &str| {
        foreign_parquet(&path, columns, pairs);
        let bad = bad(Recording::read(&path));
        assert_eq!(bad.place, format!("{}: {place}", path.display()), "{bad}");
        assert_eq!(bad.found, found, "{bad}");
    };
    let good = "message m { required double time_s; required double tip_x_m; }";
    foreign_parquet(&path, good, &ours);
    assert_eq!(Recording::read(&path).unwrap().gap(), [false]);
    reject(good, &[("format", "hysteron-recording")], "metadata version", "a parquet file without it");
    reject(good, &[("format", "other"), ("version", "1")], "metadata format", "other");
    reject(good, &[("format", "hysteron-recording"), ("version", "2")], "metadata version", "2");
    reject("message m { required double tip_x_m; }", &ours, "columns", "tip_x_m");
    let lists = "message m { required double time_s; optional group a { optional double tip_x_m; } }";
    reject(lists, &ours, "a.tip_x_m", "`a.tip_x_m`");
    reject("message m { required double time_s; required double tip_x; }", &ours, "tip_x", "`tip_x`");
}

#[test]
fn every_truncation_of_a_parquet_file_is_bad_input() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.parquet");
    example().write(&path).unwrap();
    let length = std::fs::metadata(&path).unwrap().len();
    let file = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
    for n in (0..length).rev() {
        file.set_len(n).unwrap();
        let bad = bad(Recording::read(&path));
        assert!(bad.place.starts_with(&path.display().to_string()), "{bad}");
    }
}

#[test]
fn no_damaged_byte_of_a_parquet_file_makes_the_reader_panic() {
    use std::io::{Seek, SeekFrom, Write};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.parquet");
    let whole = parquet::to_bytes(&example()).unwrap();
    file::write_bytes(&path, &whole).unwrap();
    let mut file = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
    for (i, byte) in whole.iter().enumerate() {
        for replaced in [byte ^ 0x01, byte ^ 0x80, byte ^ 0xff, *byte] {
            file.seek(SeekFrom::Start(i as u64)).unwrap();
            file.write_all(&[replaced]).unwrap();
            // What is damaged may be a number or a letter of the metadata, and then it is read.
            if let Err(error) = Recording::read(&path) {
                assert!(matches!(error, Error::BadInput(_)), "byte {i}: {error}");
                assert!(replaced != *byte);
            }
        }
    }
}

#[test]
fn other_extensions_and_missing_files_are_bad_input() {
    for (path, found) in [("a.txt", ".txt"), ("a", "no extension"), ("a.CSV", ".CSV")] {
        assert_eq!(bad(Recording::read(path)).found, found);
        assert_eq!(bad(example().write(path)).found, found);
    }
    assert_eq!(bad(Recording::read("nowhere.csv")).found, "nothing there");
    assert_eq!(bad(Recording::read("nowhere.parquet")).found, "nothing there");
}

#[test]
fn columns_that_grow_are_counted_twice() {
    for rows in [1, 1_000_000] {
        let [reserved, grown] = [ColumnMemory::Reserved, ColumnMemory::Grown].map(|it| it.n_bytes(9, rows));
        assert_eq!(reserved, (9 * rows) as f64 * size_of::<f64>() as f64);
        assert_eq!(grown, 2.0 * reserved);
    }
}

//! Files of pyarrow 26 and polars 2 (`tests/data/tables/write.py`): every codec, every type.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

use super::Table;
use crate::Recording;
use std::path::{Path, PathBuf};

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/tables").join(name)
}

fn table(name: &str) -> Table {
    Table::read(&path(name), None).unwrap()
}

#[test]
fn every_codec_gives_the_same_recording() {
    for codec in ["none", "snappy", "gzip", "brotli", "lz4", "zstd", "v2_pages"] {
        let recording = Recording::read(path(&format!("{codec}.parquet"))).unwrap();
        assert_eq!(recording.n_samples(), 41, "{codec}");
        for (k, (t, stroke)) in recording.time().iter().zip(recording.strokes()[0]).enumerate() {
            assert_eq!((*t, *stroke), (0.05 * k as f64, 0.1 * k as f64 / 1000.0), "{codec}");
        }
    }
    assert_eq!(Recording::read(path("strokes_zstd.parquet")).unwrap().strokes().len(), 4);
}

#[test]
fn stamps_spans_and_times_of_day_are_seconds() {
    let table = table("types.parquet");
    let column = |name: &str| table.index(name).unwrap();
    for name in [
        "stamp_ns", "stamp_us", "stamp_ms", "span_ns", "span_us", "span_ms", "clock_ns", "clock_us",
        "clock_ms",
    ] {
        assert_eq!(table.columns()[column(name)].values, [0.0, 0.05, 0.1, 0.15, 0.2], "{name}");
        assert!(table.is_in_seconds(column(name)), "{name}");
    }
    for name in ["stamp_s", "span_s", "text_stamp"] {
        let first = if name == "text_stamp" { 0.5 } else { 0.0 };
        let expected: Vec<f64> = (0..5).map(|k| first + f64::from(k)).collect();
        assert_eq!(table.columns()[column(name)].values, expected, "{name}");
        assert!(table.is_in_seconds(column(name)), "{name}");
    }
    assert_eq!(table.clock(column("stamp_ns")), Some(1.7e9));
    assert_eq!(table.clock(column("text_stamp")), Some(1.7e9));
    assert_eq!(table.clock(column("span_ns")), None);
    // The day of that second began 80 000 s before.
    assert_eq!(table.clock(column("day")), Some(1.7e9 - 80_000.0));
    assert_eq!(table.columns()[column("day")].values[4], 4.0 * 86_400.0);
    let julian = self::table("int96.parquet");
    assert_eq!(julian.columns()[0].values, [0.0, 0.05, 0.1, 0.15, 0.2]);
    assert_eq!(julian.clock(0), Some(1.7e9));
}

#[test]
fn numbers_of_every_type() {
    let table = table("types.parquet");
    let values = |name: &str| table.columns()[table.index(name).unwrap()].values.clone();
    for name in ["i8", "i16", "i32", "i64"] {
        assert_eq!(values(name), [-2.0, -1.0, 0.0, 1.0, 2.0], "{name}");
    }
    for (name, first) in
        [("u8", 255.0), ("u16", 65_535.0), ("u32", 4_294_967_295.0), ("u64", 9_223_372_036_854_775_808.0)]
    {
        assert_eq!(values(name), [first, 1.0, 2.0, 3.0, 4.0], "{name}");
    }
    assert_eq!(values("f16"), [1.5, -2.0, 0.25, 65_504.0, 0.0]);
    assert_eq!(values("f32"), [1.5, -2.0, 0.25, 3.0, 4.0]);
    assert!(values("f64")[3].is_nan() && values("f64")[4] == 4.0);
    assert_eq!(values("flag"), [1.0, 0.0, 1.0, 1.0, 0.0]);
    assert_eq!(values("dec"), [1.5, -2.25, 0.001, 3.0, 4.0]);
    assert_eq!(values("dec_wide"), [1.5, -2.25, 1e-6, 3.0, 4.0]);
    assert_eq!(values("dec_256"), [1.5, -2.25, 1e-6, 3.0, 4.0]);
    assert_eq!(values("dict_number"), [1.5, 2.5, 1.5, 2.5, 1.5]);
    let whole = self::table("decimal_as_integer.parquet");
    assert!(whole.columns().iter().all(|column| column.values == [1.5, -2.25]));
}

#[test]
fn words_lists_and_parts_of_tables() {
    let table = table("types.parquet");
    for name in ["word", "large_word", "dict_word"] {
        let k = table.index(name).unwrap();
        assert_eq!(
            (table.word(k, 0), table.word(k, 1), table.word(k, 4)),
            (Some("a"), Some("b"), Some("c")),
            "{name}"
        );
    }
    assert_eq!(table.word(table.index("word").unwrap(), 3), None);
    let values = |name: &str| table.columns()[table.index(name).unwrap()].values.clone();
    assert_eq!(values("fixed[3]"), [3.0; 5]);
    assert_eq!(values("large_list[2]"), [2.0; 5]);
    let pair = values("pair[2]");
    assert!(pair[..2] == [2.0, 4.0] && pair[2].is_nan() && pair[3] == 6.0 && pair[4].is_nan());
    assert_eq!(values("pose.x"), [0.0, 1.0, 2.0, 3.0, 4.0]);
    let left_out: Vec<&str> = table.left_out().iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(left_out, ["ragged", "raw"]);
}

#[test]
fn durations_of_polars_are_times_of_a_recording() {
    let polars = table("polars.parquet");
    assert_eq!(polars.columns()[0].values, [0.0, 0.05, 0.1, 0.15, 0.2]);
    assert_eq!(polars.columns()[1].values, [0.0, 0.05, 0.1, 0.15, 0.2]);
    assert_eq!(polars.word(3, 1), Some("b"));
}

#[test]
fn stamps_of_a_recording_begin_at_zero_in_seconds() {
    let recording = Recording::read(path("datetime_ns.parquet")).unwrap();
    assert_eq!(recording.n_samples(), 41);
    for (k, t) in recording.time().iter().enumerate() {
        // Written by way of doubles of seconds since 1970, which a quarter of a microsecond separates.
        assert!((t - 0.05 * k as f64).abs() < 2.5e-7, "{t}");
    }
}

#[test]
fn a_span_of_time_is_no_length() {
    let error = Recording::read(path("span_as_length.parquet")).unwrap_err().to_string();
    assert!(
        error.contains("stroke_1_mm: expected a column of numbers, got one of stamps or spans of time"),
        "{error}"
    );
}

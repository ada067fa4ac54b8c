//! Tables and descriptions of their columns with damages and slips: read, or refused in the one form of an error.

use std::path::Path;
use std::time::{Duration, Instant};

use hysteron_arm_estimation::*;
use hysteron_base::{Error, Metadata, Recording};
use hysteron_fuzz::text::{slipped, slips};
use hysteron_fuzz::{assert_in_house_form, damaged, damages, drive};

use crate::import::{COLUMNS, bam_entries, bam_log, log, write_lerobot};

/// Most memory of this process, other tests included [bytes].
const MEMORY_MAX: u64 = 1_000_000_000;

/// An array of sixteen-bit numbers (40 × 3) as numpy writes it.
fn npy() -> Vec<u8> {
    let header = "{'descr': '<i2', 'fortran_order': False, 'shape': (40, 3), }\n";
    let numbers = (0..40_i16).flat_map(|k| [k, 3 * k, -k]).flat_map(i16::to_le_bytes);
    let length = u16::try_from(header.len()).unwrap().to_le_bytes();
    b"\x93NUMPY\x01\x00".iter().copied().chain(length).chain(header.bytes()).chain(numbers).collect()
}

/// Imports `bytes` as `path`, and checks the result.
fn imported(path: &Path, bytes: &[u8], columns: Option<&ColumnMap>, bad_rows: BadRows) {
    std::fs::write(path, bytes).unwrap();
    let options = ImportOptions { columns: columns.cloned(), bad_rows, ..Default::default() };
    match import(path, &options, Metadata::default()) {
        Ok(imported) => {
            let n = imported.recording.n_samples();
            for channel in imported.recording.channels() {
                assert!(channel.values.len() == n && channel.values.iter().all(|x| x.is_finite()));
            }
        }
        Err(error) => {
            let bad = if let Error::BadInput(bad) = &error { Some(bad) } else { None };
            assert_in_house_form(bad, &error);
        }
    }
}

#[test]
fn no_damage_to_a_table_does_harm() {
    let folder = tempfile::tempdir().unwrap();
    let parquet = folder.path().join("episode.parquet");
    write_lerobot(&parquet, 1);
    let by_number =
        "format = \"hysteron-columns\"\nversion = 1\n[columns]\ntime_ms = 1\n\"q_*_deg\" = [2, 3]\n";
    let files = [
        ("log.csv", log(0, "5000,0,0,10,20,-1000").into_bytes(), ColumnMap::parse(COLUMNS, "test").ok()),
        ("log.npy", npy(), ColumnMap::parse(by_number, "test").ok()),
        ("log.json", bam_log("xl330", &bam_entries().join(",")).into_bytes(), None),
        ("log.parquet", std::fs::read(&parquet).unwrap(), ColumnMap::named("lerobot-deg").ok()),
    ];
    for (name, bytes, columns) in &files {
        let path = folder.path().join(name);
        imported(&path, bytes, columns.as_ref(), BadRows::Refuse);
        let options = ImportOptions { columns: columns.clone(), ..Default::default() };
        import(&path, &options, Metadata::default()).unwrap();
    }
    let rows = [BadRows::Refuse, BadRows::LeaveOut];
    drive(
        "table of an arm",
        400,
        MEMORY_MAX,
        (damages(), 0..files.len(), 0..2_usize),
        |(damages, k, rule)| {
            let (name, bytes, columns) = &files[k];
            imported(&folder.path().join(name), &damaged(bytes, &damages), columns.as_ref(), rows[rule]);
        },
    );
}

/// Longest that a damaged file takes [s].
const TIME_MAX: Duration = Duration::from_secs(1);

#[test]
fn no_damage_to_a_file_of_another_program_does_harm() {
    let tables = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../core/base/tests/data/tables");
    let mut paths: Vec<_> = std::fs::read_dir(tables).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension != "toml" && extension != "py"));
    paths.sort();
    let files: Vec<_> = paths
        .iter()
        .map(|path| (path.file_name().unwrap().to_owned(), std::fs::read(path).unwrap()))
        .collect();
    assert!(files.len() > 15);
    let folder = tempfile::tempdir().unwrap();
    let check = |error: &Error| {
        let bad = if let Error::BadInput(bad) = error { Some(bad) } else { None };
        assert_in_house_form(bad, error);
    };
    drive("table of another program", 600, MEMORY_MAX, (damages(), 0..files.len()), |(damages, k)| {
        let (name, bytes) = &files[k];
        let path = folder.path().join(name);
        std::fs::write(&path, damaged(bytes, &damages)).unwrap();
        let start = Instant::now();
        if let Err(error) = hysteron_base::import::propose_for(&path) {
            check(&error);
        }
        if path.extension().is_some_and(|extension| extension == "parquet")
            && let Err(error) = Recording::read(&path)
        {
            check(&error);
        }
        assert!(start.elapsed() < TIME_MAX, "{:?} for {name:?}", start.elapsed());
    });
}

#[test]
fn no_slip_in_a_description_of_columns_does_harm() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    let bytes = log(0, "5000,0,0,10,20,-1000").into_bytes();
    let lists = "format = \"hysteron-columns\"\nversion = 1\nrate_hz = 100.0\n[lists]\nq = { file = \"q.txt\", width = 7 }\n\
                 [columns]\n\"q_*_rad\" = \"q[*]\"\n";
    let texts = [COLUMNS, lists];
    drive("description of columns", 400, MEMORY_MAX, (slips(), 0..2_usize), |(slips, k)| {
        match ColumnMap::parse(&slipped(texts[k], &slips), "columns.toml") {
            Ok(columns) => imported(&path, &bytes, Some(&columns), BadRows::Refuse),
            Err(bad) => assert_in_house_form(Some(&bad), &bad),
        }
    });
}

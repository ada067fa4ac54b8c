//! Tables that other programs wrote, and the maps by which they are imported.

use std::path::{Path, PathBuf};

use hysteron_base::import::{self, ColumnMap, Request};
use hysteron_base::{Channel, Metadata, Recording, Table, TrajectoryShard};
use hysteron_fuzz::text::{slipped, slips};
use hysteron_fuzz::{Damage, damaged, damages, drive};
use proptest::prelude::*;
use proptest::sample::Index;

use super::{Case, MEMORY_MAX, refused, refused_by_base};

/// The folder of tables that pyarrow, polars, NumPy and SciPy wrote.
fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/tables")
}

/// The tables of that ending.
fn written(ending: &str) -> Vec<Vec<u8>> {
    let paths = std::fs::read_dir(folder()).unwrap().map(|entry| entry.unwrap().path());
    let mut paths: Vec<PathBuf> = paths.filter(|path| path.to_string_lossy().ends_with(ending)).collect();
    paths.sort();
    let files: Vec<Vec<u8>> = paths.iter().map(|path| std::fs::read(path).unwrap()).collect();
    assert!(!files.is_empty(), "{ending}");
    files
}

/// Reads a table; what is accepted has columns of one length.
fn read(path: &Path) {
    match Table::read(path, None) {
        Ok(table) => {
            let n = table.n_rows();
            assert!(n > 0 && table.columns().iter().all(|column| column.values.len() == n));
            for k in 0..table.columns().len() {
                assert!(table.clock(k).is_none_or(f64::is_finite));
                let _ = (table.shown(k, n - 1), table.unit(k).len());
            }
        }
        Err(error) => refused_by_base(&error),
    }
}

const TEXTS: [&str; 8] = [
    "t;q\n0,0;0,5\n0,1;-1,25\n0,2;3e-2\n",
    "sep=;\nt;q\n0.0;0.5\n0.1;-1.25\n",
    "t,\"x, \"\"left\"\"\",\"two\nlines\"\n0,1,2\n1,2,3\n",
    "Logger 3000\nserial 17\n\nt,q\n[s],[mm]\n0.0,0.5\n0.1,-1.25\n",
    "# t q\n0.0 0.5\n% pause\n0.1 -1.25\n",
    "when,q\n2024-05-06T12:00:00.5Z,1\n2024-05-06T14:00:01+02:00,2\n2024-05-06 12:00:01.25,3\n",
    "day;clock;q\n2024-05-06;12:00:00,5;1,5\n2024-05-06;12:00:01;2\n06.05.2024;23:59:60;3\n",
    "t|label|q\n0.0|a|0.5\n0.1|b|-1.25\n0.2||nan\n",
];

#[test]
fn no_slip_in_a_table_of_text_does_harm() {
    let case = Case::new("a.csv");
    drive("table, text", 2000, MEMORY_MAX, (slips(), 0..TEXTS.len()), |(slips, k)| {
        read(case.write(slipped(TEXTS[k], &slips)));
    });
    drive("table, bytes of text", 1000, MEMORY_MAX, (damages(), 0..TEXTS.len()), |(damages, k)| {
        read(case.write(damaged(TEXTS[k].as_bytes(), &damages)));
    });
}

/// Dates and times of day as people and programs write them, and what only looks like one.
fn stamp() -> impl Strategy<Value = String> {
    let number = |most: u32| prop_oneof![4 => 0..most, 1 => any::<u32>()];
    let date = (number(10_000), number(14), number(33), 0..3_usize).prop_map(|(y, m, d, how)| match how {
        0 => format!("{y:04}-{m:02}-{d:02}"),
        1 => format!("{d:02}.{m:02}.{y}"),
        _ => format!("{m}/{d}/{y}"),
    });
    let clock = (number(26), number(62), number(62), "[.,]?[0-9]{0,20}")
        .prop_map(|(h, m, s, rest)| format!("{h:02}:{m:02}:{s:02}{rest}"));
    let zone = prop_oneof![
        Just(String::new()),
        Just("Z".to_owned()),
        (number(30), number(70)).prop_map(|(h, m)| format!("+{h:02}:{m:02}")),
        "[-+ A-Z0-9:]{0,8}",
    ];
    (date, "[T _]?", clock, zone)
        .prop_map(|(date, between, clock, zone)| [date, between, clock, zone].concat())
}

#[test]
fn no_stamp_does_harm() {
    let case = Case::new("a.csv");
    let stamps = prop::collection::vec(stamp(), 1..6);
    drive("stamps", 2000, MEMORY_MAX, stamps, |stamps| {
        let rows: String = stamps.iter().enumerate().map(|(k, stamp)| format!("\"{stamp}\";{k}\n")).collect();
        read(case.write(format!("when;q\n{rows}")));
    });
}

/// A part of a Parquet file.
#[derive(Debug, Clone)]
enum Part {
    /// The schema, the statistics, where the pages are: its length is updated.
    Footer,
    /// The first bytes of a page: its sizes and codec.
    PageHeader(Index),
    /// Length of the footer, as stated.
    FooterLength([u8; 4]),
    Anywhere,
}

fn part() -> impl Strategy<Value = Part> {
    prop_oneof![
        4 => Just(Part::Footer),
        4 => any::<Index>().prop_map(Part::PageHeader),
        1 => any::<[u8; 4]>().prop_map(Part::FooterLength),
        2 => Just(Part::Anywhere),
    ]
}

/// A file of Parquet and where its pages are.
struct Pages {
    bytes: Vec<u8>,
    /// Where the footer begins.
    footer: usize,
    /// Where the first page of each column begins.
    pages: Vec<usize>,
}

/// Bytes of a page's header, about.
const PAGE_HEADER: usize = 40;
/// Length of the footer and the mark behind it.
const TAIL: usize = 8;

impl Pages {
    fn of(bytes: Vec<u8>) -> Self {
        let reader = parquet::file::metadata::ParquetMetaDataReader::new();
        let mut file = tempfile::tempfile().unwrap();
        std::io::Write::write_all(&mut file, &bytes).unwrap();
        let metadata = reader.parse_and_finish(&file).unwrap();
        let columns = metadata.row_groups().iter().flat_map(|group| group.columns());
        let starts = columns.flat_map(|column| {
            [column.dictionary_page_offset(), Some(column.data_page_offset())].into_iter().flatten()
        });
        let pages = starts.map(|start| usize::try_from(start).unwrap()).collect();
        let length = bytes[bytes.len() - TAIL..][..4].try_into().unwrap();
        let footer = bytes.len() - TAIL - u32::from_le_bytes(length) as usize;
        Self { bytes, footer, pages }
    }

    fn damaged(&self, part: &Part, damages: &[Damage]) -> Vec<u8> {
        let (data, rest) = self.bytes.split_at(self.footer);
        let (footer, tail) = rest.split_at(rest.len() - TAIL);
        match part {
            Part::Footer => {
                let footer = damaged(footer, damages);
                let length = (footer.len() as u32).to_le_bytes();
                [data, &footer, &length, &tail[4..]].concat()
            }
            Part::PageHeader(at) => {
                let from = self.pages[at.index(self.pages.len())];
                let to = (from + PAGE_HEADER).min(data.len());
                // As long as before, so that everything else is at its place in the footer.
                let mut header = damaged(&data[from..to], damages);
                header.resize(to - from, 0);
                [&data[..from], &header, &data[to..], rest].concat()
            }
            Part::FooterLength(length) => [data, footer, length, &tail[4..]].concat(),
            Part::Anywhere => damaged(&self.bytes, damages),
        }
    }
}

#[test]
fn no_damage_to_a_parquet_file_does_harm() {
    let files: Vec<Pages> = written(".parquet").into_iter().map(Pages::of).collect();
    let case = Case::new("a.parquet");
    let damage = (any::<Index>(), part(), damages());
    drive("table, Parquet", 1000, MEMORY_MAX, damage, |(which, part, damages)| {
        read(case.write(files[which.index(files.len())].damaged(&part, &damages)));
    });
}

/// The bytes of a small shard of two trajectories.
fn shard() -> Vec<u8> {
    let recording = || {
        let channel = Channel::new("stroke_1_m", (0..40).map(|i| 1e-3 * f64::from(i).sin()).collect());
        Recording::new((0..40).map(f64::from).collect(), vec![channel], vec![], Metadata::default()).unwrap()
    };
    let parts = vec![(3, recording()), (4, recording())];
    TrajectoryShard::new(Metadata::default(), parts).unwrap().to_bytes().unwrap()
}

#[test]
fn no_damage_to_a_shard_does_harm() {
    let pages = Pages::of(shard());
    let case = Case::new("a.parquet");
    drive("shard, Parquet", 1000, MEMORY_MAX, (part(), damages()), |(part, damages)| {
        if let Err(error) = TrajectoryShard::read(case.write(pages.damaged(&part, &damages))) {
            refused_by_base(&error);
        }
    });
}

/// An `.npy` with this text in its header, its length as it then is.
fn with_header(array: &[u8], header: &str) -> Vec<u8> {
    let length = usize::from(u16::from_le_bytes([array[8], array[9]]));
    let stated = (header.len() as u16).to_le_bytes();
    [&array[..8], &stated, header.as_bytes(), &array[10 + length..]].concat()
}

/// An archive of one stored array, all its sizes as they are.
fn archive(array: &[u8]) -> Vec<u8> {
    let size = (array.len() as u32).to_le_bytes();
    let name: &[u8] = b"q.npy";
    let common = [&[0; 2][..], &[0; 8], &size, &size, &[5, 0, 0, 0]].concat();
    let local = [b"PK\x03\x04\x14\0\0\0", &common[..], name, array].concat();
    let entry = [b"PK\x01\x02\x14\0\x14\0\0\0", &common[..], &[0; 14], name].concat();
    let [length, at] = [entry.len(), local.len()].map(|n| (n as u32).to_le_bytes());
    let end = [b"PK\x05\x06\0\0\0\0\x01\0\x01\0", &length[..], &at, &[0; 2]].concat();
    [local, entry, end].concat()
}

#[test]
fn no_damage_to_arrays_of_numpy_does_harm() {
    let array = written(".npy").remove(0);
    let header =
        String::from_utf8(array[10..10 + usize::from(u16::from_le_bytes([array[8], array[9]]))].to_vec());
    let header = header.unwrap().replace(", '", ",\n '").replace(": ", " = ");
    let [single, several] = [Case::new("a.npy"), Case::new("a.npz")];
    read(single.write(with_header(&array, &header.replace(" = ", ": "))));
    read(several.write(archive(&array)));
    drive("array, header", 1000, MEMORY_MAX, slips(), |slips| {
        let changed = with_header(&array, &slipped(&header, &slips).replace(" = ", ": "));
        read(single.write(&changed));
        read(several.write(archive(&changed)));
    });
    drive("array, bytes", 1000, MEMORY_MAX, damages(), |damages| {
        let changed = damaged(&array, &damages);
        read(single.write(&changed));
        read(several.write(archive(&changed)));
    });
    let whole = written(".npz").remove(0);
    drive("arrays, archive", 1000, MEMORY_MAX, damages(), |damages| {
        read(several.write(damaged(&whole, &damages)));
    });
}

/// Bytes of the head of a MAT file.
const MAT_HEAD: usize = 128;
/// Type of an element that is compressed.
const COMPRESSED: u32 = 15;

/// The elements of a MAT file of little end, those that are compressed as they are without.
fn elements(bytes: &[u8]) -> Vec<Vec<u8>> {
    let (mut rest, mut found) = (&bytes[MAT_HEAD..], Vec::new());
    while rest.len() >= 8 {
        let word = |at: usize| u32::from_le_bytes(rest[at..at + 4].try_into().unwrap());
        let end = 8 + word(4) as usize;
        match word(0) {
            COMPRESSED => found.push(miniz_oxide::inflate::decompress_to_vec_zlib(&rest[8..end]).unwrap()),
            _ => found.push(rest[..end].to_vec()),
        }
        rest = &rest[end..];
    }
    found
}

/// A MAT file of these elements, each compressed.
fn compressed(head: &[u8], elements: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = head.to_vec();
    for element in elements {
        let packed = miniz_oxide::deflate::compress_to_vec_zlib(element, 1);
        bytes.extend([COMPRESSED.to_le_bytes(), (packed.len() as u32).to_le_bytes()].concat());
        bytes.extend(packed);
    }
    bytes
}

#[test]
fn no_damage_to_a_mat_file_does_harm() {
    let files = written("v5.mat").into_iter().chain(written("v5_compressed.mat")).collect::<Vec<_>>();
    let case = Case::new("a.mat");
    for file in &files {
        read(case.write(compressed(&file[..MAT_HEAD], &elements(file))));
    }
    drive("MAT, bytes", 1000, MEMORY_MAX, (any::<Index>(), damages()), |(which, damages)| {
        read(case.write(damaged(&files[which.index(files.len())], &damages)));
    });
    let damage = (any::<Index>(), any::<Index>(), damages());
    drive("MAT, elements", 1000, MEMORY_MAX, damage, |(which, element, damages)| {
        let file = &files[which.index(files.len())];
        let mut elements = elements(file);
        let k = element.index(elements.len());
        elements[k] = damaged(&elements[k], &damages);
        read(case.write(compressed(&file[..MAT_HEAD], &elements)));
        read(case.write([&file[..MAT_HEAD], &elements.concat()].concat()));
    });
}

#[test]
fn no_slip_in_a_map_does_harm() {
    let map = std::fs::read_to_string(folder().join("cols.toml")).unwrap();
    let table = folder().join("semicolon_decimal_comma.csv");
    ColumnMap::parse(&map, "cols.toml").unwrap();
    drive("map of columns", 2000, MEMORY_MAX, slips(), |slips| {
        match ColumnMap::parse(&slipped(&map, &slips), "cols.toml") {
            Ok(columns) => {
                let request = Request { columns: Some(columns), ..Request::default() };
                match import::read(std::slice::from_ref(&table), &request, Metadata::default()) {
                    Ok(read) => assert!(!read.is_empty()),
                    Err(error) => refused_by_base(&error),
                }
            }
            Err(bad) => refused(&bad),
        }
    });
    let case = Case::new("a.csv");
    let text = std::fs::read_to_string(&table).unwrap();
    drive("import of a table", 500, MEMORY_MAX, slips(), |slips| {
        let request =
            Request { columns: Some(ColumnMap::parse(&map, "cols.toml").unwrap()), ..Request::default() };
        let path = case.write(slipped(&text, &slips)).clone();
        if let Err(error) = import::read(&[path], &request, Metadata::default()) {
            refused_by_base(&error);
        }
    });
}

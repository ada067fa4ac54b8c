//! Files of other programs, read unchanged.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

use super::*;

fn of_text(text: &str) -> Table {
    text::read(text, &TextFormat::default()).unwrap()
}

#[test]
fn separators_and_headers_are_seen() {
    for text in [
        "t,q\n0,1\n1,2\n",
        "t;q\n0;1\n1;2\n",
        "t\tq\n0\t1\n1\t2\n",
        "  t   q\n 0  1 \n\n 1  2\n",
        "# x\n\"t\", \"q\"\n0, 1\n1, 2",
    ] {
        let table = of_text(text);
        assert_eq!(table.names(), "t, q", "{text:?}");
        assert_eq!(table.columns()[1].values, [1.0, 2.0], "{text:?}");
    }
    let bare = of_text("0,1.5\n1,-2e3\n");
    assert_eq!((bare.names().as_str(), bare.n_rows()), ("1, 2", 2));
    assert_eq!(bare.columns()[1].values, [1.5, -2000.0]);
}

/// Two columns, 0.5 and -1.25 in the second.
#[test]
fn tables_of_every_program_are_read() {
    for text in [
        "t;q\n0,0;0,5\n0,1;-1,25\n",        // a spreadsheet of central Europe
        "t\tq\n0,0\t0,5\n0,1\t-1,25\n",     // the same, copied
        "t q\n0,0 0,5\n0,1 -1,25\n",        // decimal commas between spaces
        "t|q\n0.0|0.5\n0.1|-1.25\n",        // a database
        "sep=;\nt;q\n0.0;0.5\n0.1;-1.25\n", // Excel
        "\u{feff}\"t\",\"q\"\r\n\"0.0\",\"0.5\"\r\n\"0.1\",\"-1.25\"\r\n", // quotes throughout, CRLF, BOM
        "t,q\n[s],[mm]\n0.0,0.5\n0.1,-1.25\n", // a row of units
        "t;q\ns;N\n0,0;0,5\n0,1;-1,25\n",   // the same, without brackets
        "Logger 3000\nserial 17\n\nt,q\n0.0,0.5\n0.1,-1.25\n", // an instrument's preamble
        "# t q\n0.0 0.5\n0.1 -1.25\n",      // numpy.savetxt
        "% made by hand\nt,q\n0.0,0.5\n% pause\n0.1,-1.25\n", // comments of MATLAB
        "t,q\n0.0,0.5\n0.1,\u{2212}1.25\n", // a typesetter's minus sign
    ] {
        let table = of_text(text);
        assert_eq!((table.names().as_str(), table.n_rows()), ("t, q", 2), "{text:?}");
        assert_eq!(table.columns()[0].values, [0.0, 0.1], "{text:?}");
        assert_eq!(table.columns()[1].values, [0.5, -1.25], "{text:?}");
    }
    let units = of_text("t,q\n[s],[mm]\n0.0,0.5\n");
    assert_eq!((units.unit(0), units.unit(1), units.row_name(0)), ("s", "mm", "line 3".to_owned()));
    let quoted = of_text("t,\"x, \"\"left\"\"\",\"two\nlines\"\n0,1,2\n");
    assert_eq!(
        (quoted.names().as_str(), quoted.row_name(0)),
        ("t, x, \"left\", two lines", "line 3".to_owned())
    );
}

#[test]
fn stamps_are_seconds_from_the_first_and_zones_count() {
    let text = "when,q\n2024-05-06T12:00:00.5Z,1\n2024-05-06T14:00:01+02:00,2\n2024-05-06 12:00:01.25,3\n";
    let table = of_text(text);
    assert_eq!(table.columns()[0].values, [0.5, 1.0, 1.25]);
    assert_eq!((table.clock(0), table.is_in_seconds(0), table.clock(1)), (Some(1_714_996_800.0), true, None));
    let apart = of_text("day;clock;q\n2024-05-06;12:00:00,5;1,5\n2024-05-06;12:00:01;2\n");
    assert_eq!((apart.clock(0), apart.clock(1)), (Some(1_714_953_600.0), Some(43_200.0)));
    assert_eq!(apart.columns()[1].values, [0.5, 1.0]);
}

#[test]
fn text_of_every_encoding() {
    let text = "t,\u{e4}\n0,1\n";
    let le: Vec<u8> = [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let be: Vec<u8> = [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(u16::to_be_bytes).collect();
    for bytes in [text.as_bytes().to_vec(), le, be, b"t,\xe4\n0,1\n".to_vec()] {
        assert_eq!(of_text(&text::decoded(bytes)).names(), "t, \u{e4}");
    }
}

#[test]
fn a_header_of_another_width_is_refused_and_what_is_stated_is_taken() {
    let error = text::read("a,b\n1,2,3\n4,5,6\n", &TextFormat::default()).unwrap_err().to_string();
    assert!(error.contains("line 1: expected a header of 3 cells, as the rows below have, got 2"), "{error}");
    // Two columns, or one with decimal commas: ambiguous.
    let stated = TextFormat { delimiter: Some(' '), decimal: Some(',') };
    assert_eq!(of_text("1,2\n3,4\n").names(), "1, 2");
    assert_eq!(text::read("1,2\n3,4\n", &stated).unwrap().columns()[0].values, [1.2, 3.4]);
    // A character of one's own.
    let stated = TextFormat { delimiter: Some('~'), decimal: None };
    assert_eq!(text::read("a~b\n3~4\n", &stated).unwrap().columns()[1].values, [4.0]);
}

#[test]
fn cells_without_a_number_are_known_by_their_line() {
    let table = of_text("t,q,label\n0,1,a\n\n1,,b\n2,x,b\n3,4\n");
    assert_eq!(table.uneven(), [(3, 2)]);
    assert!(table.columns()[1].values[1..].iter().all(|x| x.is_nan()));
    assert_eq!((table.row_name(2), table.shown(1, 2)), ("line 5".to_owned(), "\"x\"".to_owned()));
    assert_eq!(table.shown(1, 1), "no number");
    let only_b = RowFilter { column: "label".into(), value: "b".into() };
    let filtered = of_text("t,q,label\n0,1,a\n\n1,5,b\n2,6,b\n").filtered(&only_b).unwrap();
    assert_eq!(
        (filtered.columns()[1].values.as_slice(), filtered.row_name(0)),
        (&[5.0, 6.0][..], "line 4".to_owned())
    );
    let nowhere = RowFilter { column: "label".into(), value: "c".into() };
    assert!(of_text("t,label\n0,a\n").filtered(&nowhere).unwrap_err().to_string().contains("label = c"));
    assert!(of_text("t,q\n0,1\n").filtered(&nowhere).unwrap_err().to_string().contains("a column \"label\""));
}

#[test]
fn nothing_is_no_table() {
    let nothing = "a table of numbers";
    for (text, expected) in
        [("", nothing), ("\n\n", nothing), ("t,q\n", "at least one row of numbers"), ("\u{feff}", nothing)]
    {
        let bad = text::read(text, &TextFormat::default()).unwrap_err();
        assert_eq!(bad.expected, expected, "{text:?}");
    }
}

/// An `.npy` of this type and shape.
fn npy(descr: &str, fortran: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

#[test]
fn arrays_of_every_type_and_order() {
    let read = |descr: &str, data: &[u8]| {
        npz::read_single(&npy(descr, "False", "(2,)", data)).unwrap().columns()[0].values.clone()
    };
    assert_eq!(read("<f8", &[1.5_f64.to_le_bytes(), (-2.0_f64).to_le_bytes()].concat()), [1.5, -2.0]);
    assert_eq!(read(">f4", &[1.5_f32.to_be_bytes(), (-2.0_f32).to_be_bytes()].concat()), [1.5, -2.0]);
    assert_eq!(read("<i2", &[7_i16.to_le_bytes(), (-7_i16).to_le_bytes()].concat()), [7.0, -7.0]);
    assert_eq!(read(">i8", &[7_i64.to_be_bytes(), (-7_i64).to_be_bytes()].concat()), [7.0, -7.0]);
    assert_eq!(read("|u1", &[7, 255]), [7.0, 255.0]);
    assert_eq!(read("|b1", &[1, 0]), [1.0, 0.0]);
    let by_columns = npz::read_single(&npy("|u1", "True", "(2, 3)", &[1, 2, 3, 4, 5, 6])).unwrap();
    assert_eq!(by_columns.names(), "array[1], array[2], array[3]");
    assert_eq!(by_columns.columns()[1].values, [3.0, 4.0]);
    for (bytes, expected, found) in [
        (npy("<f8", "False", "(2,)", &[0; 15]), "a whole archive of arrays", "an early end"),
        (npy("<f8", "False", "(99999999999, 9)", &[]), "a NumPy array", "a shape too large"),
        (npy("|O", "False", "(2,)", &[0; 16]), "numbers with one or two axes", "another"),
        (b"PK".to_vec(), "a NumPy array", "another beginning"),
    ] {
        let bad = npz::read_single(&bytes).unwrap_err();
        assert!(bad.expected.contains(expected) && bad.found == found, "{bad}");
    }
}

#[test]
fn halves_records_and_archives_of_numpy() {
    let file = |name: &str| {
        Table::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/tables").join(name), None)
            .unwrap()
    };
    let records = file("structured.npy");
    assert_eq!(records.names(), "t, n, f, flag");
    let values = |k: usize| records.columns()[k].values.clone();
    assert_eq!(values(0), [0.0, 0.05, 0.1, 0.15000000000000002, 0.2]);
    assert_eq!(values(1), [-2.0, -1.0, 0.0, 1.0, 2.0]);
    assert_eq!(values(2), [1.5, -2.0, 0.25, 65_504.0, 0.0]);
    assert_eq!(values(3), [1.0, 0.0, 1.0, 1.0, 0.0]);
    let archive = file("arrays.npz");
    assert_eq!(archive.names(), "t, half, stroke[1], stroke[2]");
    assert_eq!(archive.columns()[1].values, [1.5, -2.0, 0.25, 65_504.0, 0.0]);
    assert_eq!(archive.columns()[3].values, [1.0, 3.0, 5.0, 7.0, 9.0].map(|x: f64| x / 7.0));
    let left_out: Vec<&str> = archive.left_out().iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(left_out, ["name", "other"]);
}

#[test]
fn stored_and_deflated_archives() {
    let array = npy("|u1", "False", "(3,)", &[1, 2, 3]);
    for method in [0_u16, 8] {
        let packed =
            if method == 0 { array.clone() } else { miniz_oxide::deflate::compress_to_vec(&array, 6) };
        let sizes = [(packed.len() as u32).to_le_bytes(), (array.len() as u32).to_le_bytes()].concat();
        let mut bytes = b"PK\x03\x04\x14\0\0\0".to_vec();
        bytes.extend([&method.to_le_bytes()[..], &[0; 8], &sizes, &[5, 0, 0, 0], b"q.npy", &packed].concat());
        let directory = bytes.len() as u32;
        bytes.extend(
            [
                b"PK\x01\x02\x14\0\x14\0\0\0",
                &method.to_le_bytes()[..],
                &[0; 8],
                &sizes,
                &[5, 0, 0, 0],
                &[0; 14],
                b"q.npy",
            ]
            .concat(),
        );
        bytes.extend(
            [b"PK\x05\x06\0\0\0\0\x01\0\x01\0", &[0; 4][..], &directory.to_le_bytes(), &[0; 2]].concat(),
        );
        let table = npz::read_archive(&bytes).unwrap();
        assert_eq!(
            (table.names().as_str(), table.columns()[0].values.as_slice()),
            ("q", &[1.0, 2.0, 3.0][..])
        );
        // Cut short or altered anywhere, it is refused or read, and never stops the program.
        for n in 0..bytes.len() {
            let _ = npz::read_archive(&bytes[..n]);
            let mut altered = bytes.clone();
            altered[n] ^= 0xff;
            let _ = npz::read_archive(&altered);
        }
    }
}

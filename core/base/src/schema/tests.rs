//! Refused files: the message, and the text that it points at.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

use std::collections::BTreeMap;

use serde::Deserialize;

use super::FixedArray;

#[derive(Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    #[serde(default)]
    is_on: bool,
    length: f64,
    count: Option<u64>,
    #[serde(default)]
    part: Vec<Part>,
    #[serde(default)]
    by_name: BTreeMap<String, Part>,
}

#[derive(Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Part {
    kind: Kind,
    at: FixedArray<f64, 3>,
    #[serde(default)]
    of: Option<Either>,
}

#[derive(Debug, Deserialize, PartialEq)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    Hard,
    VerySoft,
}

#[derive(Debug, Deserialize, PartialEq)]
#[serde(untagged, expecting = "a number or a name")]
enum Either {
    Number(f64),
    Name(String),
}

#[test]
fn numbers_may_be_typed_as_whole_or_hexadecimal() {
    let text = r#"
        name = "a\u00e4"
        is_on = true
        length = 3
        count = 18_446_744_073_709_551_615
        [[part]]
        kind = "very-soft"
        at = [1, 0x10, -2.5e-3]
        of = 7
        [[part]]
        kind = "hard"
        at = [inf, -inf, 0.0]
        [by_name.first]
        kind = "hard"
        at = [0, 0, 0]
        of = "x"
    "#;
    let file: File = toml::from_str(text).unwrap();
    assert_eq!((file.length, file.count), (3.0, Some(u64::MAX)));
    assert_eq!((file.part[0].at.0, &file.part[0].kind), ([1.0, 16.0, -2.5e-3], &Kind::VerySoft));
    assert_eq!(
        (&file.part[0].of, &file.by_name["first"].of),
        (&Some(Either::Number(7.0)), &Some(Either::Name("x".into())))
    );
}

/// The message, and the text that it points at; nothing where it is accepted.
fn refused(text: &str) -> Option<(String, &str)> {
    let error = toml::from_str::<File>(text).err()?;
    Some((error.message().to_owned(), &text[error.span()?]))
}

#[test]
fn errors_name_their_place() {
    let with = |line: &str| format!("name = \"a\"\nlength = 1.0\n{line}\n");
    for (line, message, at) in [
        ("count = -1", "invalid value: integer `-1`, expected u64", "-1"),
        ("count = 1.5", "invalid type: floating point `1.5`, expected u64", "1.5"),
        (
            "count = 18446744073709551616",
            "invalid type: integer `18446744073709551616` as i128, expected u64",
            "18446744073709551616",
        ),
        ("is_on = \"yes\"", "invalid type: string \"yes\", expected a boolean", "\"yes\""),
        ("part = 3", "invalid type: integer `3`, expected a sequence", "3"),
        ("leng = 3", "unknown field `leng`", "leng"),
        (
            "part = [{ kind = \"soft\", at = [0, 0, 0] }]",
            "unknown variant `soft`, expected `hard` or `very-soft`",
            "\"soft\"",
        ),
        ("part = [{ kind = 3, at = [0, 0, 0] }]", "wanted string or table", "3"),
        (
            "part = [{ kind = \"hard\", at = [0, 0] }]",
            "invalid length 2, expected an array of length 3",
            "[0, 0]",
        ),
        (
            "part = [{ kind = \"hard\", at = [0, 0, 0, 9] }]",
            "invalid length 4, expected an array of length 3",
            "[0, 0, 0, 9]",
        ),
        ("part = [{ kind = \"hard\" }]", "missing field `at`", "{ kind = \"hard\" }"),
        ("part = [{ kind = \"hard\", at = [0, 0, 0], of = [1] }]", "a number or a name", "[1]"),
    ] {
        let text = with(line);
        let found = refused(&text);
        let is_expected =
            found.as_ref().is_some_and(|(found, place)| found.starts_with(message) && *place == at);
        assert!(is_expected, "{line}: {found:?}");
    }
    let day = with("").replace("1.0", "1979-05-27");
    assert_eq!(refused(&day), Some(("invalid type: map, expected f64".to_owned(), "1979-05-27")));
}

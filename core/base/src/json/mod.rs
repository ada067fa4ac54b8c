//! JSON that reads back what was written, numbers that are not finite included.
//!
//! JSON has no word for NaN and infinity, and a `null` in their place cannot be read as a number. So they are the texts
//! `"NaN"`, `"Infinity"` and `"-Infinity"`, as in JavaScript; a number that is asked for is read from them too. All files and all output of JSON go through here. In a part that serde holds back to decide on
//! its type (`flatten`, `untagged`) such a text stays a text, and its number is refused.

mod construct;
mod read;
mod write;

use serde::Serialize;
use serde::de::DeserializeOwned;
pub use serde_json::{Error, Map, Value};

#[doc(hidden)]
pub use construct::expression;
use read::JsonReader;
use write::Readable;

/// As a value.
///
/// # Errors
/// Of a map whose keys are no texts, and what the type itself refuses.
pub fn to_value(content: impl Serialize) -> Result<Value, Error> {
    serde_json::to_value(Readable(&content))
}

/// As text on one line.
///
/// # Errors
/// As [`to_value`].
pub fn to_line(content: impl Serialize) -> Result<String, Error> {
    serde_json::to_string(&Readable(&content))
}

/// As text for people, a file of lines.
///
/// # Errors
/// As [`to_value`].
pub fn to_text(content: impl Serialize) -> Result<String, Error> {
    let mut text = serde_json::to_string_pretty(&Readable(&content))?;
    text.push('\n');
    Ok(text)
}

/// Out of a value.
///
/// # Errors
/// If it is not of this type.
pub fn from_value<T: DeserializeOwned>(value: &Value) -> Result<T, Error> {
    T::deserialize(JsonReader(value))
}

/// Out of text, in UTF-8.
///
/// # Errors
/// If it is no JSON, naming line and column, or not of this type.
pub fn from_text<T: DeserializeOwned>(text: impl AsRef<[u8]>) -> Result<T, Error> {
    from_value(&serde_json::from_slice(text.as_ref())?)
}

/// The text of a number that is not finite.
fn name_of(number: f64) -> &'static str {
    match number {
        n if n.is_nan() => "NaN",
        n if n > 0.0 => "Infinity",
        _ => "-Infinity",
    }
}

/// The number of such a text.
fn number_named(text: &str) -> Option<f64> {
    match text {
        "NaN" => Some(f64::NAN),
        "Infinity" => Some(f64::INFINITY),
        "-Infinity" => Some(f64::NEG_INFINITY),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use std::collections::BTreeMap;

    use proptest::prelude::*;
    use serde::Deserialize;

    use super::*;

    /// One of every shape that serde knows.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    struct Everything {
        number: f64,
        single: f32,
        maybe: Option<f64>,
        list: Vec<f64>,
        array: [f64; 2],
        pair: (f64, u64),
        map: BTreeMap<String, f64>,
        by_number: BTreeMap<u32, f64>,
        newtype: Newtype,
        kinds: Vec<Kind>,
        name: String,
        value: Value,
        unit: (),
    }

    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    struct Newtype(f64);

    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    enum Kind {
        Unit,
        Number(f64),
        Pair(f64, i64),
        Fields { number: f64, maybe: Option<f64> },
    }

    fn everything(x: f64, y: f64, name: &str) -> Everything {
        Everything {
            number: x,
            single: y as f32,
            maybe: Some(x),
            list: vec![x, y],
            array: [y, x],
            pair: (x, u64::MAX),
            map: BTreeMap::from([(name.to_owned(), x)]),
            by_number: BTreeMap::from([(7, y)]),
            newtype: Newtype(y),
            kinds: vec![
                Kind::Unit,
                Kind::Number(x),
                Kind::Pair(y, i64::MIN),
                Kind::Fields { number: x, maybe: Some(y) },
                Kind::Fields { number: y, maybe: None },
            ],
            name: name.to_owned(),
            value: serde_json::json!({ "name": name, "none": null }),
            unit: (),
        }
    }

    /// The same bits, of which NaN has many and JSON one.
    fn shown(content: &Everything) -> String {
        format!("{content:?}")
    }

    fn any_number() -> impl Strategy<Value = f64> {
        use proptest::num::f64;
        let special =
            prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0, 5e-324, f64::MAX]);
        prop_oneof![special, f64::ANY]
    }

    mod std {
        pub use ::std::*;
    }

    proptest! {
        #[test]
        fn everything_written_reads_back(x in any_number(), y in any_number(), name in "NaN|Infinity|\\PC*") {
            let content = everything(x, y, &name);
            let value = to_value(&content).unwrap();
            prop_assert_eq!(shown(&from_value(&value).unwrap()), shown(&content));
            for text in [to_line(&content).unwrap(), to_text(&content).unwrap(), value.to_string()] {
                prop_assert_eq!(shown(&from_text(&text).unwrap()), shown(&content));
            }
        }
    }

    #[test]
    fn what_is_not_finite_has_the_names_of_javascript() {
        let numbers = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0, 1.0];
        assert_eq!(to_line(numbers).unwrap(), r#"["NaN","Infinity","-Infinity",-0.0,1.0]"#);
        for (text, what) in [("null", "invalid type"), ("\"nan\"", "invalid"), ("[1]", "invalid type")] {
            let error = from_text::<f64>(text).unwrap_err();
            assert!(error.to_string().contains(what), "{text}: {error}");
        }
    }

    #[test]
    fn a_value_in_a_program_is_as_any_other() {
        let (name, list) = ("a".to_owned(), vec![1.0, f64::NAN]);
        let found = crate::json!({
            "name": name, "list": list, "empty": {}, "none": null, "sum": list[0] + 1.0,
            "in": { "items": [null, [], { "worst": f64::INFINITY }, [f64::NEG_INFINITY, name.len()], if list.is_empty() { 1 } else { 2 }], },
            (format!("{name}_m")): Some(-0.0),
        });
        let expected = r#"{"a_m":-0.0,"empty":{},"in":{"items":[null,[],{"worst":"Infinity"},["-Infinity",1],2]},"list":[1.0,"NaN"],"name":"a","none":null,"sum":2.0}"#;
        assert_eq!(found.to_string(), expected);
        assert_eq!(crate::json!([f64::NAN]).to_string(), r#"["NaN"]"#);
    }

    #[test]
    fn a_text_that_is_no_json_names_its_place() {
        let error = from_text::<f64>("{\n  \"a\": }").unwrap_err();
        assert!(error.to_string().contains("line 2 column 8"), "{error}");
    }
}

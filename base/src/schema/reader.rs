//! A parsed TOML file as what serde reads from.
//!
//! The reader of the crate `toml` hands every value to its visitor by one function for all types, so for each struct
//! and number all of them are built, through layers for spans and dates that no file here has: a third of the code of
//! crates with many files. Here a struct is read from a table, a number from a number, and nothing else is built. An
//! array with more elements than its field holds, which that reader cuts, is an error.

use serde::de::value::StrDeserializer;
use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, Error as _, Expected, IntoDeserializer, MapAccess,
    SeqAccess, Unexpected, Visitor,
};
use serde::forward_to_deserialize_any;
use std::fmt::Display;
use std::marker::PhantomData;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeArray, DeInteger, DeTable, DeValue};

/// What is wrong in a file, and the bytes where it is.
#[derive(Debug)]
pub(super) struct Error {
    pub(super) message: String,
    pub(super) span: Option<Range<usize>>,
}

type Result<T> = std::result::Result<T, Error>;

/// Reads a struct with one field per key.
pub(super) fn read<T: DeserializeOwned>(text: &str) -> Result<T> {
    let table =
        DeTable::parse(text).map_err(|e| Error { message: e.message().to_owned(), span: e.span() })?;
    Node { span: table.span(), value: DeValue::Table(table.into_inner()) }.read(PhantomData)
}

impl Error {
    /// The place, unless something within it has been named.
    fn at(mut self, span: &Range<usize>) -> Self {
        self.span.get_or_insert_with(|| span.clone());
        self
    }
}

impl Display for Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Error {}

impl serde::de::Error for Error {
    fn custom<T: Display>(message: T) -> Self {
        Self { message: message.to_string(), span: None }
    }
}

/// A value and where it stands.
struct Node<'i> {
    span: Range<usize>,
    value: DeValue<'i>,
}

enum Number {
    Signed(i64),
    Unsigned(u64),
    Float(f64),
}

impl<'i> Node<'i> {
    fn of(spanned: Spanned<DeValue<'i>>) -> Self {
        Self { span: spanned.span(), value: spanned.into_inner() }
    }

    /// Every value is read through here, so that an error says where. Not inlined: a file would become one function, on
    /// which a compiler takes a second.
    #[inline(never)]
    fn read<T: DeserializeSeed<'i>>(self, seed: T) -> Result<T::Value> {
        let span = self.span.clone();
        seed.deserialize(self).map_err(|error| error.at(&span))
    }

    fn mismatch(&self, expected: &dyn Expected) -> Error {
        let found = match &self.value {
            DeValue::String(text) => Unexpected::Str(text),
            DeValue::Boolean(flag) => Unexpected::Bool(*flag),
            DeValue::Array(_) => Unexpected::Seq,
            DeValue::Table(_) => Unexpected::Map,
            DeValue::Datetime(_) => Unexpected::Other("date or time"),
            DeValue::Integer(_) | DeValue::Float(_) => match self.number(expected) {
                Ok(Number::Signed(x)) => Unexpected::Signed(x),
                Ok(Number::Unsigned(x)) => Unexpected::Unsigned(x),
                Ok(Number::Float(x)) => Unexpected::Float(x),
                Err(error) => return error,
            },
        };
        Error::invalid_type(found, expected)
    }

    fn number(&self, expected: &dyn Expected) -> Result<Number> {
        let read = match &self.value {
            DeValue::Integer(typed) => whole(typed),
            DeValue::Float(typed) => typed.as_str().parse().ok().and_then(|x: f64| {
                let fits = x.is_finite() || !typed.as_str().contains(|c: char| c.is_ascii_digit());
                fits.then_some(Number::Float(x))
            }),
            _ => return Err(self.mismatch(expected)),
        };
        read.ok_or_else(|| {
            Error::custom(format_args!("invalid value: a number out of range, expected {expected}"))
        })
    }

    fn text(self, expected: &dyn Expected) -> Result<std::borrow::Cow<'i, str>> {
        match self.value {
            DeValue::String(text) => Ok(text),
            _ => Err(self.mismatch(expected)),
        }
    }
}

fn whole(typed: &DeInteger<'_>) -> Option<Number> {
    let (text, radix) = (typed.as_str(), typed.radix());
    let signed = i64::from_str_radix(text, radix).map(Number::Signed);
    signed.or_else(|_| u64::from_str_radix(text, radix).map(Number::Unsigned)).ok()
}

/// A number goes to the visitor as it was typed, which accepts what its type can hold.
macro_rules! numbers {
    ($($method:ident)*) => {$(
        fn $method<V: Visitor<'i>>(self, visitor: V) -> Result<V::Value> {
            match self.number(&visitor)? {
                Number::Signed(x) => visitor.visit_i64(x),
                Number::Unsigned(x) => visitor.visit_u64(x),
                Number::Float(x) => visitor.visit_f64(x),
            }
        }
    )*};
}

impl<'i> Deserializer<'i> for Node<'i> {
    type Error = Error;

    numbers! {
        deserialize_i8 deserialize_i16 deserialize_i32 deserialize_i64 deserialize_i128
        deserialize_u8 deserialize_u16 deserialize_u32 deserialize_u64 deserialize_u128
        deserialize_f32 deserialize_f64
    }

    fn deserialize_bool<V: Visitor<'i>>(self, visitor: V) -> Result<V::Value> {
        match self.value {
            DeValue::Boolean(flag) => visitor.visit_bool(flag),
            _ => Err(self.mismatch(&visitor)),
        }
    }

    fn deserialize_str<V: Visitor<'i>>(self, visitor: V) -> Result<V::Value> {
        let text = self.text(&visitor)?;
        visitor.visit_str(&text)
    }

    fn deserialize_string<V: Visitor<'i>>(self, visitor: V) -> Result<V::Value> {
        self.deserialize_str(visitor)
    }

    fn deserialize_option<V: Visitor<'i>>(self, visitor: V) -> Result<V::Value> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'i>>(self, _: &'static str, visitor: V) -> Result<V::Value> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'i>>(self, visitor: V) -> Result<V::Value> {
        let DeValue::Array(array) = self.value else { return Err(self.mismatch(&visitor)) };
        let n = array.len();
        let mut elements = Elements { left: array.into_iter() };
        let read = visitor.visit_seq(&mut elements);
        match elements.left.len() {
            0 => read,
            left => read.and(Err(too_long(n, n - left))),
        }
    }

    fn deserialize_tuple<V: Visitor<'i>>(self, _: usize, visitor: V) -> Result<V::Value> {
        self.deserialize_seq(visitor)
    }

    fn deserialize_map<V: Visitor<'i>>(self, visitor: V) -> Result<V::Value> {
        let DeValue::Table(table) = self.value else { return Err(self.mismatch(&visitor)) };
        visitor.visit_map(Entries { left: table.into_iter(), value: None })
    }

    fn deserialize_struct<V: Visitor<'i>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value> {
        self.deserialize_map(visitor)
    }

    fn deserialize_enum<V: Visitor<'i>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value> {
        let name = self.text(&OneOf(variants))?;
        let name: StrDeserializer<'_, Error> = (&*name).into_deserializer();
        visitor.visit_enum(name)
    }

    /// For what takes values of several types.
    fn deserialize_any<V: Visitor<'i>>(self, visitor: V) -> Result<V::Value> {
        match &self.value {
            DeValue::Boolean(_) => self.deserialize_bool(visitor),
            DeValue::Integer(_) | DeValue::Float(_) => self.deserialize_f64(visitor),
            DeValue::String(_) => self.deserialize_str(visitor),
            DeValue::Array(_) => self.deserialize_seq(visitor),
            DeValue::Table(_) => self.deserialize_map(visitor),
            DeValue::Datetime(_) => Err(self.mismatch(&visitor)),
        }
    }

    fn deserialize_ignored_any<V: Visitor<'i>>(self, visitor: V) -> Result<V::Value> {
        visitor.visit_unit()
    }

    forward_to_deserialize_any! { <V: Visitor<'i>> char bytes byte_buf unit unit_struct tuple_struct identifier }
}

fn too_long(found: usize, expected: usize) -> Error {
    Error::custom(format_args!("invalid length {found}, expected an array of length {expected}"))
}

struct Elements<'i> {
    left: <DeArray<'i> as IntoIterator>::IntoIter,
}

impl<'i> SeqAccess<'i> for Elements<'i> {
    type Error = Error;

    fn next_element_seed<T: DeserializeSeed<'i>>(&mut self, seed: T) -> Result<Option<T::Value>> {
        self.left.next().map(|value| Node::of(value).read(seed)).transpose()
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.left.len())
    }
}

struct Entries<'i> {
    left: <DeTable<'i> as IntoIterator>::IntoIter,
    value: Option<Node<'i>>,
}

impl<'i> MapAccess<'i> for Entries<'i> {
    type Error = Error;

    fn next_key_seed<K: DeserializeSeed<'i>>(&mut self, seed: K) -> Result<Option<K::Value>> {
        let Some((key, value)) = self.left.next() else { return Ok(None) };
        self.value = Some(Node::of(value));
        let name: StrDeserializer<'_, Error> = (&**key.get_ref()).into_deserializer();
        seed.deserialize(name).map(Some).map_err(|error| error.at(&key.span()))
    }

    fn next_value_seed<T: DeserializeSeed<'i>>(&mut self, seed: T) -> Result<T::Value> {
        self.value.take().ok_or_else(|| Error::custom("a value was read before its key"))?.read(seed)
    }
}

struct OneOf(&'static [&'static str]);

impl Expected for OneOf {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "one of {}", self.0.join(", "))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::*;
    use serde::Deserialize;
    use std::collections::BTreeMap;

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
        at: [f64; 3],
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
    fn a_file_is_read_as_the_reader_of_the_crate_reads_it() {
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
        let file: File = read(text).unwrap();
        assert_eq!(file, toml::from_str(text).unwrap());
        assert_eq!((file.part[0].at, &file.part[0].kind), ([1.0, 16.0, -2.5e-3], &Kind::VerySoft));
    }

    /// The message, and the text that it points at; nothing where it is accepted.
    fn refused(text: &str) -> Option<(String, &str)> {
        let error = read::<File>(text).err()?;
        Some((error.message, &text[error.span?]))
    }

    #[test]
    fn what_is_wrong_is_said_where_it_stands() {
        let with = |line: &str| format!("name = \"a\"\nlength = 1.0\n{line}\n");
        for (line, message, at) in [
            ("count = -1", "invalid value: integer `-1`, expected u64", "-1"),
            ("count = 1.5", "invalid type: floating point `1.5`, expected u64", "1.5"),
            (
                "count = 18446744073709551616",
                "invalid value: a number out of range, expected u64",
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
            (
                "part = [{ kind = 3, at = [0, 0, 0] }]",
                "invalid type: integer `3`, expected one of hard, very-soft",
                "3",
            ),
            (
                "part = [{ kind = \"hard\", at = [0, 0] }]",
                "invalid length 2, expected an array of length 3",
                "[0, 0]",
            ),
            // The reader of the crate drops the fourth.
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
            let is_as_wanted =
                found.as_ref().is_some_and(|(found, place)| found.starts_with(message) && *place == at);
            assert!(is_as_wanted, "{line}: {found:?}");
        }
        let day = with("").replace("1.0", "1979-05-27");
        assert_eq!(
            refused(&day),
            Some(("invalid type: date or time, expected f64".to_owned(), "1979-05-27"))
        );
    }
}

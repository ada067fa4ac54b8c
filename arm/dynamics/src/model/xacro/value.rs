//! Values of expressions, as Python has them.

use std::fmt;
use std::rc::Rc;

/// Result of an evaluation, or what could not be evaluated, in words that follow "got".
pub(super) type Evaluated<T> = Result<T, String>;

/// A number, a word or a list of values.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Bool(bool),
    Int(i64),
    Float(f64),
    Text(Rc<str>),
    List(Rc<Vec<Value>>),
}

impl Value {
    /// Value of a property whose text is `text`: a number or a truth value where it reads as one.
    pub fn literal(text: &str) -> Self {
        if let Some(inner) = text.strip_prefix('\'').and_then(|rest| rest.strip_suffix('\'')) {
            return Self::Text(inner.into());
        }
        let trimmed = text.trim();
        match trimmed {
            "true" | "True" => return Self::Bool(true),
            "false" | "False" => return Self::Bool(false),
            _ if text.contains('_') => return Self::Text(text.into()),
            _ => {}
        }
        let is_number = trimmed.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
        if let (true, Ok(whole)) = (is_number, trimmed.parse()) {
            return Self::Int(whole);
        }
        match trimmed.parse() {
            Ok(number) if is_number => Self::Float(number),
            _ => Self::Text(text.into()),
        }
    }

    /// As a number, where it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Bool(is) => Some(f64::from(u8::from(*is))),
            Self::Int(whole) => Some(*whole as f64),
            Self::Float(number) => Some(*number),
            Self::Text(_) | Self::List(_) => None,
        }
    }

    /// As a whole number, where it is one.
    pub fn whole(&self) -> Option<i64> {
        match self {
            Self::Bool(is) => Some(i64::from(*is)),
            Self::Int(whole) => Some(*whole),
            _ => None,
        }
    }

    /// As Python decides.
    pub fn is_true(&self) -> bool {
        match self {
            Self::Text(text) => !text.is_empty(),
            Self::List(items) => !items.is_empty(),
            other => other.number() != Some(0.0),
        }
    }

    /// As conditions of xacro decide: a word must be true, false or a whole number.
    pub fn condition(&self) -> Option<bool> {
        match self {
            Self::Text(text) => match text.trim() {
                "true" | "True" => Some(true),
                "false" | "False" => Some(false),
                other => other.parse::<i64>().ok().map(|whole| whole != 0),
            },
            other => Some(other.is_true()),
        }
    }

    /// Bytes of its text, roughly.
    pub fn size(&self) -> usize {
        match self {
            Self::Text(text) => text.len(),
            Self::List(items) => items.iter().map(|item| 2 + item.size()).sum(),
            _ => 8,
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bool(true) => f.write_str("True"),
            Self::Bool(false) => f.write_str("False"),
            Self::Int(whole) => write!(f, "{whole}"),
            Self::Float(number) => write_float(*number, f),
            Self::Text(text) => f.write_str(text),
            Self::List(items) => {
                f.write_str("[")?;
                for (k, item) in items.iter().enumerate() {
                    f.write_str(if k == 0 { "" } else { ", " })?;
                    match item {
                        Self::Text(text) => write!(f, "'{text}'")?,
                        other => write!(f, "{other}")?,
                    }
                }
                f.write_str("]")
            }
        }
    }
}

/// The shortest text that gives the same number, as Python writes it.
fn write_float(number: f64, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let size = number.abs();
    if number.is_finite() && size != 0.0 && !(1e-4..1e16).contains(&size) {
        let text = format!("{number:e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let exponent: i32 = exponent.parse().unwrap_or(0);
        let sign = if exponent < 0 { '-' } else { '+' };
        return write!(f, "{digits}e{sign}{:02}", exponent.abs());
    }
    if number.fract() == 0.0 { write!(f, "{number:.1}") } else { write!(f, "{number}") }
}

//! The parts of an expression: numbers, quoted words, names, symbols.

use super::value::{Evaluated, Value};

/// A part of an expression.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Token {
    /// A number or a quoted word.
    Value(Value),
    /// A word without quotes.
    Name(String),
    /// An operator, a bracket or a separator.
    Symbol(&'static str),
    End,
}

/// Symbols, longer ones first.
const SYMBOLS: [&str; 23] = [
    "**", "//", "==", "!=", "<=", ">=", "(", ")", "[", "]", "{", "}", "+", "-", "*", "/", "%", "<", ">", ",",
    ":", ".", "=",
];

/// The parts of `text`, the last of which is its end.
///
/// # Errors
/// The text that is no part of an expression, in words that follow "got".
pub(super) fn tokens(text: &str) -> Evaluated<Vec<Token>> {
    let mut found = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let length = if first.is_ascii_digit() || (first == '.' && starts_number(&rest[1..])) {
            let length = number_length(rest);
            found.push(Token::Value(number(&rest[..length])?));
            length
        } else if first == '\'' || first == '"' {
            let inner = &rest[1..];
            let end = inner.find(first).ok_or("a word without its second quote")?;
            if inner[..end].contains('\\') {
                return Err("a word with \\".to_owned());
            }
            found.push(Token::Value(Value::Text(inner[..end].into())));
            end + 2
        } else if first.is_ascii_alphabetic() || first == '_' {
            let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
            let length = rest.find(|c| !is_part(c)).unwrap_or(rest.len());
            found.push(Token::Name(rest[..length].to_owned()));
            length
        } else {
            let symbol = SYMBOLS.iter().find(|symbol| rest.starts_with(**symbol));
            let symbol = symbol.ok_or_else(|| format!("the character {first}"))?;
            found.push(Token::Symbol(symbol));
            symbol.len()
        };
        rest = rest[length..].trim_start();
    }
    found.push(Token::End);
    Ok(found)
}

fn starts_number(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_digit())
}

fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |from: usize| bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let mut length = digits(0);
    if bytes.get(length) == Some(&b'.') {
        length += 1;
        length += digits(length);
    }
    if matches!(bytes.get(length), Some(b'e' | b'E')) {
        let signed = length + 1 + usize::from(matches!(bytes.get(length + 1), Some(b'+' | b'-')));
        let exponent = if signed <= bytes.len() { digits(signed) } else { 0 };
        if exponent > 0 {
            length = signed + exponent;
        }
    }
    length
}

fn number(text: &str) -> Evaluated<Value> {
    if text.bytes().all(|byte| byte.is_ascii_digit()) {
        return text.parse().map(Value::Int).map_err(|_| format!("the whole number {text}, too large"));
    }
    text.parse().map(Value::Float).map_err(|_| format!("the number {text}"))
}

/// A part as an error quotes it.
pub(super) fn shown(token: &Token) -> String {
    match token {
        Token::Value(value) => format!("\"{value}\""),
        Token::Name(name) => format!("\"{name}\""),
        Token::Symbol(symbol) => format!("\"{symbol}\""),
        Token::End => "the end".to_owned(),
    }
}

//! Expressions of xacro, which are Python's: numbers, words, lists, comparisons, the functions of `math`.
//!
//! Anything else is refused by its name; nothing is guessed.

use std::rc::Rc;

use super::lexer::{Token, shown, tokens};
use super::operations::{call, combine, compare, math_constant};
use super::value::{Evaluated, Value};

/// Parentheses, operators and calls within each other.
const MAX_NESTED: usize = 64;

/// Looks up the value of a name.
pub(super) trait Names {
    /// The value of a property.
    fn property(&mut self, name: &str) -> Evaluated<Option<Value>>;
    /// The value of `$(arg name)`.
    fn argument(&mut self, name: &str) -> Evaluated<Value>;
    /// Accounts for the work on so many bytes.
    fn spend(&mut self, bytes: usize) -> Evaluated<()>;
}

/// The value of an expression.
///
/// # Errors
/// The text that is not understood, in words that follow "got".
pub(super) fn evaluate(text: &str, names: &mut dyn Names) -> Evaluated<Value> {
    let mut parser = Parser { tokens: tokens(text)?, at: 0, depth: 0, names, is_skipping: 0 };
    let value = parser.conditional()?;
    match parser.peek() {
        Token::End => Ok(value),
        other => Err(format!("{} behind an expression", shown(other))),
    }
}

struct Parser<'n> {
    tokens: Vec<Token>,
    at: usize,
    depth: usize,
    names: &'n mut dyn Names,
    /// Above zero in a part that Python would not evaluate: names are not looked up.
    is_skipping: usize,
}

impl Parser<'_> {
    fn peek(&self) -> &Token {
        self.tokens.get(self.at).unwrap_or(&Token::End)
    }

    fn next(&mut self) -> Token {
        let token = self.peek().clone();
        self.at += 1;
        token
    }

    fn takes(&mut self, symbol: &str) -> bool {
        let is_it = matches!(self.peek(), Token::Symbol(found) if *found == symbol);
        self.at += usize::from(is_it);
        is_it
    }

    fn takes_word(&mut self, word: &str) -> bool {
        let is_it = matches!(self.peek(), Token::Name(found) if found == word);
        self.at += usize::from(is_it);
        is_it
    }

    fn must_take(&mut self, symbol: &str) -> Evaluated<()> {
        if self.takes(symbol) { Ok(()) } else { Err(format!("{} for \"{symbol}\"", shown(self.peek()))) }
    }

    /// Evaluates what Python would not, for its syntax alone.
    fn skipped<T>(&mut self, is_skipped: bool, part: impl FnOnce(&mut Self) -> Evaluated<T>) -> Evaluated<T> {
        self.is_skipping += usize::from(is_skipped);
        let found = part(self);
        self.is_skipping -= usize::from(is_skipped);
        found
    }

    /// `a if condition else b`: `a` is evaluated again once it is known that it counts.
    fn conditional(&mut self) -> Evaluated<Value> {
        self.depth += 1;
        if self.depth > MAX_NESTED {
            return Err(format!("more than {MAX_NESTED} levels"));
        }
        let start = self.at;
        let has_if = self.has_if_ahead();
        let mut value = self.skipped(has_if, Self::any_of)?;
        if has_if && self.takes_word("if") {
            let condition = self.any_of()?.is_true();
            if !self.takes_word("else") {
                return Err(format!("{} for \"else\"", shown(self.peek())));
            }
            let other = self.skipped(condition, Self::conditional)?;
            let end = self.at;
            value = other;
            // Syntax alone needs one pass, so that conditions within conditions cost no more than their text.
            if condition && self.is_skipping == 0 {
                self.at = start;
                value = self.any_of()?;
                self.at = end;
            }
        }
        self.depth -= 1;
        Ok(value)
    }

    /// True where an `if` follows in the same pair of parentheses, before a comma.
    fn has_if_ahead(&self) -> bool {
        let mut depth = 0_usize;
        for token in self.tokens.iter().skip(self.at) {
            match token {
                Token::Symbol("(" | "[" | "{") => depth += 1,
                Token::Symbol(")" | "]" | "}") if depth == 0 => return false,
                Token::Symbol(")" | "]" | "}") => depth -= 1,
                Token::Symbol(",") if depth == 0 => return false,
                Token::Name(name) if depth == 0 && name == "if" => return true,
                _ => {}
            }
        }
        false
    }

    fn any_of(&mut self) -> Evaluated<Value> {
        let mut value = self.all_of()?;
        while self.takes_word("or") {
            let is_known = value.is_true();
            let other = self.skipped(is_known, Self::all_of)?;
            value = if is_known { value } else { other };
        }
        Ok(value)
    }

    fn all_of(&mut self) -> Evaluated<Value> {
        let mut value = self.negation()?;
        while self.takes_word("and") {
            let is_known = !value.is_true();
            let other = self.skipped(is_known, Self::negation)?;
            value = if is_known { value } else { other };
        }
        Ok(value)
    }

    fn negation(&mut self) -> Evaluated<Value> {
        let mut n = 0;
        while self.takes_word("not") {
            n += 1;
        }
        let value = self.comparison()?;
        Ok(match n {
            0 => value,
            n => Value::Bool(value.is_true() == (n % 2 == 0)),
        })
    }

    fn comparison(&mut self) -> Evaluated<Value> {
        let mut left = self.sum()?;
        let (mut is_true, mut compared) = (true, false);
        loop {
            let operator = match self.peek() {
                Token::Symbol(symbol @ ("==" | "!=" | "<" | "<=" | ">" | ">=")) => *symbol,
                Token::Name(name) if name == "in" => "in",
                Token::Name(name) if name == "not" => "not",
                _ => break,
            };
            self.at += 1;
            if operator == "not" && !self.takes_word("in") {
                return Err(format!("{} for \"in\"", shown(self.peek())));
            }
            let right = self.sum()?;
            compared = true;
            if self.is_skipping == 0 {
                self.names.spend(left.size() + right.size())?;
                is_true &= compare(operator, &left, &right)?;
            }
            left = right;
        }
        Ok(if compared { Value::Bool(is_true) } else { left })
    }

    fn sum(&mut self) -> Evaluated<Value> {
        let mut value = self.product()?;
        loop {
            let operator = match self.peek() {
                Token::Symbol(symbol @ ("+" | "-")) => *symbol,
                _ => return Ok(value),
            };
            self.at += 1;
            let other = self.product()?;
            value = self.combined(operator, &value, &other)?;
        }
    }

    fn product(&mut self) -> Evaluated<Value> {
        let mut value = self.signed()?;
        loop {
            let operator = match self.peek() {
                Token::Symbol(symbol @ ("*" | "/" | "//" | "%")) => *symbol,
                _ => return Ok(value),
            };
            self.at += 1;
            let other = self.signed()?;
            value = self.combined(operator, &value, &other)?;
        }
    }

    fn signed(&mut self) -> Evaluated<Value> {
        let mut is_negative = false;
        let mut has_sign = false;
        loop {
            if self.takes("-") {
                is_negative = !is_negative;
            } else if !self.takes("+") {
                break;
            }
            has_sign = true;
        }
        let value = self.power()?;
        match (has_sign, is_negative) {
            (false, _) => Ok(value),
            (true, true) => self.combined("-", &Value::Int(0), &value).map(|value| match value {
                Value::Float(0.0) => Value::Float(-0.0),
                other => other,
            }),
            (true, false) => self.combined("+", &Value::Int(0), &value),
        }
    }

    fn power(&mut self) -> Evaluated<Value> {
        let base = self.postfix()?;
        if !self.takes("**") {
            return Ok(base);
        }
        self.depth += 1;
        if self.depth > MAX_NESTED {
            return Err(format!("more than {MAX_NESTED} levels"));
        }
        let exponent = self.signed()?;
        self.depth -= 1;
        self.combined("**", &base, &exponent)
    }

    fn combined(&mut self, operator: &str, a: &Value, b: &Value) -> Evaluated<Value> {
        if self.is_skipping > 0 {
            return Ok(Value::Int(0));
        }
        self.names.spend(a.size() + b.size())?;
        combine(operator, a, b)
    }

    /// A value, its items and members.
    fn postfix(&mut self) -> Evaluated<Value> {
        let mut value = self.atom()?;
        while self.takes("[") {
            let index = self.conditional()?;
            self.must_take("]")?;
            if self.is_skipping > 0 {
                continue;
            }
            let Value::List(items) = &value else {
                return Err("[…] after a value that is not a list".to_owned());
            };
            let at = index.whole().ok_or_else(|| format!("the index {index}"))?;
            let from_end = i64::try_from(items.len()).unwrap_or(0) + at;
            let at = usize::try_from(if at < 0 { from_end } else { at }).ok();
            value = at
                .and_then(|at| items.get(at))
                .cloned()
                .ok_or_else(|| format!("item {index} of {}", items.len()))?;
        }
        Ok(value)
    }

    fn atom(&mut self) -> Evaluated<Value> {
        match self.next() {
            Token::Value(Value::Text(first)) => {
                let mut text = first.to_string();
                while let Token::Value(Value::Text(more)) = self.peek() {
                    text.push_str(more);
                    self.at += 1;
                }
                Ok(Value::Text(text.into()))
            }
            Token::Value(value) => Ok(value),
            Token::Symbol("(") => {
                let value = self.conditional()?;
                if self.takes(",") {
                    let items = self.items(")", vec![value])?;
                    return Ok(Value::List(Rc::new(items)));
                }
                self.must_take(")")?;
                Ok(value)
            }
            Token::Symbol("[") => Ok(Value::List(Rc::new(self.items("]", Vec::new())?))),
            Token::Name(name) => self.named(&name),
            other => Err(format!("{} for a value", shown(&other))),
        }
    }

    /// Values between commas up to `end`.
    fn items(&mut self, end: &'static str, mut items: Vec<Value>) -> Evaluated<Vec<Value>> {
        while !self.takes(end) {
            items.push(self.conditional()?);
            if !self.takes(",") {
                self.must_take(end)?;
                break;
            }
        }
        Ok(items)
    }

    /// A property, a constant, or a function with its arguments.
    fn named(&mut self, name: &str) -> Evaluated<Value> {
        let mut name = name.to_owned();
        if let Some(found) = self.constant(&name)? {
            return Ok(found);
        }
        while self.takes(".") {
            match self.next() {
                Token::Name(part) => name = format!("{name}.{part}"),
                other => return Err(format!("{} behind a point", shown(&other))),
            }
        }
        if self.takes("(") {
            let arguments = self.items(")", Vec::new())?;
            if self.is_skipping > 0 {
                return Ok(Value::Int(0));
            }
            self.names.spend(arguments.iter().map(Value::size).sum())?;
            let bare = ["math.", "python.", "xacro."].iter().find_map(|space| name.strip_prefix(space));
            return match (&*name, &arguments[..]) {
                ("xacro.arg", [Value::Text(argument)]) => self.names.argument(argument),
                _ => call(bare.unwrap_or(&name), &arguments),
            };
        }
        match math_constant(name.strip_prefix("math.").unwrap_or(&name)) {
            Some(value) => Ok(Value::Float(value)),
            None if self.is_skipping > 0 => Ok(Value::Int(0)),
            None => Err(format!("\"{name}\", which is no property here")),
        }
    }

    fn constant(&mut self, name: &str) -> Evaluated<Option<Value>> {
        match name {
            "True" | "true" => Ok(Some(Value::Bool(true))),
            "False" | "false" => Ok(Some(Value::Bool(false))),
            _ if self.is_skipping > 0 => Ok(None),
            _ => self.names.property(name),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Properties;

    impl Names for Properties {
        fn property(&mut self, name: &str) -> Evaluated<Option<Value>> {
            Ok(match name {
                "two" => Some(Value::Int(2)),
                "half" => Some(Value::Float(0.5)),
                "side" => Some(Value::Text("left".into())),
                _ => None,
            })
        }

        fn argument(&mut self, name: &str) -> Evaluated<Value> {
            Err(format!("argument {name}"))
        }

        fn spend(&mut self, _: usize) -> Evaluated<()> {
            Ok(())
        }
    }

    /// The texts are those of Python 3.11.
    #[test]
    fn values_are_those_of_python() {
        for (text, python) in [
            ("1 + 2 * 3", "7"),
            ("7 / 2", "3.5"),
            ("-7 // 2", "-4"),
            ("7 // -2", "-4"),
            ("-7 % 3", "2"),
            ("7 % -3", "-2"),
            ("-6 // -2", "3"),
            ("6 // -2", "-3"),
            ("-2 ** 2", "-4"),
            ("2 ** -1", "0.5"),
            ("2 ** 3 ** 2", "512"),
            ("pi", "3.141592653589793"),
            ("math.pi / 2", "1.5707963267948966"),
            ("radians(90)", "1.5707963267948966"),
            ("two * half", "1.0"),
            ("1e-5", "1e-05"),
            ("1e16", "1e+16"),
            ("1.0/3", "0.3333333333333333"),
            ("'a' if two == 2 else missing", "a"),
            ("missing if two != 2 else 'b'", "b"),
            ("1 < two < 3", "True"),
            ("not two", "False"),
            ("side == 'left' and half < 1", "True"),
            ("two or missing", "2"),
            ("[1, 2.5, 'x'][1]", "2.5"),
            ("[1, 2][-1]", "2"),
            ("max(1, two, 0.5)", "2"),
            ("int(2.9)", "2"),
            ("round(2.675, 2)", "2.67"),
            ("str(two) + '_' + side", "2_left"),
            ("-(two)", "-2"),
            ("(1, 2)", "[1, 2]"),
            (".5 + 1.", "1.5"),
        ] {
            assert_eq!(
                evaluate(text, &mut Properties).map(|value| value.to_string()),
                Ok(python.to_owned()),
                "{text}"
            );
        }
    }

    #[test]
    fn what_is_not_understood_is_named() {
        for (text, named) in [
            ("missing + 1", "missing"),
            ("load_yaml('a')", "load_yaml"),
            ("1 / 0", "1 / 0"),
            ("1 +", "the end"),
            ("(1", "\")\""),
            ("2 ** 100", "2 ** 100"),
            ("9999999999999999999", "too large"),
            ("'a", "quote"),
            ("1 2", "behind"),
            ("a.b.c", "a.b.c"),
            ("__import__('os')", "__import__"),
            ("lambda: 1", "lambda"),
            ("sqrt(-1)", "sqrt(-1)"),
        ] {
            let error = evaluate(text, &mut Properties).expect_err(text);
            assert!(error.contains(named), "{text}: {error}");
        }
        let deep = "(".repeat(100_000);
        assert!(evaluate(&deep, &mut Properties).expect_err("deep").contains("levels"));
        let powers = "2**".repeat(100_000);
        assert!(evaluate(&powers, &mut Properties).expect_err("deep").contains("levels"));
    }
}

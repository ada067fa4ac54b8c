//! Operators and functions on values, as Python has them.

use std::rc::Rc;

use super::value::{Evaluated, Value};

/// Longest text or list that an expression makes [bytes].
pub(super) const MAX_BYTES: usize = 1 << 16;

/// A constant of `math`.
pub(super) fn math_constant(name: &str) -> Option<f64> {
    Some(match name {
        "pi" => std::f64::consts::PI,
        "tau" => std::f64::consts::TAU,
        "e" => std::f64::consts::E,
        "inf" => f64::INFINITY,
        _ => return None,
    })
}

/// The truth of `a operator b`.
///
/// # Errors
/// The comparison, where Python has none of these kinds of values.
pub(super) fn compare(operator: &str, a: &Value, b: &Value) -> Evaluated<bool> {
    let equal = |a: &Value, b: &Value| match (a.number(), b.number()) {
        (Some(a), Some(b)) => a == b,
        _ => a == b,
    };
    let order = match (a, b) {
        (Value::Text(a), Value::Text(b)) => a.partial_cmp(b),
        _ => a.number().zip(b.number()).and_then(|(a, b)| a.partial_cmp(&b)),
    };
    Ok(match (operator, b) {
        ("==", _) => equal(a, b),
        ("!=", _) => !equal(a, b),
        ("in" | "not", Value::List(items)) => items.iter().any(|item| equal(a, item)) == (operator == "in"),
        ("in" | "not", Value::Text(text)) => text.contains(&*a.to_string()) == (operator == "in"),
        ("<", _) if order.is_some() => order.is_some_and(std::cmp::Ordering::is_lt),
        ("<=", _) if order.is_some() => order.is_some_and(std::cmp::Ordering::is_le),
        (">", _) if order.is_some() => order.is_some_and(std::cmp::Ordering::is_gt),
        (">=", _) if order.is_some() => order.is_some_and(std::cmp::Ordering::is_ge),
        _ => return Err(format!("{a} {operator} {b}")),
    })
}

/// The value of `a operator b`.
///
/// # Errors
/// The operation, where it has no value, or one that is too large.
pub(super) fn combine(operator: &str, a: &Value, b: &Value) -> Evaluated<Value> {
    match (operator, a, b) {
        ("+", Value::Text(x), Value::Text(y)) if x.len() + y.len() <= MAX_BYTES => {
            return Ok(Value::Text(format!("{x}{y}").into()));
        }
        ("+", Value::List(x), Value::List(y)) if a.size() + b.size() <= MAX_BYTES => {
            return Ok(Value::List(Rc::new(x.iter().chain(y.iter()).cloned().collect())));
        }
        _ => {}
    }
    let bad = || format!("{a} {operator} {b}");
    if let (Some(x), Some(y)) = (a.whole(), b.whole()) {
        let whole = match operator {
            "+" => x.checked_add(y),
            "-" => x.checked_sub(y),
            "*" => x.checked_mul(y),
            "//" if y != 0 => x.checked_div_euclid(y).map(|q| q - i64::from(y < 0 && x.rem_euclid(y) != 0)),
            "%" if y != 0 => x.checked_rem(y).map(|r| if r != 0 && (r < 0) != (y < 0) { r + y } else { r }),
            "**" if y >= 0 => u32::try_from(y).ok().and_then(|y| x.checked_pow(y)),
            "/" | "**" => {
                return float(operator, x as f64, y as f64).ok_or_else(bad);
            }
            _ => None,
        };
        return whole.map(Value::Int).ok_or_else(bad);
    }
    let (x, y) = a.number().zip(b.number()).ok_or_else(bad)?;
    float(operator, x, y).ok_or_else(bad)
}

fn float(operator: &str, x: f64, y: f64) -> Option<Value> {
    let value = match operator {
        "+" => x + y,
        "-" => x - y,
        "*" => x * y,
        "/" if y != 0.0 => x / y,
        "//" if y != 0.0 => (x / y).floor(),
        "%" if y != 0.0 => x - y * (x / y).floor(),
        "**" => x.powf(y),
        _ => return None,
    };
    (!value.is_nan()).then_some(Value::Float(value))
}

/// The value of a function of `math`, or of one of Python that numbers of robots need.
///
/// # Errors
/// The call, where the function is not known or has no value there.
pub(super) fn call(name: &str, arguments: &[Value]) -> Evaluated<Value> {
    let bad = || {
        let arguments: Vec<String> = arguments.iter().map(Value::to_string).collect();
        format!("{name}({})", arguments.join(", "))
    };
    let whole = |x: f64| if x.abs() < 9e15 { Ok(Value::Int(x as i64)) } else { Err(bad()) };
    let number = |x: f64| if x.is_nan() { Err(bad()) } else { Ok(Value::Float(x)) };
    match (name, arguments) {
        ("len", [Value::List(items)]) => return Ok(Value::Int(i64::try_from(items.len()).unwrap_or(0))),
        ("len", [Value::Text(text)]) => {
            return Ok(Value::Int(i64::try_from(text.chars().count()).unwrap_or(0)));
        }
        ("str", [value]) => return Ok(Value::Text(value.to_string().into())),
        ("bool", [value]) => return Ok(Value::Bool(value.is_true())),
        ("int", [Value::Text(text)]) => return text.trim().parse().map(Value::Int).map_err(|_| bad()),
        ("float", [Value::Text(text)]) => return text.trim().parse().map_err(|_| bad()).and_then(number),
        ("abs", [Value::Int(x)]) => return x.checked_abs().map(Value::Int).ok_or_else(bad),
        ("min" | "max" | "sum", [Value::List(items)]) => return call(name, items),
        ("min" | "max", [first, rest @ ..]) => {
            let mut best = first;
            for other in rest {
                if compare(if name == "min" { "<" } else { ">" }, other, best)? {
                    best = other;
                }
            }
            return Ok(best.clone());
        }
        ("sum", items) => return items.iter().try_fold(Value::Int(0), |sum, item| combine("+", &sum, item)),
        _ => {}
    }
    let numbers: Option<Vec<f64>> = arguments.iter().map(Value::number).collect();
    match (name, &numbers.ok_or_else(bad)?[..]) {
        ("int" | "trunc", [x]) => whole(x.trunc()),
        ("floor", [x]) => whole(x.floor()),
        ("ceil", [x]) => whole(x.ceil()),
        ("round", [x]) => whole(x.round_ties_even()),
        ("round", [x, digits]) if digits.abs() <= 20.0 => {
            // Rounded once, as text: 2.675 is nearer to 2.67.
            let digits = *digits as i32;
            match usize::try_from(digits) {
                Ok(digits) => number(format!("{x:.digits$}").parse().unwrap_or(f64::NAN)),
                Err(_) => number((x * 10_f64.powi(digits)).round_ties_even() / 10_f64.powi(digits)),
            }
        }
        ("float", [x]) => number(*x),
        ("abs" | "fabs", [x]) => number(x.abs()),
        ("sqrt", [x]) => number(x.sqrt()),
        ("sin", [x]) => number(x.sin()),
        ("cos", [x]) => number(x.cos()),
        ("tan", [x]) => number(x.tan()),
        ("asin", [x]) => number(x.asin()),
        ("acos", [x]) => number(x.acos()),
        ("atan", [x]) => number(x.atan()),
        ("sinh", [x]) => number(x.sinh()),
        ("cosh", [x]) => number(x.cosh()),
        ("tanh", [x]) => number(x.tanh()),
        ("exp", [x]) => number(x.exp()),
        ("log", [x]) if *x > 0.0 => number(x.ln()),
        ("log10", [x]) if *x > 0.0 => number(x.log10()),
        ("radians", [x]) => number(x.to_radians()),
        ("degrees", [x]) => number(x.to_degrees()),
        ("atan2", [y, x]) => number(y.atan2(*x)),
        ("hypot", [x, y]) => number(x.hypot(*y)),
        ("pow", [x, y]) => number(x.powf(*y)),
        ("fmod", [x, y]) if *y != 0.0 => number(x % y),
        ("copysign", [x, y]) => number(x.copysign(*y)),
        _ => Err(bad()),
    }
}

//! `json!`: a value as it is written in a program, its numbers as all others here.
//!
//! Takes what the macro of `serde_json` takes, and goes through an object entry by entry as that does; there a number that
//! is not finite becomes `null`.

use serde_json::Value;

use super::to_value;

/// JSON value of an expression; `null` for what is no JSON, a map whose keys are no texts.
#[doc(hidden)]
pub fn expression(content: impl serde::Serialize) -> Value {
    to_value(content).unwrap_or_default()
}

/// A [`Value`] as it is written in a program: `json!({ "name": name, "rmse_m": [0.1, f64::NAN] })`.
#[macro_export]
macro_rules! json {
    (null) => { $crate::json::Value::Null };
    ([ $($items:tt)* ]) => { $crate::json::Value::Array($crate::json_items!([] $($items)*)) };
    ({ $($entries:tt)* }) => {{
        #[allow(unused_mut)] // an empty one
        let mut object = $crate::json::Map::new();
        $crate::json_entries!(object $($entries)*);
        $crate::json::Value::Object(object)
    }};
    ($other:expr) => { $crate::json::expression(&$other) };
}

/// The items of an array, those done in brackets.
#[doc(hidden)]
#[macro_export]
macro_rules! json_items {
    ([ $($done:expr,)* ]) => { vec![ $($done),* ] };
    ([ $($done:expr,)* ] null $(, $($rest:tt)*)?) => {
        $crate::json_items!([ $($done,)* $crate::json!(null), ] $($($rest)*)?)
    };
    ([ $($done:expr,)* ] [ $($item:tt)* ] $(, $($rest:tt)*)?) => {
        $crate::json_items!([ $($done,)* $crate::json!([ $($item)* ]), ] $($($rest)*)?)
    };
    ([ $($done:expr,)* ] { $($item:tt)* } $(, $($rest:tt)*)?) => {
        $crate::json_items!([ $($done,)* $crate::json!({ $($item)* }), ] $($($rest)*)?)
    };
    ([ $($done:expr,)* ] $item:expr $(, $($rest:tt)*)?) => {
        $crate::json_items!([ $($done,)* $crate::json!($item), ] $($($rest)*)?)
    };
}

/// Puts the entries into an object, one after the other.
#[doc(hidden)]
#[macro_export]
macro_rules! json_entries {
    ($object:ident) => {};
    ($object:ident $key:tt : null $(, $($rest:tt)*)?) => {
        $object.insert(($key).into(), $crate::json!(null));
        $crate::json_entries!($object $($($rest)*)?);
    };
    ($object:ident $key:tt : [ $($item:tt)* ] $(, $($rest:tt)*)?) => {
        $object.insert(($key).into(), $crate::json!([ $($item)* ]));
        $crate::json_entries!($object $($($rest)*)?);
    };
    ($object:ident $key:tt : { $($item:tt)* } $(, $($rest:tt)*)?) => {
        $object.insert(($key).into(), $crate::json!({ $($item)* }));
        $crate::json_entries!($object $($($rest)*)?);
    };
    ($object:ident $key:tt : $item:expr $(, $($rest:tt)*)?) => {
        $object.insert(($key).into(), $crate::json!($item));
        $crate::json_entries!($object $($($rest)*)?);
    };
}

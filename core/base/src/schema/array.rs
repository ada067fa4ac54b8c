//! Arrays of a fixed length, as a file types them.

use std::ops::Deref;

use serde::{Deserialize, Serialize, Serializer};

/// `N` values, no fewer and no more. The reader of TOML drops what an array has beyond a plain `[T; N]`.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "Vec<T>")]
pub struct FixedArray<T, const N: usize>(pub [T; N]);

impl<T, const N: usize> TryFrom<Vec<T>> for FixedArray<T, N> {
    type Error = String;

    fn try_from(typed: Vec<T>) -> Result<Self, String> {
        let found = typed.len();
        typed
            .try_into()
            .map(Self)
            .map_err(|_| format!("invalid length {found}, expected an array of length {N}"))
    }
}

impl<T, const N: usize> Deref for FixedArray<T, N> {
    type Target = [T; N];

    fn deref(&self) -> &[T; N] {
        &self.0
    }
}

impl<T, const N: usize> From<FixedArray<T, N>> for [T; N] {
    fn from(typed: FixedArray<T, N>) -> Self {
        typed.0
    }
}

impl<T: Default + Copy, const N: usize> Default for FixedArray<T, N> {
    fn default() -> Self {
        Self([T::default(); N])
    }
}

impl<T: Serialize, const N: usize> Serialize for FixedArray<T, N> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.as_slice().serialize(serializer)
    }
}

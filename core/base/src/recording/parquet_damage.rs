//! Errors of damaged Parquet files, whether `parquet` returns an error or panics.

use super::Check;
use crate::BadInput;
use crate::panics::caught;
use ::parquet::errors::ParquetError;

/// Result of `pages` on the column `name`; `parquet` asserts what the pages of a damaged file do not keep.
pub(super) fn guarded<T>(name: &str, pages: impl FnOnce() -> Check<T>) -> Check<T> {
    caught(pages).unwrap_or_else(|| {
        Err(damaged(&ParquetError::General("pages that contradict each other".into())).within(name))
    })
}

pub(super) fn damaged(error: &ParquetError) -> BadInput {
    BadInput::new("contents", "a whole parquet file", error.to_string())
        .hint("was it copied or downloaded to the end?")
}

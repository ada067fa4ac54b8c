//! Reports of the study of identification.

pub mod study;

//! Gmsh's mesh files: MSH 1, 2, 4.0 and 4.1 are read, text and binary; 4.1 is written.
//!
//! Main decision: the sections are parsed here and not by the crate `mshio`. Version 0.4 of it knows 4.1
//! alone, drops the node tags whenever they are contiguous, so a file whose blocks list them in another order
//! is read as a different mesh without a word; it also panics on odd headers and on huge counts, refuses
//! parametric nodes and skips the physical names. The tests read the same files with it to compare.

mod blocks;
mod elements;
mod entities;
mod foreign;
mod groups;
mod header;
mod legacy;
mod read;
mod scan;
mod sections;
mod split;
mod write;

pub use read::read_mesh;
pub use write::{MshEncoding, write_mesh};

/// Gmsh's number of the four-node tetrahedron.
const TET4: i64 = 4;
/// Gmsh's number of the ten-node tetrahedron.
const TET10: i64 = 11;

/// Ten nodes in Gmsh's order from ours, and back: the last two middles (edges 13 and 23) change places.
fn swap_last_two(mut n: [u32; 10]) -> [u32; 10] {
    n.swap(8, 9);
    n
}

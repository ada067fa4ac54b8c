//! Figures, pages and what a program may write over. Knows no verb of the program, and is the only crate that knows
//! plotters.
//!
//! From the bottom up, each file knowing only those before it: `maker` (who made a file), `axis`, `simplify`;
//! `sheet` and
//! `figure` (sizes, fonts, tiles, files); `lines`, `series` (panels over time), `scatter` (clouds); `verdict` (whether a
//! result can be used), `page` (reports).

pub mod axis;
pub mod figure;
mod legend;
pub mod lines;
pub mod maker;
pub mod page;
pub mod scatter;
pub mod series;
pub mod sheet;
pub mod simplify;
pub mod text;
pub mod verdict;

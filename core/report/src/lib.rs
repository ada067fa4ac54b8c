//! Figures, pages and what a program may write over. Knows no verb of the program, and is the only crate that knows
//! plotters.
//!
//! From the bottom up, each file knowing only those before it: `maker` (who made a file), `axis`, `simplify`, `color`;
//! `sheet`, `axes`, `svg` and `figure` (sizes, fonts, tiles, files); the blocks that reports draw: `lines`, `series`,
//! `strokes` (panels over time), `scatter` (clouds), `dot_plot` (methods, repeat by repeat), `plane`, `overlay`, `error_path`, `target_map`, `path_views` (paths),
//! `heat_map` (where samples are), `body_views` (a deformed body); `verdict` (whether a result can be used), `page`
//! (reports), `folder` (their files).

mod axes;
mod axes_place;
pub mod axis;
pub mod body_views;
mod color;
pub mod dot_plot;
pub mod error_path;
pub mod figure;
pub mod folder;
pub mod heat_map;
pub mod hysteresis_loop;
mod legend;
pub mod line_style;
pub mod lines;
pub mod maker;
pub mod overlay;
pub mod page;
pub mod path_views;
pub mod plane;
pub mod scatter;
pub mod series;
pub mod sheet;
pub mod simplify;
pub mod stick_figure;
pub mod strokes;
mod svg;
pub mod target_map;
pub mod text;
pub mod verdict;

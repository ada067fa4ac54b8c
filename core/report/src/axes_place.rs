//! A pair of axes: its chart, and its place on a sheet.

use plotters::chart::ChartContext;
use plotters::prelude::*;
use serde::Serialize;

use crate::axis::Axis;

/// A chart with plain axes.
pub type Chart<'a, DB> = ChartContext<'a, DB, Cartesian2d<Axis, Axis>>;

/// Place and ranges of a pair of axes, by which a page reads values from the curves in it.
#[derive(Debug, Clone, Serialize)]
pub struct AxesPlace {
    /// Left and upper edge, width and height, in units of the drawing.
    pub at: [i32; 4],
    /// Values at the left and the right edge.
    pub x: [f64; 2],
    /// Values at the lower and the upper edge.
    pub y: [f64; 2],
    /// Names of both axes, with their units; that of the abscissa may be empty.
    pub names: [String; 2],
}

//! Pairs of axes on a sheet: as many labels as there is room for, all whole.

use std::ops::Range;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::axes_place::{AxesPlace, Chart};
use crate::axis::Axis;
use crate::color::{AXIS, GRID};
use crate::sheet::{BELOW, LEFT, Sheet, TEXT};

/// Room for labels left of an axis whose name is above it [px].
pub(crate) const LEFT_OF_NAMED_ABOVE: f64 = 58.0;
/// Space left of a name at the side of an axis: letters reach farther than backends reckon [px].
const EDGE: f64 = 3.0;
/// Room for a name above an axis [px].
pub(crate) const NAME_ABOVE: f64 = 20.0;
/// Room below axes without labels [px].
pub(crate) const BELOW_WITHOUT_LABELS: f64 = 10.0;
/// Room that a tick has at least, right and down [px].
const TICK: [f64; 2] = [75.0, 30.0];
/// Air between labels, and height of one [px].
const BETWEEN_LABELS: f64 = 10.0;
const LABEL_HEIGHT: f64 = 17.0;

/// Abscissas of a pair of axes.
#[derive(Clone, Copy, PartialEq)]
pub enum Abscissas {
    /// Any number.
    Numbers,
    /// Whole numbers, as of joints and repeats.
    Counts,
}

/// Place of the name of the vertical axis.
#[derive(Clone, Copy, PartialEq)]
enum NamePlace {
    Side,
    Above,
    /// The vertical axis has neither name nor labels: rows stand over each other.
    Nowhere,
}

impl<DB: DrawingBackend> Sheet<DB>
where
    DB::ErrorType: 'static,
{
    /// Axes over the whole sheet, with room for labels to the left and, where `x_name` is not empty, below.
    pub fn chart(
        &self,
        x: Range<f64>,
        y: Range<f64>,
        x_name: &str,
        y_name: &str,
    ) -> anyhow::Result<Chart<'_, DB>> {
        check([(x_name, &x), (y_name, &y)])?;
        let (width, height) = self.size();
        let x = Axis::new(&x, (width / TICK[0]) as usize);
        self.axes(x, Axis::new(&y, (height / TICK[1]) as usize), [x_name, y_name], NamePlace::Side)
    }

    /// The same with the name of the vertical axis above it, however long.
    pub(crate) fn chart_named_above(
        &self,
        (x, abscissas): (Range<f64>, Abscissas),
        y: Range<f64>,
        x_name: &str,
        y_name: &str,
    ) -> anyhow::Result<Chart<'_, DB>> {
        check([(x_name, &x), (y_name, &y)])?;
        let (width, height) = self.size();
        let n_ticks = (width / TICK[0]) as usize;
        let x = match abscissas {
            Abscissas::Counts => Axis::of_counts(&x, n_ticks),
            Abscissas::Numbers => Axis::new(&x, n_ticks),
        };
        let y = Axis::new(&y, ((height - NAME_ABOVE) / TICK[1]) as usize);
        self.axes(x, y, [x_name, y_name], NamePlace::Above)
    }

    /// Axes whose vertical one counts rows from the foot, without name and labels.
    pub(crate) fn chart_of_rows(
        &self,
        x: Range<f64>,
        n_rows: usize,
        x_name: &str,
    ) -> anyhow::Result<Chart<'_, DB>> {
        let rows = 0.0..n_rows as f64;
        check([(x_name, &x), ("rows", &rows)])?;
        let x = Axis::new(&x, (self.size().0 / TICK[0]) as usize);
        self.axes(x, Axis::of_counts(&rows, n_rows), [x_name, ""], NamePlace::Nowhere)
    }

    fn axes(&self, x: Axis, y: Axis, names: [&str; 2], place: NamePlace) -> anyhow::Result<Chart<'_, DB>> {
        let (width, height) = self.size();
        let below = if names[0].is_empty() { BELOW_WITHOUT_LABELS } else { BELOW };
        let (left, above) = match place {
            NamePlace::Side => (LEFT, 0.0),
            NamePlace::Above => (LEFT_OF_NAMED_ABOVE, NAME_ABOVE),
            NamePlace::Nowhere => (EDGE, 0.0),
        };
        let x = x.thinned(width - left, |label| self.text_width(label) + BETWEEN_LABELS);
        let y = y.thinned(height - above - below, |_| LABEL_HEIGHT);
        let mut chart = ChartBuilder::on(&self.area)
            .margin_top(self.px(above))
            .margin_left(self.px(EDGE))
            .set_label_area_size(LabelAreaPosition::Left, self.px(left) - self.px(EDGE))
            .set_label_area_size(LabelAreaPosition::Bottom, self.px(below))
            .build_cartesian_2d(x.clone(), y.clone())?;
        let text = self.text_style(TEXT, Pos::new(HPos::Left, VPos::Center));
        // The last label may be wider than the space next to the axes.
        let edge = width + self.room;
        let x_label = |tick: &f64| {
            let label = x.label(*tick);
            let middle = left + x.part(*tick) * (width - left);
            let is_whole = middle + 0.5 * self.text_width(&label) <= edge;
            if is_whole && !names[0].is_empty() { label } else { String::new() }
        };
        let mut mesh = chart.configure_mesh();
        mesh.light_line_style(TRANSPARENT)
            .bold_line_style(self.line(GRID, 1.0))
            .axis_style(self.line(AXIS, 1.0))
            .set_all_tick_mark_size(self.px(4.0))
            .label_style(text.clone())
            .axis_desc_style(text)
            .x_label_formatter(&x_label);
        if !names[0].is_empty() {
            mesh.x_desc(x.named(names[0]));
        }
        match place {
            NamePlace::Side => {
                mesh.y_desc(y.named(names[1]));
            }
            NamePlace::Above => {}
            NamePlace::Nowhere => {
                mesh.disable_y_axis().disable_y_mesh();
            }
        }
        mesh.draw()?;
        if place == NamePlace::Above {
            self.text(&y.named(names[1]), 0.0, 0.5 * NAME_ABOVE - 2.0)?;
        }
        if place == NamePlace::Nowhere {
            return Ok(chart);
        }
        let (across, down) = chart.plotting_area().get_pixel_range();
        self.record_place(AxesPlace {
            at: [across.start, down.start, across.end - across.start, down.end - down.start],
            x: x.ends(),
            y: y.ends(),
            names: names.map(str::to_owned),
        });
        Ok(chart)
    }
}

/// An axis has two ends that differ.
fn check(axes: [(&str, &Range<f64>); 2]) -> anyhow::Result<()> {
    for (name, range) in axes {
        anyhow::ensure!(
            range.start.is_finite() && range.end.is_finite() && range.start < range.end,
            "axis {name:?} from {} to {}: nothing to draw",
            range.start,
            range.end
        );
    }
    Ok(())
}

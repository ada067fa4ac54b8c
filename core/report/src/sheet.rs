//! The look of all figures: sizes, fonts, legends, colour bars.

use std::cell::RefCell;
use std::rc::Rc;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::axes_place::AxesPlace;
pub use crate::axes_place::Chart;
use crate::color::INK;
pub use crate::color::{COLORS, DULL, GHOST, ramp};
use crate::legend::{LegendEntry, legend_width};

/// Sizes of type. An SVG shows it 1.24 times smaller: backends measure a font by its height, browsers by its em.
const TITLE: f64 = 19.0;
pub(crate) const TEXT: f64 = 15.5;
/// Room for tick labels and the axis' name, left and below [px].
pub const LEFT: f64 = 72.0;
/// Room below a pair of axes [px].
pub const BELOW: f64 = 44.0;
/// Widest tile that a phone shows whole [px].
pub const NARROW: f64 = 324.0;
/// Width of a tile with a colour bar [px].
pub const BAR: f64 = 100.0;

/// Part of a figure, measured in pixels of normal size.
pub struct Sheet<DB: DrawingBackend> {
    pub(crate) area: DrawingArea<DB, Shift>,
    pub(crate) scale: f64,
    /// Room to the right of the part [px].
    pub(crate) room: f64,
    /// Pairs of axes on the whole sheet.
    plots: Rc<RefCell<Vec<AxesPlace>>>,
}

impl<DB: DrawingBackend> Sheet<DB>
where
    DB::ErrorType: 'static,
{
    /// A white sheet over the whole area, drawn `scale` times as large.
    pub fn new(area: DrawingArea<DB, Shift>, scale: f64) -> anyhow::Result<Self> {
        area.fill(&WHITE)?;
        Ok(Self { area, scale, room: 0.0, plots: Rc::default() })
    }

    /// Length of `px` normal pixels.
    pub fn px(&self, px: f64) -> i32 {
        (px * self.scale).round() as i32
    }

    /// Width and height in normal pixels.
    pub fn size(&self) -> (f64, f64) {
        let (width, height) = self.area.dim_in_pixel();
        (f64::from(width) / self.scale, f64::from(height) / self.scale)
    }

    /// The part from (x, y), so wide and so high.
    pub fn part(&self, x: f64, y: f64, width: f64, height: f64) -> Self {
        let size = (self.px(width) as u32, self.px(height) as u32);
        let room = (self.size().0 + self.room - x - width).max(0.0);
        let area = self.area.clone().shrink((self.px(x), self.px(y)), size);
        Self { area, scale: self.scale, room, plots: Rc::clone(&self.plots) }
    }

    /// Remembers a pair of axes.
    pub(crate) fn record_place(&self, plot: AxesPlace) {
        self.plots.borrow_mut().push(plot);
    }

    /// All pairs of axes that were drawn.
    pub(crate) fn plots(&self) -> Vec<AxesPlace> {
        self.plots.borrow().clone()
    }

    /// Width of a text [px].
    pub(crate) fn text_width(&self, text: &str) -> f64 {
        let style = self.text_style(TEXT, Pos::new(HPos::Left, VPos::Center));
        let size = self.area.estimate_text_size(text, &style);
        size.map_or(0.0, |(width, _)| f64::from(width) / self.scale)
    }

    /// The text itself, or as much of it as fits so many pixels, with dots; the text after the last bracket, as a
    /// unit, stays.
    fn shortened(&self, text: &str, width: f64) -> String {
        if self.text_width(text) <= width {
            return text.to_owned();
        }
        let (words, unit) = text.rfind(" [").map_or((text, ""), |at| text.split_at(at));
        let letters: Vec<char> = words.chars().collect();
        let cut = |n: usize| format!("{}...{unit}", letters[..n].iter().collect::<String>().trim_end());
        (1..letters.len()).rev().map(cut).find(|cut| self.text_width(cut) <= width).unwrap_or_else(|| cut(1))
    }

    /// A line style.
    pub fn line(&self, color: RGBColor, width: f64) -> ShapeStyle {
        color.stroke_width((width * self.scale).round().max(1.0) as u32)
    }

    pub(crate) fn text_style(&self, size: f64, at: Pos) -> TextStyle<'static> {
        ("sans-serif", size * self.scale).into_font().color(&INK).pos(at)
    }

    /// Text whose left end is in the middle of the height at (x, y), shortened where there is no room for it.
    pub fn text(&self, text: &str, x: f64, y: f64) -> anyhow::Result<()> {
        let style = self.text_style(TEXT, Pos::new(HPos::Left, VPos::Center));
        let text = self.shortened(text, self.size().0 + self.room - x);
        self.area.draw_text(&text, &style, (self.px(x), self.px(y)))?;
        Ok(())
    }

    /// Title at the top left.
    pub fn title(&self, text: &str) -> anyhow::Result<()> {
        let style = self.text_style(TITLE, Pos::new(HPos::Left, VPos::Center));
        self.area.draw_text(text, &style, (self.px(14.0), self.px(20.0)))?;
        Ok(())
    }

    /// Line samples and names in a row from `left`, at the height of the row's middle.
    pub fn legend(&self, entries: &[LegendEntry], left: f64, y: f64) -> anyhow::Result<()> {
        let mut x = left;
        for (name, color) in entries {
            let ends = vec![(self.px(x), self.px(y)), (self.px(x + 22.0), self.px(y))];
            self.area.draw(&PathElement::new(ends, self.line(*color, 2.5)))?;
            self.text(name, x + 28.0, y)?;
            x += legend_width(name);
        }
        Ok(())
    }

    /// A vertical bar from the colour of `low` below to that of `high` above, with its name on top.
    pub fn color_bar(&self, name: &str, low: f64, high: f64) -> anyhow::Result<()> {
        self.labelled_bar(name, &[0.0, 0.5, 1.0].map(|part| number(low + part * (high - low))))
    }

    /// The same with labels at the foot, in the middle and on top.
    pub fn labelled_bar(&self, name: &str, labels: &[String; 3]) -> anyhow::Result<()> {
        const STEPS: usize = 64;
        const WIDTH: f64 = 14.0;
        const TOP: f64 = 24.0;
        let height = self.size().1 - TOP - 8.0;
        self.text(name, 0.0, 8.0)?;
        // From the top, each down to the foot, so that no gap shows between them.
        for k in (0..STEPS).rev() {
            let y = |k: usize| self.px(TOP + height * (1.0 - k as f64 / STEPS as f64));
            let color = ramp((k as f64 + 0.5) / STEPS as f64);
            self.area.draw(&Rectangle::new([(0, y(k + 1)), (self.px(WIDTH), y(0))], color.filled()))?;
        }
        for (part, label) in [0.0, 0.5, 1.0].into_iter().zip(labels) {
            self.text(label, WIDTH + 6.0, TOP + height * (1.0 - part))?;
        }
        Ok(())
    }

    /// A filled square and a text, as in a legend.
    pub fn sample(&self, color: RGBColor, text: &str, x: f64, y: f64) -> anyhow::Result<()> {
        let corner = |dx: f64, dy: f64| (self.px(x + dx), self.px(y + dy));
        self.area.draw(&Rectangle::new([corner(0.0, -5.0), corner(14.0, 5.0)], color.filled()))?;
        self.text(text, x + 20.0, y)
    }
}

/// The range of the values with 5 % of air; that of one value alone goes 10 % to either side.
pub fn padded(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    // Thinner is one value, in the units of an axis.
    const THINNEST: f64 = 1e-6;
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values {
        (low, high) = (low.min(value), high.max(value));
    }
    let far = low.abs().max(high.abs());
    let air = match high - low {
        span if span >= THINNEST * far.max(1.0) => 0.05 * span,
        _ if far >= THINNEST => 0.1 * far,
        _ => 0.5,
    };
    low - air..high + air
}

/// Whether all values are whole numbers, as those of joints and repeats are.
pub fn are_counts(mut values: impl Iterator<Item = f64>) -> bool {
    values.all(|value| value.fract() == 0.0)
}

/// A number of three or four digits.
pub fn number(value: f64) -> String {
    match value.abs() {
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 10.0 => format!("{value:.1}"),
        size if size > 0.0 => format!("{value:.2}"),
        _ => "0".to_owned(),
    }
}

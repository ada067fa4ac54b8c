//! The look of all figures: sizes, fonts, colours, axes, legends, colour bars.

use plotters::chart::ChartContext;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::axis::Axis;
use crate::legend::{LegendEntry, legend_width};

/// Colours that can be distinguished without red and green (Okabe and Ito, 2008).
pub const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(60, 60, 60),
];
const INK: RGBColor = RGBColor(40, 44, 52);
const GRID: RGBColor = RGBColor(225, 228, 232);
const AXIS: RGBColor = RGBColor(120, 126, 134);

const TITLE: f64 = 16.0;
const TEXT: f64 = 12.5;
/// Room for tick labels and the axis' name, left and below [px].
pub const LEFT: f64 = 54.0;
/// Room below a pair of axes [px].
pub const BELOW: f64 = 38.0;

/// A chart with plain axes.
pub type Chart<'a, DB> = ChartContext<'a, DB, Cartesian2d<Axis, Axis>>;

/// Part of a figure, measured in pixels of normal size.
pub struct Sheet<DB: DrawingBackend> {
    area: DrawingArea<DB, Shift>,
    scale: f64,
}

impl<DB: DrawingBackend> Sheet<DB>
where
    DB::ErrorType: 'static,
{
    /// A white sheet over the whole area, drawn `scale` times as large.
    pub fn new(area: DrawingArea<DB, Shift>, scale: f64) -> anyhow::Result<Self> {
        area.fill(&WHITE)?;
        Ok(Self { area, scale })
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
        Self { area: self.area.clone().shrink((self.px(x), self.px(y)), size), scale: self.scale }
    }

    /// A line style.
    pub fn line(&self, color: RGBColor, width: f64) -> ShapeStyle {
        color.stroke_width((width * self.scale).round().max(1.0) as u32)
    }

    fn text_style(&self, size: f64, at: Pos) -> TextStyle<'static> {
        ("sans-serif", size * self.scale).into_font().color(&INK).pos(at)
    }

    /// Text whose left end is in the middle of the height at (x, y).
    pub fn text(&self, text: &str, x: f64, y: f64) -> anyhow::Result<()> {
        let style = self.text_style(TEXT, Pos::new(HPos::Left, VPos::Center));
        self.area.draw_text(text, &style, (self.px(x), self.px(y)))?;
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

    /// Axes over the whole sheet, with room for labels to the left and, where `x_name` is not empty, below.
    pub fn chart(
        &self,
        x: std::ops::Range<f64>,
        y: std::ops::Range<f64>,
        x_name: &str,
        y_name: &str,
    ) -> anyhow::Result<Chart<'_, DB>> {
        self.chart_over(x, false, y, x_name, y_name)
    }

    /// The same, where only whole numbers are abscissas if `is_count`.
    pub fn chart_over(
        &self,
        x: std::ops::Range<f64>,
        is_count: bool,
        y: std::ops::Range<f64>,
        x_name: &str,
        y_name: &str,
    ) -> anyhow::Result<Chart<'_, DB>> {
        for (name, range) in [(x_name, &x), (y_name, &y)] {
            let is_drawable = range.start.is_finite() && range.end.is_finite() && range.start < range.end;
            anyhow::ensure!(
                is_drawable,
                "axis {name:?} from {} to {}: nothing to draw",
                range.start,
                range.end
            );
        }
        let (width, height) = self.size();
        let below = if x_name.is_empty() { 8.0 } else { BELOW };
        // A label is some 60 px wide and 16 px high.
        let most = (width / 75.0) as usize;
        let x = if is_count { Axis::of_counts(&x, most) } else { Axis::new(&x, most) };
        let y = Axis::new(&y, (height / 30.0) as usize);
        let mut chart = ChartBuilder::on(&self.area)
            .set_label_area_size(LabelAreaPosition::Left, self.px(LEFT))
            .set_label_area_size(LabelAreaPosition::Bottom, self.px(below))
            .build_cartesian_2d(x.clone(), y.clone())?;
        let text = ("sans-serif", TEXT * self.scale).into_font().color(&INK);
        let mut mesh = chart.configure_mesh();
        mesh.light_line_style(TRANSPARENT)
            .bold_line_style(self.line(GRID, 1.0))
            .axis_style(self.line(AXIS, 1.0))
            .set_all_tick_mark_size(self.px(4.0))
            .label_style(text.clone())
            .axis_desc_style(text)
            .y_desc(y.named(y_name));
        if x_name.is_empty() {
            mesh.x_label_formatter(&|_| String::new());
        } else {
            mesh.x_desc(x.named(x_name));
        }
        mesh.draw()?;
        Ok(chart)
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

/// Colour of a part from 0 to 1: dark violet over red to yellow, even in lightness.
pub fn ramp(part: f64) -> RGBColor {
    // Five colours of the map `plasma` (S. van der Walt and N. Smith, CC0), without its palest end.
    const STOPS: [[f64; 3]; 5] = [
        [13.0, 8.0, 135.0],
        [120.0, 1.0, 168.0],
        [196.0, 62.0, 127.0],
        [241.0, 130.0, 77.0],
        [252.0, 206.0, 37.0],
    ];
    let at = part.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let k = (at as usize).min(STOPS.len() - 2);
    let mixed = |c: usize| STOPS[k][c] + (at - k as f64) * (STOPS[k + 1][c] - STOPS[k][c]);
    RGBColor(mixed(0).round() as u8, mixed(1).round() as u8, mixed(2).round() as u8)
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

//! A deformed body with the lines that pull it, from two sides.
//!
//! Orthographic; faces are drawn from the farthest to the nearest (painter's algorithm), which is right for small
//! faces that do not cut each other. Lines are drawn over the body, as if it were transparent.

use anyhow::Result;
use plotters::prelude::*;

use crate::figure::Figure;
use crate::sheet::{BELOW, Chart, DULL, GHOST, LEFT, Sheet, number, padded, ramp};

/// A body at rest and deformed, with its lines.
pub struct BodyViews {
    /// Name of the file.
    pub name: String,
    /// Title.
    pub title: String,
    /// Caption: the content of the figure.
    pub caption: String,
    /// Faces of the surface, seen from outside counter-clockwise: indices of points.
    pub faces: Vec<[u32; 3]>,
    /// Points at rest (n_points) [mm].
    pub rest: Vec<[f64; 3]>,
    /// The same points, deformed (n_points) [mm].
    pub moved: Vec<[f64; 3]>,
    /// Lines that pull the body.
    pub lines: Vec<TensionLine>,
}

/// A line that pulls a body.
pub struct TensionLine {
    /// Name next to the colour bar.
    pub name: String,
    /// Weight in the figure.
    pub rank: Rank,
    /// Points [mm].
    pub points: Vec<[f64; 3]>,
    /// Tension [N]; 0 is slack.
    pub tension: f64,
}

/// Weight of a line in a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rank {
    /// Drawn wide, its tension next to the colour bar.
    Primary,
    /// Drawn thin, without its tension in figures.
    Auxiliary,
}

/// A direction to look from.
struct View {
    title: &'static str,
    /// Axes to the right and up.
    axes: [usize; 2],
    /// Axis along which one looks, and the sign of the side that is near.
    depth: usize,
    near: f64,
}

const VIEWS: [View; 2] = [
    View { title: "from the front", axes: [0, 2], depth: 1, near: -1.0 },
    View { title: "from the right", axes: [1, 2], depth: 0, near: 1.0 },
];

/// Size of a view, and of the tensions next to it [px].
const VIEW: [f64; 2] = [320.0, 460.0];
const SIDE: [f64; 2] = [190.0, 470.0];

const BODY: [f64; 3] = [176.0, 190.0, 204.0];
const GHOST_EDGE: RGBColor = RGBColor(170, 176, 184);
const SLACK: RGBColor = DULL;

impl BodyViews {
    fn max_tension(&self) -> f64 {
        self.lines.iter().map(|line| line.tension.abs()).fold(0.0, f64::max)
    }

    fn draw_view<DB: DrawingBackend>(&self, sheet: &Sheet<DB>, view: &View, mm_per_px: f64) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let (width, height) = sheet.size();
        let range = |axis: usize, px: f64| {
            let own = self.extent(axis);
            let (middle, half) = (0.5 * (own.start + own.end), 0.5 * px * mm_per_px);
            middle - half..middle + half
        };
        let names = view.axes.map(|axis| format!("{} [mm]", ["x", "y", "z"][axis]));
        let (x, y) = (range(view.axes[0], width - LEFT), range(view.axes[1], height - BELOW));
        let mut chart = sheet.chart(x, y, &names[0], &names[1])?;
        self.draw_ghost(sheet, &mut chart, view)?;
        self.draw_body(sheet, &mut chart, view)?;
        self.draw_lines(sheet, &mut chart, view)
    }

    /// The outline of the rest shape: the faces with thick edges, then without.
    fn draw_ghost<DB: DrawingBackend>(
        &self,
        sheet: &Sheet<DB>,
        chart: &mut Chart<DB>,
        view: &View,
    ) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let faces: Vec<Vec<(f64, f64)>> = self.visible(&self.rest, view).map(|face| face.outline).collect();
        let edge = sheet.line(GHOST_EDGE, 2.0);
        chart.draw_series(faces.iter().map(|face| PathElement::new(closed(face), edge)))?;
        // Thin edges of the same colour close the seams between neighbours.
        let seam = sheet.line(GHOST, 0.6);
        chart.draw_series(faces.iter().map(|face| PathElement::new(closed(face), seam)))?;
        chart.draw_series(faces.into_iter().map(|face| Polygon::new(face, GHOST.filled())))?;
        Ok(())
    }

    fn draw_body<DB: DrawingBackend>(
        &self,
        sheet: &Sheet<DB>,
        chart: &mut Chart<DB>,
        view: &View,
    ) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let mut faces: Vec<VisibleFace> = self.visible(&self.moved, view).collect();
        faces.sort_by(|a, b| a.nearness.total_cmp(&b.nearness));
        for face in faces {
            let shade = |light: f64| {
                let [r, g, b] = BODY.map(|c| (c * light).min(255.0) as u8);
                RGBColor(r, g, b)
            };
            let light = 0.55 + 0.55 * face.light;
            let edges = PathElement::new(closed(&face.outline), sheet.line(shade(0.86 * light), 0.4));
            chart.draw_series([Polygon::new(face.outline, shade(light).filled())])?;
            chart.draw_series([edges])?;
        }
        Ok(())
    }

    fn draw_lines<DB: DrawingBackend>(
        &self,
        sheet: &Sheet<DB>,
        chart: &mut Chart<DB>,
        view: &View,
    ) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let most = self.max_tension();
        let mut order: Vec<&TensionLine> = self.lines.iter().collect();
        // The tightest last, so that it is never covered.
        order.sort_by(|a, b| a.tension.abs().total_cmp(&b.tension.abs()));
        for line in order {
            let points: Vec<(f64, f64)> =
                line.points.iter().map(|point| (point[view.axes[0]], point[view.axes[1]])).collect();
            let thin = if line.rank == Rank::Primary { 1.0 } else { 0.5 };
            if line.tension == 0.0 {
                chart.draw_series([PathElement::new(points, sheet.line(SLACK, 1.2 * thin))])?;
                continue;
            }
            let color = ramp(line.tension.abs() / most);
            chart.draw_series([PathElement::new(points.clone(), sheet.line(WHITE, 5.0 * thin))])?;
            chart.draw_series([PathElement::new(points, sheet.line(color, 3.2 * thin))])?;
        }
        Ok(())
    }

    /// The colours of tensions, and the tension of the first lines.
    fn draw_tensions<DB: DrawingBackend>(&self, sheet: &Sheet<DB>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        const LEFT: f64 = 12.0;
        let most = self.max_tension();
        if most > 0.0 {
            sheet.part(LEFT, 20.0, SIDE[0] - LEFT, 200.0).color_bar("tension [N]", 0.0, most)?;
        }
        let shown = self.lines.iter().filter(|line| line.rank == Rank::Primary).take(10);
        for (k, line) in shown.enumerate() {
            let color = if line.tension == 0.0 { SLACK } else { ramp(line.tension.abs() / most) };
            let text = format!("{} {} N", line.name, number(line.tension));
            sheet.sample(color, &text, LEFT, 250.0 + 20.0 * k as f64)?;
        }
        Ok(())
    }

    /// Range of both shapes along an axis [mm].
    fn extent(&self, axis: usize) -> std::ops::Range<f64> {
        padded(self.rest.iter().chain(&self.moved).map(|point| point[axis]))
    }

    /// The faces that look towards the viewer.
    fn visible<'a>(
        &'a self,
        points: &'a [[f64; 3]],
        view: &'a View,
    ) -> impl Iterator<Item = VisibleFace> + 'a {
        self.faces.iter().filter_map(move |face| {
            let [a, b, c] = face.map(|node| points[node as usize]);
            let [u, v]: [[f64; 3]; 2] = [b, c].map(|p| std::array::from_fn(|i| p[i] - a[i]));
            let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let size = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
            let facing = view.near * normal[view.depth] / size;
            // Lit from the viewer's left and above.
            let light =
                0.75 * facing - 0.35 * normal[view.axes[0]] / size + 0.3 * normal[view.axes[1]] / size;
            (facing > 0.0).then(|| VisibleFace {
                outline: [a, b, c].map(|p| (p[view.axes[0]], p[view.axes[1]])).to_vec(),
                nearness: view.near * (a[view.depth] + b[view.depth] + c[view.depth]),
                light: light.clamp(0.0, 1.0),
            })
        })
    }
}

struct VisibleFace {
    outline: Vec<(f64, f64)>,
    nearness: f64,
    /// 0 dark to 1 bright.
    light: f64,
}

fn closed(outline: &[(f64, f64)]) -> Vec<(f64, f64)> {
    outline.iter().chain(outline.first()).copied().collect()
}

impl Figure for BodyViews {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn title(&self) -> String {
        self.title.clone()
    }

    fn caption(&self) -> String {
        self.caption.clone()
    }

    fn tiles(&self) -> Vec<[f64; 2]> {
        vec![VIEW, VIEW, SIDE]
    }

    fn draw<DB: DrawingBackend>(&self, tile: usize, sheet: &Sheet<DB>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        const TITLE: f64 = 20.0;
        let Some(view) = VIEWS.get(tile) else { return self.draw_tensions(sheet) };
        let length = |axis: usize| {
            let range = self.extent(axis);
            range.end - range.start
        };
        let size = [VIEW[0], VIEW[1] - TITLE];
        let mm_per_px = VIEWS
            .iter()
            .map(|view| {
                (length(view.axes[0]) / (size[0] - LEFT)).max(length(view.axes[1]) / (size[1] - BELOW))
            })
            .fold(0.0, f64::max);
        sheet.text(view.title, 4.0, 8.0)?;
        self.draw_view(&sheet.part(0.0, TITLE, size[0], size[1]), view, mm_per_px)
    }
}

//! Figures and the report of a run; the only module that knows plotters.
//!
//! Every figure is drawn once as SVG, at several times its size: plotters rounds to whole pixels, and curves would
//! show it. The same code draws the PNG. Text is measured with an embedded font (`assets/`), so a figure is the
//! same on a machine without fonts; an SVG is shown in the viewer's own sans-serif.

pub mod commands;
pub mod coverage;
pub mod data_set;
pub mod fit;
pub mod identification;
mod lines;
mod report;
mod robot;
mod shapes;
mod sheet;
mod simplify;
pub mod study;
pub mod target;
mod tip;
pub mod tracking;

use std::path::Path;

use anyhow::{Context, anyhow};
use hysteron_base::file;
use plotters::prelude::*;
use plotters::style::register_font;

use crate::run::{Run, Task};
use lines::{Curve, TimeChart, TimePanel};
use robot::RobotPicture;
use shapes::CommandAndTip;
use sheet::{COLORS, Sheet};
use tip::TipPath;

/// A picture that can be drawn on any backend.
trait Figure {
    /// Name of the file, without ending.
    fn name(&self) -> &'static str;
    /// What it shows, for a reader.
    fn caption(&self) -> String;
    /// Width and height at normal size [px].
    fn size(&self) -> (u32, u32);
    /// Draws it.
    fn draw<DB: DrawingBackend>(&self, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static;
}

const SVG_SCALE: u32 = 5;
const PNG_SCALE: u32 = 2;

/// Writes all figures of a run, `report.html` and `metrics.json` to `folder`.
pub fn write(folder: &Path, run: &Run, with_png: bool) -> anyhow::Result<()> {
    register_embedded_font()?;
    let mut drawn = vec![save(folder, &RobotPicture::new(run), with_png)?];
    drawn.push(save(folder, &TipPath::new(run)?, with_png)?);
    let shape = command_and_tip(run);
    if let Some(figure) = &shape {
        drawn.push(save(folder, figure, with_png)?);
    }
    drawn.push(save(folder, &tip_over_time(run)?, with_png)?);
    if run.twin.n_primary > 0 {
        drawn.push(save(folder, &strokes(run), with_png)?);
        drawn.push(save(folder, &tensions(run), with_png)?);
    }
    report::write(folder, run, &shape.map_or(vec![], |figure| figure.numbers()), &drawn)
}

fn register_embedded_font() -> anyhow::Result<()> {
    let font = include_bytes!("../../assets/DejaVuSans-subset.ttf");
    register_font("sans-serif", FontStyle::Normal, font)
        .map_err(|_| anyhow!("the embedded font cannot be read"))
}

/// Command and tip of a run that followed strokes, where the tendons bend in two directions and something moved.
fn command_and_tip(run: &Run) -> Option<CommandAndTip> {
    let angles = crate::plan::angles_of(run.scene);
    match run.task {
        Task::Simulate => CommandAndTip::new(&angles, &[(&run.scene.name, run.recording)]).ok(),
        Task::Reach(_) => None,
    }
}

/// A figure as it goes into the report.
struct Drawn {
    svg: String,
    caption: String,
}

fn save(folder: &Path, figure: &impl Figure, with_png: bool) -> anyhow::Result<Drawn> {
    let svg = svg_of(figure)?;
    file::write_bytes(&folder.join(format!("{}.svg", figure.name())), &svg)?;
    if with_png {
        file::write_bytes(&folder.join(format!("{}.png", figure.name())), png_of(figure)?)?;
    }
    Ok(Drawn { svg, caption: figure.caption() })
}

fn svg_of(figure: &impl Figure) -> anyhow::Result<String> {
    let (width, height) = figure.size();
    let large = (width * SVG_SCALE, height * SVG_SCALE);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, large).into_drawing_area();
        figure.draw(&Sheet::new(root.clone(), f64::from(SVG_SCALE))?)?;
        root.present()?;
    }
    // Shown at normal size; the view box keeps the fine coordinates.
    let own = format!("width=\"{}\" height=\"{}\"", large.0, large.1);
    let shown = format!("width=\"{width}\" height=\"{height}\"");
    Ok(svg.replacen(&own, &shown, 1))
}

fn png_of(figure: &impl Figure) -> anyhow::Result<Vec<u8>> {
    let (width, height) = figure.size();
    let folder = tempfile::tempdir().context("making a temporary folder")?;
    let path = folder.path().join("figure.png");
    {
        let root = BitMapBackend::new(&path, (width * PNG_SCALE, height * PNG_SCALE)).into_drawing_area();
        figure.draw(&Sheet::new(root.clone(), f64::from(PNG_SCALE))?)?;
        root.present()?;
    }
    Ok(file::read_bytes(&path)?)
}

fn millimetres(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| 1e3 * value).collect()
}

/// Commanded and measured stroke, one panel per tendon.
fn strokes(run: &Run) -> TimeChart {
    let measured = run.recording.numbered("measured_stroke", "m");
    let panels = run.recording.strokes().into_iter().zip(measured).zip(&run.twin.tendons);
    let panel = |((commanded, measured), tendon): ((&[f64], &[f64]), &hysteron_twin::TendonSpec)| {
        // The measured one below: where the tendon is taut the two coincide.
        let curves = vec![
            Curve {
                name: "along the body".into(),
                color: COLORS[1],
                width: 1.0,
                values: millimetres(measured),
            },
            Curve { name: "commanded".into(), color: COLORS[0], width: 1.4, values: millimetres(commanded) },
        ];
        TimePanel { label: format!("{} [mm]", tendon.name), curves }
    };
    TimeChart {
        name: "strokes",
        title: "Stroke of every tendon".into(),
        caption: "Strokes: pulled length as commanded, and as the body has shortened along the tendon. They differ \
                  where a tendon is slack."
            .into(),
        time: run.recording.time().to_vec(),
        panels: panels.map(panel).collect(),
    }
}

fn tensions(run: &Run) -> TimeChart {
    let series = run.recording.numbered("tension", "n").into_iter().zip(&run.twin.tendons).enumerate();
    let curves = series.take(run.twin.n_primary).map(|(k, (values, tendon))| Curve {
        name: tendon.name.clone(),
        color: COLORS[k % COLORS.len()],
        width: 1.2,
        values: values.to_vec(),
    });
    TimeChart {
        name: "tensions",
        title: "Tension of every tendon".into(),
        caption: "Tensions of the tendons; zero is slack.".into(),
        time: run.recording.time().to_vec(),
        panels: vec![TimePanel { label: "tension [N]".into(), curves: curves.collect() }],
    }
}

fn tip_over_time(run: &Run) -> anyhow::Result<TimeChart> {
    let tip = run.recording.tip().context("the recording has no tip")?;
    let rest = run.twin.tip_of(&run.twin.rest());
    let curve = |c: usize| Curve {
        name: ["x", "y", "z"][c].into(),
        color: COLORS[c],
        width: 1.2,
        values: tip[c].iter().map(|value| 1e3 * (value - rest[c])).collect(),
    };
    Ok(TimeChart {
        name: "tip-time",
        title: "Displacement of the tip from rest".into(),
        caption: "Displacement of the tip from its place in the unloaded body.".into(),
        time: run.recording.time().to_vec(),
        panels: vec![TimePanel { label: "displacement [mm]".into(), curves: (0..3).map(curve).collect() }],
    })
}

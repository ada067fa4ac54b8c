//! `report.html`, one file with everything in it, and `metrics.json` with every number it shows.

use std::path::Path;

use hysteron_control::score::AxisScore;
use plotters::style::RGBColor;
use serde::Serialize;

use super::figure::{Drawn, Entry};
use super::shapes::NamedShape;
use crate::outputs;
use crate::run::{Run, Summary};
use crate::terminal;

#[derive(Serialize)]
struct Metrics<'a> {
    format: &'static str,
    version: u32,
    robot: Robot<'a>,
    run: &'a Summary,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    shapes: &'a [NamedShape],
    steps_per_s: f64,
    iterations_per_step: f64,
    source: &'a str,
    command: &'a str,
    commit: &'a str,
}

#[derive(Serialize)]
struct Robot<'a> {
    name: &'a str,
    scene_sha256: &'a str,
    nodes: usize,
    tetrahedra: usize,
    unknowns: usize,
    tendons: usize,
    auxiliary_tendons: usize,
}

pub(super) fn write(
    folder: &Path,
    run: &Run,
    shapes: &[NamedShape],
    figures: &[Drawn],
) -> anyhow::Result<()> {
    let metrics = metrics(run, shapes);
    write_metrics(folder, &metrics)?;
    write_page(folder, html(&metrics, run.task.title(), figures))
}

/// The summary, where no report is asked for.
pub(super) fn summarise(run: &Run, shapes: &[NamedShape]) -> anyhow::Result<()> {
    terminal::summarise(&metrics(run, shapes))
}

fn metrics<'a>(run: &'a Run, shapes: &'a [NamedShape]) -> Metrics<'a> {
    let meta = run.recording.meta();
    Metrics {
        format: "hysteron-metrics",
        version: 1,
        robot: Robot {
            name: &run.scene.name,
            scene_sha256: &run.scene.hash,
            nodes: run.twin.body.n_nodes(),
            tetrahedra: run.twin.body.cells.len(),
            unknowns: run.twin.body.n_unknowns(),
            tendons: run.twin.n_primary,
            auxiliary_tendons: run.twin.tendons.len() - run.twin.n_primary,
        },
        run: run.summary,
        shapes,
        steps_per_s: run.summary.rate(),
        iterations_per_step: run.summary.iterations as f64 / run.summary.steps.max(1) as f64,
        source: &meta.source,
        command: &meta.command,
        commit: &meta.commit,
    }
}

/// Writes `metrics.json`, which is the summary of the verb too.
pub fn write_metrics(folder: &Path, metrics: &impl Serialize) -> anyhow::Result<()> {
    terminal::summarise(metrics)?;
    let mut json = serde_json::to_string_pretty(metrics)?;
    json.push('\n');
    outputs::replace(&folder.join("metrics.json"), json)
}

/// Writes `report.html`.
pub(super) fn write_page(folder: &Path, html: String) -> anyhow::Result<()> {
    outputs::replace(&folder.join("report.html"), html)
}

/// A report as it grows: one file with everything in it.
pub(super) struct Page(String);

impl Page {
    /// A page with a title, what it is about and the command that made it.
    pub(super) fn new(title: &str, about: &str, command: &str) -> Self {
        let [title, about, command] = [title, about, command].map(escaped);
        Self(format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
             <meta name=\"generator\" content=\"hysteron\"/>\n<title>{title}</title>\n\
             <style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n<p>{about}</p>\n<pre>{command}</pre>\n"
        ))
    }

    /// A heading.
    pub(super) fn heading(&mut self, text: &str) {
        self.0.push_str(&format!("<h2>{}</h2>\n", escaped(text)));
    }

    /// A paragraph.
    pub(super) fn paragraph(&mut self, text: &str) {
        self.0.push_str(&format!("<p>{}</p>\n", escaped(text)));
    }

    /// Lines of code that are shown when asked for.
    pub(super) fn details(&mut self, summary: &str, code: &str) {
        let [summary, code] = [summary, code].map(escaped);
        self.0.push_str(&format!("<details>\n<summary>{summary}</summary>\n<pre>{code}</pre>\n</details>\n"));
    }

    /// A table with a row of headings.
    pub(super) fn table(&mut self, headings: &[&str], rows: impl IntoIterator<Item = Vec<String>>) {
        self.0.push_str("<div class=\"scroll\"><table>\n<tr>");
        headings
            .iter()
            .for_each(|heading| self.0.push_str(&format!("<th scope=\"col\">{}</th>", escaped(heading))));
        self.0.push_str("</tr>\n");
        for row in rows {
            self.0.push_str("<tr>");
            row.iter().for_each(|cell| self.0.push_str(&table_cell(cell)));
            self.0.push_str("</tr>\n");
        }
        self.0.push_str("</table></div>\n");
    }

    /// A table of names and values.
    pub(super) fn list<'a>(&mut self, rows: impl IntoIterator<Item = (&'a str, String)>) {
        self.0.push_str("<div class=\"scroll\"><table>\n");
        for (name, value) in rows {
            let (name, value) = (escaped(name), table_cell(&value));
            self.0.push_str(&format!("<tr><th scope=\"row\">{name}</th>{value}</tr>\n"));
        }
        self.0.push_str("</table></div>\n");
    }

    /// Names and values that are shown when asked for: how it was computed, not what came of it.
    pub(super) fn details_list<'a>(
        &mut self,
        summary: &str,
        rows: impl IntoIterator<Item = (&'a str, String)>,
    ) {
        self.0.push_str(&format!("<details>\n<summary>{}</summary>\n", escaped(summary)));
        self.list(rows);
        self.0.push_str("</details>\n");
    }

    /// A figure with its caption.
    pub(super) fn figure(&mut self, figure: &Drawn) {
        let [title, caption] = [&figure.title, &figure.caption].map(|text| escaped(text));
        self.0.push_str(&format!("<figure>\n<h3>{title}</h3>\n"));
        if !figure.legend.is_empty() {
            let entry = |(name, RGBColor(r, g, b)): &Entry| {
                format!("<span><i style=\"background:rgb({r},{g},{b})\"></i>{}</span>", escaped(name))
            };
            let entries: Vec<String> = figure.legend.iter().map(entry).collect();
            self.0.push_str(&format!("<p class=\"legend\">{}</p>\n", entries.join("\n")));
        }
        let class = if figure.is_wide { "wide" } else { "tiles" };
        let tiles = figure.tiles.concat();
        self.0.push_str(&format!(
            "<div class=\"{class}\">\n{tiles}</div>\n<figcaption>{caption}</figcaption>\n</figure>\n"
        ));
    }

    /// A line in small print.
    pub(super) fn small(&mut self, text: &str) {
        self.0.push_str(&format!("<p class=\"small\">{}</p>\n", escaped(text)));
    }

    /// The whole page.
    pub(super) fn finish(mut self, commit: &str) -> String {
        self.small(&format!("Program {}.", if commit.is_empty() { "of unknown commit" } else { commit }));
        self.0.push_str("</body>\n</html>\n");
        self.0
    }
}

fn mm(value: f64) -> String {
    format!("{:.2}", 1e3 * value)
}

fn html(metrics: &Metrics, title: &str, figures: &[Drawn]) -> String {
    let run = metrics.run;
    let mut page = Page::new(&format!("{}: {title}", metrics.robot.name), metrics.source, metrics.command);
    results(&mut page, metrics);
    if !metrics.shapes.is_empty() {
        page.table(&NamedShape::HEADINGS, metrics.shapes.iter().map(NamedShape::cells));
    }
    page.heading("Figures");
    figures.iter().for_each(|figure| page.figure(figure));
    page.heading("Model and solver");
    page.list([
        ("Mesh", format!("{} nodes, {} tetrahedra", metrics.robot.nodes, metrics.robot.tetrahedra)),
        ("Degrees of freedom", metrics.robot.unknowns.to_string()),
        ("Auxiliary tendons", metrics.robot.auxiliary_tendons.to_string()),
        ("Computing time [s]", format!("{:.2}", run.wall_s)),
    ]);
    page.details_list("Solver details", solver(metrics));
    page.small(&format!("Scene {}.", metrics.robot.scene_sha256));
    page.finish(metrics.commit)
}

/// What came of a run.
fn results(page: &mut Page, metrics: &Metrics) {
    let run = metrics.run;
    page.heading("Results");
    if let Some(score) = &run.against_measured {
        let percent =
            |nrmse: Option<f64>| nrmse.map_or("-".to_owned(), |part| format!("{:.2}", 100.0 * part));
        let row = |(axis, score): (&str, &AxisScore)| {
            vec![axis.to_owned(), format!("{:.3}", 1e3 * score.rmse_m), percent(score.nrmse)]
        };
        let distance = vec!["distance".to_owned(), format!("{:.3}", 1e3 * score.rmse_m), "-".to_owned()];
        let rows = ["x", "y", "z"].into_iter().zip(&score.axes).map(row).chain([distance]);
        page.table(&["Simulated against measured tip", "RMSE [mm]", "NRMSE [%]"], rows);
        page.list([("Largest distance from the measured tip [mm]", format!("{:.3}", 1e3 * score.max_m))]);
    }
    if let Some(goals) = &run.goals {
        page.list([
            ("Goals out of reach", format!("{} of {}", goals.out_of_reach, run.samples)),
            ("Tolerance [mm]", (1e3 * goals.tolerance_m).to_string()),
            ("Largest distance from a goal [mm]", format!("{:.1e}", 1e3 * goals.largest_distance_m)),
        ]);
    }
    if let Some(part) = run.extrapolated {
        page.list([("Network outside its training range", format!("{:.1} % of the samples", 100.0 * part))]);
    }
    let range = |c: usize| format!("{} to {}", mm(run.tip_min_m[c]), mm(run.tip_max_m[c]));
    page.list([
        ("Samples", run.samples.to_string()),
        ("Duration [s]", format!("{:.2}", run.duration_s)),
        ("Tip x [mm]", range(0)),
        ("Tip y [mm]", range(1)),
        ("Tip z [mm]", range(2)),
    ]);
    if !run.tendons.is_empty() {
        let headings = ["Tendon", "Stroke [mm]", "Largest tension [N]", "At the lower tension bound"];
        let rows = run.tendons.iter().map(|tendon| {
            vec![
                tendon.name.clone(),
                format!("{} to {}", mm(tendon.stroke_min_m), mm(tendon.stroke_max_m)),
                format!("{:.2}", tendon.tension_max_n),
                format!("{:.1} % of the time", 100.0 * tendon.share_at_lower_bound),
            ]
        });
        page.table(&headings, rows);
    }
}

/// How a run was computed.
fn solver(metrics: &Metrics) -> Vec<(&'static str, String)> {
    let run = metrics.run;
    let mut rows = vec![
        ("Steps", run.steps.to_string()),
        ("Steps per second", format!("{:.0}", metrics.steps_per_s)),
        ("Iterations per step", format!("{:.2}", metrics.iterations_per_step)),
        ("Refactorisations of the stiffness", run.renewals.to_string()),
        ("Newton iterations", run.newton_iterations.to_string()),
        ("Substeps", run.sub_steps.to_string()),
        ("QPs solved by Clarabel", run.clarabel_solves.to_string()),
        ("Largest relative force residual", format!("{:.1e}", run.worst_relative_residual)),
        ("Largest stroke residual [mm]", format!("{:.1e}", 1e3 * run.worst_stroke_error_m)),
    ];
    if run.goals.is_some() {
        rows.push(("QPs solved for strokes", run.rounds.to_string()));
    }
    rows
}

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;color:#282c34;max-width:944px;margin:2em auto;padding:0 1em}\
pre{background:#f4f5f7;padding:.8em 1em;white-space:pre-wrap;border-radius:4px}\
table{border-collapse:collapse;margin:1em 0}th,td{text-align:left;padding:.15em 1.2em .15em 0;font-weight:normal;\
border-bottom:1px solid #e1e4e8}td{white-space:nowrap}td.long{white-space:normal;min-width:16em}td{font-variant-numeric:tabular-nums}th{vertical-align:bottom}\
h1{font-size:1.7em;line-height:1.25;overflow-wrap:anywhere}h3{font-size:1em;margin:0}.scroll{overflow-x:auto}\
figure{margin:2em 0}svg{display:block;max-width:100%;height:auto}.tiles{display:flex;flex-wrap:wrap;align-items:flex-start}\
.wide{overflow-x:auto}@media(max-width:640px){.wide svg{max-width:none;width:680px}}\
.legend{display:flex;flex-wrap:wrap;gap:.2em 1.4em;margin:.3em 0;font-size:13px}\
.legend i{display:inline-block;width:22px;height:4px;margin-right:6px;vertical-align:middle}\
summary{cursor:pointer}figcaption{color:#5a6068}.small{color:#5a6068;font-size:12px;overflow-wrap:anywhere}";

/// A cell; prose is broken into lines, numbers are not.
fn table_cell(text: &str) -> String {
    const LONG: usize = 32;
    let class = if text.chars().count() > LONG { " class=\"long\"" } else { "" };
    format!("<td{class}>{}</td>", escaped(text))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

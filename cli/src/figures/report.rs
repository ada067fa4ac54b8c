//! `report.html`, one file with everything in it, and `metrics.json` with every number it shows.

use std::path::Path;

use hysteron_base::file;
use serde::Serialize;

use super::Drawn;
use super::shapes::NamedShape;
use crate::run::{Run, Summary};

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
    let meta = run.recording.meta();
    let metrics = Metrics {
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
    };
    let mut json = serde_json::to_string_pretty(&metrics)?;
    json.push('\n');
    file::write_bytes(&folder.join("metrics.json"), json)?;
    file::write_bytes(&folder.join("report.html"), html(&metrics, run.task.title(), figures))?;
    Ok(())
}

fn html(metrics: &Metrics, title: &str, figures: &[Drawn]) -> String {
    let run = metrics.run;
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>{0}: {1}</title>\n\
         <style>{STYLE}</style>\n</head>\n<body>\n<h1>{0}: {1}</h1>\n<p>{2}</p>\n<pre>{3}</pre>\n",
        escaped(metrics.robot.name),
        title,
        escaped(metrics.source),
        escaped(metrics.command),
    );
    let mm = |value: f64| format!("{:.2}", 1e3 * value);
    let rows = [
        ("Samples", run.samples.to_string()),
        ("Duration [s]", format!("{:.2}", run.duration_s)),
        ("Mesh", format!("{} nodes, {} tetrahedra", metrics.robot.nodes, metrics.robot.tetrahedra)),
        ("Unknowns", metrics.robot.unknowns.to_string()),
        ("Virtual tendons", metrics.robot.auxiliary_tendons.to_string()),
        ("Steps of this run", run.steps.to_string()),
        ("Time for them [s]", format!("{:.2}", run.wall_s)),
        ("Steps per second", format!("{:.0}", metrics.steps_per_s)),
        ("Iterations per step", format!("{:.2}", metrics.iterations_per_step)),
        ("Renewals of the factor", run.renewals.to_string()),
        ("Newton iterations", run.newton_iterations.to_string()),
        ("Sub-steps", run.sub_steps.to_string()),
        ("QPs solved by clarabel", run.clarabel_solves.to_string()),
        ("Worst relative residual", format!("{:.1e}", run.worst_relative_residual)),
        ("Worst stroke error [mm]", format!("{:.1e}", 1e3 * run.worst_stroke_error_m)),
        ("Tip x [mm]", format!("{} to {}", mm(run.tip_min_m[0]), mm(run.tip_max_m[0]))),
        ("Tip y [mm]", format!("{} to {}", mm(run.tip_min_m[1]), mm(run.tip_max_m[1]))),
        ("Tip z [mm]", format!("{} to {}", mm(run.tip_min_m[2]), mm(run.tip_max_m[2]))),
    ];
    let goals = run.goals.iter().flat_map(|goals| {
        [
            ("Goals out of reach", goals.out_of_reach.to_string()),
            ("Tolerance [mm]", (1e3 * goals.tolerance_m).to_string()),
            ("Largest distance from a goal [mm]", format!("{:.1e}", 1e3 * goals.largest_distance_m)),
            ("QPs solved for strokes", run.rounds.to_string()),
        ]
    });
    page.push_str("<table>\n");
    for (name, value) in rows.into_iter().chain(goals) {
        page.push_str(&format!("<tr><th>{name}</th><td>{value}</td></tr>\n"));
    }
    page.push_str("</table>\n");
    if !run.tendons.is_empty() {
        page.push_str(
            "<table>\n<tr><th>Tendon</th><th>Stroke [mm]</th><th>Largest tension [N]</th>\
             <th>At the lower tension bound</th></tr>\n",
        );
        for tendon in &run.tendons {
            page.push_str(&format!(
                "<tr><th>{}</th><td>{} to {}</td><td>{:.2}</td><td>{:.1} % of the time</td></tr>\n",
                escaped(&tendon.name),
                mm(tendon.stroke_min_m),
                mm(tendon.stroke_max_m),
                tendon.tension_max_n,
                100.0 * tendon.share_at_lower_bound,
            ));
        }
        page.push_str("</table>\n");
    }
    for NamedShape { name, numbers } in metrics.shapes {
        page.push_str(&format!("<table>\n<tr><th>Shape of {}</th><td></td></tr>\n", escaped(name)));
        let rows = [
            ("Largest displacement [mm]", Some(mm(numbers.excursion_m))),
            ("Tip over command", Some(format!("{:.2}", numbers.tip_per_stroke))),
            ("Diamond ratio", numbers.diamond_ratio.map(|ratio| format!("{ratio:.3}"))),
            ("Rest missed by [%]", Some(format!("{:.2}", 100.0 * numbers.rest_miss))),
        ];
        for (name, value) in rows.into_iter().filter_map(|(name, value)| Some((name, value?))) {
            page.push_str(&format!("<tr><th>{name}</th><td>{value}</td></tr>\n"));
        }
        page.push_str("</table>\n");
    }
    for figure in figures {
        page.push_str(&format!(
            "<figure>\n{}\n<figcaption>{}</figcaption>\n</figure>\n",
            figure.svg,
            escaped(&figure.caption)
        ));
    }
    page.push_str(&format!(
        "<p class=\"small\">Scene {}. Program {}.</p>\n</body>\n</html>\n",
        metrics.robot.scene_sha256,
        if metrics.commit.is_empty() { "of unknown commit" } else { metrics.commit },
    ));
    page
}

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;color:#282c34;max-width:940px;margin:2em auto;padding:0 1em}\
pre{background:#f4f5f7;padding:.8em 1em;white-space:pre-wrap;border-radius:4px}\
table{border-collapse:collapse;margin:1em 0}th,td{text-align:left;padding:.15em 1.2em .15em 0;font-weight:normal;\
border-bottom:1px solid #e1e4e8}td{font-variant-numeric:tabular-nums}figure{margin:2em 0}svg{max-width:100%;height:auto}\
figcaption{color:#5a6068}.small{color:#5a6068;font-size:12px;overflow-wrap:anywhere}";

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

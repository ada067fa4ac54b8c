//! `report.html`, one file with everything in it, and `metrics.json` with every number it shows.
//!
//! No template engine: a page is headings, tables and figures in the order in which code adds them, one function escapes
//! text, and a template would be a second place that knows what a verb reports.

use hysteron_base::json;
use std::path::Path;

use serde::Serialize;

use crate::color::{hex, style};
use crate::figure::{Drawn, LegendEntry};
use crate::line_style::LineStyle;
use crate::maker::replace;
use crate::svg::SCALE;
use crate::text::without_signs_of_zeros;
use crate::verdict::{Usability, Verdict};

/// Writes `metrics.json` to `folder`.
pub fn write_metrics(folder: &Path, metrics: &impl Serialize) -> anyhow::Result<()> {
    replace(&folder.join("metrics.json"), json::to_text(metrics)?)
}

/// Writes `report.html` to `folder`.
pub fn write_page(folder: &Path, html: String) -> anyhow::Result<()> {
    replace(&folder.join("report.html"), html)
}

/// A report as it grows: one file with everything in it.
pub struct Page(String);

impl Page {
    /// A page that begins with a verdict on its result.
    pub fn with_verdict(title: &str, verdict: &Verdict, about: &str, command: &str) -> Self {
        Self::beginning_with(|page| page.verdict(verdict), title, about, command)
    }

    /// A page that begins with its result in a sentence, where no limits decide whether it can be used.
    pub fn concluded(title: &str, conclusion: &str, about: &str, command: &str) -> Self {
        let sentence = format!("<p class=\"verdict\">{}</p>\n", escaped(&without_signs_of_zeros(conclusion)));
        Self::beginning_with(|page| page.0.push_str(&sentence), title, about, command)
    }

    /// Title, result, what it is about and the command that made it, in this order.
    fn beginning_with(result: impl FnOnce(&mut Self), title: &str, about: &str, command: &str) -> Self {
        let [title, about, command] = [title, about, command].map(escaped);
        let mut page = Self(format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
             <meta name=\"generator\" content=\"hysteron\"/>\n<title>{title}</title>\n\
             <style>\n{STYLE}{}</style>\n</head>\n<body>\n<h1>{title}</h1>\n",
            style(SCALE)
        ));
        result(&mut page);
        page.0.push_str(&format!("<p>{about}</p>\n<pre>{command}</pre>\n"));
        page
    }

    /// The sentence of a verdict, and its reasons with their limits.
    fn verdict(&mut self, verdict: &Verdict) {
        let class = match verdict.usability {
            Usability::Usable => "usable",
            Usability::UsableWithCare => "care",
            Usability::NotUsable => "not-usable",
        };
        self.0.push_str(&format!("<p class=\"verdict {class}\">{}</p>\n", escaped(&verdict.sentence)));
        if !verdict.reasons.is_empty() {
            self.table(&Verdict::HEADINGS, verdict.reasons.iter().map(|reason| reason.cells().to_vec()));
        }
    }

    /// A heading.
    pub fn heading(&mut self, text: &str) {
        self.0.push_str(&format!("<h2>{}</h2>\n", escaped(text)));
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) {
        self.0.push_str(&format!("<p>{}</p>\n", escaped(text)));
    }

    /// Lines of code that are shown when asked for.
    pub fn details(&mut self, summary: &str, code: &str) {
        let [summary, code] = [summary, code].map(escaped);
        self.0.push_str(&format!("<details>\n<summary>{summary}</summary>\n<pre>{code}</pre>\n</details>\n"));
    }

    /// A table with a row of headings.
    pub fn table(&mut self, headings: &[&str], rows: impl IntoIterator<Item = Vec<String>>) {
        self.0.push_str("<div class=\"scroll\"><table>\n<thead><tr>");
        headings
            .iter()
            .for_each(|heading| self.0.push_str(&format!("<th scope=\"col\">{}</th>", escaped(heading))));
        self.0.push_str("</tr></thead>\n<tbody>\n");
        for row in rows {
            self.0.push_str("<tr>");
            let headings = headings.iter().copied().chain(std::iter::repeat(""));
            row.iter().zip(headings).for_each(|(cell, heading)| self.0.push_str(&table_cell(cell, heading)));
            self.0.push_str("</tr>\n");
        }
        self.0.push_str("</tbody>\n</table></div>\n");
    }

    /// A table of names and values.
    pub fn list<'a>(&mut self, rows: impl IntoIterator<Item = (&'a str, String)>) {
        self.0.push_str("<div class=\"scroll\"><table class=\"pair\">\n");
        for (name, value) in rows {
            let (name, value) = (escaped(name), table_cell(&value, ""));
            self.0.push_str(&format!("<tr><th scope=\"row\">{name}</th>{value}</tr>\n"));
        }
        self.0.push_str("</table></div>\n");
    }

    /// Names and values that are shown on request: details of the computation, not results.
    pub fn details_list<'a>(&mut self, summary: &str, rows: impl IntoIterator<Item = (&'a str, String)>) {
        self.0.push_str(&format!("<details>\n<summary>{}</summary>\n", escaped(summary)));
        self.list(rows);
        self.0.push_str("</details>\n");
    }

    /// A figure with its caption.
    pub fn figure(&mut self, figure: &Drawn) {
        let [title, caption] = [&figure.title, &figure.caption].map(|text| escaped(text));
        self.0.push_str(&format!("<figure>\n<h3>{title}</h3>\n"));
        self.0.push_str(&legend(&figure.legend, figure.line_style));
        if figure.narrow.is_empty() {
            self.tiles("tiles", &figure.tiles, figure);
        } else {
            self.tiles("tiles wide", &figure.tiles, figure);
            self.tiles("tiles narrow", &figure.narrow, figure);
        }
        self.0.push_str(&format!("<figcaption>{caption}</figcaption>\n</figure>\n"));
    }

    /// Tiles with their legends; what is more than a reader compares at once is shown on request.
    fn tiles(&mut self, class: &str, tiles: &[String], figure: &Drawn) {
        let tile = |(k, svg): (usize, &String)| {
            let own = figure.tile_legends.get(k).map_or(String::new(), |own| legend(own, figure.line_style));
            format!("<div class=\"tile\">\n{own}{svg}</div>\n")
        };
        let tiles: Vec<String> = tiles.iter().enumerate().map(tile).collect();
        let (first, rest) = tiles.split_at(tiles.len().min(MAX_TILES));
        self.0.push_str(&format!("<div class=\"{class}\">\n{}</div>\n", first.concat()));
        if !rest.is_empty() {
            self.0.push_str(&format!(
                "<details class=\"{}\">\n<summary>{} more</summary>\n<div class=\"tiles\">\n{}</div>\n</details>\n",
                class.trim_start_matches("tiles").trim(),
                rest.len(),
                rest.concat()
            ));
        }
    }

    /// A line in small print.
    pub fn small(&mut self, text: &str) {
        self.0.push_str(&format!("<p class=\"small\">{}</p>\n", escaped(text)));
    }

    /// The whole page.
    pub fn finish(mut self, commit: &str) -> String {
        self.small(&format!("Program {}.", if commit.is_empty() { "of unknown commit" } else { commit }));
        self.0.push_str(&format!("<script>//<![CDATA[\n{SCRIPT}//]]></script>\n</body>\n</html>\n"));
        self.0
    }
}

const STYLE: &str = include_str!("../assets/page.css");
const SCRIPT: &str = include_str!("../assets/page.js");
/// Tiles of a figure that are shown unasked.
const MAX_TILES: usize = 12;

/// A legend, if it has entries: each a line in its colour and a name.
fn legend(entries: &[LegendEntry], line_style: LineStyle) -> String {
    if entries.is_empty() {
        return String::new();
    }
    let class = if line_style == LineStyle::ByColor { "key dashed" } else { "key" };
    let entry = |(name, color): &LegendEntry| {
        let (color, name) = (hex(*color), escaped(name));
        format!(
            "<span data-color=\"{color}\"><svg class=\"{class}\" width=\"30\" height=\"10\" viewBox=\"0 0 150 50\" \
             aria-hidden=\"true\"><polyline fill=\"none\" stroke=\"{color}\" stroke-width=\"15\" \
             points=\"0,25 150,25\"/></svg>{name}</span>"
        )
    };
    let entries: Vec<String> = entries.iter().map(entry).collect();
    format!("<p class=\"legend\">{}</p>\n", entries.join("\n"))
}

/// A cell, with the heading of its column for a narrow window in which rows are lists; prose is broken into lines,
/// numbers are not.
fn table_cell(text: &str, heading: &str) -> String {
    const LONG: usize = 32;
    let class = if text.chars().count() > LONG { " class=\"long\"" } else { "" };
    let text = escaped(&without_signs_of_zeros(text));
    match heading {
        "" => format!("<td{class}>{text}</td>"),
        heading => format!("<td{class} data-label=\"{}\"><span>{text}</span></td>", escaped(heading)),
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

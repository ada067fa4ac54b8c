//! `report.html`, one file with everything in it, and `metrics.json` with every number it shows.
//!
//! No template engine: a page is headings, tables and figures in the order in which code adds them, one function escapes
//! text, and a template would be a second place that knows what a verb reports.

use hysteron_base::json;
use std::path::Path;

use plotters::style::RGBColor;
use serde::Serialize;
use serde_json::Value;

use crate::figure::{Drawn, LegendEntry};
use crate::maker::replace;
use crate::text::without_signs_of_zeros;
use crate::verdict::{Usability, Verdict};

/// Writes `metrics.json` to `folder`, and gives it back as a value: what a verb came to.
pub fn write_metrics(folder: &Path, metrics: &impl Serialize) -> anyhow::Result<Value> {
    let value = json::to_value(metrics)?;
    replace(&folder.join("metrics.json"), json::to_text(metrics)?)?;
    Ok(value)
}

/// Writes `report.html` to `folder`.
pub fn write_page(folder: &Path, html: String) -> anyhow::Result<()> {
    replace(&folder.join("report.html"), html)
}

/// A report as it grows: one file with everything in it.
pub struct Page(String);

impl Page {
    /// A page with a title, what it is about and the command that made it.
    pub fn new(title: &str, about: &str, command: &str) -> Self {
        let [title, about, command] = [title, about, command].map(escaped);
        Self(format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
             <meta name=\"generator\" content=\"hysteron\"/>\n<title>{title}</title>\n\
             <style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n<p>{about}</p>\n<pre>{command}</pre>\n"
        ))
    }

    /// A page that begins with a verdict on its result.
    pub fn judged(title: &str, verdict: &Verdict, about: &str, command: &str) -> Self {
        let mut page = Self::new(title, about, command);
        let end = page.0.find("</h1>\n").map_or(page.0.len(), |at| at + "</h1>\n".len());
        let rest = page.0.split_off(end);
        page.verdict(verdict);
        page.0.push_str(&rest);
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
    pub fn list<'a>(&mut self, rows: impl IntoIterator<Item = (&'a str, String)>) {
        self.0.push_str("<div class=\"scroll\"><table>\n");
        for (name, value) in rows {
            let (name, value) = (escaped(name), table_cell(&value));
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
        if !figure.legend.is_empty() {
            let entry = |(name, RGBColor(r, g, b)): &LegendEntry| {
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
    pub fn small(&mut self, text: &str) {
        self.0.push_str(&format!("<p class=\"small\">{}</p>\n", escaped(text)));
    }

    /// The whole page.
    pub fn finish(mut self, commit: &str) -> String {
        self.small(&format!("Program {}.", if commit.is_empty() { "of unknown commit" } else { commit }));
        self.0.push_str("</body>\n</html>\n");
        self.0
    }
}

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;color:#282c34;max-width:944px;margin:2em auto;padding:0 1em}\
pre{background:#f4f5f7;padding:.8em 1em;white-space:pre-wrap;border-radius:4px}\
table{border-collapse:collapse;margin:1em 0}th,td{text-align:left;padding:.15em 1.2em .15em 0;font-weight:normal;\
border-bottom:1px solid #e1e4e8}td{white-space:nowrap}td.long{white-space:normal;min-width:16em}td{font-variant-numeric:tabular-nums}th{vertical-align:bottom}\
h1{font-size:1.7em;line-height:1.25;overflow-wrap:anywhere}h3{font-size:1em;margin:0}.scroll{overflow-x:auto}\
figure{margin:2em 0}svg{display:block;max-width:100%;height:auto}.tiles{display:flex;flex-wrap:wrap;align-items:flex-start}\
.wide{overflow-x:auto}@media(max-width:640px){.wide svg{max-width:none;width:680px}}\
.verdict{border-left:6px solid;padding:.5em 1em;font-size:1.1em;overflow-wrap:anywhere}.usable{border-color:#2a7d46;background:#eef7f0}\
.care{border-color:#b7791f;background:#fdf6e7}.not-usable{border-color:#b3261e;background:#fbecea}\
.legend{display:flex;flex-wrap:wrap;gap:.2em 1.4em;margin:.3em 0;font-size:13px}\
.legend i{display:inline-block;width:22px;height:4px;margin-right:6px;vertical-align:middle}\
summary{cursor:pointer}figcaption{color:#5a6068}.small{color:#5a6068;font-size:12px;overflow-wrap:anywhere}";

/// A cell; prose is broken into lines, numbers are not.
fn table_cell(text: &str) -> String {
    const LONG: usize = 32;
    let class = if text.chars().count() > LONG { " class=\"long\"" } else { "" };
    format!("<td{class}>{}</td>", escaped(&without_signs_of_zeros(text)))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

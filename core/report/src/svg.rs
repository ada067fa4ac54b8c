//! SVG from plotters, adapted to pages: at normal size, without empty elements, with the places of its axes.

use plotters::prelude::*;

use crate::axes_place::AxesPlace;
use crate::line_style::LineStyle;
use crate::sheet::Sheet;

/// How many times larger everything is drawn: plotters rounds to whole pixels, and curves would show it.
pub(crate) const SCALE: u32 = 5;

/// Properties of an SVG apart from its content.
pub(crate) struct SvgFrame<'a> {
    /// Width and height [px].
    pub(crate) size: [f64; 2],
    /// Lines of the curves.
    pub(crate) line_style: LineStyle,
    /// Style sheet; empty in a page, which has its own.
    pub(crate) rules: &'a str,
}

/// Draws an SVG.
pub(crate) fn svg(
    drawing: &SvgFrame,
    draw: impl FnOnce(&Sheet<SVGBackend>) -> anyhow::Result<()>,
) -> anyhow::Result<String> {
    let [width, height] = drawing.size.map(|length| length.ceil() as u32);
    let large = (width * SCALE, height * SCALE);
    let mut svg = String::new();
    let plots = {
        let root = SVGBackend::with_string(&mut svg, large).into_drawing_area();
        let sheet = Sheet::new(root.clone(), f64::from(SCALE))?;
        draw(&sheet)?;
        root.present()?;
        sheet.plots()
    };
    // Shown at normal size; the view box keeps the fine coordinates.
    let own = format!("width=\"{}\" height=\"{}\"", large.0, large.1);
    let shown =
        format!("class=\"{}\"{} width=\"{width}\" height=\"{height}\"", class(drawing), data(&plots)?);
    let svg = without_empty_text(&svg.replacen(&own, &shown, 1)).replace(" opacity=\"1\"", "");
    if drawing.rules.is_empty() {
        return Ok(svg);
    }
    let head = svg.find(">\n").map_or(svg.len(), |at| at + 2);
    Ok(format!("{}<style>{}</style>\n{}", &svg[..head], drawing.rules, &svg[head..]))
}

fn class(drawing: &SvgFrame) -> &'static str {
    match drawing.line_style {
        LineStyle::Solid => "plot",
        LineStyle::ByColor => "plot dashed",
    }
}

/// The places of all axes, as an attribute.
fn data(plots: &[AxesPlace]) -> anyhow::Result<String> {
    if plots.is_empty() {
        return Ok(String::new());
    }
    let text =
        serde_json::to_string(plots)?.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
    Ok(format!(" data-plot=\"{text}\""))
}

/// Labels that were left out are empty.
fn without_empty_text(svg: &str) -> String {
    let mut cleaned = String::with_capacity(svg.len());
    let mut rest = svg;
    while let Some(at) = rest.find("<text ") {
        let end = rest[at..].find("</text>\n").map_or(rest.len(), |end| at + end + "</text>\n".len());
        let is_empty = rest[at..end].contains(">\n\n</text>");
        cleaned.push_str(&rest[..if is_empty { at } else { end }]);
        rest = &rest[end..];
    }
    cleaned.push_str(rest);
    cleaned
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_without_content_is_left_out() {
        let svg = "<svg>\n<text x=\"1\">\n\n</text>\n<line/>\n<text y=\"1\">\na\n</text>\n<text y=\"2\">\n\n</text>\n</svg>\n";
        assert_eq!(without_empty_text(svg), "<svg>\n<line/>\n<text y=\"1\">\na\n</text>\n</svg>\n");
    }
}

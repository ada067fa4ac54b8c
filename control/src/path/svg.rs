//! Outlines as SVG, from any drawing program; the only module that knows roxmltree, kurbo and svgtypes.
//!
//! One shape is read: a path of one subpath, a polygon, polyline, circle, ellipse or rectangle, with the transforms
//! on it and around it. Its size is that of the drawing: where `width` of the drawing is in mm, cm, in, pt or pc, a
//! unit of `viewBox` is that width over the one of the view box; without view box it is a CSS pixel, 25.4 / 96 mm.
//! A drawing that gives its width in pixels, in percent or not at all has no size, and is refused. y points down in
//! a drawing and up here. The arcs of a path (A) are kept within 0.03 % of their radius. Its place on the page
//! does not matter: its bounding box is centred.

use super::outline::{MAX_CROSSING_POINTS, OutlinePoint};
use hysteron_base::BadInput;
use hysteron_base::number::shown;
use hysteron_base::size::check_at_most;
use kurbo::{Affine, BezPath, Circle, Ellipse, PathEl, RoundedRect, Shape};
use roxmltree::{Document, Node, ParsingOptions};
use std::fmt::Display;
use std::str::FromStr;
use svgtypes::{Length, LengthUnit, PathParser, PathSegment, PointsParser, Transform, ViewBox};

type Check<T> = Result<T, BadInput>;

/// Largest distance of a curve from its polyline [m].
const FLATNESS: f64 = 1e-6;
const PIXEL: f64 = 25.4e-3 / 96.0;
const SHAPES: [&str; 7] = ["path", "polygon", "polyline", "circle", "ellipse", "rect", "line"];
/// Largest number of a shape in units of the drawing: beyond any page, and small enough for the curves of arcs to be
/// few.
const LARGEST: f64 = 1e7;
/// Most lines and curves of a shape.
const MAX_SEGMENTS: usize = 20_000;
/// Most elements of a drawing, and characters after the expansion of its entities.
const MAX_NODES: u32 = 200_000;
const MAX_EXPANDED: usize = 1 << 20;
/// Most attributes of an element, and elements in each other: the reader compares each with all.
const MAX_ATTRIBUTES: usize = 1000;
const DEEPEST: usize = 1000;
/// Longest side of a drawing [m].
const LONGEST_SIDE: f64 = 100.0;
/// Elements whose content is not drawn in place.
const HIDDEN: [&str; 7] = ["defs", "symbol", "clipPath", "mask", "marker", "pattern", "linearGradient"];

/// The points [m] of the one outline in a drawing, centred, and whether it is closed.
pub(super) fn read(text: &str) -> Check<(Vec<OutlinePoint>, bool)> {
    check_markup(text)?;
    check_entities(text)?;
    let options = ParsingOptions { allow_dtd: true, nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options)
        .map_err(|error| BadInput::new("SVG", "a well-formed drawing", error.to_string()))?;
    let root = document.root_element();
    if root.tag_name().name() != "svg" {
        return Err(BadInput::new(
            "SVG",
            "an element <svg> around all",
            format!("<{}>", root.tag_name().name()),
        ));
    }
    let unit = unit(&root)?;
    let shapes: Vec<Node> = root.descendants().filter(is_shape).collect();
    let [shape] = shapes[..] else {
        return Err(BadInput::new("SVG", "one shape", format!("{} of them", shapes.len())).hint(
            "path, polygon, polyline, circle, ellipse or rect; leave only the outline in the drawing",
        ));
    };
    let path = path(&shape)?;
    let mut transform = Affine::scale_non_uniform(unit, -unit);
    let around: Vec<Node> = shape.ancestors().collect();
    for node in around.iter().rev() {
        if let Some(text) = node.attribute("transform") {
            let t: Transform = parsed(node, "transform", text)?;
            transform *= Affine::new([t.a, t.b, t.c, t.d, t.e, t.f]);
        }
    }
    let (points, is_closed) = points(&(transform * path))?;
    Ok((points, is_closed || ["circle", "ellipse", "rect"].contains(&shape.tag_name().name())))
}

/// Refuses elements with more attributes, or deeper in each other, than a drawing has.
fn check_markup(text: &str) -> Check<()> {
    let (mut depth, mut deepest, mut attributes) = (0usize, 0, 0);
    for tag in text.split('<').skip(1) {
        let inside = tag.split('>').next().unwrap_or_default();
        attributes = inside.matches('=').count().max(attributes);
        match inside.as_bytes() {
            [b'/', ..] => depth = depth.saturating_sub(1),
            [b'!' | b'?', ..] | [.., b'/'] => {}
            _ => depth += 1,
        }
        deepest = depth.max(deepest);
    }
    check_at_most("SVG: attributes of an element", attributes, MAX_ATTRIBUTES)?;
    check_at_most("SVG: elements in each other", deepest, DEEPEST)
}

/// Refuses entities whose use would make much of little: drawing programs have them for names, a few dozen
/// characters long.
fn check_entities(text: &str) -> Check<()> {
    let values = text.split("<!ENTITY").skip(1).map(|rest| rest.split('>').next().unwrap_or_default());
    let (mut longest, mut n) = (0, 0);
    for value in values {
        if value.contains('&') || value.contains('%') {
            return Err(BadInput::new("SVG: <!ENTITY>", "text without other entities", "some")
                .hint("save it as plain SVG"));
        }
        (longest, n) = (value.len().max(longest), n + 1);
    }
    if n == 0 {
        return Ok(());
    }
    let expanded = longest.saturating_mul(text.matches('&').count());
    check_at_most("SVG: <!ENTITY>: characters they stand for", expanded, MAX_EXPANDED)
}

fn is_shape(node: &Node) -> bool {
    SHAPES.contains(&node.tag_name().name())
        && !node.ancestors().any(|outer| HIDDEN.contains(&outer.tag_name().name()))
}

/// Metres in a unit of the drawing.
fn unit(root: &Node) -> Check<f64> {
    let no_size = |found: &str| {
        BadInput::new("SVG: width", "the width of the drawing in mm, cm, in, pt or pc", found)
            .hint("set the size of the page in the drawing program, as in width=\"80mm\"")
    };
    let width = side(root, "width")?.ok_or_else(|| no_size(root.attribute("width").unwrap_or("nothing")))?;
    let Some(text) = root.attribute("viewBox") else { return Ok(PIXEL) };
    let view: ViewBox = parsed(root, "viewBox", text)?;
    if !(view.w > 0.0 && view.h > 0.0 && view.w <= LARGEST && view.h <= LARGEST) {
        return Err(BadInput::new("SVG: viewBox", format!("width and height from 0 to {LARGEST:e}"), text));
    }
    let unit = width / view.w;
    if let Some(height) = side(root, "height")?
        && (height / view.h - unit).abs() > 1e-2 * unit
    {
        let found =
            format!("{} mm by {} mm over {} by {}", shown(1e3 * width), shown(1e3 * height), view.w, view.h);
        return Err(BadInput::new("SVG: viewBox", "one scale in width and height", found));
    }
    Ok(unit)
}

/// Width or height of the drawing [m], where it is a length.
fn side(root: &Node, name: &str) -> Check<Option<f64>> {
    let Some(text) = root.attribute(name) else { return Ok(None) };
    let Length { number, unit } = parsed(root, name, text)?;
    let unit = match unit {
        LengthUnit::Mm => 1e-3,
        LengthUnit::Cm => 1e-2,
        LengthUnit::In => 25.4e-3,
        LengthUnit::Pt => 25.4e-3 / 72.0,
        LengthUnit::Pc => 25.4e-3 / 6.0,
        _ => return Ok(None),
    };
    let side = number * unit;
    if side > 0.0 && side <= LONGEST_SIDE {
        return Ok(Some(side));
    }
    Err(BadInput::new(format!("SVG: {name}"), format!("a length from 0 to {LONGEST_SIDE} m"), text))
}

/// A shape in units of the drawing.
fn path(shape: &Node) -> Check<BezPath> {
    const FINE: f64 = 1e-6; // of a circle's arcs as Bézier curves; flattened later
    let number = |name: &str| match shape.attribute(name) {
        None => Ok(0.0),
        Some(text) => match parsed(shape, name, text)? {
            Length { number, unit: LengthUnit::None | LengthUnit::Px } => {
                check_number(&place(shape, name), number)
            }
            _ => Err(BadInput::new(place(shape, name), "a number without unit", text)),
        },
    };
    Ok(match shape.tag_name().name() {
        "path" => {
            let text = shape.attribute("d").unwrap_or_default();
            check_segments(shape, text)?;
            BezPath::from_svg(text).map_err(|error| not_svg(shape, "d", text, &error))?
        }
        name @ ("polygon" | "polyline") => {
            let text = shape.attribute("points").unwrap_or_default();
            let mut path = BezPath::new();
            for (i, point) in PointsParser::from(text).enumerate() {
                check_at_most(&place(shape, "points"), i + 1, MAX_CROSSING_POINTS)?;
                path.push(if i == 0 { PathEl::MoveTo(point.into()) } else { PathEl::LineTo(point.into()) });
            }
            if name == "polygon" && !path.is_empty() {
                path.close_path();
            }
            path
        }
        "circle" => Circle::new((number("cx")?, number("cy")?), number("r")?).to_path(FINE),
        "ellipse" => {
            let (centre, radii) = ((number("cx")?, number("cy")?), (number("rx")?, number("ry")?));
            Ellipse::new(centre, radii, 0.0).to_path(FINE)
        }
        "rect" => {
            let (x, y) = (number("x")?, number("y")?);
            let (right, below) = (x + number("width")?, y + number("height")?);
            RoundedRect::new(x, y, right, below, number("rx")?).to_path(FINE)
        }
        name => return Err(BadInput::new("SVG", "a shape with corners or curves", format!("<{name}>"))),
    })
}

/// Refuses a path with more segments, or larger numbers, than a drawing has, before its arcs become curves.
fn check_segments(shape: &Node, text: &str) -> Check<()> {
    let place = place(shape, "d");
    for (i, segment) in PathParser::from(text).enumerate() {
        check_at_most(&place, i + 1, MAX_SEGMENTS)?;
        // The reader that draws the path reports what it cannot read.
        let Ok(segment) = segment else { return Ok(()) };
        let numbers = match segment {
            PathSegment::MoveTo { x, y, .. }
            | PathSegment::LineTo { x, y, .. }
            | PathSegment::SmoothQuadratic { x, y, .. } => [x, y, 0.0, 0.0, 0.0, 0.0],
            PathSegment::HorizontalLineTo { x, .. } => [x, 0.0, 0.0, 0.0, 0.0, 0.0],
            PathSegment::VerticalLineTo { y, .. } => [0.0, y, 0.0, 0.0, 0.0, 0.0],
            PathSegment::CurveTo { x1, y1, x2, y2, x, y, .. } => [x1, y1, x2, y2, x, y],
            PathSegment::SmoothCurveTo { x2, y2, x, y, .. } => [x2, y2, x, y, 0.0, 0.0],
            PathSegment::Quadratic { x1, y1, x, y, .. } => [x1, y1, x, y, 0.0, 0.0],
            PathSegment::EllipticalArc { rx, ry, x_axis_rotation, x, y, .. } => {
                [rx, ry, x_axis_rotation, x, y, 0.0]
            }
            PathSegment::ClosePath { .. } => [0.0; 6],
        };
        for number in numbers {
            check_number(&place, number)?;
        }
    }
    Ok(())
}

fn check_number(place: &str, number: f64) -> Check<f64> {
    if number.abs() <= LARGEST {
        return Ok(number);
    }
    Err(BadInput::new(place, format!("numbers from -{LARGEST:e} to {LARGEST:e}"), format!("{number:e}")))
}

/// Points of a path in metres, its bounding box centred.
fn points(path: &BezPath) -> Check<(Vec<OutlinePoint>, bool)> {
    if !path.is_finite() {
        return Err(BadInput::new("SVG", "finite coordinates", "others"));
    }
    let subpaths = path.elements().iter().filter(|element| matches!(element, PathEl::MoveTo(_))).count();
    if subpaths != 1 {
        return Err(BadInput::new("SVG: path", "a single subpath", format!("{subpaths} subpaths"))
            .hint("one M at the beginning of d; break the path apart in the drawing program"));
    }
    let (box_, mut points, mut is_closed) = (path.bounding_box(), Vec::new(), false);
    if !(box_.width() <= LONGEST_SIDE && box_.height() <= LONGEST_SIDE) {
        let found = format!("{:.2e} m by {:.2e} m", box_.width(), box_.height());
        return Err(BadInput::new("SVG", format!("a shape of at most {LONGEST_SIDE} m"), found));
    }
    let centre = box_.center();
    kurbo::flatten(path, FLATNESS, |element| match element {
        PathEl::MoveTo(p) | PathEl::LineTo(p) => points.push([p.x - centre.x, p.y - centre.y, 0.0]),
        _ => is_closed = true,
    });
    check_at_most("SVG: points of the shape", points.len(), MAX_CROSSING_POINTS)?;
    Ok((points, is_closed))
}

fn place(node: &Node, name: &str) -> String {
    format!("SVG: {}.{name}", node.tag_name().name())
}

fn parsed<T: FromStr<Err: Display>>(node: &Node, name: &str, text: &str) -> Check<T> {
    text.parse().map_err(|error| not_svg(node, name, text, &error))
}

fn not_svg(node: &Node, name: &str, text: &str, error: &dyn Display) -> BadInput {
    let shown: String = text.chars().take(60).collect();
    BadInput::new(place(node, name), "a value that SVG 1.1 allows", format!("\"{shown}\" ({error})"))
}

//! The mass of a geom.

use super::super::xml::Check;
use super::assets::Assets;
use super::attributes::{Attributes, Classes};
use super::element::brief;
use super::mass::ShapeMoments;
use super::orientation::{pose, segment};
use super::settings::Settings;
use crate::spatial::{Inertia, Pose};

/// Density of a geom that names none [kg/m³].
const DENSITY: f64 = 1000.0;
/// Volume [m³] or area [m²] below which MuJoCo gives no mass.
const MIN_SIZE: f64 = 1e-15;

/// The body of a geom in `frame` of its body; `None` where it has no mass.
///
/// # Errors
/// `BadInput` for shapes without size, negative masses, and shapes whose mass is not computed.
pub(super) fn inertia(
    at: &Attributes,
    settings: &Settings,
    (assets, classes): (&Assets, &Classes),
    frame: &Pose<f64>,
) -> Check<Option<Inertia<f64>>> {
    let group = at.number("group")?.unwrap_or(0.0);
    let [least, most] = settings.inertia_groups;
    let (mass, density) = (at.number("mass")?, at.number("density")?.unwrap_or(DENSITY));
    if let Some(negative) = mass.into_iter().chain([density]).find(|x| *x < 0.0) {
        return Err(at.element.error("mass and density >= 0", negative.to_string()));
    }
    if group < least || group > most || mass.unwrap_or(density) == 0.0 {
        return Ok(None);
    }
    let kind = at.text("type").unwrap_or("sphere");
    if ["plane", "hfield"].contains(&kind) {
        return Ok(None);
    }
    let (shape, placed) = match (kind, at.text("mesh")) {
        ("mesh", Some(name)) => (assets.shape(at.element, name, classes, settings)?, pose(at, settings)?),
        ("mesh", None) => return Err(at.element.error("an attribute mesh", "none")),
        (_, Some(name)) => {
            return Err(at
                .element
                .error(
                    "a mesh as type=\"mesh\": shapes are not fitted to meshes",
                    format!("type {kind} and mesh {}", brief(name)),
                )
                .hint("give the body an <inertial>, or save the compiled model (mj_saveLastXML)"));
        }
        (kind, None) => primitive(at, settings, kind)?,
    };
    let density = match mass {
        Some(mass) if shape.size > MIN_SIZE => mass / shape.size,
        Some(_) => 0.0,
        None => density,
    };
    let at_frame = frame.times(&placed);
    Ok(Some(shape.body(density, &at_frame)))
}

/// A shape with its sizes, and its pose in its frame.
fn primitive(at: &Attributes, settings: &Settings, kind: &str) -> Check<(ShapeMoments, Pose<f64>)> {
    let mut sizes = at.numbers("size")?.unwrap_or_default();
    let is_shell = at.is_true("shellinertia")?;
    let placed = match segment(at)? {
        None => pose(at, settings)?,
        Some(_) if kind == "sphere" => {
            return Err(at.element.error("fromto of a capsule, cylinder, box or ellipsoid", "a sphere"));
        }
        Some((placed, length)) => {
            // The half length takes the place of the size in that direction.
            let radius = sizes.first().copied().unwrap_or(0.0);
            sizes = if ["capsule", "cylinder"].contains(&kind) {
                vec![radius, 0.5 * length]
            } else {
                vec![radius, radius, 0.5 * length]
            };
            placed
        }
    };
    let needed = match kind {
        "sphere" => 1,
        "capsule" | "cylinder" => 2,
        "ellipsoid" | "box" => 3,
        other => {
            let expected = "a shape whose mass is known: sphere, capsule, ellipsoid, cylinder, box, mesh";
            return Err(at.element.error(expected, format!("\"{}\"", brief(other))));
        }
    };
    if sizes.len() < needed || sizes[..needed].iter().any(|size| *size <= 0.0) {
        let found = at.text("size").map_or_else(|| "none".to_owned(), |text| format!("\"{}\"", brief(text)));
        return Err(at.element.error(&format!("{needed} sizes > 0 of a {kind}"), found));
    }
    let size = |k: usize| sizes[k];
    let shape = match (kind, is_shell) {
        ("sphere", false) => ShapeMoments::ellipsoid([size(0); 3]),
        ("sphere", true) => ShapeMoments::sphere_shell(size(0)),
        ("capsule", false) => ShapeMoments::capsule(size(0), size(1)),
        ("capsule", true) => ShapeMoments::capsule_shell(size(0), size(1)),
        ("cylinder", false) => ShapeMoments::cylinder(size(0), size(1)),
        ("cylinder", true) => ShapeMoments::cylinder_shell(size(0), size(1)),
        ("box", false) => ShapeMoments::solid_box([size(0), size(1), size(2)]),
        ("box", true) => ShapeMoments::box_shell([size(0), size(1), size(2)]),
        (_, false) => ShapeMoments::ellipsoid([size(0), size(1), size(2)]),
        (_, true) => {
            return Err(at
                .element
                .error("no shellinertia of an ellipsoid: it is not computed", "one")
                .hint("give the body an <inertial>"));
        }
    };
    Ok((shape, placed))
}

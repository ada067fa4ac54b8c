//! URDF, and xacro that becomes URDF.
//!
//! Read element by element, because what is missing differs from what is zero: an absent `<inertial>` or `<limit>` is
//! an error where it matters, and every error names its line. Joints of a floating or planar base are taken as fixed and noted:
//! the caller decides whether that is allowed.
//!
//! # Reference
//! wiki.ros.org/urdf/XML.

mod schema;

use std::collections::BTreeMap;

use hysteron_base::BadInput;
use hysteron_base::plausible_range::ANGLE;

use super::Model;
use super::build::{check_inertia, unit};
use super::description::{Description, FreeJoint, JointDescription, JointKind, JointLimits, Link, Mimic};
use super::edit::limits_in_degrees;
use super::xml::{Check, Element};
use crate::spatial::{Inertia, Pose, Vec3};

/// Standard gravity along −z, which URDF does not hold [m/s²].
const GRAVITY: Vec3<f64> = [0.0, 0.0, -9.81];

/// Table in Markdown of every element and attribute with its treatment by the reader.
pub(super) fn table() -> String {
    schema::table()
}

pub(super) fn read(robot: &Element) -> Check<Model> {
    if *robot.tag != *"robot" {
        return Err(robot.error("<robot>", format!("<{}>", robot.tag)));
    }
    let warnings = schema::unknown(robot)?;
    let mut index = BTreeMap::new();
    let mut description = Description {
        file: robot.file.to_string(),
        name: robot.attribute("name").unwrap_or("robot").to_owned(),
        links: Vec::new(),
        joints: Vec::new(),
        sites: Vec::new(),
        free: Vec::new(),
        faults: Vec::new(),
        gravity: GRAVITY,
    };
    for link in robot.children_of("link") {
        let name = link.text("name")?;
        let number = description.links.len();
        if index.insert(name, number).is_some() {
            return Err(link.error("names of links that differ", format!("\"{name}\" twice")));
        }
        let (inertia, fault) = inertia(link)?;
        description.faults.extend(fault.map(|fault| (number, fault)));
        description.links.push(Link {
            name: name.to_owned(),
            place: link.place(),
            inertia,
            compensation: 0.0,
        });
    }
    for element in robot.children_of("joint") {
        let (joint, free) = joint(element, &index)?;
        description.free.extend(free);
        description.joints.push(joint);
    }
    let mut model = super::build::build(description)?;
    model.notes.warnings.splice(0..0, warnings);
    let limits: Vec<String> = model.joints.iter().filter_map(limits_in_degrees).collect();
    model.notes.warnings.extend(limits);
    Ok(model)
}

/// Inertia of a link, and the error in it that counts where the link moves.
fn inertia(link: &Element) -> Check<(Option<Inertia<f64>>, Option<BadInput>)> {
    let Some(inertial) = link.child("inertial")? else { return Ok((None, None)) };
    let part =
        |tag: &'static str| inertial.child(tag)?.ok_or_else(|| inertial.error(&format!("a <{tag}>"), "none"));
    let (mass, tensor) = (part("mass")?, part("inertia")?);
    let kg = mass.required("value")?;
    if kg < 0.0 {
        return Err(within(mass.error("a mass >= 0 kg", kg.to_string()), link));
    }
    let mut second = [0.0; 6];
    for (value, name) in second.iter_mut().zip(["ixx", "ixy", "iyy", "ixz", "iyz", "izz"]) {
        *value = tensor.required(name)?;
    }
    let fault = check_inertia(kg, &second)
        .err()
        .map(|found| within(tensor.error("an inertia without negative principal value", found), link));
    let pose = origin(inertial)?;
    let centred = Inertia { mass: kg, first: [0.0; 3], second };
    Ok((Some(centred.placed(&pose.rotation, pose.position)), fault))
}

/// Names the link of an element that has no name.
fn within(mut bad: BadInput, link: &Element) -> BadInput {
    if let Some(name) = link.attribute("name") {
        bad.place.push_str(&format!(" of link[{name}]"));
    }
    bad
}

/// `<origin xyz rpy>` of an element; the same frame where it has none.
fn origin(element: &Element) -> Check<Pose<f64>> {
    let Some(origin) = element.child("origin")? else { return Ok(Pose::IDENTITY) };
    let position = origin.array("xyz")?.unwrap_or_default();
    let angles: Vec3<f64> = origin.array("rpy")?.unwrap_or_default();
    ANGLE.check_all(&origin.place(), &angles)?;
    let [roll, pitch, yaw] = angles;
    let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
    let rotation = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ];
    Ok(Pose { rotation, position })
}

/// How a type of URDF moves.
enum Type {
    Fixed,
    /// Of more than one degree of freedom.
    Free,
    Moves(JointKind),
    /// About its axis for ever.
    Turns,
}

fn type_of(element: &Element) -> Check<Type> {
    Ok(match element.text("type")? {
        "fixed" => Type::Fixed,
        "revolute" => Type::Moves(JointKind::Revolute),
        "continuous" => Type::Turns,
        "prismatic" => Type::Moves(JointKind::Prismatic),
        "floating" | "planar" => Type::Free,
        other => {
            let expected = "type fixed, revolute, continuous or prismatic";
            return Err(element.error(expected, format!("\"{other}\"")));
        }
    })
}

fn joint(element: &Element, links: &BTreeMap<&str, usize>) -> Check<(JointDescription, Option<FreeJoint>)> {
    let name = element.text("name")?;
    let link = |tag: &'static str| {
        let end = element.child(tag)?.ok_or_else(|| element.error(&format!("a <{tag} link=…>"), "none"))?;
        let name = end.text("link")?;
        let found = links.get(name).copied();
        found.ok_or_else(|| end.error("a link of this robot", format!("\"{name}\"")))
    };
    let (parent, child) = (link("parent")?, link("child")?);
    let of = type_of(element)?;
    let kind = match of {
        Type::Fixed | Type::Free => None,
        Type::Moves(kind) => Some(kind),
        Type::Turns => Some(JointKind::Revolute),
    };
    let (mut drive, mut mimic, mut axis) = (JointLimits::default(), None, [1.0, 0.0, 0.0]);
    if kind.is_some() {
        axis = unit_axis(element)?;
        drive = limits(element, matches!(of, Type::Turns))?;
        if let Some(dynamics) = element.child("dynamics")? {
            drive.damping = dynamics.not_negative("damping")?.unwrap_or(0.0);
            drive.dry_friction = dynamics.not_negative("friction")?.unwrap_or(0.0);
        }
        if let Some(own) = element.child("mimic")? {
            let ratio = own.number("multiplier")?.unwrap_or(1.0);
            let offset = own.number("offset")?.unwrap_or(0.0);
            mimic = Some(Mimic { joint: own.text("joint")?.to_owned(), ratio, offset });
        }
    }
    let free = matches!(of, Type::Free).then(|| FreeJoint {
        name: name.to_owned(),
        place: element.place(),
        kind: element.attribute("type").unwrap_or_default().to_owned(),
    });
    let origin = origin(element)?;
    let (name, place) = (name.to_owned(), element.place());
    Ok((JointDescription { name, place, kind, parent, child, origin, axis, drive, mimic }, free))
}

fn unit_axis(element: &Element) -> Check<Vec3<f64>> {
    let Some(own) = element.child("axis")? else { return Ok([1.0, 0.0, 0.0]) };
    let axis: Vec3<f64> = own.array("xyz")?.unwrap_or([1.0, 0.0, 0.0]);
    unit(axis).ok_or_else(|| own.error("an axis longer than zero", format!("{axis:?}")))
}

fn limits(element: &Element, turns: bool) -> Check<JointLimits> {
    let Some(limit) = element.child("limit")? else {
        return if turns {
            Ok(JointLimits::default())
        } else {
            Err(element
                .error("a <limit> with lower, upper, effort and velocity", "none")
                .hint("a joint that turns for ever has type continuous"))
        };
    };
    let range = if turns {
        None
    } else {
        let end = |name| Ok(limit.number(name)?.unwrap_or(0.0));
        let [lower, upper] = [end("lower")?, end("upper")?];
        if lower > upper {
            return Err(element.error("lower <= upper", format!("lower {lower}, upper {upper}")));
        }
        Some([lower, upper])
    };
    Ok(JointLimits {
        range,
        speed_limit: limit.not_negative("velocity")?,
        effort_limit: limit.not_negative("effort")?,
        ..JointLimits::default()
    })
}

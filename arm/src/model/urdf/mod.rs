//! URDF.
//!
//! Read element by element, because what is missing differs from what is zero: an absent `<inertial>` or `<limit>` is
//! an error where it matters, and every error names its line.
//!
//! # Reference
//! wiki.ros.org/urdf/XML.

use std::collections::BTreeMap;

use super::Model;
use super::description::{Description, Drive, JointDescription, JointKind, Link, Mimic};
use super::xml::{Check, Node, Place, parse};
use crate::spatial::{Inertia, Pose, Vec3};

/// Standard gravity along −z, which URDF does not say [m/s²].
const GRAVITY: Vec3<f64> = [0.0, 0.0, -9.81];

pub(super) fn read(text: &str, file: &str) -> Check<Model> {
    let document = parse(text, file)?;
    let (root, place) = (document.root_element(), Place { file });
    if root.tag_name().name() != "robot" {
        return Err(place.error(&root, "<robot>", format!("<{}>", root.tag_name().name())));
    }
    let mut index = BTreeMap::new();
    let mut links = Vec::new();
    for node in place.children(&root, "link") {
        let name = place.text(&node, "name")?;
        if index.insert(name, links.len()).is_some() {
            return Err(place.error(&node, "names of links that differ", format!("\"{name}\" twice")));
        }
        links.push(Link {
            name: name.to_owned(),
            place: place.of(&node),
            inertia: inertia(&place, &node)?,
            compensation: 0.0,
        });
    }
    let mut joints = Vec::new();
    for node in place.children(&root, "joint") {
        joints.push(joint(&place, &node, &index)?);
    }
    let name = root.attribute("name").unwrap_or("robot").to_owned();
    super::build::build(Description {
        file: file.to_owned(),
        name,
        links,
        joints,
        sites: Vec::new(),
        gravity: GRAVITY,
    })
}

fn inertia(place: &Place, link: &Node) -> Check<Option<Inertia<f64>>> {
    let Some(node) = place.child(link, "inertial")? else { return Ok(None) };
    let part = |tag: &'static str| {
        place.child(&node, tag)?.ok_or_else(|| place.error(&node, &format!("a <{tag}>"), "none"))
    };
    let (mass, tensor) = (part("mass")?, part("inertia")?);
    let kg = place.required(&mass, "value")?;
    if kg < 0.0 {
        return Err(place.error(&mass, "a mass >= 0 kg", kg.to_string()).within_link(link));
    }
    let mut second = [0.0; 6];
    for (value, name) in second.iter_mut().zip(["ixx", "ixy", "iyy", "ixz", "iyz", "izz"]) {
        *value = place.required(&tensor, name)?;
    }
    super::build::check_second(&second).map_err(|found| {
        place.error(&tensor, "an inertia without negative principal value", found).within_link(link)
    })?;
    let pose = origin(place, &node)?;
    let centred = Inertia { mass: kg, first: [0.0; 3], second };
    Ok(Some(centred.placed(&pose.rotation, pose.position)))
}

trait WithinLink {
    fn within_link(self, link: &Node) -> Self;
}

impl WithinLink for hysteron_base::BadInput {
    /// Names the link of an element that has no name.
    fn within_link(mut self, link: &Node) -> Self {
        if let Some(name) = link.attribute("name") {
            self.place.push_str(&format!(" of link[{name}]"));
        }
        self
    }
}

/// `<origin xyz rpy>` of an element; the same frame where it has none.
fn origin(place: &Place, node: &Node) -> Check<Pose<f64>> {
    let Some(node) = place.child(node, "origin")? else { return Ok(Pose::IDENTITY) };
    let position = place.array(&node, "xyz")?.unwrap_or_default();
    let [roll, pitch, yaw] = place.array(&node, "rpy")?.unwrap_or_default();
    let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
    let rotation = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ];
    Ok(Pose { rotation, position })
}

fn joint(place: &Place, node: &Node, links: &BTreeMap<&str, usize>) -> Check<JointDescription> {
    let name = place.text(node, "name")?;
    let link = |tag: &'static str| {
        let end =
            place.child(node, tag)?.ok_or_else(|| place.error(node, &format!("a <{tag} link=…>"), "none"))?;
        let name = place.text(&end, "link")?;
        links
            .get(name)
            .copied()
            .ok_or_else(|| place.error(&end, "a link of this robot", format!("\"{name}\"")))
    };
    let (parent, child) = (link("parent")?, link("child")?);
    let (kind, turns) = match place.text(node, "type")? {
        "fixed" => (None, false),
        "revolute" => (Some(JointKind::Revolute), false),
        "continuous" => (Some(JointKind::Revolute), true),
        "prismatic" => (Some(JointKind::Prismatic), false),
        other => {
            return Err(place
                .error(node, "type fixed, revolute, continuous or prismatic", format!("\"{other}\""))
                .hint(
                    "model a floating or planar base as fixed, or as prismatic and revolute joints in a row",
                ));
        }
    };
    let mut drive = Drive::default();
    let mut mimic = None;
    let mut axis = [1.0, 0.0, 0.0];
    if kind.is_some() {
        axis = unit_axis(place, node)?;
        drive = limits(place, node, turns)?;
        if let Some(dynamics) = place.child(node, "dynamics")? {
            drive.damping = place.not_negative(&dynamics, "damping")?.unwrap_or(0.0);
            drive.dry_friction = place.not_negative(&dynamics, "friction")?.unwrap_or(0.0);
        }
        if let Some(node) = place.child(node, "mimic")? {
            let ratio = place.number(&node, "multiplier")?.unwrap_or(1.0);
            let offset = place.number(&node, "offset")?.unwrap_or(0.0);
            mimic = Some(Mimic { joint: place.text(&node, "joint")?.to_owned(), ratio, offset });
        }
    }
    let origin = origin(place, node)?;
    Ok(JointDescription {
        name: name.to_owned(),
        place: place.of(node),
        kind,
        parent,
        child,
        origin,
        axis,
        drive,
        mimic,
    })
}

fn unit_axis(place: &Place, node: &Node) -> Check<Vec3<f64>> {
    let Some(node) = place.child(node, "axis")? else { return Ok([1.0, 0.0, 0.0]) };
    let axis: Vec3<f64> = place.array(&node, "xyz")?.unwrap_or([1.0, 0.0, 0.0]);
    super::build::unit(axis)
        .ok_or_else(|| place.error(&node, "an axis longer than zero", format!("{axis:?}")))
}

fn limits(place: &Place, node: &Node, turns: bool) -> Check<Drive> {
    let Some(limit) = place.child(node, "limit")? else {
        return if turns {
            Ok(Drive::default())
        } else {
            Err(place
                .error(node, "a <limit> with lower, upper, effort and velocity", "none")
                .hint("a joint that turns for ever has type continuous"))
        };
    };
    let range = if turns {
        None
    } else {
        let end = |name| Ok(place.number(&limit, name)?.unwrap_or(0.0));
        let [lower, upper] = [end("lower")?, end("upper")?];
        if lower > upper {
            let found = format!("lower {lower}, upper {upper}");
            return Err(place.error(node, "lower <= upper", found));
        }
        Some([lower, upper])
    };
    Ok(Drive {
        range,
        speed_limit: place.not_negative(&limit, "velocity")?,
        effort_limit: place.not_negative(&limit, "effort")?,
        ..Drive::default()
    })
}

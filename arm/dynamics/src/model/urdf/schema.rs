//! Schema of URDF: what is read, what has no effect on the numbers that are computed, and what is done with
//! the rest.
//!
//! An element or attribute that is not in the table is named once as ignored; one that is spelled almost like something that
//! is read is an error, because it is a typing error.

use std::collections::BTreeSet;

use super::super::xml::{Check, Element};

/// An element that is read.
pub(super) struct UrdfEntry {
    pub tag: &'static str,
    /// Attributes that are read.
    pub attributes: &'static [&'static str],
    /// Attributes that change nothing that is computed.
    pub silent_attributes: &'static [&'static str],
    /// Elements within it that are read.
    pub children: &'static [UrdfEntry],
    /// Elements within it that change nothing that is computed, with all that they hold.
    pub silent_children: &'static [&'static str],
}

const fn leaf(tag: &'static str, attributes: &'static [&'static str]) -> UrdfEntry {
    UrdfEntry { tag, attributes, silent_attributes: &[], children: &[], silent_children: &[] }
}

const ORIGIN: UrdfEntry = leaf("origin", &["xyz", "rpy"]);

const LINK: UrdfEntry = UrdfEntry {
    tag: "link",
    attributes: &["name"],
    silent_attributes: &["type"],
    children: &[UrdfEntry {
        tag: "inertial",
        attributes: &[],
        silent_attributes: &[],
        children: &[
            ORIGIN,
            leaf("mass", &["value"]),
            leaf("inertia", &["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]),
        ],
        silent_children: &[],
    }],
    silent_children: &[
        "visual",
        "collision",
        "collision_checking",
        "contact",
        "self_filter",
        "sensor",
        "surface",
        "audio",
        "verbose",
    ],
};

const JOINT: UrdfEntry = UrdfEntry {
    tag: "joint",
    attributes: &["name", "type"],
    silent_attributes: &["dont_collapse"],
    children: &[
        ORIGIN,
        leaf("parent", &["link"]),
        leaf("child", &["link"]),
        leaf("axis", &["xyz"]),
        leaf("limit", &["lower", "upper", "effort", "velocity"]),
        leaf("dynamics", &["damping", "friction"]),
        leaf("mimic", &["joint", "multiplier", "offset"]),
    ],
    silent_children: &["calibration", "safety_controller", "hardwareInterface"],
};

/// The whole language.
pub(super) const ROBOT: UrdfEntry = UrdfEntry {
    tag: "robot",
    attributes: &["name"],
    silent_attributes: &["version", "schemaLocation"],
    children: &[LINK, JOINT],
    silent_children: &[
        "material",
        "gazebo",
        "transmission",
        "sensor",
        "ros2_control",
        "loop_joint",
        "kinematics_property",
        "verbose",
    ],
};

/// Elements of xacro without the prefix that xacro asks for; they would be ignored in silence.
const UNPREFIXED: [&str; 5] = ["include", "macro", "property", "if", "unless"];

/// Warnings of elements and attributes in none of the tables, one sentence for each kind.
///
/// # Errors
/// `BadInput` for what is spelled almost like something that is read.
pub(super) fn unknown(robot: &Element) -> Check<Vec<String>> {
    let mut unknown = UnknownParts { seen: BTreeSet::new(), sentences: Vec::new() };
    unknown.element(robot, &ROBOT)?;
    Ok(unknown.sentences)
}

struct UnknownParts {
    seen: BTreeSet<(&'static str, String)>,
    sentences: Vec<String>,
}

impl UnknownParts {
    fn element(&mut self, element: &Element, entry: &'static UrdfEntry) -> Check<()> {
        for (name, _) in element.attributes() {
            if entry.attributes.contains(&&**name) || entry.silent_attributes.contains(&&**name) {
                continue;
            }
            if let Some(meant) = entry.attributes.iter().find(|known| is_slip(name, known)) {
                return Err(misspelled(element, &format!("an attribute {meant}"), name));
            }
            self.ignored(element, entry.tag, &format!("attribute {name} of <{}>", entry.tag));
        }
        for child in &element.children {
            let tag = &*child.tag;
            if let Some(known) = entry.children.iter().find(|known| known.tag == tag) {
                self.element(child, known)?;
            } else if !entry.silent_children.contains(&tag) {
                if entry.tag == "robot" && UNPREFIXED.contains(&tag) {
                    return Err(child.error(&format!("<xacro:{tag}>"), format!("<{tag}>")).hint(
                        "elements of xacro have its prefix, which <robot xmlns:xacro=\"http://ros.org/wiki/xacro\"> declares",
                    ));
                }
                if let Some(meant) = entry.children.iter().find(|known| is_slip(tag, known.tag)) {
                    return Err(misspelled(child, &format!("<{}>", meant.tag), &format!("<{tag}>")));
                }
                self.ignored(child, entry.tag, &format!("<{tag}> within <{}>", entry.tag));
            }
        }
        Ok(())
    }

    fn ignored(&mut self, element: &Element, within: &'static str, what: &str) {
        if self.seen.len() < MAX_SENTENCES && self.seen.insert((within, what.to_owned())) {
            self.sentences
                .push(format!("{}: line {}: {what} is not in URDF: ignored", element.file, element.line));
        }
    }
}

/// Kinds of unknown things that are named.
const MAX_SENTENCES: usize = 20;

fn misspelled(element: &Element, meant: &str, found: &str) -> hysteron_base::BadInput {
    element.error(&format!("{meant}, or a name unlike any that is read"), format!("\"{found}\""))
}

/// True where `typed` is another word that differs from `known` by the size of its letters, or by one letter too many, too
/// few, wrong or exchanged with its neighbour, in words of at least four letters.
fn is_slip(typed: &str, known: &str) -> bool {
    let lower = typed.to_ascii_lowercase();
    if lower == known {
        return true;
    }
    let (a, b) = (lower.as_bytes(), known.as_bytes());
    if a.len().min(b.len()) < 4 || a.len().abs_diff(b.len()) > 1 {
        return false;
    }
    let same = a.iter().zip(b).take_while(|(x, y)| x == y).count();
    let (a, b) = (&a[same..], &b[same..]);
    match (a, b) {
        ([_, rest @ ..], _) if rest == b => true,
        (_, [_, rest @ ..]) if rest == a => true,
        ([x, y, rest @ ..], [u, v, others @ ..]) if x == v && y == u && rest == others => true,
        ([_, rest @ ..], [_, others @ ..]) => rest == others,
        _ => false,
    }
}

/// Table in Markdown of every element and attribute with its treatment by the reader.
pub(super) fn table() -> String {
    let mut rows = String::from("| element | attributes read | without effect |\n|---|---|---|\n");
    add_rows(&ROBOT, "", &mut rows);
    rows
}

fn add_rows(entry: &UrdfEntry, outer: &str, rows: &mut String) {
    let path = if outer.is_empty() { entry.tag.to_owned() } else { format!("{outer}/{}", entry.tag) };
    let read: Vec<String> = entry.attributes.iter().map(|name| format!("`{name}`")).collect();
    let silent = entry.silent_attributes.iter().map(|name| format!("`{name}`"));
    let silent: Vec<String> =
        silent.chain(entry.silent_children.iter().map(|tag| format!("`<{tag}>`"))).collect();
    rows.push_str(&format!("| `{path}` | {} | {} |\n", read.join(", "), silent.join(", ")));
    entry.children.iter().for_each(|child| add_rows(child, &path, rows));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typing_errors_are_distinguished_from_other_words() {
        for (typed, known) in [
            ("inertal", "inertial"),
            ("Mass", "mass"),
            ("orgin", "origin"),
            ("uper", "upper"),
            ("limti", "limit"),
        ] {
            assert!(is_slip(typed, known), "{typed}");
        }
        for (typed, known) in
            [("D", "damping"), ("current", "parent"), ("contact", "child"), ("link", "limit")]
        {
            assert!(!is_slip(typed, known), "{typed}");
        }
    }
}

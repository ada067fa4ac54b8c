//! The closed table of MJCF: every element and attribute of MuJoCo's schema, and what it is to this reader.
//!
//! Whatever is not in the table is an error that names the nearest entry, so that nothing in a file is dropped in silence.
//! A test compares the table with the schema that MuJoCo prints.
//!
//! # Reference
//! MuJoCo 4.0.0, `mj_printSchema` and XML reference.

mod actuators;
mod robot;
mod scene;
mod sensors;

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::LazyLock;

use super::super::xml::Check;
use super::element::{MjcfElement, brief};

/// Treatment of an element or attribute by the reader.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Use {
    /// It enters the robot.
    Read,
    /// It changes nothing that is computed, for this reason.
    Without(&'static str),
    /// It is accepted at this value alone: another one would change the robot, for this reason.
    Only(&'static str, &'static str),
    /// It would change the robot, for this reason.
    Refused(&'static str),
}

use Use::{Only, Read, Refused, Without};

/// An element of the schema.
#[derive(Debug)]
pub(super) struct MjcfEntry {
    /// Unique; what children name in `within`.
    pub id: &'static str,
    pub tag: &'static str,
    /// Its possible parent elements, separated by spaces.
    within: &'static str,
    pub role: Use,
    /// Names of attributes, separated by spaces, by what they are.
    attributes: &'static [(Use, &'static str)],
}

impl MjcfEntry {
    /// Names of its attributes, and what each is.
    pub fn attributes(&self) -> impl Iterator<Item = (&'static str, Use)> {
        self.attributes.iter().flat_map(|(what, names)| names.split_whitespace().map(|name| (name, *what)))
    }
}

/// Children by parent and tag, and attributes by element and name.
struct Index {
    children: BTreeMap<(&'static str, &'static str), &'static MjcfEntry>,
    attributes: BTreeMap<(&'static str, &'static str), Use>,
}

static INDEX: LazyLock<Index> = LazyLock::new(|| {
    let mut index = Index { children: BTreeMap::new(), attributes: BTreeMap::new() };
    for entry in entries() {
        index.children.extend(entry.within.split_whitespace().map(|parent| ((parent, entry.tag), entry)));
        index.attributes.extend(entry.attributes().map(|(name, what)| ((entry.id, name), what)));
    }
    index
});

fn entries() -> impl Iterator<Item = &'static MjcfEntry> {
    robot::ENTRIES.iter().chain(actuators::ENTRIES).chain(scene::ENTRIES).chain(sensors::ENTRIES)
}

/// The entry of the root.
pub(super) fn root() -> &'static MjcfEntry {
    &robot::ENTRIES[0]
}

/// The entry of an element called `tag` within one of `parent`.
pub(super) fn child(parent: &MjcfEntry, tag: &str) -> Option<&'static MjcfEntry> {
    INDEX.children.get(&(parent.id, tag)).copied()
}

/// Treatment of the attribute `name` of `entry`; `None` where it has none of that name.
pub(super) fn attribute(entry: &MjcfEntry, name: &str) -> Option<Use> {
    INDEX.attributes.get(&(entry.id, name)).copied()
}

/// Refuses everything within `element`, an element of `entry`, that is not in the table, and elements that are refused wherever they
/// stand.
///
/// # Errors
/// `BadInput` naming the element with its line, and the nearest name of the table or the reason.
pub(super) fn check(element: &MjcfElement, entry: &'static MjcfEntry) -> Check<()> {
    for (name, _) in element.attributes() {
        if attribute(entry, name).is_none() {
            let known = entry.attributes().map(|(name, _)| name);
            return Err(unknown(element, &format!("an attribute of <{}>", entry.tag), name, known));
        }
    }
    for inner in &element.children {
        let Some(found) = child(entry, &inner.tag) else {
            let known = INDEX.children.keys().filter(|(parent, _)| *parent == entry.id).map(|(_, tag)| *tag);
            return Err(unknown(inner, &format!("an element of <{}>", entry.tag), &inner.tag, known));
        };
        check(inner, found)?;
    }
    Ok(())
}

/// An error about `found` at `element`, with the nearest of the names that are known there.
fn unknown<'k>(
    element: &MjcfElement,
    expected: &str,
    found: &str,
    known: impl Iterator<Item = &'k str>,
) -> hysteron_base::BadInput {
    let error = element.error(&format!("{expected} of MJCF"), format!("\"{}\"", brief(found)));
    if let Some((_, reason)) = OUTDATED.iter().find(|(name, _)| *name == found) {
        return error.hint(*reason);
    }
    let nearest = known.map(|name| (distance(found, name), name)).min();
    match nearest {
        Some((far, name)) if far <= 1 + found.len() / 3 => error.hint(format!("did you mean \"{name}\"?")),
        Some(_) => error
            .hint("it is not in the schema of MuJoCo 4.0: remove it, or ask for the element it belongs to"),
        None => error.hint(format!("<{}> has nothing within it", element.tag)),
    }
}

/// Names of older versions of MuJoCo, and what came after them.
const OUTDATED: [(&str, &str); 4] = [
    (
        "composite",
        "MuJoCo has replaced <composite> by <replicate> and <flexcomp>: save the model with a newer version",
    ),
    ("exactmeshinertia", "MuJoCo has replaced it by the attribute inertia of <mesh>"),
    ("convexhull", "MuJoCo always makes convex hulls now: remove the attribute"),
    ("collision", "MuJoCo has removed it: contacts are chosen by contype and conaffinity"),
];

/// Characters to insert, delete or replace to get from `a` to `b` (Levenshtein).
fn distance(a: &str, b: &str) -> usize {
    // Names are short; what a file has in their place may not be.
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().take(64).collect(), b.chars().collect());
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

/// The table as Markdown: a row for each element and each kind of attribute.
pub(super) fn markdown() -> String {
    let mut out = String::from("| element | attributes | treatment |\n|---|---|---|\n");
    for entry in entries() {
        let path = entry.id;
        if entry.attributes.is_empty() || matches!(entry.role, Refused(_)) {
            let _ = writeln!(out, "| `{path}` | the element | {} |", treatment(entry.role));
        }
        for (what, names) in entry.attributes.iter().filter(|_| !matches!(entry.role, Refused(_))) {
            let names: Vec<&str> = names.split_whitespace().collect();
            let _ = writeln!(out, "| `{path}` | {} | {} |", names.join(", "), treatment(*what));
        }
    }
    out
}

fn treatment(what: Use) -> String {
    match what {
        Read => "read".to_owned(),
        Without(reason) => format!("without effect: {reason}"),
        Only(value, reason) => format!("`{value}` alone, else refused: {reason}"),
        Refused(reason) => format!("refused: {reason}"),
    }
}

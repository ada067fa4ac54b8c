//! An MSH file of any version, section by section.

use hysteron_base::BadInput;

use super::header::{self, Version};
use super::scan::{Scan, printable};
use super::sections::Sections;
use super::{blocks, entities, legacy};

/// Splits the bytes of a file into its sections.
///
/// # Errors
/// `BadInput` with the line (text) or byte (binary) that is wrong.
pub(super) fn parse(bytes: &[u8]) -> Result<Sections, BadInput> {
    let mut scan = Scan::new(bytes);
    let version = header::parse(&mut scan)?;
    let mut out =
        Sections { is_partitioned: matches!(version, Version::V1 | Version::V2), ..Sections::default() };
    let mut seen = FoundSections::default();
    loop {
        scan.skip_blank();
        if scan.at_end() {
            break;
        }
        parse_section(&mut scan, version, &mut seen, &mut out)?;
    }
    for (seen, section) in [(seen.nodes, "$Nodes"), (seen.elements, "$Elements")] {
        if !seen {
            return Err(scan
                .bad(format!("a section `{section}`"), "the end of the file")
                .hint("the file is cut short, or was saved before the mesh was made"));
        }
    }
    Ok(out)
}

/// The sections that a mesh needs, as far as they were found.
#[derive(Default)]
struct FoundSections {
    nodes: bool,
    elements: bool,
}

fn parse_section(
    scan: &mut Scan<'_>,
    version: Version,
    seen: &mut FoundSections,
    out: &mut Sections,
) -> Result<(), BadInput> {
    let at = scan.position();
    let line = scan.line().trim_ascii_end();
    let bad = |scan: &Scan<'_>, found: String| {
        BadInput::new(scan.place_of(at), "a section such as `$Nodes`", found)
    };
    let name = line.strip_prefix(b"$").and_then(|n| std::str::from_utf8(n).ok());
    let Some(name) = name.filter(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_alphanumeric())) else {
        return Err(bad(scan, format!("`{}`", printable(line))));
    };
    let is_block = matches!(version, Version::V40 | Version::V41);
    match name {
        "PhysicalNames" => entities::parse_names(scan, out)?,
        "Entities" if is_block => entities::parse_entities(scan, version, out)?,
        "PartitionedEntities" if is_block => entities::parse_partitioned(scan, version, out)?,
        "Nodes" | "NOD" | "ParametricNodes" => {
            if std::mem::replace(&mut seen.nodes, true) {
                return Err(bad(scan, format!("a second `${name}`")));
            }
            match name {
                "ParametricNodes" => legacy::parse_parametric_nodes(scan, out)?,
                _ if is_block => blocks::parse_nodes(scan, version, out)?,
                _ if version == Version::V1 => legacy::parse_nodes_1(scan, out)?,
                _ => legacy::parse_nodes(scan, out)?,
            }
        }
        "Elements" | "ELM" => {
            if !seen.nodes {
                return Err(bad(scan, format!("`${name}` before `$Nodes`")));
            }
            if std::mem::replace(&mut seen.elements, true) {
                return Err(bad(scan, format!("a second `${name}`")));
            }
            if is_block {
                blocks::parse_elements(scan, version, out)?;
            } else {
                legacy::parse_elements(scan, version, out)?;
            }
        }
        other => return scan.skip_behind(&format!("$End{other}")),
    }
    match name {
        "NOD" | "ELM" => scan.end_of(&format!("$END{name}")),
        _ => scan.end_of(&format!("$End{name}")),
    }
}

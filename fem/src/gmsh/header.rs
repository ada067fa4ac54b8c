//! The first lines of an MSH file: which version, text or binary.

use hysteron_base::BadInput;

use super::scan::{Binary, Scan, printable};

/// MSH version of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Version {
    /// MSH 1: `$NOD` and `$ELM`, text only.
    V1,
    /// MSH 2.0 to 2.2: one element a line, with tags.
    V2,
    /// MSH 4.0: blocks by entity, tags of four bytes.
    V40,
    /// MSH 4.1: blocks by entity, tags of the size in the header.
    V41,
}

const EXPECTED: &str = "MSH version 1, 2.2, 4.0 or 4.1";

/// Reads up to the first section of the mesh, `$MeshFormat` included; a byte-order mark and `$Comments` may stand
/// before it.
///
/// # Errors
/// `BadInput` for a file that is no mesh of Gmsh, or of a version that is not known.
pub(super) fn parse(scan: &mut Scan<'_>) -> Result<Version, BadInput> {
    scan.skip_byte_order_mark()?;
    loop {
        scan.skip_blank();
        if scan.at_end() {
            return Err(scan.bad("a Gmsh mesh", "an empty file"));
        }
        if scan.is_at("$NOD") {
            return Ok(Version::V1);
        }
        let start = scan.place();
        match scan.line().trim_ascii_end() {
            b"$MeshFormat" => return parse_format(scan),
            b"$Comments" => scan.skip_behind("$EndComments")?,
            other => {
                let found = format!("`{}`", printable(other));
                return Err(BadInput::new(start, "`$MeshFormat`", found)
                    .hint("this is not a Gmsh mesh; export the part as .msh version 4.1"));
            }
        }
    }
}

fn parse_format(scan: &mut Scan<'_>) -> Result<Version, BadInput> {
    let word = scan.word("a format version")?;
    let version = match word {
        "1" | "1.0" => Version::V1,
        "2" | "2.0" | "2.1" | "2.2" => Version::V2,
        "4" | "4.0" => Version::V40,
        "4.1" => Version::V41,
        other => {
            return Err(scan
                .bad(EXPECTED, format!("version {}", printable(other.as_bytes())))
                .hint("convert it: `gmsh old.msh -save -format msh41 -o new.msh`"));
        }
    };
    let kind = scan.word("0 (text) or 1 (binary)")?;
    if kind != "0" && kind != "1" {
        return Err(scan.bad("0 (text) or 1 (binary)", format!("`{}`", printable(kind.as_bytes()))));
    }
    let size = match scan.word("the size of a number in bytes, 4 or 8")? {
        "4" => 4,
        "8" => 8,
        other => {
            let found = format!("`{}`", printable(other.as_bytes()));
            return Err(scan.bad("the size of a number in bytes, 4 or 8", found));
        }
    };
    if kind == "1" {
        scan.line();
        let big_endian = scan.byte_order()?;
        // Version 2 gives the size of a coordinate, and its counts have four bytes.
        let size_bytes = match version {
            Version::V41 => size,
            Version::V40 => 8,
            Version::V1 | Version::V2 => 4,
        };
        if size == 4 && version != Version::V41 {
            return Err(scan
                .bad("coordinates of 8 bytes", "4")
                .hint("convert it: `gmsh old.msh -save -format msh41 -o new.msh`"));
        }
        scan.binary = Some(Binary { big_endian, size_bytes });
    }
    scan.end_of("$EndMeshFormat")?;
    Ok(version)
}

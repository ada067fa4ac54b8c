//! Provenance of a file: every result of this program names the program.

use std::path::Path;

use hysteron_base::{BadInput, Recording, file, json};

/// Bytes at the beginning of a file in which its maker is looked for.
const HEAD: usize = 1 << 16;
/// Largest file of JSON that is looked into for its maker [byte].
const MAX_JSON: u64 = 64 << 20;
/// Mark of this program in a picture in XML.
pub const SIGNATURE: &str = "<!-- generator: hysteron -->";
/// All marks of this program in pictures and pages.
const SIGNATURES: [&str; 3] =
    [SIGNATURE, "<meta name=\"generator\" content=\"hysteron\"/>", "Software\0hysteron"];
/// So begins a scene that was written, with the command behind it.
pub const MADE_BY: &str = "# made by: ";

/// Who made a file.
#[derive(Debug, PartialEq)]
pub enum Maker {
    /// This program, with this command.
    Command(String),
    /// This program.
    Program,
    /// Another program, or a person.
    Another,
}

/// Replaces a picture or a page of this program; another's is refused.
pub fn replace(path: &Path, bytes: impl AsRef<[u8]>) -> anyhow::Result<()> {
    if path.exists() && maker(path) == Maker::Another {
        let place = path.display().to_string();
        return Err(BadInput::new(place, "a new file, or one by hysteron", "another's")
            .hint("move it away, or choose another folder")
            .into());
    }
    Ok(file::write_bytes(path, bytes)?)
}

/// Provenance of a recording, a text, a picture or a page, where it has one.
pub fn maker(path: &Path) -> Maker {
    let by =
        |command: Option<String>| command.filter(|it| !it.is_empty()).map_or(Maker::Another, Maker::Command);
    if let Some("parquet" | "csv") = path.extension().and_then(|ending| ending.to_str()) {
        return by(Recording::read_metadata(path).ok().map(|meta| meta.command));
    }
    let Ok(head) = file::read_head(path, HEAD) else { return Maker::Another };
    if let Some(json) = json(path, &head) {
        let is_ours = json["format"].as_str().is_some_and(|format| format.starts_with("hysteron-"));
        let command = json["command"].as_str().map_or(Maker::Program, |it| Maker::Command(it.to_owned()));
        return if is_ours { command } else { Maker::Another };
    }
    let text = String::from_utf8_lossy(&head);
    if let Some(command) = text.strip_prefix(MADE_BY).and_then(|rest| rest.lines().next()) {
        return by(Some(command.to_owned()));
    }
    if SIGNATURES.iter().any(|signature| text.contains(signature)) { Maker::Program } else { Maker::Another }
}

/// The JSON that a file is, or begins with on a line of its own.
fn json(path: &Path, head: &[u8]) -> Option<serde_json::Value> {
    if head.first() != Some(&b'{') {
        return None;
    }
    let line = head.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let line = json::from_text(line).ok();
    line.or_else(|| json::from_text(&file::read_up_to(path, MAX_JSON).ok()?).ok())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    #[test]
    fn the_maker_of_a_file_stands_in_it() {
        let folder = tempfile::tempdir().unwrap();
        let maker = |name: &str, content: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, content).unwrap();
            maker(&path)
        };
        let by = |command: &str| Maker::Command(command.to_owned());
        let table = "time_s,tip_x_mm\n0,1\n";
        assert_eq!(maker("a.csv", table), Maker::Another);
        assert_eq!(maker("a.csv", &format!("# command: hysteron reach\n{table}")), by("hysteron reach"));
        assert_eq!(maker("a.json", "{\"command\": \"hysteron x\"}"), Maker::Another);
        let json = "{\n\"format\": \"hysteron-metrics\",\n\"command\": \"hysteron x\"\n}\n";
        assert_eq!(maker("a.json", json), by("hysteron x"));
        let state = "{\"format\":\"hysteron-state\",\"command\":\"hysteron simulate\"}\n\0\0";
        assert_eq!(maker("a.state", state), by("hysteron simulate"));
        assert_eq!(maker("a.svg", "<svg></svg>"), Maker::Another);
        assert_eq!(maker("a.svg", &format!("<svg>{}</svg>", SIGNATURES[0])), Maker::Program);
        assert_eq!(
            maker("a.toml", "# made by: hysteron fit-material a\nname"),
            by("hysteron fit-material a")
        );
    }
}

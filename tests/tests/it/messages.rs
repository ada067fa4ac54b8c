//! Messages for people show values, not the program's own structs.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use hysteron_tests::{members, root};

/// Crates whose messages only developers of the project read.
const INTERNAL: [&str; 3] = ["tests", "tests/fuzz", "bench"];
/// Numbers that share their name with a value of a struct.
const ALLOWED: [(&str, &str); 2] =
    [("core/base/src/scene/convert.rs", "point"), ("control/src/path/mod.rs", "size")];

/// Sources of a crate without tests, each with its path from the root.
fn sources(of: &str) -> Vec<(String, String)> {
    let mut left: Vec<PathBuf> = vec![root().join(of).join("src")];
    let mut found = Vec::new();
    while let Some(folder) = left.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_dir() && name != "tests" {
                left.push(path);
            } else if name.ends_with(".rs") && !name.ends_with("tests.rs") {
                let text = std::fs::read_to_string(&path).unwrap();
                let code = text.split("#[cfg(test)]").next().unwrap_or_default().to_owned();
                found.push((path.strip_prefix(root()).unwrap_or(Path::new("")).display().to_string(), code));
            }
        }
    }
    found
}

fn is_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

/// Structs and enums that the sources define.
fn types(code: &str) -> impl Iterator<Item = &str> {
    let words: Vec<&str> = code.split(|c| !is_word(c)).filter(|word| !word.is_empty()).collect();
    words
        .windows(2)
        .filter(|pair| ["struct", "enum"].contains(&pair[0]))
        .map(|pair| pair[1])
        .collect::<Vec<_>>()
        .into_iter()
}

/// Names of fields and arguments with the type of each, references, options and lists taken off.
fn declared(code: &str) -> Vec<(&str, &str)> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices(": ") {
        let name = code[..at].rsplit(|c| !is_word(c)).next().unwrap_or_default();
        let mut of = code[at + 2..].trim_start_matches(['&', '[']);
        for wrapper in ["'a ", "mut ", "Option<", "Vec<"] {
            of = of.strip_prefix(wrapper).unwrap_or(of).trim_start_matches('&');
        }
        let of = of.split(|c| !is_word(c)).next().unwrap_or_default();
        if !name.is_empty() && !of.is_empty() {
            found.push((name, of));
        }
    }
    found
}

/// Names that a line prints by `Debug`: names in `{name:?}`.
fn debugged(line: &str) -> Vec<&str> {
    let of = |end: usize| {
        line[..end].rsplit('{').next().filter(|name| !name.is_empty() && name.chars().all(is_word))
    };
    [":?}", ":#?}"].iter().flat_map(|end| line.match_indices(end)).filter_map(|(at, _)| of(at)).collect()
}

/// Places where a value of one of `own` types, or `self`, is printed with its fields.
fn dumps(sources: &[(String, String)], own: &BTreeSet<&str>) -> Vec<String> {
    let mut of_name: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (_, code) in sources {
        declared(code).into_iter().for_each(|(name, of)| {
            of_name.entry(name).or_default().insert(of);
        });
    }
    let is_own = |name: &str| name == "self" || of_name.get(name).is_some_and(|types| types.is_subset(own));
    let mut found = Vec::new();
    for (path, code) in sources {
        let lines = code.lines().map(str::trim);
        let messages = lines
            .filter(|line| !line.starts_with("//") && !line.contains("assert") && !line.contains("panic!"));
        for line in messages {
            let is_allowed = |name: &&str| !ALLOWED.contains(&(path.as_str(), *name));
            let names = debugged(line).into_iter().filter(|name| is_own(name)).filter(is_allowed);
            found.extend(names.map(|name| format!("{path}: {name} in `{line}`")));
        }
    }
    found
}

#[test]
fn no_message_shows_the_inside_of_a_struct() {
    let crates = members().into_iter().filter(|name| !INTERNAL.contains(&name.as_str()));
    let all: Vec<Vec<(String, String)>> = crates.map(|name| sources(&name)).collect();
    let own: BTreeSet<&str> = all.iter().flatten().flat_map(|(_, code)| types(code)).collect();
    let found: Vec<String> = all.iter().flat_map(|sources| dumps(sources, &own)).collect();
    assert!(found.is_empty(), "name the value that is wrong instead:\n{}", found.join("\n"));
}

#[test]
fn a_dump_is_found() {
    let code =
        "struct Spec { width: f64 }\nfn f(spec: &Spec, text: &str) { g(format!(\"{spec:?} {text:?}\")) }";
    let sources = [("x.rs".to_owned(), code.to_owned())];
    let own = types(code).collect();
    assert_eq!(dumps(&sources, &own).len(), 1);
    let own_name = [("x.rs".to_owned(), "format!(\"{self:?}\")".to_owned())];
    assert_eq!(dumps(&own_name, &BTreeSet::new()).len(), 1);
}

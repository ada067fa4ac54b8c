//! Words, lines and names of Python sources.

/// First lines of every generated file.
pub const HEAD: &str =
    "# Made by `cargo run --release -p hysteron-python --example generate_sources`; do not edit.\n";

/// Longest line of documentation.
const WIDTH: usize = 110;

/// Words of Python, which are no names.
const KEYWORDS: [&str; 32] = [
    "and", "as", "assert", "async", "await", "break", "class", "continue", "def", "del", "elif", "else",
    "except", "finally", "for", "from", "global", "if", "import", "in", "is", "lambda", "nonlocal", "not",
    "or", "pass", "raise", "return", "try", "while", "with", "yield",
];

/// A name of the program as one of Python: `fit-material` is `fit_material`, `import` is `import_`, `100` is `key_100`.
pub fn identifier(name: &str) -> String {
    let words = name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let name = words.collect::<Vec<_>>().join("_").to_lowercase();
    if name.starts_with(|c: char| c.is_ascii_digit()) {
        return format!("key_{name}");
    }
    if KEYWORDS.contains(&name.as_str()) { name + "_" } else { name }
}

/// A name in words as that of a class: `arm identify inertia` is `ArmIdentifyInertia`.
pub fn class_name(words: &str) -> String {
    let words = words.split([' ', '-', '_']);
    words
        .map(|word| {
            let (first, rest) = word.split_at(word.len().min(1));
            first.to_uppercase() + rest
        })
        .collect()
}

/// A text between quotes.
pub fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// Lines of a text, wrapped and indented; words that are not the first begin `hanging` further to the right.
pub fn wrapped(text: &str, indent: usize, hanging: usize) -> String {
    let escaped = text.replace('\\', "\\\\").replace("\"\"\"", "'''");
    let (mut out, mut line) = (String::new(), " ".repeat(indent));
    let mut is_empty = true;
    for word in escaped.split_whitespace() {
        if !is_empty && line.chars().count() + 1 + word.chars().count() > WIDTH {
            out.push_str(&line);
            out.push('\n');
            line = " ".repeat(indent + hanging);
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
        }
        line.push_str(word);
        is_empty = false;
    }
    out + &line + "\n"
}

/// The paragraphs of a text, wrapped and indented, with empty lines between.
pub fn paragraphs(text: &str, indent: usize) -> String {
    let all = text.split("\n\n").filter(|part| !part.trim().is_empty());
    all.map(|part| wrapped(part, indent, 0)).collect::<Vec<_>>().join("\n")
}

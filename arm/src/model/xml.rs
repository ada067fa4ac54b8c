//! XML with errors that name the line; the only module that knows roxmltree.

use std::path::Path;

use hysteron_base::BadInput;
pub(super) use roxmltree::Node;
use roxmltree::{Document, ParsingOptions};

pub(super) type Check<T> = Result<T, BadInput>;

/// The largest file that is opened: robots are kilobytes.
const MOST_BYTES: usize = 16 << 20;
/// Elements, texts and comments of a file.
const MOST_NODES: u32 = 200_000;
/// Elements within elements: the parser recurses.
const MOST_NESTED: usize = 256;

/// Parses `text`, the content of a file called `name`.
///
/// # Errors
/// `BadInput` naming line and column where the text is no XML, or has more bytes, nodes or levels than a robot.
pub(super) fn parse<'t>(text: &'t str, name: &str) -> Check<Document<'t>> {
    if text.len() > MOST_BYTES {
        let found = format!("{} MB", text.len() >> 20);
        return Err(BadInput::new(name, format!("a robot file of at most {} MB", MOST_BYTES >> 20), found));
    }
    if deepest(text) > MOST_NESTED {
        let expected = format!("at most {MOST_NESTED} elements within each other");
        return Err(BadInput::new(name, expected, format!("{}", deepest(text))));
    }
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|error| {
        let at = error.pos();
        BadInput::new(format!("{name}: line {}, column {}", at.row, at.col), "XML", brief(&error.to_string()))
            .hint("a robot is described by URDF or MJCF, which are XML files")
    })
}

/// True where the first element of `text` is called `tag`.
pub(super) fn root_is(text: &str, tag: &str) -> bool {
    let mut rest = text.trim_start_matches('\u{feff}').trim_start();
    while let Some(after) = rest.strip_prefix("<?").or_else(|| rest.strip_prefix("<!--")) {
        let end = if rest.starts_with("<?") { "?>" } else { "-->" };
        let Some((_, next)) = after.split_once(end) else { return false };
        rest = next.trim_start();
    }
    rest.strip_prefix('<')
        .and_then(|rest| rest.strip_prefix(tag))
        .is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
}

/// An upper bound of the levels of elements in `text`, valid whatever it is.
fn deepest(text: &str) -> usize {
    let (mut depth, mut most, bytes) = (0_usize, 0, text.as_bytes());
    for (i, pair) in bytes.windows(2).enumerate() {
        match pair {
            b"</" => depth = depth.saturating_sub(1),
            b"/>" => depth = depth.saturating_sub(usize::from(i > 0)),
            [b'<', c] if c.is_ascii_alphabetic() || *c == b'_' || !c.is_ascii() => depth += 1,
            _ => {}
        }
        most = most.max(depth);
    }
    most
}

/// At most 80 characters of what an error says.
fn brief(text: &str) -> String {
    let mut kept: String = text.chars().take(80).collect();
    if kept.len() < text.len() {
        kept.push('…');
    }
    kept
}

/// Where an element stands: file, line, and its name attribute.
pub(super) struct Place<'f> {
    pub file: &'f str,
}

impl Place<'_> {
    /// `file: line 12: joint[elbow]`.
    pub fn of(&self, node: &Node) -> String {
        let line = node.document().text_pos_at(node.range().start).row;
        let tag = node.tag_name().name();
        match node.attribute("name") {
            Some(name) => format!("{}: line {line}: {tag}[{}]", self.file, brief(name)),
            None => format!("{}: line {line}: {tag}", self.file),
        }
    }

    /// An error about this element.
    pub fn error(&self, node: &Node, expected: &str, found: impl Into<String>) -> BadInput {
        BadInput::new(self.of(node), expected, found)
    }

    /// Child elements called `tag`.
    pub fn children<'a, 'i>(
        &self,
        node: &Node<'a, 'i>,
        tag: &'static str,
    ) -> impl Iterator<Item = Node<'a, 'i>> + use<'a, 'i> {
        node.children().filter(move |child| child.is_element() && child.tag_name().name() == tag)
    }

    /// The only child element called `tag`, if there is one.
    pub fn child<'a, 'i>(&self, node: &Node<'a, 'i>, tag: &'static str) -> Check<Option<Node<'a, 'i>>> {
        let mut all = self.children(node, tag);
        let first = all.next();
        match all.next() {
            Some(second) => {
                let line = second.document().text_pos_at(second.range().start).row;
                let found = format!("a second one in line {line}");
                let hint = format!(
                    "delete one: readers that take the first <{tag}> and readers that take the last do not agree"
                );
                Err(self.error(node, &format!("one <{tag}>"), found).hint(hint))
            }
            None => Ok(first),
        }
    }

    /// The text of an attribute that must be there.
    pub fn text<'a>(&self, node: &Node<'a, '_>, name: &str) -> Check<&'a str> {
        match node.attribute(name) {
            Some(text) if !text.trim().is_empty() => Ok(text),
            Some(_) => {
                Err(self.error(node, &format!("an attribute {name} that says something"), "an empty one"))
            }
            None => Err(self.error(node, &format!("an attribute {name}"), "none")),
        }
    }

    /// Finite numbers of an attribute, where it is there.
    pub fn numbers(&self, node: &Node, name: &str) -> Check<Option<Vec<f64>>> {
        let Some(text) = node.attribute(name) else { return Ok(None) };
        let number = |word: &str| word.parse::<f64>().ok().filter(|x| x.is_finite());
        let numbers: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
        numbers.map(Some).ok_or_else(|| self.error(node, &format!("finite numbers in {name}"), brief(text)))
    }

    /// Exactly N finite numbers of an attribute, where it is there.
    pub fn array<const N: usize>(&self, node: &Node, name: &str) -> Check<Option<[f64; N]>> {
        let Some(numbers) = self.numbers(node, name)? else { return Ok(None) };
        let n = numbers.len();
        match <[f64; N]>::try_from(numbers) {
            Ok(array) => Ok(Some(array)),
            Err(_) => Err(self.error(node, &format!("{N} numbers in {name}"), format!("{n}"))),
        }
    }

    /// One finite number, where it is there.
    pub fn number(&self, node: &Node, name: &str) -> Check<Option<f64>> {
        Ok(self.array::<1>(node, name)?.map(|[x]| x))
    }

    /// One finite number that must be there.
    pub fn required(&self, node: &Node, name: &str) -> Check<f64> {
        self.number(node, name)?.ok_or_else(|| self.error(node, &format!("an attribute {name}"), "none"))
    }

    /// One finite number ≥ 0, where it is there.
    pub fn not_negative(&self, node: &Node, name: &str) -> Check<Option<f64>> {
        match self.number(node, name)? {
            Some(x) if x < 0.0 => Err(self.error(node, &format!("{name} >= 0"), x.to_string())),
            other => Ok(other),
        }
    }
}

/// The last part of a path, to stand in errors.
pub(super) fn file_name(path: &Path) -> String {
    path.display().to_string()
}

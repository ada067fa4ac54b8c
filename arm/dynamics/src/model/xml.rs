//! XML with errors that name the line; the only module that knows roxmltree.

use std::path::Path;
use std::rc::Rc;

use hysteron_base::BadInput;
pub(super) use roxmltree::Node;
use roxmltree::{Document, ParsingOptions};

pub(super) type Check<T> = Result<T, BadInput>;

/// The largest file that is opened: robots are kilobytes.
const MAX_BYTES: usize = 16 << 20;
/// Elements, texts and comments of a file.
const MAX_NODES: u32 = 200_000;
/// Elements within elements: the parser recurses.
const MAX_NESTED: usize = 256;
/// Attributes of one element: the parser compares each with all others.
const MAX_ATTRIBUTES: usize = 128;
/// Namespaces that a file declares: the parser compares each with all others.
const MAX_NAMESPACES: usize = 64;

/// Parses `text`, the content of a file called `name`.
///
/// # Errors
/// `BadInput` naming line and column where the text is no XML, or has more bytes, nodes or levels than a robot.
pub(super) fn parse<'t>(text: &'t str, name: &str) -> Check<Document<'t>> {
    if text.len() > MAX_BYTES {
        let found = format!("{} MB", text.len() >> 20);
        return Err(BadInput::new(name, format!("a robot file of at most {} MB", MAX_BYTES >> 20), found));
    }
    if deepest(text) > MAX_NESTED {
        let expected = format!("at most {MAX_NESTED} elements within each other");
        return Err(BadInput::new(name, expected, format!("{}", deepest(text))));
    }
    check_attributes(text).map_err(|bad| bad.within(name))?;
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MAX_NODES, ..ParsingOptions::default() };
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

/// An upper bound of the levels of elements in `text`, for any text.
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

/// Refuses elements with more attributes than a robot has, before the parser compares all of them.
fn check_attributes(text: &str) -> Check<()> {
    let bytes = text.as_bytes();
    let (mut at, mut n_namespaces) = (0, 0);
    while let Some(from) = memchr(bytes, b'<', at) {
        let rest = &bytes[from..];
        at = match rest {
            [b'<', b'!', b'-', b'-', ..] => after(text, from, "-->"),
            [b'<', b'!', b'[', ..] => after(text, from, "]]>"),
            [b'<', b'?' | b'!' | b'/', ..] => from + 2,
            _ => {
                let (end, n, declared) = tag_end(text, from);
                n_namespaces += declared;
                let [n_most, found] = match (n > MAX_ATTRIBUTES, n_namespaces > MAX_NAMESPACES) {
                    (true, _) => [MAX_ATTRIBUTES, n],
                    (_, true) => [MAX_NAMESPACES, n_namespaces],
                    _ => {
                        at = end;
                        continue;
                    }
                };
                let what = if n > MAX_ATTRIBUTES { "attributes of an element" } else { "namespaces" };
                let line = 1 + bytes[..from].iter().filter(|byte| **byte == b'\n').count();
                return Err(BadInput::new(
                    format!("line {line}"),
                    format!("at most {n_most} {what}"),
                    found.to_string(),
                ));
            }
        };
    }
    Ok(())
}

fn memchr(bytes: &[u8], byte: u8, from: usize) -> Option<usize> {
    bytes.get(from..)?.iter().position(|other| *other == byte).map(|at| from + at)
}

/// Where `end` ends that follows `from`, or the end of the text.
fn after(text: &str, from: usize, end: &str) -> usize {
    text[from..].find(end).map_or(text.len(), |at| from + at + end.len())
}

/// End of the tag that begins at `from`, its attributes, and how many of these declare a namespace.
fn tag_end(text: &str, from: usize) -> (usize, usize, usize) {
    let bytes = text.as_bytes();
    let (mut quote, mut n, mut n_namespaces, mut name) = (None, 0, 0, from);
    for (at, byte) in bytes.iter().enumerate().skip(from + 1) {
        match (quote, byte) {
            (Some(open), _) if open == byte => quote = None,
            (Some(_), _) => {}
            (None, b'"' | b'\'') => quote = Some(byte),
            (None, b'=') => {
                n += 1;
                n_namespaces += usize::from(bytes[name..at].starts_with(b"xmlns"));
            }
            (None, b'>') => return (at + 1, n, n_namespaces),
            (None, byte) if byte.is_ascii_whitespace() => name = at + 1,
            _ => {}
        }
    }
    (text.len(), n, n_namespaces)
}

/// At most 80 characters of an error message.
pub(super) fn brief(text: &str) -> String {
    let mut kept: String = text.chars().take(80).collect();
    if kept.len() < text.len() {
        kept.push('…');
    }
    kept
}

/// An element with its place; the macros of xacro make such elements too.
#[derive(Debug, Clone)]
pub(super) struct Element {
    /// Its name; `xacro:` is the prefix of that of the elements of xacro, with any name of their namespace in the file.
    pub tag: Rc<str>,
    attributes: Vec<(Rc<str>, Rc<str>)>,
    pub children: Vec<Element>,
    pub file: Rc<str>,
    pub line: u32,
}

/// Starts of the lines of a text.
struct Lines(Vec<usize>);

impl Lines {
    fn of(text: &str) -> Self {
        Self(text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at + 1).collect())
    }

    /// Line of a byte, from 1.
    fn at(&self, byte: usize) -> u32 {
        let before = self.0.partition_point(|start| *start <= byte);
        u32::try_from(before + 1).unwrap_or(u32::MAX)
    }
}

/// The elements of `text`, the content of a file called `name`.
///
/// # Errors
/// As [`parse`].
pub(super) fn elements(text: &str, name: &str) -> Check<Element> {
    let document = parse(text, name)?;
    let (lines, file) = (Lines::of(text), Rc::from(name));
    Ok(Element::of(&document.root_element(), &lines, &file))
}

impl Element {
    /// At most [`MAX_NESTED`] levels.
    fn of(node: &Node, lines: &Lines, file: &Rc<str>) -> Self {
        let name = node.tag_name();
        let is_xacro = name.namespace().is_some_and(|uri| uri.contains("xacro"));
        let tag = if is_xacro { format!("xacro:{}", name.name()).into() } else { Rc::from(name.name()) };
        let attributes = node.attributes().map(|own| (Rc::from(own.name()), Rc::from(own.value())));
        Self {
            tag,
            attributes: attributes.collect(),
            children: node
                .children()
                .filter(Node::is_element)
                .map(|child| Self::of(&child, lines, file))
                .collect(),
            file: file.clone(),
            line: lines.at(node.range().start),
        }
    }

    /// The same element with these attributes and children.
    pub fn with(&self, attributes: Vec<(Rc<str>, Rc<str>)>, children: Vec<Element>) -> Self {
        Self { tag: self.tag.clone(), attributes, children, file: self.file.clone(), line: self.line }
    }

    /// Its elements in their order, then theirs.
    pub fn descendants(&self) -> impl Iterator<Item = &Element> {
        let mut waiting = vec![self];
        std::iter::from_fn(move || {
            let next = waiting.pop()?;
            waiting.extend(next.children.iter().rev());
            Some(next)
        })
    }

    /// Names and texts of its attributes.
    pub fn attributes(&self) -> impl Iterator<Item = (&Rc<str>, &Rc<str>)> {
        self.attributes.iter().map(|(name, text)| (name, text))
    }

    /// The text of an attribute.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(known, _)| **known == *name).map(|(_, text)| &**text)
    }

    /// `file: line 12: joint[elbow]`.
    pub fn place(&self) -> String {
        let Self { file, line, tag, .. } = self;
        match self.attribute("name") {
            Some(name) => format!("{file}: line {line}: {tag}[{}]", brief(name)),
            None => format!("{file}: line {line}: {tag}"),
        }
    }

    /// An error about this element.
    pub fn error(&self, expected: &str, found: impl Into<String>) -> BadInput {
        BadInput::new(self.place(), expected, found)
    }

    /// Child elements called `tag`.
    pub fn children_of(&self, tag: &'static str) -> impl Iterator<Item = &Element> {
        self.children.iter().filter(move |child| *child.tag == *tag)
    }

    /// The only child element called `tag`, if there is one.
    pub fn child(&self, tag: &'static str) -> Check<Option<&Element>> {
        let mut all = self.children_of(tag);
        let first = all.next();
        match all.next() {
            Some(second) => {
                let found = format!("a second one in line {}", second.line);
                let hint = format!(
                    "delete one: readers that take the first <{tag}> and readers that take the last do not agree"
                );
                Err(self.error(&format!("one <{tag}>"), found).hint(hint))
            }
            None => Ok(first),
        }
    }

    /// The text of an attribute that must be there.
    pub fn text(&self, name: &str) -> Check<&str> {
        match self.attribute(name) {
            Some(text) if !text.trim().is_empty() => Ok(text),
            Some(_) => Err(self.error(&format!("an attribute {name} with a value"), "an empty one")),
            None => Err(self.error(&format!("an attribute {name}"), "none")),
        }
    }

    /// Exactly N finite numbers of an attribute, where it is there.
    pub fn array<const N: usize>(&self, name: &str) -> Check<Option<[f64; N]>> {
        let Some(text) = self.attribute(name) else { return Ok(None) };
        let number = |word: &str| word.parse::<f64>().ok().filter(|x| x.is_finite());
        let numbers: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
        let numbers = numbers.ok_or_else(|| self.error(&format!("finite numbers in {name}"), brief(text)))?;
        let n = numbers.len();
        <[f64; N]>::try_from(numbers)
            .map(Some)
            .map_err(|_| self.error(&format!("{N} numbers in {name}"), n.to_string()))
    }

    /// One finite number, where it is there.
    pub fn number(&self, name: &str) -> Check<Option<f64>> {
        Ok(self.array::<1>(name)?.map(|[x]| x))
    }

    /// One finite number that must be there.
    pub fn required(&self, name: &str) -> Check<f64> {
        self.number(name)?.ok_or_else(|| self.error(&format!("an attribute {name}"), "none"))
    }

    /// One finite number ≥ 0, where it is there.
    pub fn not_negative(&self, name: &str) -> Check<Option<f64>> {
        match self.number(name)? {
            Some(x) if x < 0.0 => Err(self.error(&format!("{name} >= 0"), x.to_string())),
            other => Ok(other),
        }
    }
}

/// The last part of a path, for errors.
pub(super) fn file_name(path: &Path) -> String {
    path.display().to_string()
}

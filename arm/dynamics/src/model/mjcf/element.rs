//! Elements of MJCF with their file and line: read once, files that are included put in their places.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use hysteron_base::BadInput;

use super::super::xml::{Check, Node, parse};

/// All files of one robot together.
const MAX_BYTES: u64 = 16 << 20;
/// Elements of all files of one robot together.
const MAX_ELEMENTS: usize = 200_000;
/// Elements within elements, over all files.
const MAX_NESTED: usize = 256;
/// Files within files.
const MAX_INCLUDED: usize = 32;

/// An element of the assembled document.
#[derive(Debug)]
pub(super) struct MjcfElement {
    pub tag: Box<str>,
    attributes: Vec<(Box<str>, Box<str>)>,
    pub children: Vec<MjcfElement>,
    file: Rc<str>,
    line: u32,
}

impl MjcfElement {
    /// Text of an attribute of its own.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(known, _)| **known == *name).map(|(_, text)| &**text)
    }

    /// Names and texts of its attributes, in the order of the file.
    pub fn attributes(&self) -> impl Iterator<Item = (&str, &str)> {
        self.attributes.iter().map(|(name, text)| (&**name, &**text))
    }

    /// Child elements called `tag`.
    pub fn children_of<'a>(&'a self, tag: &'static str) -> impl Iterator<Item = &'a MjcfElement> {
        self.children.iter().filter(move |child| *child.tag == *tag)
    }

    /// Its file.
    pub fn file(&self) -> &str {
        &self.file
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
}

/// At most 80 characters of what an error quotes.
pub(super) fn brief(text: &str) -> String {
    let mut kept: String = text.chars().take(80).collect();
    if kept.len() < text.len() {
        kept.push('…');
    }
    kept
}

/// Reads the files of one robot.
#[derive(Debug)]
pub(super) struct Files {
    /// Folder of the first file; `None` for a text that comes from no file.
    folder: Option<PathBuf>,
    read: BTreeSet<PathBuf>,
    bytes_left: u64,
    elements_left: usize,
}

/// Document being read: a file, where its lines end, its folder, and how many files enclose it.
struct MjcfSource<'t> {
    file: Rc<str>,
    line_ends: &'t [usize],
    folder: Option<&'t Path>,
    included: usize,
}

impl Files {
    /// Those of a robot whose first file is in `folder`.
    pub fn new(folder: Option<&Path>) -> Self {
        let folder = folder.map(Path::to_owned);
        Self { folder, read: BTreeSet::new(), bytes_left: MAX_BYTES, elements_left: MAX_ELEMENTS }
    }

    /// The root of `text`, the content of a file called `name`, with all that it includes.
    ///
    /// # Errors
    /// `BadInput` naming file and line for text that is no XML, a file that cannot be read or is included twice, or more bytes,
    /// elements or levels than a robot has.
    pub fn assemble(&mut self, text: &str, name: &str) -> Check<MjcfElement> {
        let folder = self.folder.clone();
        self.text(text, name, folder.as_deref(), 0, 0)
    }

    /// Root and folder of the file `name` that `element`, which is in `folder`, asks for, with all that it includes.
    pub fn open(
        &mut self,
        element: &MjcfElement,
        folder: Option<&Path>,
        name: &str,
    ) -> Check<(MjcfElement, PathBuf)> {
        let (path, text) = self.find(element, name, folder)?;
        let folder = path.parent().map(Path::to_owned).unwrap_or_default();
        // What it includes is relative to itself, and may be what another document has.
        let before = self.folder.replace(folder.clone());
        let read = std::mem::take(&mut self.read);
        let root = self.text(&text, &path.display().to_string(), Some(&folder), 1, 0);
        (self.folder, self.read) = (before, read);
        Ok((root?, folder))
    }

    fn text(
        &mut self,
        text: &str,
        name: &str,
        folder: Option<&Path>,
        included: usize,
        depth: usize,
    ) -> Check<MjcfElement> {
        let document = parse(text, name)?;
        let line_ends: Vec<usize> =
            text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(k, _)| k).collect();
        let source = MjcfSource { file: Rc::from(name), line_ends: &line_ends, folder, included };
        self.element(&document.root_element(), &source, depth)
    }

    fn element(&mut self, node: &Node, source: &MjcfSource, depth: usize) -> Check<MjcfElement> {
        let line = source.line_ends.partition_point(|end| *end < node.range().start) + 1;
        let mut element = MjcfElement {
            tag: node.tag_name().name().into(),
            attributes: node
                .attributes()
                .filter(|attribute| attribute.namespace().is_none())
                .map(|attribute| (attribute.name().into(), attribute.value().into()))
                .collect(),
            children: Vec::new(),
            file: source.file.clone(),
            line: u32::try_from(line).unwrap_or(u32::MAX),
        };
        self.elements_left = self.elements_left.checked_sub(1).ok_or_else(|| {
            element.error(&format!("at most {MAX_ELEMENTS} elements in all files of a robot"), "more")
        })?;
        if depth > MAX_NESTED {
            return Err(element.error(&format!("at most {MAX_NESTED} elements within each other"), "more"));
        }
        for node in node.children().filter(Node::is_element) {
            let child = self.element(&node, source, depth + 1)?;
            if *child.tag == *"include" {
                element.children.extend(self.include(&child, source, depth)?.children);
            } else {
                element.children.push(child);
            }
        }
        Ok(element)
    }

    /// The root of the file that `element` includes.
    fn include(&mut self, element: &MjcfElement, source: &MjcfSource, depth: usize) -> Check<MjcfElement> {
        let name = match element.attribute("file") {
            Some(name) if !name.trim().is_empty() => name,
            _ => return Err(element.error("an attribute file", "none")),
        };
        if let Some((other, _)) = element.attributes().find(|(name, _)| *name != "file") {
            return Err(element.error("file, the only attribute of <include>", format!("\"{other}\"")));
        }
        if source.included >= MAX_INCLUDED {
            return Err(element.error(&format!("at most {MAX_INCLUDED} files within each other"), "more"));
        }
        let (path, text) = self.find(element, name, source.folder)?;
        let once = std::fs::canonicalize(&path).unwrap_or_else(|_| path.clone());
        if !self.read.insert(once) {
            return Err(element
                .error("a file that is included once", format!("\"{}\" again", brief(name)))
                .hint("a model that is needed twice is an asset <model>, put in place by <attach>"));
        }
        self.text(&text, &path.display().to_string(), path.parent(), source.included + 1, depth)
    }

    /// Path and text of the file `name`, relative to the first file or to the one that names it.
    fn find(&mut self, element: &MjcfElement, name: &str, folder: Option<&Path>) -> Check<(PathBuf, String)> {
        let Some(first) = &self.folder else {
            return Err(element
                .error("a robot in one text", format!("another file, \"{}\"", brief(name)))
                .hint("give the robot as a file, so that the others are found next to it"));
        };
        let paths = [first.join(name), folder.unwrap_or(first).join(name)];
        let path = paths.iter().find(|path| path.is_file()).ok_or_else(|| {
            let expected = format!("a file relative to {}", shown(first));
            element.error(&expected, format!("\"{}\", which is not there", brief(name)))
        })?;
        let text = read_at_most(path, self.bytes_left)
            .map_err(|error| element.error(&format!("{} as text", path.display()), error.to_string()))?;
        self.bytes_left = self.bytes_left.checked_sub(text.len() as u64).ok_or_else(|| {
            element.error(&format!("at most {} MB in all files of a robot", MAX_BYTES >> 20), "more")
        })?;
        Ok((path.clone(), text))
    }
}

fn shown(folder: &Path) -> String {
    if folder.as_os_str().is_empty() { "this folder".to_owned() } else { folder.display().to_string() }
}

/// Text of a file, read up to one byte past `most`.
fn read_at_most(path: &Path, most: u64) -> std::io::Result<String> {
    let mut text = String::new();
    File::open(path)?.take(most + 1).read_to_string(&mut text)?;
    Ok(text)
}

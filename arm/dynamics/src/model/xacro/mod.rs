//! xacro: URDF with properties, expressions, macros, conditions and files within files.
//!
//! Everything that the elements of a robot depend on is evaluated as xacro does, or refused by its name and line; what only
//! draws or drives a robot stays as it is typed where it cannot be. Work, text and depth are bounded.
//!
//! # Reference
//! xacro 2.1.1 (github.com/ros/xacro), whose results the tests compare.

mod expression;
mod lexer;
mod operations;
mod scopes;
mod value;

use std::collections::BTreeSet;
use std::path::Path;
use std::rc::Rc;

use hysteron_base::{BadInput, file};

use super::Arguments;
use super::xml::{Check, Element, elements};
use scopes::{Macro, MacroParameter, Property, Scopes, Strictness};
use value::Value;

/// Bytes that are evaluated, elements and scopes included.
const MAX_WORK: usize = 32 << 20;
/// Elements of the robot that results.
const MAX_ELEMENTS: usize = 200_000;
/// Macros, conditions, files and elements within each other.
const MAX_NESTED: usize = 200;
/// Largest file that is included [bytes].
const MAX_FILE: u64 = 16 << 20;
/// Elements whose content changes nothing that is computed.
const SILENT: [&str; 7] =
    ["visual", "collision", "gazebo", "transmission", "ros2_control", "material", "sensor"];

/// The robot with everything of xacro evaluated; itself where there is nothing.
///
/// # Errors
/// `BadInput` naming the first thing that cannot be expanded and its line.
pub(super) fn expanded(robot: Element, folder: Option<&Path>, arguments: &Arguments) -> Check<Element> {
    let is_xacro = robot.descendants().any(|element| {
        element.tag.starts_with("xacro:")
            || element.attributes().any(|(_, text)| text.contains("${") || text.contains("$("))
    });
    if !is_xacro {
        return match arguments.keys().next() {
            Some(name) => {
                Err(BadInput::new(format!("--arg {name}"), "a file of xacro that declares it", "none"))
            }
            None => Ok(robot),
        };
    }
    let mut expander = Expander {
        scopes: Scopes::new(arguments, MAX_WORK),
        depth: 0,
        n_elements: 0,
        declared: BTreeSet::new(),
        strictness: Strictness::Strict,
    };
    expander.scopes.folder = folder.map(folder_name);
    let attributes = expander.attributes(&robot)?;
    let children = expander.children(&robot)?;
    if let Some(name) = expander.scopes.undeclared(&expander.declared) {
        let declared: Vec<&str> = expander.declared.iter().map(String::as_str).collect();
        let expected = match declared.is_empty() {
            true => "no arguments, because the file declares none".to_owned(),
            false => format!("one of {}", declared.join(", ")),
        };
        return Err(BadInput::new("--arg", expected, format!("\"{name}\"")));
    }
    Ok(robot.with(attributes, children))
}

fn folder_name(folder: &Path) -> String {
    if folder.as_os_str().is_empty() { ".".to_owned() } else { folder.display().to_string() }
}

struct Expander<'a> {
    scopes: Scopes<'a>,
    depth: usize,
    n_elements: usize,
    declared: BTreeSet<String>,
    strictness: Strictness,
}

/// The error for what cannot be expanded.
fn unexpanded(element: &Element, what: impl Into<String>) -> BadInput {
    element
        .error("what this program expands of xacro", what)
        .hint("xacro FILE > robot.urdf expands all of it, where ROS is installed")
}

impl Expander<'_> {
    fn evaluated(&mut self, element: &Element, text: &str) -> Check<Value> {
        match self.scopes.text(text) {
            Ok(value) => Ok(value),
            Err(_) if self.strictness == Strictness::Lenient => Ok(Value::Text(text.into())),
            Err(what) => Err(unexpanded(element, what)),
        }
    }

    fn attributes(&mut self, element: &Element) -> Check<Vec<(Rc<str>, Rc<str>)>> {
        let mut evaluated = Vec::new();
        for (name, text) in element.attributes() {
            let value = match text.contains('$') {
                true => self.evaluated(element, text)?.to_string().into(),
                false => text.clone(),
            };
            evaluated.push((name.clone(), value));
        }
        Ok(evaluated)
    }

    /// Value of the required attribute `name` of an element of xacro; any attribute but it and `others` is
    /// refused.
    fn required<'e>(&self, element: &'e Element, name: &str, others: &[&str]) -> Check<&'e str> {
        self.known(element, &[&[name], others].concat())?;
        element.attribute(name).ok_or_else(|| element.error(&format!("an attribute {name}"), "none"))
    }

    fn known(&self, element: &Element, names: &[&str]) -> Check<()> {
        match element.attributes().find(|(name, _)| !names.contains(&&***name)) {
            Some((name, _)) => Err(unexpanded(element, format!("the attribute {name}"))),
            None => Ok(()),
        }
    }

    /// The elements that the children of `element` become.
    fn children(&mut self, element: &Element) -> Check<Vec<Element>> {
        self.depth += 1;
        if self.depth > MAX_NESTED {
            let found = "deeper ones, as of a macro that calls itself for ever";
            return Err(element.error(&format!("at most {MAX_NESTED} levels of elements and macros"), found));
        }
        let mut made = Vec::new();
        for child in &element.children {
            self.child(child, &mut made)?;
        }
        self.depth -= 1;
        Ok(made)
    }

    fn child(&mut self, child: &Element, made: &mut Vec<Element>) -> Check<()> {
        self.scopes.spend(64).map_err(|what| unexpanded(child, what))?;
        let Some(verb) = child.tag.strip_prefix("xacro:") else {
            return self.plain(child, made);
        };
        match verb {
            "property" => self.set_property(child),
            "macro" => self.define(child),
            "arg" => self.declare(child),
            "if" | "unless" => self.condition(child, verb == "if", made),
            "include" => self.include(child, made),
            "insert_block" => self.insert(child, made),
            "call" | "element" | "attribute" => Err(unexpanded(child, format!("<xacro:{verb}>"))),
            name => self.call(child, name, made),
        }
    }

    /// An element of URDF.
    fn plain(&mut self, element: &Element, made: &mut Vec<Element>) -> Check<()> {
        self.n_elements += 1;
        if self.n_elements > MAX_ELEMENTS {
            return Err(element.error(&format!("a robot of at most {MAX_ELEMENTS} elements"), "more"));
        }
        let before = self.strictness;
        if SILENT.contains(&&*element.tag) {
            self.strictness = Strictness::Lenient;
        }
        let attributes = self.attributes(element)?;
        let children = self.children(element)?;
        self.strictness = before;
        made.push(element.with(attributes, children));
        Ok(())
    }

    fn set_property(&mut self, element: &Element) -> Check<()> {
        let name = self.required(element, "name", &["value", "default", "scope", "lazy_eval", "remove"])?;
        let name = self.evaluated(element, name)?.to_string();
        let is_name = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
            && name.starts_with(|c: char| !c.is_ascii_digit());
        if !is_name {
            return Err(element.error("a name of letters, digits and _", format!("\"{name}\"")));
        }
        if let Some(remove) = element.attribute("remove")
            && self.truth(element, remove)?
        {
            self.scopes.remove(&name);
            return Ok(());
        }
        let text = match (element.attribute("value"), element.attribute("default")) {
            (Some(text), _) => text,
            (None, Some(_)) if self.scopes.has(&name) => return Ok(()),
            (None, Some(text)) => text,
            (None, None) => {
                self.scopes.set(&format!("**{name}"), Property::Block(Rc::new(element.clone())), 0);
                return Ok(());
            }
        };
        let outwards = match element.attribute("scope") {
            None => 0,
            Some("parent") => 1,
            Some("global") => self.scopes.depth(),
            Some(other) => return Err(unexpanded(element, format!("the scope {other}"))),
        };
        let is_lazy = match element.attribute("lazy_eval") {
            Some(text) => self.truth(element, text)?,
            None => true,
        };
        let property = match Value::literal(text) {
            Value::Text(text) if outwards == 0 && is_lazy => Property::Text(text),
            Value::Text(text) => Property::Value(match self.evaluated(element, &text)? {
                Value::Text(text) => Value::literal(&text),
                other => other,
            }),
            other => Property::Value(other),
        };
        self.scopes.set(&name, property, outwards);
        Ok(())
    }

    fn truth(&mut self, element: &Element, text: &str) -> Check<bool> {
        let value = self.evaluated(element, text)?;
        value.condition().ok_or_else(|| element.error("true, false or a number", format!("\"{value}\"")))
    }

    fn define(&mut self, element: &Element) -> Check<()> {
        let name = self.required(element, "name", &["params"])?;
        let name = name.strip_prefix("xacro:").unwrap_or(name);
        // What is kept is a copy.
        let work = 64 * element.descendants().count();
        self.scopes.spend(work).map_err(|what| unexpanded(element, what))?;
        let parameters = parameters(element.attribute("params").unwrap_or_default());
        self.scopes.define(name, Macro { parameters, body: element.clone() });
        Ok(())
    }

    fn declare(&mut self, element: &Element) -> Check<()> {
        let name = self.required(element, "name", &["default"])?;
        let default = element.attribute("default").ok_or_else(|| element.error("a default", "none"))?;
        let default = self.evaluated(element, default)?.to_string();
        self.declared.insert(name.to_owned());
        self.scopes.declare(name, default);
        Ok(())
    }

    fn condition(&mut self, element: &Element, holds: bool, made: &mut Vec<Element>) -> Check<()> {
        let text = self.required(element, "value", &[])?;
        if self.truth(element, text)? == holds {
            made.extend(self.children(element)?);
        }
        Ok(())
    }

    fn insert(&mut self, element: &Element, made: &mut Vec<Element>) -> Check<()> {
        let name = self.required(element, "name", &[])?;
        if let Some(block) = self.scopes.block(&format!("**{name}")) {
            made.extend(self.children(&block)?);
            return Ok(());
        }
        let block = self.scopes.block(&format!("*{name}"));
        let block = block.ok_or_else(|| element.error("a block of this name", format!("\"{name}\"")))?;
        self.child(&block, made)
    }

    fn include(&mut self, element: &Element, made: &mut Vec<Element>) -> Check<()> {
        let name = self.required(element, "filename", &["optional"])?;
        let name = self.evaluated(element, name)?.to_string();
        let is_optional = match element.attribute("optional") {
            Some(text) => self.truth(element, text)?,
            None => false,
        };
        let Some(folder) = self.scopes.folder.clone() else {
            return Err(unexpanded(
                element,
                format!("<xacro:include filename=\"{name}\"> of a text without a folder"),
            ));
        };
        if name.contains(['*', '?', '[']) {
            return Err(unexpanded(element, format!("the pattern {name} for files")));
        }
        let path = Path::new(&folder).join(&name);
        let size = std::fs::metadata(&path).ok().filter(std::fs::Metadata::is_file).map(|found| found.len());
        match size {
            None if is_optional => return Ok(()),
            None => {
                let found = format!("{}, which is not there", path.display());
                return Err(element.error("a file to include", found));
            }
            Some(size) if size > MAX_FILE => {
                return Err(element.error("a file of at most 16 MB", format!("{} MB", size >> 20)));
            }
            Some(size) => {
                let size = usize::try_from(size).unwrap_or(usize::MAX);
                self.scopes.spend(size).map_err(|what| unexpanded(element, what))?;
            }
        }
        let text = file::read_text(&path)
            .map_err(|error| element.error("a file that can be read", error.to_string()))?;
        let root = elements(&text, &path.display().to_string())?;
        self.scopes.folder = Some(path.parent().map_or_else(|| ".".to_owned(), folder_name));
        made.extend(self.children(&root)?);
        self.scopes.folder = Some(folder);
        Ok(())
    }

    /// A macro with its arguments.
    fn call(&mut self, element: &Element, name: &str, made: &mut Vec<Element>) -> Check<()> {
        let Some(called) = self.scopes.find_macro(name) else {
            return Err(element.error("a macro that is defined before", format!("<xacro:{name}>")));
        };
        let attributes =
            element.attributes().map(|(name, text)| (name.clone(), text.clone())).collect::<Vec<_>>();
        let mut values: Vec<(String, Property)> = Vec::new();
        for (parameter, text) in attributes {
            if !called.parameters.iter().any(|known| *known.name == *parameter) {
                let known: Vec<&str> = called.parameters.iter().map(|known| &*known.name).collect();
                let expected = format!("parameters of the macro: {}", known.join(", "));
                return Err(element.error(&expected, format!("\"{parameter}\"")));
            }
            let value = match self.evaluated(element, &text)? {
                Value::Text(text) => Value::literal(&text),
                other => other,
            };
            values.push((parameter.to_string(), Property::Value(value)));
        }
        let mut blocks = self.children(element)?.into_iter();
        for parameter in &called.parameters {
            if parameter.name.starts_with('*') {
                let block = blocks.next().ok_or_else(|| {
                    element.error(&format!("an element for the parameter {}", parameter.name), "none")
                })?;
                values.push((parameter.name.clone(), Property::Block(Rc::new(block))));
            } else if !values.iter().any(|(name, _)| *name == parameter.name) {
                let value = self.default(element, parameter)?;
                values.push((parameter.name.clone(), Property::Value(value)));
            }
        }
        if let Some(more) = blocks.next() {
            return Err(element.error("no more elements than the macro takes", format!("<{}>", more.tag)));
        }
        self.scopes.open();
        for (name, property) in values {
            self.scopes.set(&name, property, 0);
        }
        made.extend(self.children(&called.body)?);
        self.scopes.close();
        Ok(())
    }

    /// Default value of a parameter that the caller does not give.
    fn default(&mut self, element: &Element, parameter: &MacroParameter) -> Check<Value> {
        if parameter.forwards {
            match self.scopes.property(&parameter.name) {
                Ok(Some(value)) => return Ok(value),
                Ok(None) => {}
                Err(what) => return Err(unexpanded(element, what)),
            }
        }
        let Some(default) = &parameter.default else {
            return Err(element.error(&format!("the parameter {}", parameter.name), "none"));
        };
        Ok(match self.evaluated(element, default)? {
            Value::Text(text) => Value::literal(&text),
            other => other,
        })
    }
}

/// `a b:=1 c:=^|2 *d **e`: names between spaces, with what follows `:=` or `=`.
fn parameters(text: &str) -> Vec<MacroParameter> {
    let mut found = Vec::new();
    let mut rest = text.trim_start();
    while !rest.is_empty() {
        let end = rest.find(|c: char| c.is_whitespace() || c == ':' || c == '=').unwrap_or(rest.len());
        let end = end.max(rest.chars().next().map_or(1, char::len_utf8));
        let name = rest[..end].to_owned();
        rest = &rest[end..];
        let default = rest.trim_start().strip_prefix(":=").or_else(|| rest.trim_start().strip_prefix('='));
        let (mut forwards, mut value) = (false, None);
        if let Some(after) = default {
            let after = after.trim_start_matches(' ');
            let after = match after.strip_prefix('^') {
                Some(after) => {
                    forwards = true;
                    after.strip_prefix('|').unwrap_or(after)
                }
                None => after,
            };
            let length = default_length(after);
            value = Some(after[..length].to_owned()).filter(|text| !(text.is_empty() && forwards));
            rest = &after[length..];
        }
        found.push(MacroParameter { name, forwards, default: value });
        rest = rest.trim_start();
    }
    found
}

/// Bytes up to the next space outside quotes and braces.
fn default_length(text: &str) -> usize {
    let (mut quote, mut depth) = (None, 0_usize);
    for (at, c) in text.char_indices() {
        match (quote, c) {
            (Some(open), _) if open == c => quote = None,
            (Some(_), _) => {}
            (None, '\'' | '"') => quote = Some(c),
            (None, '{' | '(' | '[') => depth += 1,
            (None, '}' | ')' | ']') => depth = depth.saturating_sub(1),
            (None, c) if c.is_whitespace() && depth == 0 => return at,
            _ => {}
        }
    }
    text.len()
}

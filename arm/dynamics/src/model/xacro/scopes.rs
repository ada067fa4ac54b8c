//! Properties, macros and arguments, each where it is seen: a macro sees what its caller sees.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::super::Arguments;
use super::super::xml::Element;
use super::expression::{Names, evaluate};
use super::operations::MAX_BYTES;
use super::value::Value;

/// Properties that are looked up while another is.
const MAX_CHAIN: usize = 32;

/// Content of a property.
#[derive(Debug, Clone)]
pub(super) enum Property {
    Value(Value),
    /// Evaluated where it is first used.
    Text(Rc<str>),
    Block(Rc<Element>),
}

/// Parameters of a macro in their order, with `*` or `**` before those that are elements, and its elements.
#[derive(Debug)]
pub(super) struct Macro {
    pub parameters: Vec<MacroParameter>,
    pub body: Element,
}

/// A parameter of a macro.
#[derive(Debug)]
pub(super) struct MacroParameter {
    pub name: String,
    /// Takes the value of the caller's property of that name.
    pub forwards: bool,
    pub default: Option<String>,
}

/// Whether what cannot be evaluated is an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Strictness {
    /// It is.
    Strict,
    /// It stays as it is typed: nothing depends on it.
    Lenient,
}

#[derive(Debug, Default)]
struct Scope {
    properties: BTreeMap<String, Property>,
    macros: BTreeMap<String, Rc<Macro>>,
}

/// All scopes, that of the file first.
#[derive(Debug)]
pub(super) struct Scopes<'a> {
    scopes: Vec<Scope>,
    arguments: BTreeMap<String, String>,
    command_line: &'a Arguments,
    /// Bytes that may still be evaluated.
    fuel: usize,
    chain: Vec<String>,
    /// Folder of the file that is read.
    pub folder: Option<String>,
}

impl<'a> Scopes<'a> {
    pub fn new(command_line: &'a Arguments, fuel: usize) -> Self {
        let arguments = command_line.clone();
        Self {
            scopes: vec![Scope::default()],
            arguments,
            command_line,
            fuel,
            chain: Vec::new(),
            folder: None,
        }
    }

    pub fn open(&mut self) {
        self.scopes.push(Scope::default());
    }

    pub fn close(&mut self) {
        self.scopes.pop();
    }

    /// Sets a property: in the innermost scope, or so many scopes further out.
    pub fn set(&mut self, name: &str, property: Property, outwards: usize) {
        let at = self.scopes.len().saturating_sub(1 + outwards);
        if let Some(scope) = self.scopes.get_mut(at) {
            scope.properties.insert(name.to_owned(), property);
        }
    }

    pub fn depth(&self) -> usize {
        self.scopes.len()
    }

    pub fn remove(&mut self, name: &str) {
        self.scopes.iter_mut().for_each(|scope| drop(scope.properties.remove(name)));
    }

    pub fn has(&self, name: &str) -> bool {
        self.scopes.iter().any(|scope| scope.properties.contains_key(name))
    }

    pub fn block(&self, name: &str) -> Option<Rc<Element>> {
        self.scopes.iter().rev().find_map(|scope| match scope.properties.get(name) {
            Some(Property::Block(block)) => Some(block.clone()),
            _ => None,
        })
    }

    pub fn define(&mut self, name: &str, made: Macro) {
        if let Some(scope) = self.scopes.last_mut() {
            scope.macros.insert(name.to_owned(), Rc::new(made));
        }
    }

    pub fn find_macro(&self, name: &str) -> Option<Rc<Macro>> {
        self.scopes.iter().rev().find_map(|scope| scope.macros.get(name).cloned())
    }

    /// Declares an argument; a value from the command line, or from an earlier declaration, stays.
    pub fn declare(&mut self, name: &str, default: String) {
        self.arguments.entry(name.to_owned()).or_insert(default);
    }

    /// The first argument that was given although no file declares it.
    pub fn undeclared(&self, declared: &std::collections::BTreeSet<String>) -> Option<&'a str> {
        self.command_line.keys().find(|name| !declared.contains(*name)).map(String::as_str)
    }

    pub fn spend(&mut self, bytes: usize) -> Result<(), String> {
        self.fuel = self.fuel.checked_sub(bytes).ok_or("more work than a robot needs")?;
        Ok(())
    }

    /// The value of a text with `${…}` and `$(…)` in it.
    pub fn text(&mut self, text: &str) -> Result<Value, String> {
        self.chain.clear();
        self.text_at(text, self.scopes.len())
    }

    /// The same, as scope number `level` (from 1) sees it.
    fn text_at(&mut self, text: &str, level: usize) -> Result<Value, String> {
        self.spend(text.len() + 8)?;
        if !text.contains('$') {
            return Ok(Value::Text(text.into()));
        }
        let mut parts: Vec<Value> = Vec::new();
        let mut rest = text;
        while !rest.is_empty() {
            let at = rest.find('$').unwrap_or(rest.len());
            if at > 0 {
                parts.push(Value::Text(rest[..at].into()));
                rest = &rest[at..];
                continue;
            }
            let dollars = rest.bytes().take_while(|byte| *byte == b'$').count();
            let opens = rest[dollars..].chars().next();
            if dollars > 1 && matches!(opens, Some('{' | '(')) {
                // One dollar less, and what follows is text.
                parts.push(Value::Text(rest[1..=dollars].into()));
                rest = &rest[dollars + 1..];
                continue;
            }
            match opens {
                Some(open @ ('{' | '(')) => {
                    let close = if open == '{' { '}' } else { ')' };
                    let end = rest.find(close).ok_or_else(|| format!("${open} without its \"{close}\""))?;
                    let inner = self.text_at(&rest[2..end], level)?.to_string();
                    parts.push(match open {
                        '{' => evaluate(&inner, &mut AtLevel { scopes: self, level })
                            .map_err(|what| format!("{what} in ${{{inner}}}"))?,
                        _ => self.command(&inner)?,
                    });
                    rest = &rest[end + 1..];
                }
                _ => {
                    parts.push(Value::Text(rest[..dollars].into()));
                    rest = &rest[dollars..];
                }
            }
        }
        let size: usize = parts.iter().map(Value::size).sum();
        if let [_] = parts[..] {
            // Whoever takes it writes it as text.
            self.spend(size)?;
            return Ok(parts.remove(0));
        }
        if size > MAX_BYTES {
            return Err(format!("a text of more than {MAX_BYTES} bytes"));
        }
        self.spend(size)?;
        Ok(Value::Text(parts.iter().map(Value::to_string).collect::<String>().into()))
    }

    /// `$(…)` of an attribute.
    fn command(&mut self, command: &str) -> Result<Value, String> {
        let words: Vec<&str> = command.split_whitespace().collect();
        let text = match words[..] {
            ["arg", name] => self.argument(name)?,
            ["find", package] => {
                let folder = self.folder.as_deref().ok_or_else(|| format!("$(find {package})"))?;
                package_folder(folder, package)
                    .ok_or_else(|| format!("$(find {package}): no folder of that name above {folder}"))?
            }
            ["dirname"] => self.folder.clone().ok_or("$(dirname)")?,
            ["optenv", _] => String::new(),
            ["optenv", _, ref default @ ..] => default.join(" "),
            _ => return Err(format!("$({command})")),
        };
        Ok(Value::Text(text.into()))
    }

    fn argument(&self, name: &str) -> Result<String, String> {
        self.arguments
            .get(name)
            .cloned()
            .ok_or_else(|| format!("$(arg {name}), which has no value: give --arg {name}=VALUE"))
    }

    fn property_at(&mut self, name: &str, level: usize) -> Result<Option<Value>, String> {
        let found = (0..level).rev().find_map(|at| match self.scopes.get(at)?.properties.get(name)? {
            Property::Block(_) => None,
            property => Some((at, property.clone())),
        });
        let (at, text) = match found {
            None => return Ok(None),
            Some((_, Property::Value(value))) => return Ok(Some(value)),
            Some((at, Property::Text(text))) => (at, text),
            Some((_, Property::Block(_))) => return Ok(None),
        };
        if self.chain.iter().any(|earlier| *earlier == name) {
            return Err(format!("\"{name}\", which is defined by itself: {}", self.chain.join(", ")));
        }
        if self.chain.len() >= MAX_CHAIN {
            return Err(format!("\"{name}\", the end of a chain of more than {MAX_CHAIN} properties"));
        }
        self.chain.push(name.to_owned());
        let value = self.text_at(&text, at + 1)?;
        self.chain.pop();
        let value = match value {
            Value::Text(text) => Value::literal(&text),
            other => other,
        };
        if let Some(scope) = self.scopes.get_mut(at) {
            scope.properties.insert(name.to_owned(), Property::Value(value.clone()));
        }
        Ok(Some(value))
    }

    /// The property of that name as the innermost scope sees it.
    pub fn property(&mut self, name: &str) -> Result<Option<Value>, String> {
        self.chain.clear();
        self.property_at(name, self.scopes.len())
    }
}

/// Names as a scope sees them.
struct AtLevel<'s, 'a> {
    scopes: &'s mut Scopes<'a>,
    level: usize,
}

impl Names for AtLevel<'_, '_> {
    fn property(&mut self, name: &str) -> Result<Option<Value>, String> {
        self.scopes.spend(8)?;
        self.scopes.property_at(name, self.level)
    }

    fn argument(&mut self, name: &str) -> Result<Value, String> {
        self.scopes.argument(name).map(|text| Value::Text(text.into()))
    }

    fn spend(&mut self, bytes: usize) -> Result<(), String> {
        self.scopes.spend(bytes)
    }
}

/// The folder called `package` that holds `folder`, or is next to one that does.
fn package_folder(folder: &str, package: &str) -> Option<String> {
    let is_plain = !package.contains(['/', '\\']) && !package.starts_with('.');
    let folder = std::path::Path::new(folder).canonicalize().ok().filter(|_| is_plain)?;
    folder.ancestors().take(16).find_map(|above| {
        let own = above.file_name().is_some_and(|name| name == package);
        let neighbour = above.join(package);
        match own {
            true => Some(above.display().to_string()),
            false => neighbour.is_dir().then(|| neighbour.display().to_string()),
        }
    })
}

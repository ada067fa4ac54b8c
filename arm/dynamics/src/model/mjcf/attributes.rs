//! Attributes of an element with what its class of `<default>` adds, typed and checked against the table.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::super::xml::Check;
use super::element::{MjcfElement, brief};
use super::schema::{self, MjcfEntry, Use};

/// Texts of attributes by name.
type Values<'a> = BTreeMap<&'a str, &'a str>;

/// Defaults of each class for the elements of each kind. A class has what its outer class had where it was
/// defined, so that what many share is held once.
#[derive(Debug, Default)]
pub(super) struct Classes<'a> {
    by_name: BTreeMap<&'a str, BTreeMap<&'static str, Rc<Values<'a>>>>,
}

/// Name of the class that holds where none is named.
pub(super) const MAIN: &str = "main";

impl<'a> Classes<'a> {
    /// All classes of a document, the sections `<default>` in their order.
    ///
    /// # Errors
    /// `BadInput` for a class without a name, or one that is defined twice.
    pub fn read(root: &'a MjcfElement) -> Check<Self> {
        let mut classes = Self::default();
        classes.by_name.insert(MAIN, BTreeMap::new());
        for section in root.children_of("default") {
            if let Some(name) = section.attribute("class").filter(|name| *name != MAIN) {
                return Err(section.error("the outermost class, \"main\"", format!("\"{}\"", brief(name))));
            }
            classes.read_class(section, MAIN)?;
        }
        Ok(classes)
    }

    fn read_class(&mut self, section: &'a MjcfElement, name: &'a str) -> Check<()> {
        let entry = entry_of(schema::root(), "default");
        let mut own = self.by_name.get(name).cloned().unwrap_or_default();
        for element in section.children.iter().filter(|child| *child.tag != *"default") {
            let values = own.entry(kind(entry_of(entry, &element.tag))).or_default();
            Rc::make_mut(values).extend(element.attributes());
        }
        self.by_name.insert(name, own.clone());
        for inner in section.children_of("default") {
            let name = match inner.attribute("class") {
                Some(name) if !name.is_empty() => name,
                _ => return Err(inner.error("an attribute class", "none")),
            };
            if self.by_name.insert(name, own.clone()).is_some() {
                return Err(inner.error("names of classes that differ", format!("\"{}\" twice", brief(name))));
            }
            self.read_class(inner, name)?;
        }
        Ok(())
    }

    /// True where there is a class of this name.
    pub fn contains(&self, name: &str) -> bool {
        self.by_name.contains_key(name)
    }

    fn of(&self, class: &str, kind: &str) -> Option<&Values<'a>> {
        self.by_name.get(class)?.get(kind).map(|values| &**values)
    }
}

/// Kind of equality constraints.
pub(super) const EQUALITY: &str = "equality";

/// Which elements share what a class gives: there is one kind of actuator, one of tendon and one of equality.
fn kind(entry: &MjcfEntry) -> &'static str {
    match entry.id.split_once('/') {
        Some(("actuator", _)) => "actuator",
        Some((_, "equality")) | Some(("equality", _)) => EQUALITY,
        Some((_, "tendon")) | Some(("tendon", _)) => "tendon",
        _ => entry.tag,
    }
}

/// Attributes of one element.
#[derive(Debug, Clone, Copy)]
pub(super) struct Attributes<'a> {
    pub element: &'a MjcfElement,
    class: Option<&'a Values<'a>>,
}

impl<'a> Attributes<'a> {
    /// Those of `element`, an element of `entry`, in `class` unless it names another; kinds that have no classes have none.
    ///
    /// # Errors
    /// `BadInput` for a class that is not there, and for a value that the table refuses, in the element or in its class.
    pub fn of(
        element: &'a MjcfElement,
        entry: &MjcfEntry,
        classes: &'a Classes<'a>,
        class: &str,
    ) -> Check<Self> {
        Self::unchecked(element, classes, kind(entry), class)?.check(entry)
    }

    /// The same, with values that the table may refuse, of an element of a `kind` of [`Classes`].
    ///
    /// # Errors
    /// `BadInput` for a class that is not there.
    pub fn unchecked(
        element: &'a MjcfElement,
        classes: &'a Classes<'a>,
        kind: &str,
        class: &str,
    ) -> Check<Self> {
        match element.attribute("class") {
            Some(own) if !classes.contains(own) => {
                Err(element.error("a class of <default>", format!("\"{}\"", brief(own))))
            }
            own => Ok(Self { element, class: classes.of(own.unwrap_or(class), kind) }),
        }
    }

    /// Those of an element of a kind that has no classes.
    ///
    /// # Errors
    /// `BadInput` for a value that the table refuses.
    pub fn plain(element: &'a MjcfElement, entry: &MjcfEntry) -> Check<Self> {
        Self { element, class: None }.check(entry)
    }

    fn check(self, entry: &MjcfEntry) -> Check<Self> {
        if let Use::Refused(reason) = entry.role {
            return Err(self.element.error(&format!("no <{}>: {reason}", entry.tag), "one"));
        }
        for (name, what) in entry.attributes() {
            let (value, reason) = match what {
                Use::Only(value, reason) => (Some(value), reason),
                Use::Refused(reason) => (None, reason),
                Use::Read | Use::Without(_) => continue,
            };
            let Some(text) = self.text(name) else { continue };
            if value.is_some_and(|value| text.split_whitespace().all(|word| is_same(word, value))) {
                continue;
            }
            let expected = match value {
                Some(value) => format!("{name} {value}: {reason}"),
                None => format!("no {name}: {reason}"),
            };
            return Err(self.element.error(&expected, format!("{name}=\"{}\"", brief(text))));
        }
        Ok(self)
    }

    /// The text of an attribute, its own before that of its class.
    pub fn text(&self, name: &str) -> Option<&'a str> {
        self.element.attribute(name).or_else(|| self.class?.get(name).copied())
    }

    /// The text of an attribute of the class alone.
    pub fn of_class(&self, name: &str) -> Option<&'a str> {
        self.class?.get(name).copied()
    }

    /// The text of an attribute that must be there.
    pub fn required(&self, name: &str) -> Check<&'a str> {
        match self.text(name) {
            Some(text) if !text.trim().is_empty() => Ok(text),
            Some(_) => Err(self.element.error(&format!("an attribute {name} with a value"), "an empty one")),
            None => Err(self.element.error(&format!("an attribute {name}"), "none")),
        }
    }

    /// Finite numbers of an attribute, where it is there.
    pub fn numbers(&self, name: &str) -> Check<Option<Vec<f64>>> {
        self.text(name).map(|text| self.parse(name, text)).transpose()
    }

    /// Finite numbers of `text`, that of the attribute `name`.
    pub fn parse(&self, name: &str, text: &str) -> Check<Vec<f64>> {
        let number = |word: &str| word.parse::<f64>().ok().filter(|x| x.is_finite());
        let numbers: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
        numbers.ok_or_else(|| {
            self.element.error(&format!("finite numbers in {name}"), format!("\"{}\"", brief(text)))
        })
    }

    /// Exactly N finite numbers of an attribute, where it is there.
    pub fn array<const N: usize>(&self, name: &str) -> Check<Option<[f64; N]>> {
        self.text(name).map(|text| self.parse_array(name, text)).transpose()
    }

    /// Exactly N finite numbers of `text`, that of the attribute `name`.
    pub fn parse_array<const N: usize>(&self, name: &str, text: &str) -> Check<[f64; N]> {
        let numbers = self.parse(name, text)?;
        <[f64; N]>::try_from(numbers).map_err(|numbers| {
            self.element.error(&format!("{N} finite numbers in {name}"), numbers.len().to_string())
        })
    }

    /// One finite number, where it is there.
    pub fn number(&self, name: &str) -> Check<Option<f64>> {
        Ok(self.array::<1>(name)?.map(|[x]| x))
    }

    /// One finite number ≥ 0; zero where it is not there.
    pub fn not_negative(&self, name: &str) -> Check<f64> {
        self.linear_coefficient(name).and_then(|x| match x < 0.0 {
            true => Err(self.element.error(&format!("{name} >= 0"), x.to_string())),
            false => Ok(x),
        })
    }

    /// The first of the numbers of a polynomial whose others are zero; zero where the attribute is not there.
    fn linear_coefficient(&self, name: &str) -> Check<f64> {
        let numbers = self.numbers(name)?;
        match numbers.as_deref() {
            None => Ok(0.0),
            Some([x, rest @ ..]) if rest.iter().all(|c| *c == 0.0) && rest.len() <= 2 => Ok(*x),
            Some(_) => {
                let found = format!("{name}=\"{}\"", brief(self.text(name).unwrap_or_default()));
                Err(self.element.error(
                    &format!("one number in {name}: other forces than linear ones are not computed"),
                    found,
                ))
            }
        }
    }

    /// One of `words`, by its position; the first where the attribute is not there.
    pub fn word(&self, name: &str, words: &[&str]) -> Check<usize> {
        let Some(text) = self.text(name) else { return Ok(0) };
        words.iter().position(|word| *word == text).ok_or_else(|| {
            self.element.error(&format!("{name} {}", words.join(" or ")), format!("\"{}\"", brief(text)))
        })
    }

    /// Whether an attribute is true.
    pub fn is_true(&self, name: &str) -> Check<bool> {
        Ok(self.word(name, &["false", "true"])? == 1)
    }
}

/// True where `word` is `value`, as a number where it is one.
fn is_same(word: &str, value: &str) -> bool {
    word == value || matches!((word.parse::<f64>(), value.parse::<f64>()), (Ok(a), Ok(b)) if a == b)
}

/// The entry of the child `tag` of `parent`, both of which the table has.
pub(super) fn entry_of(parent: &'static MjcfEntry, tag: &str) -> &'static MjcfEntry {
    schema::child(parent, tag).unwrap_or_else(|| panic!("<{tag}> in <{}>", parent.tag))
}

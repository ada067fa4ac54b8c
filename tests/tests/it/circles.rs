//! No circles between files: the files that a file of a crate names do not lead back to it, parent and child
//! apart.
//!
//! Names are followed through re-exports to the file that holds the item. Names within macros are not read,
//! nor is code that is compiled for tests alone.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use hysteron_tests::{members, names_in, root};
use syn::visit::{self, Visit};
use syn::{Attribute, Item, ItemUse, UseTree};

/// Names of nested modules from the root of a crate, and of something in them.
type Name = Vec<String>;

/// Imports and paths in a file.
#[derive(Default)]
struct Source {
    /// `use`: the path of a name, as written.
    imports: BTreeMap<String, Name>,
    /// Paths of two parts or more.
    paths: BTreeSet<Name>,
    /// Modules in files of their own that are for tests.
    tests: Vec<String>,
}

fn is_for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg")
            && attribute.parse_args::<syn::Ident>().is_ok_and(|word| word == "test")
    })
}

impl Source {
    fn import(&mut self, before: &Name, tree: &UseTree) {
        let with = |ident: &syn::Ident| [before.as_slice(), &[ident.to_string()]].concat();
        // `use a::b::{self}` is `use a::b`.
        let path = |ident: &syn::Ident| if ident == "self" { before.clone() } else { with(ident) };
        match tree {
            UseTree::Path(tree) => self.import(&with(&tree.ident), &tree.tree),
            UseTree::Group(tree) => tree.items.iter().for_each(|item| self.import(before, item)),
            UseTree::Name(tree) => {
                let path = path(&tree.ident);
                self.imports.insert(path.last().cloned().unwrap_or_default(), path);
            }
            UseTree::Rename(tree) => {
                self.imports.insert(tree.rename.to_string(), path(&tree.ident));
            }
            UseTree::Glob(_) => {
                self.paths.insert(before.clone());
            }
        }
    }
}

impl Visit<'_> for Source {
    fn visit_item(&mut self, item: &Item) {
        let attributes = match item {
            Item::Mod(item) => &item.attrs,
            Item::Use(item) => &item.attrs,
            Item::Fn(item) => &item.attrs,
            Item::Impl(item) => &item.attrs,
            _ => return visit::visit_item(self, item),
        };
        match item {
            Item::Mod(item) if is_for_tests(attributes) => self.tests.push(item.ident.to_string()),
            _ if is_for_tests(attributes) => {}
            _ => visit::visit_item(self, item),
        }
    }

    fn visit_item_use(&mut self, item: &ItemUse) {
        self.import(&Vec::new(), &item.tree);
    }

    fn visit_path(&mut self, path: &syn::Path) {
        if path.leading_colon.is_none() && path.segments.len() > 1 {
            self.paths.insert(path.segments.iter().map(|part| part.ident.to_string()).collect());
        }
        visit::visit_path(self, path);
    }
}

/// The files of a crate by the module that each holds.
struct Crate {
    name: String,
    sources: BTreeMap<Name, (PathBuf, Source)>,
}

impl Crate {
    /// All files below `src`, without those for tests.
    fn read(name: &str, src: &Path) -> Self {
        let mut files = vec![src.to_owned()];
        let mut sources = BTreeMap::new();
        while let Some(path) = files.pop() {
            if path.is_dir() {
                files.extend(names_in(&path).iter().map(|name| path.join(name)));
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                let mut source = Source::default();
                source.visit_file(&syn::parse_file(&std::fs::read_to_string(&path).unwrap()).unwrap());
                let within = path.strip_prefix(src).unwrap().with_extension("");
                let mut module: Name = within.iter().map(|part| part.to_str().unwrap().to_owned()).collect();
                let is_root = ["lib", "main"].contains(&module[0].as_str()) && module.len() == 1;
                module.pop_if(|last| is_root || last == "mod");
                sources.insert(module, (path, source));
            }
        }
        let of_tests = |(module, (_, source)): (&Name, &(PathBuf, Source))| -> Vec<Name> {
            source.tests.iter().map(|name| [module.as_slice(), std::slice::from_ref(name)].concat()).collect()
        };
        let tests: Vec<Name> = sources.iter().flat_map(of_tests).collect();
        sources.retain(|module, _| !tests.iter().any(|test| module.starts_with(test)));
        Self { name: name.replace('-', "_"), sources }
    }

    /// A path as written in a file, from the root of the crate; `None` where it leads to another crate.
    fn absolute(&self, module: &Name, path: &[String]) -> Option<Name> {
        let (first, rest) = path.split_first()?;
        let source = &self.sources.get(module)?.1;
        let child = [module.as_slice(), std::slice::from_ref(first)].concat();
        match first.as_str() {
            "crate" => Some(rest.to_vec()),
            "self" => Some([module.as_slice(), rest].concat()),
            "super" => {
                let parent = module[..module.len().saturating_sub(1)].to_vec();
                if rest.first().is_some_and(|next| next == "super") {
                    self.absolute(&parent, rest)
                } else {
                    Some([parent.as_slice(), rest].concat())
                }
            }
            first if first == self.name => Some(rest.to_vec()),
            _ if self.sources.contains_key(&child) => Some([child.as_slice(), rest].concat()),
            first => {
                let import = source.imports.get(first).filter(|import| import[0] != *first)?;
                self.absolute(module, &[import.as_slice(), rest].concat())
            }
        }
    }

    /// The module whose file holds what a path from the root names.
    fn home(&self, path: &Name) -> Name {
        let depth = (0..=path.len()).rev().find(|n| self.sources.contains_key(&path[..*n])).unwrap_or(0);
        let module = path[..depth].to_vec();
        let Some(name) = path.get(depth) else { return module };
        let import = self.sources.get(&module).and_then(|(_, source)| source.imports.get(name));
        match import.and_then(|import| self.absolute(&module, import)) {
            Some(import) if import != path[..=depth] => {
                self.home(&[import.as_slice(), &path[depth + 1..]].concat())
            }
            _ => module,
        }
    }

    /// Where the names in every file lead, but for parents and children.
    fn arrows(&self) -> BTreeMap<&Name, BTreeSet<Name>> {
        let of = |(module, (_, source)): (&Name, &(PathBuf, Source))| -> BTreeSet<Name> {
            let paths = source.imports.values().chain(&source.paths);
            let homes = paths.filter_map(|path| self.absolute(module, path)).map(|path| self.home(&path));
            homes.filter(|home| !home.starts_with(module) && !module.starts_with(home)).collect()
        };
        self.sources.iter().map(|source| (source.0, of(source))).collect()
    }

    /// The files of a circle, if there is one.
    fn circle(&self) -> Option<Vec<&Path>> {
        let mut arrows = self.arrows();
        // Files that lead to none that is left are in no circle.
        loop {
            let left: BTreeSet<Name> = arrows.keys().map(|module| (*module).clone()).collect();
            let before = arrows.len();
            arrows.values_mut().for_each(|to| to.retain(|module| left.contains(module)));
            arrows.retain(|_, to| !to.is_empty());
            if arrows.len() == before {
                break;
            }
        }
        let mut passed = vec![(*arrows.keys().next()?).clone()];
        loop {
            let next = arrows[passed.last()?].first()?.clone();
            if let Some(first) = passed.iter().position(|module| *module == next) {
                return Some(passed[first..].iter().map(|module| self.sources[module].0.as_path()).collect());
            }
            passed.push(next);
        }
    }
}

#[test]
fn no_files_of_a_crate_name_each_other_in_a_circle() {
    let (mut n_read, mut circles) = (0, Vec::new());
    for folder in members() {
        let folder = root().join(folder);
        let Ok(manifest) = std::fs::read_to_string(folder.join("Cargo.toml")) else { continue };
        let name = manifest.lines().find_map(|line| line.strip_prefix("name = \"")?.strip_suffix('"'));
        if let Some(name) = name.filter(|_| folder.join("src").is_dir()) {
            let found = Crate::read(name, &folder.join("src"));
            let circle = found.circle();
            circles.extend(circle.map(|files| format!("{name}: {files:?}")));
            n_read += found.sources.len();
        }
    }
    assert!(circles.is_empty(), "move what they share to a file below both:\n{}", circles.join("\n"));
    assert!(n_read > 500, "{n_read}");
}

#[test]
fn a_circle_is_seen_through_re_exports_and_parents_are_none() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let circle = || {
        let found = Crate::read("some-crate", folder.path());
        let names = |files: Vec<&Path>| -> Vec<String> {
            files.iter().map(|file| file.file_name().unwrap().to_str().unwrap().to_owned()).collect()
        };
        found.circle().map(names)
    };
    std::fs::create_dir(folder.path().join("b")).unwrap();
    write("lib.rs", "mod a;\nmod b;\npub use a::A;\npub use b::C as D;\n");
    write("a.rs", "use crate::D;\npub struct A(D);\n");
    write("b/mod.rs", "mod c;\nmod d;\npub use c::C;\npub struct B(C);\n");
    write("b/c.rs", "use super::B;\npub struct C(Option<Box<B>>);\n");
    write("b/d.rs", "use crate::A;\n#[cfg(test)]\nmod tests { use crate::b::c::C; }\n");
    assert_eq!(circle(), None);
    write("b/c.rs", "pub struct C(Option<Box<some_crate::A>>);\n");
    assert_eq!(circle(), Some(vec!["a.rs".to_owned(), "c.rs".to_owned()]));
    write("b/c.rs", "use super::d;\npub struct C(d::D);\n");
    assert_eq!(circle(), Some(vec!["a.rs".to_owned(), "c.rs".to_owned(), "d.rs".to_owned()]));
    write("b/d.rs", "#[cfg(test)]\nuse crate::A;\n");
    assert_eq!(circle(), None);
}

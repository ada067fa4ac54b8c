//! A type's name stands for one idea in the whole workspace, and the first line of a doc comment defines the item.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use hysteron_tests::{members, names_in, root};
use syn::visit::{self, Visit};
use syn::{Attribute, Item};

/// Names of several types that may be added to those of [`SHARED`]: the number reached. It only ever falls.
const MAX_HOMONYMS: usize = 17;

/// Names that several crates or rooms hold for the same idea, each with that idea.
const SHARED: [(&str, &str); 26] = [
    ("Arguments", "what stands behind a verb of the program, one for each group of verbs"),
    ("BoxQp", "a quadratic program with bounds"),
    ("ChannelRange", "smallest and largest value of a channel"),
    ("Check", "a result that is a value or a `BadInput`"),
    ("Error", "the error of a library, one for each"),
    ("FeatureSpec", "which features of strokes a network sees"),
    ("Features", "features of strokes for a network, sample by sample"),
    ("Fold", "one split of a cross-validation"),
    ("Job", "one recording to be made or read, with where its results go"),
    ("LossWeights", "weights of the terms of a loss"),
    ("Mat3", "a 3×3 matrix"),
    (
        "MotorLine",
        "torque of a motor over its speed: of the model, and of the virtual arm, which shares no code with it",
    ),
    ("Options", "the options of a verb, one for each room"),
    ("Outcome", "the result of a verb, one for each room"),
    ("Plant", "a system that is driven and steps by one sample"),
    ("Pose", "position and orientation"),
    ("RecurrentOptions", "how a recurrent network is trained"),
    ("Registration", "the transform between a robot's frame and a tracker's"),
    ("Result", "a result with the library's error, one for each"),
    (
        "StepReport",
        "cost and convergence of a step: of the twin, and of the virtual rig, which shares no code with it",
    ),
    ("Supply", "a voltage behind a resistance: of the model, and of the virtual arm"),
    ("SupplyTable", "the same as it is typed"),
    ("SweepCell", "one cell of a sweep over the wrist's load"),
    ("Trajectory", "coordinates over time: of an arm's recordings, and of a plan of strokes"),
    ("Vec3", "x, y, z"),
    ("Verb", "verbs of a command line, one for each group of them"),
];

/// Definitions of types by name: the files that hold them, once for each definition.
type Types = BTreeMap<String, Vec<PathBuf>>;

/// Names of the types of a file, and its modules that are for tests.
#[derive(Default)]
struct Names {
    types: Vec<String>,
    tests: BTreeSet<String>,
}

fn is_for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("test")
            || attribute.path().is_ident("cfg")
                && attribute.parse_args::<syn::Ident>().is_ok_and(|word| word == "test")
    })
}

impl Visit<'_> for Names {
    fn visit_item(&mut self, item: &Item) {
        let (attributes, name) = match item {
            Item::Struct(item) => (&item.attrs, Some(&item.ident)),
            Item::Enum(item) => (&item.attrs, Some(&item.ident)),
            Item::Union(item) => (&item.attrs, Some(&item.ident)),
            Item::Trait(item) => (&item.attrs, Some(&item.ident)),
            Item::Type(item) => (&item.attrs, Some(&item.ident)),
            Item::Mod(item) => (&item.attrs, None),
            Item::Fn(item) => (&item.attrs, None),
            Item::Impl(item) => (&item.attrs, None),
            _ => return visit::visit_item(self, item),
        };
        if is_for_tests(attributes) {
            if let Item::Mod(module) = item {
                self.tests.insert(module.ident.to_string());
            }
            return;
        }
        self.types.extend(name.map(ToString::to_string));
        visit::visit_item(self, item);
    }
}

/// Adds the types of a module's file and of the files of its modules, those for tests left out. `children` is the folder
/// of the latter.
fn add(file: &Path, children: &Path, types: &mut Types) {
    let mut names = Names::default();
    names.visit_file(&syn::parse_file(&std::fs::read_to_string(file).unwrap()).unwrap());
    for name in names.types {
        types.entry(name).or_default().push(file.to_owned());
    }
    for name in Some(children).filter(|folder| folder.is_dir()).map(names_in).unwrap_or_default() {
        let path = children.join(&name);
        let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
        if names.tests.contains(&stem) || ["lib", "main", "mod"].contains(&stem.as_str()) {
            continue;
        }
        let nested = children.join(&stem);
        if path.extension().is_some_and(|ending| ending == "rs") {
            add(&path, &nested, types);
        } else if path.join("mod.rs").is_file() {
            add(&path.join("mod.rs"), &path, types);
        }
    }
}

/// The types of a crate's sources.
fn types_of(src: &Path, types: &mut Types) {
    let roots = ["lib.rs", "main.rs"].map(|name| src.join(name));
    // Modules of a program that is a library too belong to one of both; each file counts once.
    if let Some(root) = roots.iter().find(|root| root.is_file()) {
        add(root, src, types);
    }
}

/// Members of the workspace that are no tests.
fn sources() -> Vec<PathBuf> {
    let folders = members().into_iter().filter(|folder| !folder.starts_with("tests"));
    folders.map(|folder| root().join(folder).join("src")).filter(|src| src.is_dir()).collect()
}

#[test]
fn a_type_has_its_name_for_itself() {
    let mut types = Types::new();
    for src in sources() {
        types_of(&src, &mut types);
    }
    assert!(types.len() > 500, "{}", types.len());
    types.retain(|_, files| files.len() > 1);
    for (name, idea) in SHARED {
        assert!(types.remove(name).is_some(), "{name} ({idea}) stands once: take it off the list");
    }
    let lines = |(name, files): (&String, &Vec<PathBuf>)| format!("{name}: {files:?}");
    let listed: Vec<String> = types.iter().map(lines).collect();
    assert!(
        types.len() <= MAX_HOMONYMS,
        "{} names stand for several types, {MAX_HOMONYMS} are allowed: rename one of each\n{}",
        types.len(),
        listed.join("\n")
    );
}

#[test]
fn homonyms_are_counted_without_tests() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    std::fs::create_dir_all(folder.path().join("b/tests")).unwrap();
    write(
        "lib.rs",
        "mod a;\nmod b;\npub struct A;\n#[cfg(test)]\nmod test_help;\nfn f() { enum Inner {} }\n",
    );
    write("a.rs", "type A = u8;\n#[cfg(test)]\nmod tests { struct A; }\n");
    write("test_help.rs", "struct A;\n");
    write("b/mod.rs", "mod c;\n#[cfg(test)]\nmod tests;\npub trait B {}\n");
    write("b/c.rs", "pub enum Inner {}\nimpl super::B for Inner {}\n");
    write("b/tests/mod.rs", "struct B;\n");
    let mut types = Types::new();
    types_of(folder.path(), &mut types);
    let counts: Vec<(&str, usize)> = types.iter().map(|(name, files)| (name.as_str(), files.len())).collect();
    assert_eq!(counts, [("A", 2), ("B", 1), ("Inner", 2)]);
}

/// Lines of doc comments that begin with "What".
fn what_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let begins = |line: &str| {
        let line = line.trim_start();
        let comment = line.strip_prefix("///").or_else(|| line.strip_prefix("//!"));
        comment.is_some_and(|comment| {
            comment
                .trim_start()
                .strip_prefix("What")
                .is_some_and(|rest| !rest.starts_with(char::is_alphabetic))
        })
    };
    text.lines().enumerate().filter(move |(_, line)| begins(line)).map(|(k, line)| (k + 1, line))
}

#[test]
fn no_doc_comment_begins_with_what() {
    let sample =
        "/// What it is.\n    //! What\n// What counts.\n/// Whatever\nlet a = 1; // What\n/// The\n";
    assert_eq!(what_lines(sample).map(|(line, _)| line).collect::<Vec<_>>(), [1, 2]);
    let (mut left, mut found, mut n_read): (Vec<PathBuf>, Vec<String>, usize) =
        (members().into_iter().map(|folder| root().join(folder)).collect(), Vec::new(), 0);
    while let Some(path) = left.pop() {
        if path.is_dir() {
            left.extend(names_in(&path).iter().map(|name| path.join(name)));
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let text = std::fs::read_to_string(&path).unwrap();
            let lines = what_lines(&text).map(|(k, line)| format!("{}:{k}: {}", path.display(), line.trim()));
            found.extend(lines);
            n_read += 1;
        }
    }
    assert!(found.is_empty(), "say what the item is or returns:\n{}", found.join("\n"));
    assert!(n_read > 500, "{n_read}");
}

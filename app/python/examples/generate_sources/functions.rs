//! Verbs as functions, made from the command line.

use std::any::TypeId;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::{Arg, ArgAction, Command};

use crate::classes::OutcomeClasses;
use crate::text::{HEAD, identifier, paragraphs, quoted, wrapped};

/// Verbs that belong to a terminal.
const OF_TERMINAL: [&str; 3] = ["completions", "help", "man"];

/// The modules of all verbs, by their path in the package: a group of verbs is a module, a group with groups a package.
pub fn modules(program: &Command, classes: &OutcomeClasses) -> BTreeMap<PathBuf, String> {
    let mut modules = BTreeMap::new();
    add_module(&mut modules, program, &mut Vec::new(), classes);
    modules
}

fn add_module(
    modules: &mut BTreeMap<PathBuf, String>,
    group: &Command,
    path: &mut Vec<String>,
    classes: &OutcomeClasses,
) {
    let verbs = group.get_subcommands();
    let verbs = verbs.filter(|verb| !verb.is_hide_set() && !OF_TERMINAL.contains(&verb.get_name()));
    let (groups, verbs): (Vec<&Command>, Vec<&Command>) = verbs.partition(|verb| verb.has_subcommands());
    for group in &groups {
        path.push(group.get_name().to_owned());
        add_module(modules, group, path, classes);
        path.pop();
    }
    let (file, dots) = match &path[..] {
        [] => (PathBuf::from("_verbs.py"), "."),
        names if groups.is_empty() => (
            names.iter().map(|name| identifier(name)).collect::<PathBuf>().with_extension("py"),
            &"..."[..names.len()],
        ),
        names => {
            let folder: PathBuf = names.iter().map(|name| identifier(name)).collect();
            (folder.join("__init__.py"), &"..."[..=names.len()])
        }
    };
    let mut functions = String::new();
    for verb in &verbs {
        functions.push_str(&function(verb, path, classes));
    }
    let mut names: Vec<String> = verbs.iter().map(|verb| identifier(verb.get_name())).collect();
    let imported: Vec<String> = match path.is_empty() {
        true => Vec::new(),
        false => groups.iter().map(|group| identifier(group.get_name())).collect(),
    };
    names.extend(imported.iter().cloned());
    names.sort();
    let about = group.get_about().map(ToString::to_string).unwrap_or_default();
    let about = if path.is_empty() { "Verbs of the program.".to_owned() } else { about + "." };
    let mut out =
        format!("{HEAD}\"\"\"{about}\"\"\"\n\n# ruff: noqa\nfrom __future__ import annotations\n\n");
    out.push_str("from collections.abc import Sequence\nfrom typing import Literal\n\n");
    if !imported.is_empty() {
        let _ = writeln!(out, "from . import {}", imported.join(", "));
    }
    let _ = writeln!(out, "from {dots} import outcomes");
    let _ = writeln!(
        out,
        "from {dots}_verb import PathLike, flag, option, options, positional, positionals, run_verb"
    );
    let lines: String = names.iter().map(|name| format!("    {},\n", quoted(name))).collect();
    let _ = writeln!(out, "\n__all__ = [\n{lines}]");
    modules.insert(file, out + &functions);
}

/// One argument of a verb.
struct Parameter<'a> {
    arg: &'a Arg,
    name: String,
    kind: String,
    is_several: bool,
}

impl<'a> Parameter<'a> {
    fn new(arg: &'a Arg) -> Self {
        let name = identifier(arg.get_long().unwrap_or(arg.get_id().as_str()));
        let several = arg.get_num_args().is_some_and(|range| range.max_values() > 1);
        let is_several =
            several || matches!(arg.get_action(), ArgAction::Append) || arg.get_value_delimiter().is_some();
        Self { arg, name, kind: kind(arg), is_several }
    }

    fn is_flag(&self) -> bool {
        matches!(self.arg.get_action(), ArgAction::SetTrue)
    }

    /// An option that may stand without a value.
    fn is_bare(&self) -> bool {
        !self.is_flag() && self.arg.get_num_args().is_some_and(|range| range.min_values() == 0)
    }

    fn is_required(&self) -> bool {
        self.arg.is_required_set()
    }

    /// As it stands in a signature.
    fn declared(&self) -> String {
        let Self { name, kind, .. } = self;
        let kind = if self.is_several { format!("{kind} | Sequence[{kind}]") } else { kind.clone() };
        match (self.is_flag(), self.is_required()) {
            (true, _) => format!("{name}: bool = False"),
            (false, true) => format!("{name}: {kind}"),
            (false, false) if self.is_bare() => format!("{name}: {kind} | Literal[True] | None = None"),
            (false, false) => format!("{name}: {kind} | None = None"),
        }
    }

    /// The words that it becomes on a command line.
    fn words(&self) -> String {
        let name = &self.name;
        let Some(long) = self.arg.get_long() else {
            let function = if self.is_several { "positionals" } else { "positional" };
            return format!("*{function}({name})");
        };
        let option = quoted(&format!("--{long}"));
        if self.is_flag() {
            return format!("*flag({option}, {name})");
        }
        if self.is_bare() {
            return format!("*(flag({option}, True) if {name} is True else option({option}, {name}))");
        }
        match (self.is_several, self.arg.get_value_delimiter()) {
            (false, _) => format!("*option({option}, {name})"),
            (true, Some(delimiter)) => {
                format!("*options({option}, {name}, {})", quoted(&delimiter.to_string()))
            }
            (true, None) => format!("*options({option}, {name}, None)"),
        }
    }

    /// Its line in the documentation.
    fn documented(&self) -> String {
        let help = self.arg.get_long_help().or(self.arg.get_help()).map(ToString::to_string);
        let defaults: Vec<String> =
            self.arg.get_default_values().iter().map(|value| value.to_string_lossy().into_owned()).collect();
        let default = match (self.is_flag(), defaults.is_empty()) {
            (false, false) => format!(" Default: {}.", defaults.join(", ")),
            _ => String::new(),
        };
        let help = help.unwrap_or_default();
        let stop = if help.ends_with('.') { "" } else { "." };
        wrapped(&format!("{}: {help}{stop}{default}", self.name), 8, 4)
    }
}

/// The type of one value.
fn kind(arg: &Arg) -> String {
    let possible = arg.get_possible_values();
    if !possible.is_empty() && !matches!(arg.get_action(), ArgAction::SetTrue) {
        let names: Vec<String> = possible.iter().map(|value| quoted(value.get_name())).collect();
        return format!("Literal[{}]", names.join(", "));
    }
    let found = arg.get_value_parser().type_id();
    let is = |id: TypeId| found == id;
    if is(TypeId::of::<PathBuf>()) {
        return "PathLike".to_owned();
    }
    if is(TypeId::of::<f64>()) || is(TypeId::of::<f32>()) {
        return "float".to_owned();
    }
    let integers = [
        TypeId::of::<usize>(),
        TypeId::of::<u64>(),
        TypeId::of::<u32>(),
        TypeId::of::<u16>(),
        TypeId::of::<u8>(),
        TypeId::of::<i64>(),
        TypeId::of::<NonZeroUsize>(),
    ];
    if integers.into_iter().any(is) { "int".to_owned() } else { "str".to_owned() }
}

/// A verb as a function.
fn function(verb: &Command, path: &[String], classes: &OutcomeClasses) -> String {
    let words: Vec<String> = path.iter().cloned().chain([verb.get_name().to_owned()]).collect();
    let typed = words.join(" ");
    let outcome = classes.of_verb(&typed);
    let arguments = verb.get_arguments().filter(|arg| {
        !arg.is_global_set() && !arg.is_hide_set() && !["help", "version"].contains(&arg.get_id().as_str())
    });
    let (positional, options): (Vec<Parameter>, Vec<Parameter>) =
        arguments.map(Parameter::new).partition(|parameter| parameter.arg.is_positional());
    let (required, optional): (Vec<&Parameter>, Vec<&Parameter>) =
        options.iter().partition(|parameter| parameter.is_required());
    let mut out = format!("\n\ndef {}(\n", identifier(verb.get_name()));
    for parameter in &positional {
        let _ = writeln!(out, "    {},", parameter.declared());
    }
    out.push_str("    *,\n");
    for parameter in required.into_iter().chain(optional) {
        let _ = writeln!(out, "    {},", parameter.declared());
    }
    let class = outcome.map_or("None".to_owned(), |class| format!("outcomes.{class}"));
    let _ = writeln!(
        out,
        "    overwrite: bool = False,\n    verbose: bool = False,\n    progress: bool = False,\n) -> {class}:"
    );
    let about = verb.get_long_about().or(verb.get_about()).map(ToString::to_string).unwrap_or_default();
    let (first, rest) = about.split_once("\n\n").unwrap_or((&about, ""));
    let _ = writeln!(out, "    \"\"\"{}.\n", first.trim().trim_end_matches('.').replace('\\', "\\\\"));
    if !rest.is_empty() {
        let _ = writeln!(out, "{}", paragraphs(rest, 4));
    }
    let _ = writeln!(out, "    As `hysteron {typed}`.\n\n    Args:");
    for parameter in positional.iter().chain(&options) {
        out.push_str(&parameter.documented());
    }
    out.push_str(
        "        overwrite: Replace results of this program that other arguments have made.\n        \
         verbose: Print the lines of the result.\n        \
         progress: Draw a bar (tqdm, where it is installed).\n\n    \
         Raises:\n        BadInput: Input that cannot be used; nothing is written under a final name.\n        \
         Failed: Everything else that went wrong.\n    \"\"\"\n",
    );
    let verb_words = words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(", ");
    let _ = writeln!(out, "    words = [\n        {verb_words},");
    for parameter in positional.iter().chain(&options) {
        let _ = writeln!(out, "        {},", parameter.words());
    }
    out.push_str("    ]\n");
    let keywords = "overwrite=overwrite, verbose=verbose, progress=progress";
    let _ = match outcome {
        Some(_) => writeln!(
            out,
            "    outcome: {class} = run_verb(\n        {class}, words, {keywords}\n    )\n    return outcome"
        ),
        None => writeln!(out, "    run_verb(object, words, {keywords})"),
    };
    out
}

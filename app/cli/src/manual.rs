//! `hysteron completions` and `hysteron man`: scripts for shells and pages for `man`, made from the command line itself.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use hysteron_base::file;
use hysteron_workflow::Context;
use hysteron_workflow::shared::outcome;
use hysteron_workflow::shared::outputs::{Outputs, SIGNATURE};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::terminal;

const COMPLETIONS_HELP: &str = "\
Prints a script for the shell. For bash, in a terminal:
  source <(hysteron completions bash)
and for every terminal from now on:
  hysteron completions bash > ~/.local/share/bash-completion/completions/hysteron

Exit codes: 0 done, 2 bad input.";

const MAN_HELP: &str = "\
Writes a page for the program and one for every verb: hysteron.1, hysteron-simulate.1, ...
With --markdown one page with the help of every verb: hysteron.md.

Examples:
  hysteron man --out ~/.local/share/man/man1
  hysteron man --markdown --out docs

Exit codes: 0 done, 1 failed, 2 bad input.";

/// Print a script that completes verbs and options in a shell
#[derive(Debug, clap::Args)]
#[command(after_help = COMPLETIONS_HELP)]
pub struct CompletionArguments {
    /// Which shell
    #[arg(value_enum)]
    shell: clap_complete::Shell,
}

/// Write manual pages
#[derive(Debug, clap::Args)]
#[command(after_help = MAN_HELP)]
pub struct ManArguments {
    /// Folder to write to
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// One page in Markdown with the help of every verb, instead of manual pages
    #[arg(long)]
    markdown: bool,
}

/// The outcome of `man`.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Files that were written, in order of their names.
    pub pages: Vec<PathBuf>,
}

impl outcome::Outcome for Outcome {}

/// Runs the verb `completions` for the command line `program`.
pub fn completions(arguments: &CompletionArguments, mut program: clap::Command) {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut program, "hysteron", &mut script);
    terminal::print_raw(String::from_utf8_lossy(&script).trim_end());
}

/// Runs the verb `man` for the command line `program`.
///
/// # Errors
/// `BadInput` for a folder or file that is not this command's; refusals of the file system.
pub fn man(
    arguments: &ManArguments,
    mut program: clap::Command,
    context: &Context,
) -> anyhow::Result<Outcome> {
    let mut written = Vec::new();
    if arguments.markdown {
        program = program.term_width(MARKDOWN_COLUMNS);
        program.build();
        let mut page = format!("{SIGNATURE}\n<!-- made by: hysteron man --markdown -->\n\n# Command line\n");
        render_markdown(&mut program, &mut page);
        written.push((arguments.out.join("hysteron.md"), page.into_bytes()));
    } else {
        program.build();
        render_pages(&arguments.out, &program, &mut written)?;
    }
    written.sort();
    let outputs = Outputs::default().folder("--out", &arguments.out);
    let outputs = written.iter().fold(outputs, |outputs, (path, _)| outputs.file("--out", path));
    let _lock = outputs.check(context)?;
    for (path, page) in &written {
        file::write_bytes(path, page)?;
    }
    let pages: Vec<PathBuf> = written.into_iter().map(|(path, _)| path).collect();
    context.print(format_args!("{} pages in {}", pages.len(), arguments.out.display()));
    Ok(Outcome { pages })
}

/// Width of the help in a page of Markdown [characters].
const MARKDOWN_COLUMNS: usize = 110;

/// Appends the help of a command and its verbs, as a terminal shows it, each below its own heading.
fn render_markdown(command: &mut clap::Command, page: &mut String) {
    let help = command.render_long_help().to_string();
    let name = command.get_bin_name().unwrap_or_else(|| command.get_name()).to_owned();
    page.push_str(&format!("\n## {name}\n\n```text\n"));
    help.lines().for_each(|line| page.extend([line.trim_end(), "\n"]));
    page.push_str("```\n");
    let verbs = command.get_subcommands_mut().filter(|verb| !verb.is_hide_set() && verb.get_name() != "help");
    verbs.for_each(|verb| render_markdown(verb, page));
}

/// The pages of a command and its verbs, each with the file it is for.
fn render_pages(
    folder: &Path,
    command: &clap::Command,
    pages: &mut Vec<(PathBuf, Vec<u8>)>,
) -> anyhow::Result<()> {
    let manual = clap_mangen::Man::new(command.clone());
    // A comment of the page: it names the program, so that the next one may replace it.
    let mut page = format!(".\\\" {SIGNATURE}\n").into_bytes();
    manual.render(&mut page).context("a manual page")?;
    pages.push((folder.join(manual.get_filename()), page));
    let verbs = command.get_subcommands().filter(|verb| !verb.is_hide_set() && verb.get_name() != "help");
    verbs.into_iter().try_for_each(|verb| render_pages(folder, verb, pages))
}

//! Prints `docs/outcomes.md`.
#![allow(clippy::print_stdout)] // the document

fn main() {
    print!("{}", hysteron_workflow::outcome::document());
}

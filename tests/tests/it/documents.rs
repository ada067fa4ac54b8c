//! The tables in the documents name what is there.

use std::collections::BTreeSet;

use hysteron_tests::{members, names_in, root, run};

fn text(name: &str) -> String {
    std::fs::read_to_string(root().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

#[test]
fn every_crate_has_a_row_in_how_it_is_built() {
    let page = text("docs/architecture.md");
    // Rows look like: | `core/base/` | ... |
    let rows: BTreeSet<String> = page
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split_once("/` |"))
        .map(|(name, _)| name.to_owned())
        .collect();
    assert_eq!(rows, members().into_iter().collect());
}

#[test]
fn first_commands_of_the_readme_run_the_program_and_the_tests() {
    let readme = text("README.md");
    let block = readme.split("```sh\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    assert!(block.contains("-- simulate meshes/tpu80/scene.toml"), "{block}");
    assert!(block.contains("cargo test --release --workspace"), "{block}");
}

/// Pages of the book, by their names in `docs/`.
fn pages() -> impl Iterator<Item = String> {
    names_in(&root().join("docs")).into_iter().filter(|name| name.ends_with(".md"))
}

#[test]
fn every_page_is_a_chapter_of_the_book() {
    let summary = text("docs/SUMMARY.md");
    for page in pages().filter(|page| page != "SUMMARY.md") {
        assert!(summary.contains(&format!("]({page})")), "docs/SUMMARY.md has no chapter {page}");
    }
}

#[test]
fn links_of_the_documents_lead_to_files() {
    let mut n_checked = 0;
    for document in pages().map(|page| format!("docs/{page}")).chain(["README.md".to_owned()]) {
        let place = root().join(&document);
        for link in text(&document).split("](").skip(1) {
            let path = link.split([')', '#']).next().unwrap();
            // What has a scheme leads out; what is empty leads to a heading of the same page.
            if path.is_empty() || path.contains(':') {
                continue;
            }
            assert!(place.parent().unwrap().join(path).exists(), "{document} links to {path}");
            n_checked += 1;
        }
    }
    assert!(n_checked > 80, "only {n_checked} links");
}

#[test]
fn every_field_in_the_notation_is_in_the_source() {
    let notation = text("docs/notation.md");
    // Rows look like: | W | Delassus matrix | m × m | m/N | `twin/src/projection.rs: delassus` |
    let mut n_checked = 0;
    for line in notation.lines().filter(|line| line.starts_with('|')) {
        let Some(place) = line.rsplit('`').nth(1).filter(|place| place.contains(".rs: ")) else { continue };
        let (file, field) = place.split_once(": ").unwrap();
        let source = text(file);
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        assert!(source.split(|c| !is_word(c)).any(|word| word == field), "{field} in {file}");
        n_checked += 1;
    }
    assert!(n_checked >= 10, "only {n_checked} rows with a field");
}

#[test]
fn limits_of_verdicts_in_the_docs_are_those_of_the_program() {
    let docs = text("docs/verdicts.md");
    let limit = |limit: Option<f64>| limit.map_or("-".to_owned(), |limit| limit.to_string());
    for rule in hysteron_report::verdict::RULES {
        let criterion = hysteron_base::json::to_value(rule.criterion).unwrap();
        let [name, why] = [criterion.as_str().unwrap(), rule.why];
        let (care, not_usable) = (limit(Some(rule.care_above)), limit(rule.not_usable_above));
        let row = format!("| `{name}` | {care} | {not_usable} | {why} |");
        assert!(docs.contains(&row), "docs/verdicts.md has no row {row}");
    }
    // Rows of criteria have a limit in their second cell, those of verbs have text.
    let limit_of = |line: &str| line.strip_prefix("| `")?.split(" | ").nth(1)?.parse::<f64>().ok();
    let n_rows = docs.lines().filter(|line| limit_of(line).is_some()).count();
    assert_eq!(n_rows, hysteron_report::verdict::RULES.len(), "rows without a rule");
}

#[test]
#[cfg(unix)] // the help of `arm emulate` is there on Unix alone
fn the_command_line_in_the_book_is_that_of_the_program() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), &["man", "--markdown", "--out", "."]).succeeded();
    let made = std::fs::read_to_string(folder.path().join("hysteron.md")).unwrap();
    let page = text("docs/hysteron.md");
    let differs = page.lines().zip(made.lines()).find(|(there, made)| there != made);
    assert!(page == made, "make it again: hysteron man --markdown --out docs ({differs:?})");
}

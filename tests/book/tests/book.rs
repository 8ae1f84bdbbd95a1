//! The documentation as a book: it builds, its links lead somewhere, and its scenarios are valid.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use book::{complaint, program, repository, schema};

/// The built book.
static BOOK: LazyLock<PathBuf> = LazyLock::new(|| book::build().canonicalize().expect("the book"));

fn docs() -> PathBuf {
    repository("docs")
}

/// All files below a folder with this ending.
fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(files(&path, ending));
        } else if path.extension().is_some_and(|extension| extension == ending) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// What stands between these two marks, wherever they occur.
fn between<'a>(text: &'a str, start: &str, end: &str) -> Vec<&'a str> {
    text.split(start).skip(1).filter_map(|rest| Some(rest.split_once(end)?.0)).collect()
}

/// Links of a page that lead nowhere.
fn dead_links(page: &Path, pages: &BTreeMap<PathBuf, String>) -> Vec<String> {
    let text = &pages[page];
    // What mdBook adds to every page is its own business.
    let text = text.split_once("<main>").and_then(|(_, rest)| rest.split_once("</main>")).map_or("", |(main, _)| main);
    let mut dead = Vec::new();
    for link in between(text, "href=\"", "\"").into_iter().chain(between(text, "src=\"", "\"")) {
        if link.starts_with("https://") || link.starts_with("http://") {
            continue;
        }
        let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
        let target = if file.is_empty() { page.to_path_buf() } else { page.parent().expect("a folder").join(file) };
        let Ok(target) = target.canonicalize() else {
            dead.push(link.to_string());
            continue;
        };
        let known = |page: &String| anchor.is_empty() || page.contains(&format!("id=\"{anchor}\""));
        if !pages.get(&target).map_or(anchor.is_empty(), known) {
            dead.push(link.to_string());
        }
    }
    dead
}

#[test]
fn the_book_builds_and_every_link_leads_somewhere() {
    let out = BOOK.as_path();
    let pages: BTreeMap<PathBuf, String> = files(out, "html")
        .into_iter()
        // What `cargo doc` writes is its own business.
        .filter(|path| !path.starts_with(out.join("api/rust")))
        .map(|path| (path.clone(), std::fs::read_to_string(&path).expect("a page")))
        .collect();
    assert!(pages.len() > 15, "{} pages", pages.len());
    let dead: Vec<(&PathBuf, Vec<String>)> =
        pages.keys().map(|page| (page, dead_links(page, &pages))).filter(|(_, dead)| !dead.is_empty()).collect();
    assert!(dead.is_empty(), "dead links: {dead:#?}");
}

#[test]
fn every_page_is_a_chapter() {
    let summary = std::fs::read_to_string(docs().join("SUMMARY.md")).expect("the summary");
    let chapters = between(&summary, "](", ")");
    for page in files(&docs(), "md") {
        let name = page.strip_prefix(docs()).expect("a page").display().to_string();
        assert!(name == "SUMMARY.md" || chapters.contains(&name.as_str()), "docs/SUMMARY.md has no line for {name}");
    }
}

#[test]
fn every_scenario_has_its_place_in_the_gallery() {
    let output = Command::new(program()).args(["list", "--json"]).output().expect("the program, built before");
    let scenarios: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let page = std::fs::read_to_string(docs().join("gallery.md")).expect("the gallery");
    for scenario in scenarios.as_array().expect("a list") {
        let name = scenario["name"].as_str().expect("a name");
        assert!(page.contains(&format!("\nphalanx run {name}\n")), "docs/gallery.md has no command for {name}");
        let picture = format!("images/gallery/{name}.webp");
        assert!(page.contains(&format!("]({picture})")), "docs/gallery.md does not show {picture}");
        let size = std::fs::metadata(docs().join(&picture)).map(|file| file.len());
        let size = size.unwrap_or_else(|error| panic!("{picture}: {error}; tests/book/gallery.py draws it"));
        assert!(size < 60_000, "{picture} has {size} bytes");
    }
}

#[test]
fn the_search_knows_words_of_every_kind_of_page() {
    let index = files(&BOOK, "js")
        .into_iter()
        .find(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("searchindex")));
    let index = std::fs::read_to_string(index.expect("an index")).expect("the index");
    for word in ["lockstep", "phalanx_neighbours", "set_if_present", "--placement", "anti-windup"] {
        assert!(index.contains(word), "the index of the search lacks {word}");
    }
}

#[test]
fn pages_have_edit_links_if_the_repository_is_known() {
    let folder = repository("target/book-with-edit-links");
    book::build_pages(&folder, Some("https://example.org/phalanx/"));
    for (page, source) in [("tutorial.html", "tutorial.md"), ("equations/ch2.html", "equations/ch2.md")] {
        let text = std::fs::read_to_string(folder.join(page)).expect("a page");
        // The folder of the pages is `.` to mdBook; browsers remove it from an address.
        let link = format!("href=\"https://example.org/phalanx/edit/main/docs/./{source}\"");
        assert!(text.contains(&link), "{page} has no link {link}");
    }
}

#[test]
fn every_scenario_in_the_book_is_valid() {
    let schema = schema();
    let mut count = 0;
    let readme = docs().join("../README.md");
    for page in files(&docs(), "md").into_iter().chain([readme]) {
        let text = std::fs::read_to_string(&page).expect("a page");
        for block in between(&text, "\n```toml\n", "\n```") {
            let mut scenario: toml::Table = toml::from_str(block).unwrap_or_else(|e| panic!("{}: {e}", page.display()));
            // A variant beside a part of a scenario is such a part itself.
            let variants =
                scenario.contains_key("name").then(toml::Table::new).or_else(|| match scenario.remove("variants") {
                    Some(toml::Value::Table(variants)) => Some(variants),
                    _ => None,
                });
            let parts = variants.into_iter().flatten().filter_map(|(_, part)| part.as_table().cloned());
            for part in std::iter::once(scenario).chain(parts) {
                assert_eq!(complaint(&schema, &part), None, "{}:\n{block}", page.display());
                count += 1;
            }
        }
    }
    for file in files(&repository("examples/own-systems"), "toml") {
        let text = std::fs::read_to_string(&file).expect("a scenario");
        let scenario: toml::Table = toml::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        assert_eq!(complaint(&schema, &scenario), None, "{}", file.display());
        count += 1;
    }
    assert!(count >= 12, "only {count} scenarios found");
}

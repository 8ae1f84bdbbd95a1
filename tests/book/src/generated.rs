//! The parts of pages that come from elsewhere. A page marks the place with a comment, which other viewers of Markdown hide.

use crate::site::workspace;
use crate::{c_header, python_package, repository, rust_crates};

/// Makes a part of a page.
type Part = fn() -> String;

/// Marks, and what takes their place.
const PARTS: [(&str, Part); 6] = [
    ("<!-- version -->", version),
    ("<!-- changelog -->", changelog),
    ("<!-- C header -->", c_header::page),
    ("<!-- C++ header -->", c_header::cpp_page),
    ("<!-- Python package -->", python_package::page),
    ("<!-- Rust crates -->", rust_crates::list),
];

/// A page with all its generated parts.
pub fn fill(page: &str) -> String {
    let mut page = page.to_string();
    for (mark, part) in PARTS {
        if page.contains(mark) {
            page = page.replace(mark, &part());
        }
    }
    page
}

fn version() -> String {
    format!("Version {} ([what changed](changelog.md))", workspace("version").expect("a version"))
}

/// The changelog without its title; its links start from the root of the repository, those of the book from `docs/`.
fn changelog() -> String {
    let text = std::fs::read_to_string(repository("CHANGELOG.md")).expect("the changelog");
    let (_, text) = text.split_once('\n').expect("a title");
    text.replace("](docs/", "](")
}

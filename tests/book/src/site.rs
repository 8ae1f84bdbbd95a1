//! Builds the book: the pages of `docs/`, what is generated for them, and the reference of the Rust crates.

use std::path::{Path, PathBuf};

use mdbook_driver::MDBook;

use crate::generated::fill;
use crate::repository;

/// Builds the book into `target/book`, with the reference of the Rust crates if `cargo doc` has made it, and returns that folder.
///
/// One place says where the repository is: `repository` in `[workspace.package]`. Without it, pages have no edit links.
///
/// # Panics
///
/// If a page is missing or invalid, or a generated part cannot be made.
pub fn build() -> PathBuf {
    let folder = repository("target/book");
    build_pages(&folder, workspace("repository").as_deref());
    let crates = repository("target/doc");
    if crates.is_dir() {
        copy(&crates, &folder.join("api/rust"));
    }
    folder
}

/// Builds the pages into a folder, whose earlier content is removed; with edit links, if the address of the repository is given.
///
/// # Panics
///
/// As [`build`].
pub fn build_pages(folder: &Path, address: Option<&str>) {
    if folder.exists() {
        std::fs::remove_dir_all(folder).expect("the earlier book is removed");
    }
    let mut book = MDBook::load(repository("docs")).expect("the pages of the book");
    book.config.build.build_dir = folder.to_path_buf();
    if let Some(address) = address.map(|address| address.trim_end_matches('/')) {
        book.config.set("output.html.git-repository-url", address).expect("a setting");
        book.config
            .set("output.html.edit-url-template", format!("{address}/edit/main/docs/{{path}}"))
            .expect("a setting");
    }
    book.book.for_each_chapter_mut(|chapter| chapter.content = fill(&chapter.content));
    book.build().expect("a book");
}

/// A text of `[workspace.package]` in the Cargo.toml of the repository.
pub(crate) fn workspace(field: &str) -> Option<String> {
    let text = std::fs::read_to_string(repository("Cargo.toml")).expect("Cargo.toml");
    let manifest: toml::Table = toml::from_str(&text).expect("TOML");
    let value = manifest["workspace"]["package"].get(field)?.as_str()?;
    (!value.is_empty()).then(|| value.to_string())
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder").flatten() {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).expect("a copy");
        }
    }
}

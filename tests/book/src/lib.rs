//! The documentation as a book, and scenario files against the schema that `phalanx schema` prints for editors.

mod c_header;
mod generated;
mod python_package;
mod rust_crates;
mod schema;
mod site;

use std::path::{Path, PathBuf};

pub use schema::{complaint, program, schema};
pub use site::{build, build_pages};

/// A folder or file of the repository.
pub fn repository(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}

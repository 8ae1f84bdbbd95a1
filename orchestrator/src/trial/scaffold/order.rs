//! What a project is to be, and the files that it consists of.

use std::path::PathBuf;

use formation::wiring::Role;

/// What a project is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Language {
    /// With Cargo
    Rust,
    /// C++17, with CMake
    Cpp,
    /// With the package `phalanx`
    Python,
}

/// What is asked for.
#[derive(Clone, Debug)]
pub struct Order {
    /// Name of the project, and of its folder.
    pub name: String,
    /// What it is to serve as.
    pub role: Role,
    /// What it is written in.
    pub language: Language,
    /// What the user calls the scenario, with options.
    pub scenario: String,
    /// The checkout or installation that the user wants it to be built with.
    pub phalanx: Option<PathBuf>,
    /// The path of this program; an installation has the rest of Phalanx beside it.
    pub program: PathBuf,
    /// The checkout that this program was built from, which may be gone.
    pub built_from: PathBuf,
}

/// A file that is to be written.
pub(super) struct File {
    pub(super) path: &'static str,
    pub(super) text: String,
}

impl File {
    pub(super) fn new(path: &'static str, text: String) -> Self {
        Self { path, text }
    }
}

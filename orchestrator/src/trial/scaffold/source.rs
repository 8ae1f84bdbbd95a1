//! What a project is built with: a checkout of Phalanx, or what is installed beside the program.

use std::path::{Path, PathBuf};

use super::order::Language;
use crate::failure::Failure;

/// Where a project in one language gets what it is built with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// A checkout of the source, with the crates, the header and the Python package.
    Checkout(PathBuf),
    /// An installation: the header and the library below this folder, or this folder is the Python package.
    Installed(PathBuf),
}

impl Source {
    /// What `folder` is for `language`.
    fn of(folder: &Path, language: Language) -> Option<Self> {
        let (checkout, installed) = needed(language);
        if folder.join(checkout).is_file() {
            return Some(Self::Checkout(folder.into()));
        }
        installed.filter(|file| folder.join(file).is_file()).map(|_| Self::Installed(folder.into()))
    }

    /// Its folder.
    pub(super) fn folder(&self) -> &Path {
        match self {
            Self::Checkout(folder) | Self::Installed(folder) => folder,
        }
    }
}

/// Finds what a project in `language` is built with: in the folder that the user `named`, or beside the program, or in the
/// checkout that the program was `built_from`.
///
/// # Errors
/// [`Failure::Usage`] if it is not there: which file of which folder is missing, and what to do.
pub(super) fn find(
    language: Language,
    named: Option<&Path>,
    program: &Path,
    built_from: &Path,
) -> Result<Source, Failure> {
    let (file, _) = needed(language);
    if let Some(folder) = named {
        return Source::of(folder, language).ok_or_else(|| {
            Failure::Usage(format!(
                "{} is no checkout of Phalanx: it has no {file}; name one with --phalanx",
                folder.display()
            ))
        });
    }
    let beside = beside(program);
    let found = beside.iter().map(PathBuf::as_path).chain([built_from]).find_map(|one| Source::of(one, language));
    found.ok_or_else(|| {
        let (what, instead) = match language {
            Language::Rust => ("a project in Rust is built with the crates of Phalanx", "choose --lang python or cpp"),
            Language::Cpp => ("a project in C++ needs phalanx.hpp and the library", "install the Debian package or wheel"),
            Language::Python => ("a project in Python needs the package phalanx", "install the wheel"),
        };
        Failure::Usage(format!(
            "{what}, which are not installed beside {}: name a checkout with --phalanx FOLDER (it has {file}), or {instead}",
            program.display()
        ))
    })
}

/// The file that shows that a checkout, and an installation, has what a language needs. Crates are not installed.
fn needed(language: Language) -> (&'static str, Option<&'static str>) {
    match language {
        Language::Rust => ("lockstep/Cargo.toml", None),
        Language::Cpp => ("capi/include/phalanx.hpp", Some("include/phalanx.hpp")),
        Language::Python => ("python/pyproject.toml", Some("participant.py")),
    }
}

/// Folders in which an installation of `program` has the rest: `/usr` of `/usr/bin/phalanx`, and the Python packages of a
/// (virtual) environment.
fn beside(program: &Path) -> Vec<PathBuf> {
    let Some(prefix) = program.parent().and_then(Path::parent) else { return Vec::new() };
    let versions = std::fs::read_dir(prefix.join("lib")).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut pythons: Vec<PathBuf> = versions
        .filter(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("python3")))
        .collect();
    pythons.sort();
    let packages = pythons
        .iter()
        .flat_map(|python| ["site-packages", "dist-packages"].map(|folder| python.join(folder).join("phalanx")));
    // The package before the prefix: a wheel has its own header and library.
    packages.chain([prefix.to_path_buf()]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes an empty file in a folder of this name.
    fn touch(path: &Path) {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, "").unwrap();
    }

    #[test]
    fn an_installation_serves_cpp_and_python_and_says_what_rust_needs() {
        let prefix = std::env::temp_dir().join(format!("phalanx-source-{}", std::process::id()));
        let program = prefix.join("bin/phalanx");
        let package = prefix.join("lib/python3.12/site-packages/phalanx");
        let nowhere = prefix.join("nowhere");
        let found = |language| find(language, None, &program, &nowhere);
        for language in [Language::Rust, Language::Cpp, Language::Python] {
            assert!(found(language).is_err(), "{language:?}");
        }
        touch(&prefix.join("include/phalanx.hpp"));
        assert_eq!(found(Language::Cpp).unwrap(), Source::Installed(prefix.clone()));
        touch(&package.join("include/phalanx.hpp"));
        touch(&package.join("participant.py"));
        assert_eq!(found(Language::Cpp).unwrap(), Source::Installed(package.clone()));
        assert_eq!(found(Language::Python).unwrap(), Source::Installed(package));
        let refused = found(Language::Rust).unwrap_err().to_string();
        assert!(refused.contains("--phalanx FOLDER (it has lockstep/Cargo.toml)"), "{refused}");
        touch(&nowhere.join("lockstep/Cargo.toml"));
        assert_eq!(found(Language::Rust).unwrap(), Source::Checkout(nowhere.clone()));
        std::fs::remove_dir_all(prefix).unwrap();
    }
}

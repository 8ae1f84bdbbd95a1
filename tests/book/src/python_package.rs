//! The reference of the Python package, from its signatures, annotations and docstrings.

use std::process::Command;

use crate::repository;

/// What `python_reference.py` prints. The interpreter is the one that PHALANX_PYTHON names, or `python3`; it needs no packages.
pub fn page() -> String {
    let python = std::env::var("PHALANX_PYTHON").unwrap_or_else(|_| "python3".to_string());
    let script = repository("tests/book/python_reference.py");
    let output = Command::new(&python).arg(&script).arg(repository("python/src/phalanx")).output();
    let output = output.unwrap_or_else(|error| panic!("{python}: {error}; PHALANX_PYTHON names an interpreter"));
    assert!(output.status.success(), "{}:\n{}", script.display(), String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

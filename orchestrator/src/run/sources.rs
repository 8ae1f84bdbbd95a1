//! What the processes of a run build their participants from.

use std::path::Path;

use formation::wiring::{Assembly, SCENARIO_FILE};

use crate::failure::Failure;

/// Writes the effective scenario and its data files into the run directory, and returns the text of the scenario, which has the
/// digests of the files.
///
/// # Errors
/// [`Failure::System`] if a file cannot be written.
pub(crate) fn write_scenario(assembly: &Assembly, directory: &Path) -> Result<String, Failure> {
    let write = |path: &Path, bytes: &[u8]| {
        std::fs::write(path, bytes).map_err(Failure::system(format!("write {}", path.display())))
    };
    assembly.scenario.data.iter().try_for_each(|file| write(&directory.join(file.name()), &file.bytes))?;
    let text = assembly.to_toml();
    write(&directory.join(SCENARIO_FILE), text.as_bytes())?;
    Ok(text)
}

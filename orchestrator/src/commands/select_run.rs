//! Which of the active runs is meant.

use processes::RunDirectory;

use crate::failure::Failure;

/// The run that is meant: that of the name, or the only one.
///
/// # Errors
/// [`Failure::Usage`] if there is no such run, or more than one and no name.
pub(super) fn choose(name: Option<&str>) -> Result<String, Failure> {
    let runs = RunDirectory::list().map_err(Failure::from)?;
    match (name, runs.as_slice()) {
        (Some(name), _) if runs.iter().any(|run| run == name) => Ok(name.to_string()),
        (Some(name), _) => Err(Failure::Usage(no_such_run(name, &runs))),
        (None, [run]) => Ok(run.clone()),
        (None, []) => Err(Failure::Usage("no run is active".into())),
        (None, _) => Err(Failure::Usage(format!("which run? Name one of {}", runs.join(", ")))),
    }
}

/// That there is no run of this name, and which there are.
pub(super) fn no_such_run(name: &str, runs: &[String]) -> String {
    match runs {
        [] => format!("no run is called `{name}`, and no run is active; `phalanx run SCENARIO` starts one"),
        runs => format!("no run is called `{name}`; active runs: {}", runs.join(", ")),
    }
}

//! From the name of a run that is going on to its control socket.

use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;
use std::time::Duration;

use processes::RunDirectory;
use serde_json::Value;

use crate::failure::Failure;
use crate::run::control::{SOCKET, SWAP_PATIENCE};

/// How long a run may take for its answer.
const PATIENCE: Duration = Duration::from_secs(5);

/// The run that is meant: that of the name, or the only one.
pub(super) fn choose(name: Option<&str>) -> Result<String, Failure> {
    let runs = RunDirectory::list().map_err(Failure::from)?;
    let names = if runs.is_empty() { "there is none".to_string() } else { runs.join(", ") };
    match (name, runs.as_slice()) {
        (Some(name), _) if runs.iter().any(|run| run == name) => Ok(name.to_string()),
        (Some(name), _) => Err(Failure::Usage(format!("no run is called `{name}`; running: {names}"))),
        (None, [run]) => Ok(run.clone()),
        (None, []) => Err(Failure::Usage("no run is going on".into())),
        (None, _) => Err(Failure::Usage(format!("which run? Name one of {names}"))),
    }
}

/// Tells a run something and returns its status.
pub(super) fn tell(run: &str, line: &str) -> Result<Value, Failure> {
    let path = RunDirectory::path_of(run).join(SOCKET);
    let failed = || Failure::system(format!("talk to the run {run} at {}", path.display()));
    let mut stream = UnixStream::connect(&path).map_err(failed())?;
    let patience = if line.starts_with("swap ") { SWAP_PATIENCE + PATIENCE } else { PATIENCE };
    stream.set_read_timeout(Some(patience)).map_err(failed())?;
    stream.write_all(format!("{line}\n").as_bytes()).map_err(failed())?;
    let mut answer = String::new();
    BufReader::new(&stream).read_line(&mut answer).map_err(failed())?;
    let value: Value = serde_json::from_str(&answer).map_err(|error| failed()(error.into()))?;
    match value["error"].as_str() {
        Some(error) => Err(Failure::Usage(format!("the run {run} says: {error}"))),
        None => Ok(value),
    }
}

//! `phalanx doctor`.

use processes::RunDirectory;
use serde_json::json;

use crate::cli::DoctorArgs;
use crate::failure::Failure;
use crate::run::leftovers;

pub(crate) fn doctor(args: &DoctorArgs) -> Result<(), Failure> {
    let removed = leftovers::sweep()?;
    let running = RunDirectory::list()?;
    let folders: Vec<String> = removed.folders.iter().map(|folder| folder.display().to_string()).collect();
    if args.json {
        println!("{}", json!({"removed": removed.runs, "folders": folders, "running": running}));
        return Ok(());
    }
    if !running.is_empty() {
        println!("Running, and left alone: {}", running.join(", "));
    }
    if !folders.is_empty() {
        println!("Removed temporary folders whose processes are dead: {}", folders.join(", "));
    }
    match removed.runs.len() {
        0 => println!("Nothing to do: no dead run has left anything behind."),
        1 => println!("Removed what a dead run had left: {}", removed.runs[0]),
        count => println!("Removed what {count} dead runs had left: {}", removed.runs.join(", ")),
    }
    Ok(())
}

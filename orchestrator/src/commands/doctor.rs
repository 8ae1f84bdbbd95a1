//! `phalanx doctor`.

use clap::Args;
use processes::RunDirectory;
use serde_json::json;

use crate::failure::Failure;
use crate::run::leftovers::{self, Removed};

#[derive(Debug, Args)]
pub(crate) struct DoctorArgs {
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn doctor(args: &DoctorArgs) -> Result<(), Failure> {
    let removed = leftovers::sweep();
    let running = RunDirectory::list()?;
    if args.json {
        print_json(&removed, &running)
    } else {
        print_text(&removed, &running)
    }
    Ok(())
}

fn print_json(Removed { runs, folders }: &Removed, running: &[String]) {
    let kept: Vec<String> = runs.kept.iter().map(ToString::to_string).collect();
    println!(
        "{}",
        json!({
            "removed": runs.removed, "folders": folders, "running": running, "kept": kept, "foreign": runs.foreign,
            "busy": runs.busy,
        })
    );
}

fn print_text(Removed { runs, folders }: &Removed, running: &[String]) {
    if !running.is_empty() {
        println!("Running, and left alone: {}", running.join(", "));
    }
    for path in &runs.foreign {
        println!("Not of this user alone, and left alone: {} (runs use another name)", path.display());
    }
    for error in &runs.kept {
        println!("Left by a dead run, and cannot be removed: {error}");
    }
    if let Some(process) = &runs.busy {
        println!("Nothing of dead runs was removed: the lock of their directory is held by {process}.");
    }
    if !folders.is_empty() {
        let list: Vec<String> = folders.iter().map(|folder| folder.display().to_string()).collect();
        println!("Removed temporary folders whose processes are dead: {}", list.join(", "));
    }
    match runs.removed.as_slice() {
        [] if runs.busy.is_some() => {}
        [] => println!("Nothing to do: no dead run has left anything behind."),
        [run] => println!("Removed what a dead run had left: {run}"),
        several => println!("Removed what {} dead runs had left: {}", several.len(), several.join(", ")),
    }
}

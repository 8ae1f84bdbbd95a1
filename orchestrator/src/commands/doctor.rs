//! `phalanx doctor`.

use lockstep::RunDirectory;
use serde_json::json;

use crate::cli::DoctorArgs;
use crate::failure::Failure;

pub(crate) fn doctor(args: &DoctorArgs) -> Result<(), Failure> {
    let removed = RunDirectory::sweep()?;
    if args.json {
        println!("{}", json!({"removed": removed}));
    } else if removed.is_empty() {
        println!("Nothing to do: no dead run has left anything behind.");
    } else {
        println!("Removed what {} dead runs had left: {}", removed.len(), removed.join(", "));
    }
    Ok(())
}

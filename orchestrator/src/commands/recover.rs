//! `phalanx recover`.

use std::path::PathBuf;

use clap::Args;

use crate::failure::Failure;

#[derive(Debug, Args)]
pub(crate) struct RecoverArgs {
    /// The log of a killed run
    pub(crate) log: PathBuf,
    /// Where the closed log goes [default: <log>-recovered.mcap]
    #[arg(long, value_name = "FILE.mcap")]
    pub(crate) out: Option<PathBuf>,
}

pub(crate) fn recover(args: &RecoverArgs) -> Result<(), Failure> {
    let out = args.out.clone().unwrap_or_else(|| {
        let stem = args.log.file_stem().unwrap_or_default().to_string_lossy();
        args.log.with_file_name(format!("{stem}-recovered.mcap"))
    });
    if recording::is_being_written(&args.log) {
        let what = "its run goes on; wait for its end, or stop it with `phalanx ctl stop`";
        return Err(Failure::Usage(format!("{} is not closed yet: {what}", args.log.display())));
    }
    let recovered = recording::recover(&args.log, &out)?;
    let source = args.log.display();
    let kept = match recovered.until_ns {
        Some(until) => format!("all up to {:.3} s of simulated time is kept", until as f64 * 1e-9),
        None => "no step had reached it".to_string(),
    };
    match (&recovered.damage, recovered.lost) {
        _ if recovered.was_complete => println!("{source} was complete; nothing is lost."),
        (Some(damage), lost) => println!("{damage}: {kept}, the {lost} bytes from there on are lost."),
        (None, 0) => println!("{source} was cut between two blocks: {kept}; all of the file is kept."),
        (None, lost) => println!("{source} was cut within a block: {kept}, its last {lost} bytes are lost."),
    }
    if !recovered.was_complete {
        println!(
            "Steps that had not reached the file are missing: those of the last 50 ms of the run, or of its last chunk."
        );
    }
    println!(
        "{}: {} messages on {} topics, {} attachments, {} metadata records.",
        out.display(),
        recovered.file.messages,
        recovered.channels,
        recovered.attachments,
        recovered.metadata
    );
    Ok(())
}

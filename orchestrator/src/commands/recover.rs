//! `phalanx recover`.

use crate::cli::RecoverArgs;
use crate::failure::Failure;
use crate::log;

pub(crate) fn recover(args: &RecoverArgs) -> Result<(), Failure> {
    let out = args.out.clone().unwrap_or_else(|| {
        let stem = args.log.file_stem().unwrap_or_default().to_string_lossy();
        args.log.with_file_name(format!("{stem}-recovered.mcap"))
    });
    let recovered = log::recover(&args.log, &out)?;
    if recovered.was_complete {
        println!("{} was complete; nothing was lost.", args.log.display());
    }
    if let Some(damage) = &recovered.damage {
        println!("{damage}");
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

//! `phalanx man`.

use std::path::Path;
use std::path::PathBuf;

use clap::Args;

use crate::failure::Failure;

#[derive(Debug, Args)]
pub(crate) struct ManArgs {
    /// Where they go; `man -l FOLDER/phalanx-run.1` shows one
    pub(crate) folder: PathBuf,
}

/// Writes a page for the program, whose command line is `program`, and one for each of its commands.
pub(crate) fn man(args: &ManArgs, program: clap::Command) -> Result<(), Failure> {
    let folder = args.folder.as_path();
    let failed = || Failure::system(format!("write manual pages into {}", folder.display()));
    std::fs::create_dir_all(folder).map_err(failed())?;
    clap_mangen::generate_to(program.disable_help_subcommand(true), folder).map_err(failed())?;
    println!("{} pages in {}; man -l FILE shows one.", pages(folder).map_err(failed())?, folder.display());
    Ok(())
}

fn pages(folder: &Path) -> std::io::Result<usize> {
    let names = std::fs::read_dir(folder)?.filter_map(Result::ok).map(|entry| entry.file_name());
    Ok(names.filter(|name| name.to_string_lossy().ends_with(".1")).count())
}

//! `phalanx man`.

use std::path::Path;
use std::path::PathBuf;

use clap::Args;

use crate::failure::Failure;
use crate::files;
use crate::run::leftovers::Scratch;

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
    let draft = Scratch::create()?;
    clap_mangen::generate_to(program.disable_help_subcommand(true), draft.path()).map_err(failed())?;
    for page in std::fs::read_dir(draft.path()).map_err(failed())? {
        let page = page.map_err(failed())?;
        let (text, path) = (std::fs::read(page.path()).map_err(failed())?, folder.join(page.file_name()));
        files::write(&path, text).map_err(Failure::system(format!("write {}", path.display())))?;
    }
    println!("{} pages in {}; man -l FILE shows one.", pages(folder).map_err(failed())?, folder.display());
    Ok(())
}

fn pages(folder: &Path) -> std::io::Result<usize> {
    let names = std::fs::read_dir(folder)?.filter_map(Result::ok).map(|entry| entry.file_name());
    Ok(names.filter(|name| name.to_string_lossy().ends_with(".1")).count())
}

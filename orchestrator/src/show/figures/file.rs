//! From a figure to a file.

use std::path::{Path, PathBuf};

use super::paint::paint;
use super::sheet::Sheet;
use super::{FigureFormat, FigureOptions, matplotlib, picture};
use crate::failure::Failure;
use crate::files;

/// Writes a figure into `folder`, which is made if need be, as `name` with the ending of its format; its path.
///
/// # Errors
/// [`Failure::System`] if it cannot be written.
pub(super) fn store(folder: &Path, name: &str, sheet: &Sheet, options: &FigureOptions) -> Result<PathBuf, Failure> {
    std::fs::create_dir_all(folder).map_err(Failure::system(format!("create the folder {}", folder.display())))?;
    let file = |ending: &str| folder.join(format!("{name}.{ending}"));
    let write = |path: PathBuf, bytes: Result<Vec<u8>, String>| {
        let done = bytes.map_err(std::io::Error::other).and_then(|bytes| files::write(&path, bytes));
        done.map_err(Failure::system(format!("write the figure {}", path.display())))?;
        Ok(path)
    };
    match options.format {
        FigureFormat::Svg => write(file("svg"), Ok(picture::svg(&paint(sheet, options)).into_bytes())),
        FigureFormat::Png => write(file("png"), picture::png(&paint(sheet, options))),
        FigureFormat::Pdf => write(file("pdf"), picture::pdf(&paint(sheet, options))),
        FigureFormat::Matplotlib => {
            write(file("csv"), matplotlib::data(sheet))?;
            write(file("py"), Ok(matplotlib::script(sheet, options, name).into_bytes()))
        }
    }
}

//! From a drawing to a file.

use std::path::{Path, PathBuf};

use kuva::backend::png::PngBackend;
use kuva::backend::svg::SvgBackend;
use kuva::render::render::Scene;

use super::{INCHES, pdf, pixels};
use crate::failure::Failure;
use crate::files;
use crate::show::figures::FigureFormat;

/// Pixels of an inch.
const RESOLUTION: f64 = 300.0;

/// Writes a drawing into `folder`, which is made if need be, as `name` with the ending of its format.
///
/// # Errors
/// [`Failure::System`] if it cannot be written.
pub(super) fn store(folder: &Path, name: &str, mut scene: Scene, format: FigureFormat) -> Result<PathBuf, Failure> {
    std::fs::create_dir_all(folder).map_err(Failure::system(format!("create the folder {}", folder.display())))?;
    let (ending, bytes) = match format {
        FigureFormat::Svg => ("svg", Ok(sized(&SvgBackend::new().render_scene(&scene), &scene).into_bytes())),
        FigureFormat::Png => {
            pixels::prepare(&mut scene);
            ("png", PngBackend::new().with_scale((RESOLUTION * INCHES) as f32).render_scene(&scene))
        }
        FigureFormat::Pdf => ("pdf", pdf::render(&scene)),
    };
    let path = folder.join(format!("{name}.{ending}"));
    let done = bytes.map_err(std::io::Error::other).and_then(|bytes| files::write(&path, bytes));
    done.map_err(Failure::system(format!("write the figure {}", path.display())))?;
    Ok(path)
}

/// The drawing with its size in inches, so that it stands in a paper at that size without being scaled.
fn sized(svg: &str, scene: &Scene) -> String {
    let (width, height) = (scene.width, scene.height);
    let pixels = format!("width=\"{width}\" height=\"{height}\"");
    let inches = format!(
        "width=\"{:.3}in\" height=\"{:.3}in\" viewBox=\"0 0 {width} {height}\"",
        width * INCHES,
        height * INCHES
    );
    svg.replacen(&pixels, &inches, 1)
}

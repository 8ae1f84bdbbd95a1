//! Figures for a paper: those of the thesis by their numbers, and the plots of [`crate::show::view`], each in a file of its own.
//!
//! Sizes are those of one column of a journal (400 units for 3.5 inches, so that the smallest letters come out at 7 points), or
//! of two columns where many plots stand side by side. Every agent, and every run that is compared, has its colour and its
//! dashes, so that lines stay apart in grey.

mod file;
mod pdf;
mod pixels;
mod published;
mod sheet;
mod style;
mod trajectories;

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use kuva::render::render::Scene;

use crate::failure::Failure;
use crate::show::view::{Curve, Grid, Kind, LoggedRun, Panel, View, panels};
use file::store;
pub(crate) use published::{Missing, write as write_published};
use sheet::{Line, Plot};
use style::Entry;

/// How a figure is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FigureFormat {
    /// Vectors, for browsers and office programs
    Svg,
    /// Pixels, 300 an inch in one column
    Png,
    /// Vectors for LaTeX, with the letters of their font inside
    Pdf,
}

/// Width of a figure, in the units of the file.
const WIDTH: f64 = 400.0;
/// Inches of a unit: one column of a journal is 3.5 inches wide.
const INCHES: f64 = 3.5 / WIDTH;
/// Points of a curve: more than a printer can show in one column.
const POINTS: usize = 1600;
/// Plots in one figure.
const ROWS: usize = 4;

/// Writes all plots of a run into `folder` and returns their files. `mark` is part of the names; empty for none.
///
/// # Errors
/// [`Failure::System`] if a file cannot be written.
pub(crate) fn write(run: &LoggedRun, folder: &Path, mark: &str, format: FigureFormat) -> Result<Vec<PathBuf>, Failure> {
    let prefix = prefix(run, mark);
    let mut written = Vec::new();
    let mut store = |name: &str, scene: Scene| {
        written.push(store(folder, &format!("{prefix}-{name}"), scene, format)?);
        Ok::<(), Failure>(())
    };
    if let Some(scene) = trajectories::draw(run) {
        store("trajectories", scene)?;
    }
    let grid = Grid::new(run.samples(), POINTS);
    let times: Vec<f64> = grid.points().iter().map(|&sample| run.time(sample)).collect();
    for panel in panels(run, &grid).iter().filter(|panel| panel.kind == Kind::Lines && panel.id != "other-signals") {
        for (name, views) in pages(panel) {
            store(&name, draw(run, views, &times))?;
        }
    }
    Ok(written)
}

/// `ch7-2` for what belongs to section 7.2 of the thesis, else the name of the scenario or of the file.
fn prefix(run: &LoggedRun, mark: &str) -> String {
    let thesis = run.scenario.as_ref().map(|scenario| scenario.thesis.as_str()).filter(|text| !text.is_empty());
    let plain = |text: &str| -> String {
        text.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' }).collect()
    };
    let first = match (thesis, &run.scenario) {
        (Some(section), _) => format!("ch{}", plain(section)),
        (None, Some(scenario)) => scenario.name.clone(),
        (None, None) => run.stem(),
    };
    if mark.is_empty() { first } else { format!("{first}-{}", plain(mark)) }
}

/// The figures of a panel: so many plots each that they still fit on a page.
fn pages(panel: &Panel) -> Vec<(String, &[View])> {
    // An estimate and its error belong together.
    let rows = if panel.id == "estimates" { 2 } else { ROWS };
    let chunks: Vec<&[View]> = panel.views.chunks(rows).collect();
    let several = chunks.len() > 1;
    let name = |(index, views): (usize, &[View])| match (several, panel.id) {
        (true, "estimates") => format!("{}-{}", panel.id, views[0].name.replace(' ', "-")),
        (true, _) => format!("{}-{}", panel.id, index + 1),
        (false, _) => panel.id.to_string(),
    };
    chunks.iter().enumerate().map(|(index, views)| (name((index, views)), *views)).collect()
}

/// Plots above each other over the same time.
fn draw(run: &LoggedRun, views: &[View], times: &[f64]) -> Scene {
    let plot = |view: &View| Plot {
        title: view.name.clone(),
        label: labelled(&view.axis, &view.unit),
        logarithmic: view.logarithmic,
        lines: view.curves.iter().map(|curve| line(curve, times)).collect(),
        limits: view.limits.iter().map(|limit| limit.value).collect(),
        ..Plot::default()
    };
    let mut legend = style::agents(run);
    if let Some(second) = views.iter().flat_map(|view| &view.curves).find(|curve| curve.second) {
        let name = format!("{} (dotted)", second.label);
        legend.push(Entry { name, colour: style::colour(None), dashes: style::second() });
    }
    let rows = views.iter().map(|view| vec![plot(view)]).collect();
    sheet::draw(rows, [times[0], times[times.len() - 1]], WIDTH, &legend)
}

/// A quantity with its unit.
fn labelled(quantity: &str, unit: &str) -> String {
    if unit.is_empty() { quantity.into() } else { format!("{quantity} [{}]", unit.replace("^2", "\u{b2}")) }
}

fn line(curve: &Curve, times: &[f64]) -> Line {
    Line {
        points: times.iter().copied().zip(curve.values.iter().copied()).collect(),
        colour: style::colour(curve.agent),
        dashes: if curve.second { style::second() } else { style::dashes(curve.agent) },
        cut_off: curve.second,
    }
}

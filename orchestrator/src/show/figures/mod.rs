//! Figures for a paper: those of the thesis by their numbers, and the plots of [`crate::show::view`], each in a file of its own.
//!
//! A figure is a [`Sheet`] of plots. [`layout`] gives everything its place, [`paint`] makes a picture of it, and [`picture`] stores that
//! as SVG, PDF or PNG; [`matplotlib`] writes a script instead. Widths are those of one or two columns of a journal; no letter
//! but a script is smaller than the size that was asked for. Every agent, and every run that is compared, has its colour, its dashes and its
//! marker, so that curves stay apart in grey.

mod clip;
mod file;
mod layout;
mod matplotlib;
mod paint;
mod picture;
mod published;
mod sheet;
mod style;
mod ticks;
mod trajectories;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use crate::failure::Failure;
use crate::show::view::{Curve, Grid, Kind, Limit, LoggedRun, Panel, View, panels};
use file::store;
use picture::{Font, Label};
pub(crate) use published::{Missing, write as write_published};
use sheet::{Line, Plot, Sheet};
use style::{Entry, Style};

/// How a figure is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FigureFormat {
    /// Vectors, for browsers and office programs
    Svg,
    /// Pixels, 600 an inch
    Png,
    /// Vectors for LaTeX, with the letters of their font inside
    Pdf,
    /// A Python script that draws the figure with matplotlib, and its data as CSV
    Matplotlib,
}

/// How figures look.
#[derive(Clone, Debug, Args)]
pub(crate) struct FigureOptions {
    /// How the figures are stored
    #[arg(long, value_enum, default_value_t = FigureFormat::Svg, requires = "figures")]
    pub(crate) format: FigureFormat,
    /// The font of the figures
    #[arg(long, value_enum, default_value_t = Font::Helvetica, requires = "figures")]
    pub(crate) font: Font,
    /// Size of the letters in points, from 4 to 24; sub- and superscripts have 3/4 of it
    #[arg(long, value_name = "POINTS", default_value_t = 8.0, value_parser = points, requires = "figures")]
    pub(crate) font_size: f64,
    /// Width of the figures in inches, from 2 to 20 [default: 3.5, one column of a journal, or 7.16, two columns, where plots stand side
    /// by side]
    #[arg(long, value_name = "INCHES", value_parser = inches, requires = "figures")]
    pub(crate) width: Option<f64>,
}

fn points(text: &str) -> Result<f64, String> {
    within(text, 4.0, 24.0)
}

fn inches(text: &str) -> Result<f64, String> {
    within(text, 2.0, 20.0)
}

fn within(text: &str, low: f64, high: f64) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "expected a number".to_string())?;
    if (low..=high).contains(&number) { Ok(number) } else { Err(format!("expected a number from {low} to {high}")) }
}

/// Points of a curve: more than a printer can show in one column.
const POINTS: usize = 1600;
/// Plots in one figure.
const ROWS: usize = 4;

/// Writes all plots of a run into `folder` and returns their files. `mark` is part of the names; empty for none.
///
/// # Errors
/// [`Failure::System`] if a file cannot be written.
pub(crate) fn write(
    run: &LoggedRun,
    folder: &Path,
    mark: &str,
    options: &FigureOptions,
) -> Result<Vec<PathBuf>, Failure> {
    let prefix = prefix(run, mark);
    let mut written = Vec::new();
    let mut store = |name: &str, sheet: Sheet| {
        written.push(store(folder, &format!("{prefix}-{name}"), &sheet, options)?);
        Ok::<(), Failure>(())
    };
    if let Some(sheet) = trajectories::sheet(run) {
        store("trajectories", sheet)?;
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
fn draw(run: &LoggedRun, views: &[View], times: &[f64]) -> Sheet {
    let plot = |view: &View| Plot {
        title: Label::plain(&view.name),
        y_label: Label::plain(&with_unit(&view.axis, &view.unit)),
        logarithmic: view.logarithmic,
        lines: view.curves.iter().map(|curve| line(curve, times)).collect(),
        limits: view.limits.iter().map(|limit| limit.value).collect(),
        ..Plot::default()
    };
    let mut legend = if views.iter().flat_map(|view| &view.curves).any(|curve| curve.agent.is_some()) {
        style::agents(run)
    } else {
        Vec::new()
    };
    if let Some(second) = views.iter().flat_map(|view| &view.curves).find(|curve| curve.second) {
        legend.push(Entry::curve(&second.label, Style::BLACK.second()));
    }
    legend.extend(limits(views.iter().flat_map(|view| &view.limits)));
    let rows = views.iter().map(|view| vec![plot(view)]).collect();
    Sheet::over_time(rows, [times[0], times[times.len() - 1]], legend)
}

/// An entry for the horizontal lines, by their names; the negative of a limit is that limit.
fn limits<'a>(limits: impl Iterator<Item = &'a Limit>) -> Option<Entry> {
    let mut names: Vec<&str> = Vec::new();
    for limit in limits.filter(|limit| !limit.label.starts_with('-')) {
        if !names.contains(&limit.label.as_str()) {
            names.push(&limit.label);
        }
    }
    (!names.is_empty()).then(|| Entry::curve(&names.join(", "), Style::LIMIT))
}

/// A quantity with its unit, as far as the log tells it.
fn with_unit(quantity: &str, unit: &str) -> String {
    match unit {
        "" => quantity.into(),
        unit => format!("{quantity} [{}]", unit.replace("^2", "²").replace("^3", "³")),
    }
}

fn line(curve: &Curve, times: &[f64]) -> Line {
    let style = curve.agent.map_or(Style::BLACK, Style::at);
    Line {
        points: times.iter().copied().zip(curve.values.iter().copied()).collect(),
        style: if curve.second { style.second() } else { style },
        cut_off: curve.second,
        ends: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_has_its_unit() {
        assert_eq!(with_unit("norm", "m/s^2"), "norm [m/s²]");
        assert_eq!(with_unit("norm", ""), "norm");
    }

    #[test]
    fn sizes_have_limits() {
        assert_eq!((inches("3.5"), points("8")), (Ok(3.5), Ok(8.0)));
        assert_eq!(inches("1"), Err("expected a number from 2 to 20".into()));
        assert!(points("NaN").is_err() && points("small").is_err());
    }
}

//! Figures for a paper: the plots of [`crate::view`], each in a file of its own.
//!
//! Sizes are those of one column of a journal (400 units for 3.5 inches, so that the smallest letters come out at 7 points).
//! Every agent has its colour and its dashes, so that lines stay apart in grey.

mod pixels;
mod style;
mod trajectories;

use std::path::{Path, PathBuf};

use kuva::backend::png::PngBackend;
use kuva::backend::svg::SvgBackend;
use kuva::plot::LinePlot;
use kuva::render::annotations::ReferenceLine;
use kuva::render::figure::Figure;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::Scene;

use crate::cli::FigureFormat;
use crate::failure::Failure;
use crate::view::{Curve, Grid, Kind, Panel, Subject, View, panels};

/// Width of a figure, in the units of the file.
const WIDTH: f64 = 400.0;
/// Height of one plot in it.
const HEIGHT: f64 = 144.0;
/// Space around a plot: left, right, above, below. The same for all, so that the time axes lie above each other.
const MARGINS: [f64; 4] = [56.0, 12.0, 24.0, 20.0];
/// What the name of the time takes below the last plot.
const TIME_LABEL: f64 = 16.0;
/// Points of a curve: more than a printer can show in one column.
const POINTS: usize = 1600;
/// Plots in one figure.
const ROWS: usize = 4;
/// Pixels of a PNG per unit: 300 an inch in one column.
const PNG_SCALE: f32 = 300.0 * 3.5 / WIDTH as f32;

/// Writes all figures of a run into `folder` and returns their files. `mark` is part of the names; empty for none.
///
/// # Errors
/// [`Failure::System`] if a file cannot be written.
pub(crate) fn write(
    subject: &Subject,
    folder: &Path,
    mark: &str,
    format: FigureFormat,
) -> Result<Vec<PathBuf>, Failure> {
    std::fs::create_dir_all(folder).map_err(Failure::system(format!("create the folder {}", folder.display())))?;
    let prefix = prefix(subject, mark);
    let mut written = Vec::new();
    let mut store = |name: &str, mut scene: Scene| {
        let path = folder.join(format!("{prefix}-{name}.{}", ending(format)));
        let bytes = match format {
            FigureFormat::Svg => Ok(SvgBackend::new().render_scene(&scene).into_bytes()),
            FigureFormat::Png => {
                pixels::prepare(&mut scene);
                PngBackend::new().with_scale(PNG_SCALE).render_scene(&scene)
            }
        };
        let bytes = bytes.map_err(std::io::Error::other);
        let done = bytes.and_then(|bytes| std::fs::write(&path, bytes));
        done.map_err(Failure::system(format!("write the figure {}", path.display())))?;
        written.push(path);
        Ok::<(), Failure>(())
    };
    if let Some(scene) = trajectories::draw(subject) {
        store("trajectories", scene)?;
    }
    let grid = Grid::new(subject.samples(), POINTS);
    let times: Vec<f64> = grid.points().iter().map(|&sample| subject.time(sample)).collect();
    for panel in panels(subject, &grid).iter().filter(|panel| panel.kind == Kind::Lines && panel.id != "other-signals")
    {
        for (name, views) in pages(panel) {
            store(&name, draw(subject, views, &times))?;
        }
    }
    Ok(written)
}

fn ending(format: FigureFormat) -> &'static str {
    match format {
        FigureFormat::Svg => "svg",
        FigureFormat::Png => "png",
    }
}

/// `ch7-2` for what belongs to section 7.2 of the thesis, else the name of the scenario or of the file.
fn prefix(subject: &Subject, mark: &str) -> String {
    let thesis = subject.scenario.as_ref().map(|scenario| scenario.thesis.as_str()).filter(|text| !text.is_empty());
    let plain = |text: &str| -> String {
        text.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' }).collect()
    };
    let first = match (thesis, &subject.scenario) {
        (Some(section), _) => format!("ch{}", plain(section)),
        (None, Some(scenario)) => scenario.name.clone(),
        (None, None) => subject.stem(),
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
fn draw(subject: &Subject, views: &[View], times: &[f64]) -> Scene {
    let plots: Vec<Vec<Plot>> =
        views.iter().map(|view| view.curves.iter().map(|curve| line(view, curve, times)).collect()).collect();
    let last = views.len() - 1;
    let layouts = views.iter().zip(&plots).enumerate().map(|(row, (view, plots))| {
        let unit = view.unit.replace("^2", "\u{b2}");
        let layout = style::apply(Layout::auto_from_plots(plots))
            .with_title(view.name.as_str())
            .with_y_label(if unit.is_empty() { view.axis.clone() } else { format!("{} [{unit}]", view.axis) })
            .with_x_axis_min(times[0])
            .with_x_axis_max(times[times.len() - 1]);
        let [left, right, top, bottom] = MARGINS;
        let layout = layout.with_force_margins(left, right);
        let layout = if row == last {
            layout.with_x_label("time [s]").with_force_margins_y(top, bottom + TIME_LABEL)
        } else {
            layout.with_force_margins_y(top, bottom)
        };
        let layout = if is_logarithmic(view) { layout.with_log_y() } else { layout };
        let layout = match limited_range(view) {
            Some([low, high]) => layout.with_y_axis_min(low).with_y_axis_max(high),
            None => layout,
        };
        view.limits.iter().fold(layout, |layout, limit| {
            layout.with_reference_line(ReferenceLine::horizontal(limit.value).with_color("#000000"))
        })
    });
    let mut scene = Figure::new(views.len(), 1)
        .with_layouts(layouts.collect())
        .with_plots(plots)
        .with_cell_size(WIDTH, HEIGHT)
        .with_row_height(last, HEIGHT + TIME_LABEL)
        .with_spacing(0.0)
        .with_padding(0.0)
        .render();
    let second = views.iter().flat_map(|view| &view.curves).find(|curve| curve.second);
    style::add_legend(&mut scene, subject, second.map(|curve| curve.label.as_str()));
    scene
}

/// Whether a logarithmic scale is wanted and has anything to show.
fn is_logarithmic(view: &View) -> bool {
    view.logarithmic && view.curves.iter().flat_map(|curve| &curve.values).any(|value| *value > 0.0)
}

/// The range of what is subject to limits, limits included. What was asked for may exceed it by far, and is cut off there.
fn limited_range(view: &View) -> Option<[f64; 2]> {
    if !view.curves.iter().any(|curve| curve.second) || view.limits.is_empty() {
        return None;
    }
    let acting = view.curves.iter().filter(|curve| !curve.second).flat_map(|curve| curve.values.iter().copied());
    let values = acting.chain(view.limits.iter().map(|limit| limit.value)).filter(|value| value.is_finite());
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), value| (a.min(value), b.max(value)));
    let room = 0.15 * (high - low);
    (low < high).then_some([low - room, high + room])
}

fn line(view: &View, curve: &Curve, times: &[f64]) -> Plot {
    // A logarithmic scale has no place for zero.
    let drawable = |value: f64| value.is_finite() && !(is_logarithmic(view) && value <= 0.0);
    let points = times.iter().zip(&curve.values).filter(|(_, value)| drawable(**value));
    let plot = LinePlot::new()
        .with_data(points.map(|(time, value)| (*time, *value)))
        .with_color(style::colour(curve.agent))
        .with_line_style(if curve.second { style::second() } else { style::dashes(curve.agent) })
        .with_stroke_width(1.1);
    Plot::Line(plot)
}

//! Where the agents went: seen from above, and for vehicles in space from the side as well.

use kuva::plot::scatter::MarkerShape;
use kuva::plot::{LinePlot, LineStyle, ScatterPlot};
use kuva::render::figure::Figure;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::Scene;

use super::{WIDTH, style};
use crate::show::view::{Grid, LoggedRun};

/// Points of a trajectory.
const POINTS: usize = 1200;
/// Corners of a circle.
const CORNERS: usize = 64;

/// The figure; `None` if there are no positions.
pub(super) fn draw(run: &LoggedRun) -> Option<Scene> {
    let grid = Grid::new(run.samples(), POINTS);
    let mut above = plane(run, &grid, [0, 1]);
    above.extend(obstacles(run));
    if above.is_empty() {
        return None;
    }
    let layout =
        |plots: &[Plot], x: &str, y: &str| style::apply(Layout::auto_from_plots(plots)).with_x_label(x).with_y_label(y);
    let top = layout(&above, "x [m]", "y [m]").with_equal_aspect();
    let figure = if run.is_planar() {
        Figure::new(1, 1).with_layouts(vec![top]).with_plots(vec![above]).with_cell_size(WIDTH, WIDTH * 0.9)
    } else {
        let side = plane(run, &grid, [0, 2]);
        let layouts = vec![top.with_title("from above"), layout(&side, "x [m]", "z [m]").with_title("from the side")];
        Figure::new(2, 1)
            .with_layouts(layouts)
            .with_plots(vec![above, side])
            .with_cell_size(WIDTH, WIDTH * 0.8)
            .with_row_height(1, WIDTH * 0.6)
    };
    let mut scene = figure.with_spacing(4.0).with_padding(0.0).render();
    style::add_legend(&mut scene, &style::agents(run));
    Some(scene)
}

/// Paths, beginnings (open circles) and ends (full circles), projected onto two coordinates.
fn plane(run: &LoggedRun, grid: &Grid, [x, y]: [usize; 2]) -> Vec<Plot> {
    let mut plots = Vec::new();
    for place in 0..run.agents.len() {
        let Some(series) = run.signal(place, "state", "position").filter(|series| series.width() > y) else {
            continue;
        };
        let colour = style::colour(Some(place));
        let point = |sample: usize| (series.row(sample)[x], series.row(sample)[y]);
        let path = LinePlot::new()
            .with_data(grid.points().iter().map(|&sample| point(sample)))
            .with_color(colour)
            .with_line_style(style::dashes(Some(place)))
            .with_stroke_width(1.1);
        let mark = |sample: usize, size: f64, colour: &str| {
            let marker = ScatterPlot::new().with_data([point(sample)]).with_color(colour).with_size(size);
            Plot::Scatter(marker.with_marker(MarkerShape::Circle).with_marker_stroke_width(0.8))
        };
        plots.push(Plot::Line(path));
        plots.push(mark(0, 3.0, colour));
        plots.push(mark(0, 1.8, "white"));
        plots.push(mark(run.samples() - 1, 3.4, colour));
    }
    plots
}

/// Obstacles, and the boundaries around them for the largest agent.
fn obstacles(run: &LoggedRun) -> Vec<Plot> {
    let largest = (0..run.agents.len()).filter_map(|place| run.radius(place)).fold(0.0, f64::max);
    let circle = |centre: [f64; 2], radius: f64, style: LineStyle| {
        let corner = |k: usize| {
            let angle = std::f64::consts::TAU * k as f64 / CORNERS as f64;
            (centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin())
        };
        let plot = LinePlot::new().with_data((0..=CORNERS).map(corner)).with_color("#444444");
        Plot::Line(plot.with_line_style(style).with_stroke_width(0.9))
    };
    let mut plots = Vec::new();
    for obstacle in run.obstacles() {
        plots.push(circle(obstacle.centre, obstacle.radius, LineStyle::Solid));
        if let Some([inner, outer]) = obstacle.boundaries(largest) {
            plots.push(circle(obstacle.centre, inner, LineStyle::Custom("5 2".into())));
            plots.push(circle(obstacle.centre, outer, LineStyle::Custom("1.5 2".into())));
        }
    }
    plots
}

//! Where the agents went: the top view, and for vehicles in space a side view as well.

use super::picture::Label;
use super::sheet::{Line, Plot, Proportions, Sheet};
use super::style::{self, Entry, Sample, Style};
use crate::show::view::{Grid, LoggedRun};

/// Points of a trajectory.
const POINTS: usize = 1200;
/// Corners of a circle.
const CORNERS: usize = 64;

/// The figure; `None` if there are no positions.
pub(super) fn sheet(run: &LoggedRun) -> Option<Sheet> {
    let grid = Grid::new(run.samples(), POINTS);
    let mut above = plane(run, &grid, [0, 1]);
    if above.is_empty() {
        return None;
    }
    above.extend(obstacles(run));
    let plot = |lines: Vec<Line>, title: &str, y: &str, proportions: Proportions| Plot {
        title: Label::tex(title).unwrap_or_default(),
        x_label: Label::tex("$x$ [m]").unwrap_or_default(),
        y_label: Label::tex(y).unwrap_or_default(),
        lines,
        proportions,
        ..Plot::default()
    };
    let rows = if run.is_planar() {
        vec![vec![plot(above, "", "$y$ [m]", Proportions::Equal)]]
    } else {
        let side = plane(run, &grid, [0, 2]);
        vec![
            vec![plot(above, "top view", "$y$ [m]", Proportions::Equal)],
            vec![plot(side, "side view", "$z$ [m]", Proportions::Equal)],
        ]
    };
    let mut legend = style::agents(run);
    legend.push(Entry { name: Label::plain("start"), sample: Sample::Start });
    legend.push(Entry { name: Label::plain("end"), sample: Sample::End });
    Some(Sheet { rows, legend, note: String::new() })
}

/// Paths, projected onto two coordinates.
fn plane(run: &LoggedRun, grid: &Grid, [x, y]: [usize; 2]) -> Vec<Line> {
    let path = |place: usize| {
        let series = run.signal(place, "state", "position").filter(|series| series.width() > y)?;
        let point = |&sample: &usize| (series.row(sample)[x], series.row(sample)[y]);
        let points = grid.points().iter().map(point).collect();
        Some(Line { points, style: Style::at(place), cut_off: false, ends: true })
    };
    (0..run.agents.len()).filter_map(path).collect()
}

/// Obstacles, and the boundaries around them for the largest agent.
fn obstacles(run: &LoggedRun) -> Vec<Line> {
    let largest = (0..run.agents.len()).filter_map(|place| run.radius(place)).fold(0.0, f64::max);
    let circle = |centre: [f64; 2], radius: f64, dashes: &'static [f64]| {
        let corner = |k: usize| {
            let angle = std::f64::consts::TAU * k as f64 / CORNERS as f64;
            (centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin())
        };
        let style = Style { colour: [0x44; 3], dashes, marker: None };
        Line { points: (0..=CORNERS).map(corner).collect(), style, cut_off: false, ends: false }
    };
    let mut lines = Vec::new();
    for obstacle in run.obstacles() {
        lines.push(circle(obstacle.centre, obstacle.radius, &[]));
        if let Some([inner, outer]) = obstacle.boundaries(largest) {
            lines.push(circle(obstacle.centre, inner, &[3.5, 1.5]));
            lines.push(circle(obstacle.centre, outer, &[1.0, 1.5]));
        }
    }
    lines
}

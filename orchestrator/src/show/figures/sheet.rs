//! Plots over time in rows and columns, with one legend below all of them.

use std::sync::Arc;

use kuva::TickFormat;
use kuva::plot::{LinePlot, LineStyle};
use kuva::render::annotations::ReferenceLine;
use kuva::render::figure::Figure;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot as Drawn;
use kuva::render::render::Scene;

use super::style::{self, Entry};

/// Height of one plot.
const HEIGHT: f64 = 144.0;
/// Height of a plot that stands alone.
const LONE_HEIGHT: f64 = 190.0;
/// Height of one plot of many.
const LOW_HEIGHT: f64 = 104.0;
/// Rows from which on plots are lower.
const MANY_ROWS: usize = 5;
/// Space around a plot: left, right, above, below. The same for all, so that the time axes lie above each other.
const MARGINS: [f64; 4] = [56.0, 12.0, 24.0, 20.0];
/// What the name of the time takes below the last plot.
const TIME_LABEL: f64 = 16.0;
/// A curve that touches zero for an instant must not squeeze all others: so large a part of all values may lie below the axis.
const BELOW: f64 = 0.004;

/// A line in a plot.
pub(super) struct Line {
    /// Times, s, and values.
    pub(super) points: Vec<(f64, f64)>,
    pub(super) colour: &'static str,
    pub(super) dashes: LineStyle,
    /// Whether what others do decides the range, as this line may exceed it by far.
    pub(super) cut_off: bool,
}

/// One plot.
#[derive(Default)]
pub(super) struct Plot {
    pub(super) title: String,
    /// What stands at the vertical axis.
    pub(super) label: String,
    pub(super) logarithmic: bool,
    pub(super) lines: Vec<Line>,
    /// Horizontal lines.
    pub(super) limits: Vec<f64>,
    /// Numbers of agents that have a row each, the first one at the height -1, the next at -2, ...; empty if there are no rows.
    pub(super) rows: Vec<u32>,
}

impl Plot {
    fn values(&self) -> impl Iterator<Item = f64> {
        self.lines.iter().flat_map(|line| &line.points).map(|(_, value)| *value).filter(|value| value.is_finite())
    }

    /// Whether a logarithmic scale is wanted and has anything to show.
    fn is_logarithmic(&self) -> bool {
        self.logarithmic && self.values().any(|value| value > 0.0)
    }

    /// The range of the vertical axis, where it is not simply that of all values.
    fn range(&self) -> Option<[f64; 2]> {
        if self.is_logarithmic() {
            let mut values: Vec<f64> = self.values().filter(|value| *value > 0.0).collect();
            values.sort_by(f64::total_cmp);
            let low = values[0].max(values[(values.len() as f64 * BELOW) as usize] / 2.0);
            return Some([low, values[values.len() - 1]]);
        }
        if !self.lines.iter().any(|line| line.cut_off) || self.limits.is_empty() {
            return None;
        }
        // What was asked for may exceed the limits by far.
        let acting = self.lines.iter().filter(|line| !line.cut_off).flat_map(|line| &line.points);
        let values =
            acting.map(|(_, value)| *value).chain(self.limits.iter().copied()).filter(|value| value.is_finite());
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), value| (a.min(value), b.max(value)));
        let room = 0.15 * (high - low);
        (low < high).then_some([low - room, high + room])
    }

    fn drawn(&self) -> Vec<Drawn> {
        let logarithmic = self.is_logarithmic();
        let low = self.range().map_or(f64::NEG_INFINITY, |[low, _]| low);
        let line = |line: &Line| {
            // A logarithmic scale has no place for zero.
            let point = |&(time, value): &(f64, f64)| match logarithmic {
                true => (value > 0.0).then(|| (time, value.max(low / 10.0))),
                false => value.is_finite().then_some((time, value)),
            };
            let plot = LinePlot::new()
                .with_data(line.points.iter().filter_map(point))
                .with_color(line.colour)
                .with_line_style(line.dashes.clone())
                .with_stroke_width(1.1);
            Drawn::Line(plot)
        };
        self.lines.iter().map(line).collect()
    }
}

/// Rows of plots over `span` in s, `width` wide, with a legend.
pub(super) fn draw(rows: Vec<Vec<Plot>>, span: [f64; 2], width: f64, legend: &[Entry]) -> Scene {
    let (count, columns) = (rows.len(), rows.iter().map(Vec::len).max().unwrap_or(1));
    let height = match count {
        1 => LONE_HEIGHT,
        _ if count >= MANY_ROWS => LOW_HEIGHT,
        _ => HEIGHT,
    };
    let (mut layouts, mut plots) = (Vec::new(), Vec::new());
    for (row, cells) in rows.iter().enumerate() {
        for plot in cells {
            let drawn = plot.drawn();
            layouts.push(layout(plot, &drawn, span, row + 1 == count));
            plots.push(drawn);
        }
    }
    let mut scene = Figure::new(count, columns)
        .with_layouts(layouts)
        .with_plots(plots)
        .with_cell_size(width / columns as f64, height)
        .with_row_height(count - 1, height + TIME_LABEL)
        .with_spacing(0.0)
        .with_padding(0.0)
        .render();
    style::add_legend(&mut scene, legend);
    scene
}

fn layout(plot: &Plot, drawn: &[Drawn], [start, end]: [f64; 2], last: bool) -> Layout {
    let layout = style::apply(Layout::auto_from_plots(drawn))
        .with_title(plot.title.as_str())
        .with_y_label(plot.label.as_str())
        .with_x_axis_min(start)
        .with_x_axis_max(end);
    let [left, right, top, bottom] = MARGINS;
    let layout = layout.with_force_margins(left, right);
    let layout = if last {
        layout.with_x_label("time [s]").with_force_margins_y(top, bottom + TIME_LABEL)
    } else {
        layout.with_force_margins_y(top, bottom)
    };
    let layout = match plot.is_logarithmic() {
        true => {
            let decades = plot.range().map_or(1.0, |[low, high]| (high / low).log10());
            let named = move |value: f64| if sparse(value, decades) { String::new() } else { power(value) };
            layout.with_log_y().with_y_tick_format(TickFormat::Custom(Arc::new(named)))
        }
        false => layout,
    };
    let layout = match plot.range() {
        Some([low, high]) => layout.with_y_axis_min(low).with_y_axis_max(high),
        None => layout,
    };
    let layout = if plot.rows.is_empty() { layout } else { rows(layout, plot.rows.clone()) };
    plot.limits.iter().fold(layout, |layout, limit| {
        layout.with_reference_line(ReferenceLine::horizontal(*limit).with_color("#000000"))
    })
}

/// A row for each of these agents instead of numbers at the vertical axis.
fn rows(layout: Layout, agents: Vec<u32>) -> Layout {
    let low = -(agents.len() as f64) - 0.3;
    let name = move |height: f64| {
        let row = (-height).round() as usize;
        agents.get(row.wrapping_sub(1)).map(u32::to_string).unwrap_or_default()
    };
    let named = layout.with_y_tick_format(TickFormat::Custom(Arc::new(name))).with_y_tick_step(1.0);
    named.with_y_axis_min(low).with_y_axis_max(0.0)
}

/// A number at a logarithmic axis: `10⁻³`, but `0.1`, `1`, `10` as they are.
fn power(value: f64) -> String {
    let exponent = value.log10().round();
    let is_power = (value.log10() - exponent).abs() < 1e-6;
    if !is_power || exponent.abs() <= 1.0 {
        return format!("{value}");
    }
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raised = format!("{exponent}")
        .chars()
        .map(|c| c.to_digit(10).map_or('⁻', |digit| DIGITS[digit as usize]))
        .collect::<String>();
    format!("10{raised}")
}

/// Whether there is no room for the name of this value, where so many decades stand above each other.
fn sparse(value: f64, decades: f64) -> bool {
    const NAMES: f64 = 6.0;
    let stride = (decades / NAMES).ceil().max(1.0);
    stride > 1.0 && value.log10().round().rem_euclid(stride) != 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_are_written_as_powers() {
        assert_eq!([1e-12, 1e-3, 0.1, 1.0, 10.0, 1e4].map(power), ["10⁻¹²", "10⁻³", "0.1", "1", "10", "10⁴"]);
        assert_eq!(power(0.5), "0.5");
        assert!(!sparse(1e-3, 5.0) && sparse(1e-3, 11.0) && !sparse(1e-4, 11.0));
    }

    #[test]
    fn an_instant_at_zero_does_not_squeeze_the_rest() {
        let line = |points| Line { points, colour: "#000000", dashes: LineStyle::Solid, cut_off: false };
        let points = (0..1000).map(|k| (f64::from(k), if k == 500 { 1e-18 } else { 1.0 })).collect();
        let plot = Plot { logarithmic: true, lines: vec![line(points)], ..Plot::default() };
        assert_eq!(plot.range(), Some([0.5, 1.0]));
        let zero = Plot { logarithmic: true, lines: vec![line(vec![(0.0, 0.0)])], ..Plot::default() };
        assert!(!zero.is_logarithmic() && zero.range().is_none());
    }
}

//! What a figure shows: plots in rows and columns, with one legend below all of them.

use super::picture::Label;
use super::style::{Entry, Style};

/// A curve that touches zero for an instant must not squeeze all others: so large a part of all values may lie below the axis.
const BELOW: f64 = 0.004;
/// Room between the curves and the frame, in parts of the range.
const ROOM: f64 = 0.06;

/// A line in a plot.
#[derive(Clone, Debug)]
pub(super) struct Line {
    /// Values of the horizontal and of the vertical axis.
    pub(super) points: Vec<(f64, f64)>,
    pub(super) style: Style,
    /// Whether what others do decides the range, as this line may exceed it by far.
    pub(super) cut_off: bool,
    /// Whether its beginning and its end are marked.
    pub(super) ends: bool,
}

/// The proportions of a plot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Proportions {
    /// As it fits.
    #[default]
    Free,
    /// A metre is as long to the right as upwards.
    Equal,
}

/// One plot.
#[derive(Clone, Debug, Default)]
pub(super) struct Plot {
    pub(super) title: Label,
    /// What stands at the horizontal axis.
    pub(super) x_label: Label,
    /// What stands at the vertical axis.
    pub(super) y_label: Label,
    /// Where the horizontal axis begins and ends, if not where the curves do.
    pub(super) span: Option<[f64; 2]>,
    pub(super) logarithmic: bool,
    pub(super) lines: Vec<Line>,
    /// Horizontal lines.
    pub(super) limits: Vec<f64>,
    /// Numbers of agents that have a row each, the first one at the height -1, the next at -2, ...; empty if there are no rows.
    pub(super) rows: Vec<u32>,
    pub(super) proportions: Proportions,
}

/// A figure.
#[derive(Clone, Debug, Default)]
pub(super) struct Sheet {
    pub(super) rows: Vec<Vec<Plot>>,
    pub(super) legend: Vec<Entry>,
    /// What has to be known about the figure, above everything else.
    pub(super) note: String,
}

impl Sheet {
    /// Rows of plots over the same time, `span` in s.
    pub(super) fn over_time(mut rows: Vec<Vec<Plot>>, span: [f64; 2], legend: Vec<Entry>) -> Self {
        for plot in rows.iter_mut().flatten() {
            plot.span = Some(span);
            plot.x_label = Label::plain("time [s]");
        }
        Self { rows, legend, note: String::new() }
    }

    /// Whether all plots of a column have the same horizontal axis, which is then named once.
    pub(super) fn shares_axis(&self) -> bool {
        let mut plots = self.rows.iter().flatten();
        let first = plots.next().and_then(|plot| plot.span);
        first.is_some() && plots.all(|plot| plot.span == first)
    }

    pub(super) fn columns(&self) -> usize {
        self.rows.iter().map(Vec::len).max().unwrap_or(1)
    }
}

impl Plot {
    fn values(&self) -> impl Iterator<Item = f64> {
        self.lines.iter().flat_map(|line| &line.points).map(|(_, value)| *value).filter(|value| value.is_finite())
    }

    /// Whether a logarithmic scale is wanted and has anything to show.
    pub(super) fn is_logarithmic(&self) -> bool {
        self.logarithmic && self.values().any(|value| value > 0.0)
    }

    /// The range of the horizontal axis.
    pub(super) fn x_range(&self) -> [f64; 2] {
        let all = self.lines.iter().flat_map(|line| &line.points).map(|(x, _)| *x);
        self.span.unwrap_or_else(|| roomy(extent(all).unwrap_or([0.0, 1.0])))
    }

    /// The range of the vertical axis; a logarithmic one begins and ends at decades.
    pub(super) fn y_range(&self) -> [f64; 2] {
        if !self.rows.is_empty() {
            return [-(self.rows.len() as f64) - 0.4, 0.0];
        }
        if self.is_logarithmic() {
            let mut values: Vec<f64> = self.values().filter(|value| *value > 0.0).collect();
            values.sort_by(f64::total_cmp);
            let low = values[0].max(values[(values.len() as f64 * BELOW) as usize] / 2.0);
            return decades([low, values[values.len() - 1]]);
        }
        // What was demanded may exceed the limits by far.
        let acting = self.lines.iter().filter(|line| !line.cut_off).flat_map(|line| &line.points);
        let values = acting.map(|(_, value)| *value).chain(self.limits.iter().copied());
        roomy(extent(values).unwrap_or([0.0, 1.0]))
    }
}

/// The smallest and the largest of some values.
fn extent(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    (low <= high).then_some([low, high])
}

fn roomy([low, high]: [f64; 2]) -> [f64; 2] {
    // A constant is a line in the middle.
    let least = 0.1 * low.abs().max(high.abs());
    let room = if high - low > 1e-9 * least {
        ROOM * (high - low)
    } else if least > 0.0 {
        least
    } else {
        1.0
    };
    [low - room, high + room]
}

/// The decades around a range, at least one.
fn decades([low, high]: [f64; 2]) -> [f64; 2] {
    let first = (low.log10() + 1e-9).floor() as i32;
    let last = ((high.log10() - 1e-9).ceil() as i32).max(first + 1);
    [10_f64.powi(first), 10_f64.powi(last)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(points: Vec<(f64, f64)>, logarithmic: bool) -> Plot {
        let line = Line { points, style: Style::BLACK, cut_off: false, ends: false };
        Plot { logarithmic, lines: vec![line], ..Plot::default() }
    }

    #[test]
    fn logarithmic_ranges_end_at_decades() {
        assert_eq!(plot(vec![(0.0, 8e-4), (1.0, 7.0)], true).y_range(), [1e-4, 10.0]);
        assert_eq!(plot(vec![(0.0, 0.01), (1.0, 10.0)], true).y_range(), [0.01, 10.0]);
        assert_eq!(plot(vec![(0.0, 1.0)], true).y_range(), [1.0, 10.0]);
    }

    #[test]
    fn an_instant_at_zero_does_not_squeeze_the_rest() {
        let points = (0..1000).map(|k| (f64::from(k), if k == 500 { 1e-18 } else { 1.0 })).collect();
        assert_eq!(plot(points, true).y_range(), [0.1, 1.0]);
        assert!(!plot(vec![(0.0, 0.0)], true).is_logarithmic());
    }

    #[test]
    fn curves_do_not_touch_the_frame() {
        assert_eq!(plot(vec![(0.0, 0.0), (1.0, 100.0)], false).y_range(), [-6.0, 106.0]);
        assert_eq!(plot(vec![(0.0, 0.0)], false).y_range(), [-1.0, 1.0]);
        let [low, high] = plot(vec![(0.0, 2.0)], false).y_range();
        assert!(low < 2.0 && high > 2.0);
    }
}

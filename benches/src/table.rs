//! The table that is printed.

use std::fmt::Write;

/// What a figure has to keep.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Bound {
    /// At most so many times the yardstick.
    Times(f64),
    /// At least so many steps per second.
    Rate(f64),
    /// At most so many seconds.
    Seconds(f64),
    /// At most so many bytes; the figure is bytes.
    Bytes(f64),
    /// The cost per participant, in that of six agents, and what it may be at most.
    Growth(f64, f64),
}

/// A measurement with its bound.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    what: &'static str,
    figure: f64,
    yardstick: Option<f64>,
    bound: Bound,
}

impl Row {
    pub(crate) fn new(what: &'static str, figure: f64, yardstick: Option<f64>, bound: Bound) -> Self {
        Self { what, figure, yardstick, bound }
    }

    fn ratio(&self) -> Option<f64> {
        Some(self.figure / self.yardstick?)
    }

    fn ok(&self) -> bool {
        match self.bound {
            Bound::Times(most) => self.ratio().is_some_and(|ratio| ratio <= most),
            Bound::Rate(least) => 1.0 / self.figure >= least,
            Bound::Seconds(most) | Bound::Bytes(most) => self.figure <= most,
            Bound::Growth(grown, most) => grown <= most,
        }
    }
}

/// The rows, and below them what the columns mean.
pub(crate) fn table(rows: &[Row]) -> String {
    let mut text = format!(
        "{:<38} | {:>12} | {:>12} | {:>10} | {:>6} | {:<30} | ok\n",
        "what", "measured", "steps/s", "yardstick", "ratio", "bound"
    );
    for row in rows {
        let yardstick = row.yardstick.map_or(String::new(), |seconds| format!("{:.2} us", seconds * 1e6));
        let ratio = row.ratio().map_or(String::new(), |ratio| format!("{ratio:.2}"));
        let bound = match row.bound {
            Bound::Times(most) => format!("<= {most} x the yardstick"),
            Bound::Rate(least) => format!(">= {least} steps/s"),
            Bound::Seconds(most) => format!("<= {most} s"),
            Bound::Bytes(most) => format!("<= {} MB", most / 1e6),
            Bound::Growth(grown, most) => format!("per process {grown:.2} <= {most} x 6 agents"),
        };
        let (measured, rate) = match row.bound {
            Bound::Seconds(_) => (format!("{:.3} s", row.figure), String::new()),
            Bound::Bytes(_) => (format!("{:.2} MB", row.figure / 1e6), String::new()),
            _ => (format!("{:.3} us", row.figure * 1e6), format!("{:.0}", 1.0 / row.figure)),
        };
        let ok = if row.ok() { "yes" } else { "NO" };
        let _ = writeln!(
            text,
            "{:<38} | {measured:>12} | {rate:>12} | {yardstick:>10} | {ratio:>6} | {bound:<30} | {ok}",
            row.what
        );
    }
    text + "\nThe yardstick: a raw futex barrier with as many processes in the same phases, no sample, no bookkeeping.\n"
}

//! How far a run is: a bar on a terminal, a plain line now and then elsewhere. Always on stderr, and never waiting for it.

use std::io::{self, IsTerminal};
use std::time::{Duration, Instant};

use processes::console;

use crate::terminal::{is_ours, size_of};

/// Time between two plain lines.
const LINE_EVERY: Duration = Duration::from_secs(5);
/// Time between two looks of the bar.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// Columns of the bar.
const BAR: usize = 32;
/// Columns of a terminal that does not say how many it has.
const COLUMNS: usize = 80;

/// Shows the progress of a run.
pub(crate) struct Progress {
    display: Display,
    periods: u64,
    dt: f64,
    start: Instant,
    next_look: Instant,
}

enum Display {
    Silent,
    Lines,
    /// On a terminal, as long as the run is its foreground job.
    Bar,
}

impl Progress {
    /// Of a run of `periods` steps of `dt` seconds.
    pub(crate) fn new(shown: bool, periods: u64, dt: f64) -> Self {
        let start = Instant::now();
        let display = match (shown, io::stderr().is_terminal()) {
            (false, _) => Display::Silent,
            (true, false) => Display::Lines,
            (true, true) => Display::Bar,
        };
        let wait = if matches!(display, Display::Bar) { LOOK_EVERY } else { LINE_EVERY };
        Self { display, periods, dt, start, next_look: start + wait }
    }

    /// The run has done `step`.
    pub(crate) fn at(&mut self, step: u64) {
        if matches!(self.display, Display::Silent) {
            return;
        }
        let now = Instant::now();
        if now < self.next_look {
            return;
        }
        match self.display {
            Display::Silent => {}
            Display::Lines => {
                eprintln!("{}", self.text(step, now));
                self.next_look = now + LINE_EVERY;
            }
            Display::Bar => {
                if is_ours(io::stderr()) {
                    console::footer(&self.bar(step, now));
                } else {
                    console::leave_footer();
                }
                self.next_look = now + LOOK_EVERY;
            }
        }
    }

    /// Says something that happened, above the bar.
    pub(crate) fn say(&self, text: &str) {
        if !matches!(self.display, Display::Silent) {
            eprintln!("{text}");
        }
    }

    /// The run is over.
    pub(crate) fn finish(&self) {
        if matches!(self.display, Display::Bar) {
            console::footer("");
        }
    }

    /// The bar and its text, on one line of the terminal.
    fn bar(&self, step: u64, now: Instant) -> String {
        let columns = size_of(io::stderr()).map_or(COLUMNS, |(columns, _)| columns);
        let full = (BAR as u64 * step / self.periods.max(1)) as usize;
        let bar: String = (0..BAR).map(|place| if place < full { '█' } else { '░' }).collect();
        let line: String = format!("{bar} {}", self.text(step, now)).chars().take(columns.saturating_sub(1)).collect();
        match line.char_indices().nth(BAR).filter(|_| std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()))
        {
            Some((end, _)) => format!("\x1b[36m{}\x1b[0m{}", &line[..end], &line[end..]),
            None => line,
        }
    }

    fn text(&self, step: u64, now: Instant) -> String {
        let wall = (now - self.start).as_secs_f64();
        let left = wall / step.max(1) as f64 * (self.periods - step) as f64;
        let (simulated, duration) = (step as f64 * self.dt, self.periods as f64 * self.dt);
        format!("t = {simulated:.2} of {duration:.0} s, {:.1} x real time, {left:.0} s left", simulated / wall)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_grows_with_the_run() {
        let progress = Progress::new(false, 100, 0.1);
        let now = progress.start + Duration::from_secs(5);
        let full = |step| progress.bar(step, now).matches('█').count();
        assert_eq!((full(0), full(50), full(100)), (0, BAR / 2, BAR));
        assert!(progress.bar(50, now).contains("t = 5.00 of 10 s, 1.0 x real time, 5 s left"));
    }
}

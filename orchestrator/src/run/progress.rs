//! How far a run is: a bar on a terminal, a plain line now and then elsewhere. Always on stderr.

use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use crate::terminal::plain;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Time between two plain lines.
const LINE_EVERY: Duration = Duration::from_secs(5);
/// Time between two looks of the bar.
const LOOK_EVERY: Duration = Duration::from_millis(100);

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
    Bar(ProgressBar),
}

impl Progress {
    /// Of a run of `periods` steps of `dt` seconds.
    pub(crate) fn new(shown: bool, periods: u64, dt: f64) -> Self {
        let start = Instant::now();
        let display = match (shown, std::io::stderr().is_terminal()) {
            (false, _) => Display::Silent,
            (true, false) => Display::Lines,
            (true, true) => {
                let bar = ProgressBar::with_draw_target(Some(periods), ProgressDrawTarget::stderr_with_hz(10));
                if let Ok(style) = ProgressStyle::with_template("{bar:32.cyan/dim} {msg}") {
                    bar.set_style(style);
                }
                Display::Bar(bar)
            }
        };
        let wait = if matches!(display, Display::Bar(_)) { LOOK_EVERY } else { LINE_EVERY };
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
        let text = self.text(step, now);
        match &self.display {
            Display::Silent => {}
            Display::Lines => {
                // A run goes on when nobody reads of it any more.
                let _ = writeln!(std::io::stderr(), "{text}");
                self.next_look = now + LINE_EVERY;
            }
            Display::Bar(bar) => {
                bar.set_position(step);
                bar.set_message(text);
                self.next_look = now + LOOK_EVERY;
            }
        }
    }

    /// Says something that happened, above the bar.
    pub(crate) fn say(&self, text: &str) {
        match &self.display {
            Display::Silent => {}
            Display::Lines => eprintln!("{text}"),
            Display::Bar(bar) => bar.println(plain(text)),
        }
    }

    /// The run is over.
    pub(crate) fn finish(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.finish_and_clear();
        }
    }

    fn text(&self, step: u64, now: Instant) -> String {
        let wall = (now - self.start).as_secs_f64();
        let left = wall / step.max(1) as f64 * (self.periods - step) as f64;
        let (simulated, duration) = (step as f64 * self.dt, self.periods as f64 * self.dt);
        format!("t = {simulated:.2} of {duration:.0} s, {:.1} x real time, {left:.0} s left", simulated / wall)
    }
}

//! `phalanx top`.

use std::fmt::Write;
use std::io::IsTerminal;
use std::thread;

use clap::Args;

use super::arguments::{RunName, wait_time};
use super::select_run::choose;
use crate::failure::Failure;
use crate::run::control::{Request, Status, Unanswered, ask};

#[derive(Debug, Args)]
pub(crate) struct TopArgs {
    #[command(flatten)]
    pub(crate) run: RunName,
    /// Seconds between two looks
    #[arg(long, default_value = "1", value_parser = wait_time)]
    pub(crate) interval: f64,
    /// Print one look and end
    #[arg(long)]
    pub(crate) once: bool,
}

pub(crate) fn top(args: &TopArgs) -> Result<(), Failure> {
    let run = choose(args.run.name.as_deref())?;
    let mut before = ask(&run, &Request::Status)?;
    let clear = if std::io::stdout().is_terminal() && !args.once { "\x1b[H\x1b[J" } else { "" };
    loop {
        thread::sleep(lockstep::duration(args.interval));
        let now = match ask(&run, &Request::Status) {
            Ok(now) => now,
            Err(Unanswered::Over(_) | Unanswered::Closed(_)) => {
                println!("The run {run} is over.");
                return Ok(());
            }
            Err(error) => return Err(error.into()),
        };
        draw!("{clear}");
        println!("{}", table(&before, &now));
        if args.once {
            return Ok(());
        }
        before = now;
    }
}

/// What happened between two looks.
fn table(before: &Status, now: &Status) -> String {
    let (steps, wall) = (now.steps.saturating_sub(before.steps) as f64, (now.wall_s - before.wall_s).max(1e-9));
    let mut text = format!(
        "{}\n{:.0} steps/s, {:.2} x real time; waits for: {}\n\n{:<24} {:>12} {:>12} {:>12} {:>8}\n",
        now.sentence(),
        steps / wall,
        (now.time - before.time) / wall,
        now.awaited.join(", "),
        "participant",
        "compute",
        "wake-up",
        "waiting",
        "last"
    );
    for (old, new) in before.workers.iter().zip(&now.workers) {
        let per_step = |gain: f64| gain / steps.max(1.0) * 1e6;
        let runs = new.runs.saturating_sub(old.runs).max(1);
        let _ = writeln!(
            text,
            "{:<24} {:>9.2} us {:>9.2} us {:>9.2} us {:>6.1} %",
            new.name,
            per_step(new.compute_s - old.compute_s),
            per_step(new.waking_s - old.waking_s),
            per_step(new.waiting_s - old.waiting_s),
            100.0 * new.last.saturating_sub(old.last) as f64 / runs as f64
        );
    }
    text
}

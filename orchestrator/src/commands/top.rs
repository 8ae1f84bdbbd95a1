//! `phalanx top`.

use std::io::IsTerminal;
use std::thread;

use clap::Args;

use super::arguments::{RunName, wait_time};
use super::select_run::choose;
use crate::failure::Failure;
use crate::run::control::{Request, Status, Unanswered, ask};
use crate::run::profile::{LEGEND, Usage, usage_table};
use crate::terminal::{columns, wrapped};

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
        println!("{}", table(&before, &now, columns()));
        if args.once {
            return Ok(());
        }
        before = now;
    }
}

/// What happened between two looks, in so many columns.
fn table(before: &Status, now: &Status, columns: Option<usize>) -> String {
    let (steps, wall) = (now.steps.saturating_sub(before.steps) as f64, (now.wall_s - before.wall_s).max(1e-9));
    let rows = before.workers.iter().zip(&now.workers).map(|(old, new)| {
        let gains = [new.compute_s - old.compute_s, new.waking_s - old.waking_s, new.waiting_s - old.waiting_s];
        Usage {
            participant: new.name.clone(),
            per_step: gains.map(|gain| gain / steps.max(1.0) * 1e6),
            last: new.last.saturating_sub(old.last) as f64 / new.runs.saturating_sub(old.runs).max(1) as f64,
        }
    });
    let speed = format!("{:.0} steps/s, {:.2} x real time", steps / wall, (now.time - before.time) / wall);
    let head = format!("{}\n{speed}; waits for: {}", now.sentence(), now.awaited.join(", "));
    format!("{}\n\n{}\n{}", wrapped(&head, columns), usage_table(rows), wrapped(LEGEND, columns))
}

//! `phalanx top`.

use std::fmt::Write;
use std::io::IsTerminal;
use std::thread;
use std::time::Duration;

use serde_json::Value;

use super::ctl::sentence;
use super::select_run::{choose, tell};
use crate::cli::TopArgs;
use crate::failure::Failure;

pub(crate) fn top(args: &TopArgs) -> Result<(), Failure> {
    let run = choose(args.run.name.as_deref())?;
    let mut before = tell(&run, "status")?;
    let clear = if std::io::stdout().is_terminal() && !args.once { "\x1b[H\x1b[J" } else { "" };
    loop {
        thread::sleep(Duration::from_secs_f64(args.interval));
        let now = match tell(&run, "status") {
            Ok(now) => now,
            Err(Failure::System { .. }) => {
                println!("The run {run} is over.");
                return Ok(());
            }
            Err(failure) => return Err(failure),
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
fn table(before: &Value, now: &Value) -> String {
    let gain = |name: &str| now[name].as_f64().unwrap_or(0.0) - before[name].as_f64().unwrap_or(0.0);
    let (steps, wall) = (gain("steps"), gain("wall_s").max(1e-9));
    let awaited: Vec<&str> = now["awaited"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    let mut text = format!(
        "{}\n{:.0} steps/s, {:.2} x real time; waits for: {}\n\n{:<24} {:>12} {:>12} {:>12} {:>8}\n",
        sentence(now),
        steps / wall,
        gain("time") / wall,
        awaited.join(", "),
        "participant",
        "compute",
        "wake-up",
        "waiting",
        "last"
    );
    let workers = |status: &Value| status["workers"].as_array().cloned().unwrap_or_default();
    for (old, new) in workers(before).iter().zip(&workers(now)) {
        let gain = |name: &str| new[name].as_f64().unwrap_or(0.0) - old[name].as_f64().unwrap_or(0.0);
        let per_step = |name: &str| gain(name) / steps.max(1.0) * 1e6;
        let _ = writeln!(
            text,
            "{:<24} {:>9.2} us {:>9.2} us {:>9.2} us {:>6.1} %",
            new["name"].as_str().unwrap_or_default(),
            per_step("compute_s"),
            per_step("waking_s"),
            per_step("waiting_s"),
            100.0 * gain("last") / gain("runs").max(1.0)
        );
    }
    text
}

//! Where the time of a run went: as a table, and as a trace that opens in Perfetto.

use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::Path;
use std::time::Duration;

use lockstep::Plan;
use processes::{Snapshot, Statistics};

use crate::files::OutFile;

/// Last runs of every process that go into a trace.
pub const TRACED_RUNS: u32 = 2000;

/// The table of a run that took `wall` seconds.
pub fn table(snapshot: &Snapshot, wall: f64) -> String {
    let steps = snapshot.completed.max(1) as f64;
    let per_step = |time: Duration| time.as_secs_f64() / steps * 1e6;
    let width = snapshot.workers.iter().map(|worker| worker.name.len()).max().unwrap_or(0).max("participant".len());
    let mut text =
        format!("{:<width$}  {:>10}  {:>10}  {:>10}  {:>8}\n", "participant", "compute", "wake-up", "waiting", "last");
    for worker in &snapshot.workers {
        let last = 100.0 * worker.last as f64 / worker.runs.max(1) as f64;
        let _ = writeln!(
            text,
            "{:<width$}  {:>7.2} us  {:>7.2} us  {:>7.2} us  {last:>6.1} %",
            worker.name,
            per_step(worker.compute),
            per_step(worker.waking),
            per_step(worker.waiting),
        );
    }
    let phases: Vec<String> = snapshot.phases.iter().map(|phase| format!("{:.2}", per_step(phase.lasted))).collect();
    let path: f64 = snapshot.phases.iter().map(|phase| per_step(phase.lasted)).sum();
    let _ = writeln!(
        text,
        "\nper step: {:.2} us, of which {path:.2} us in its phases ({} us); the rest is between steps",
        wall / steps * 1e6,
        phases.join(" + ")
    );
    text.push_str(
        "compute: from its start to its arrival; wake-up: from the opening of its gate to its start; last: how often the\n\
         others waited for it. Times of processes that share a core include each other's.\n",
    );
    text
}

/// Writes the last runs of every process as Chrome trace events.
///
/// # Errors
/// If the file cannot be written.
pub fn write_trace(path: &Path, statistics: &Statistics, plan: &Plan) -> io::Result<()> {
    let mut file = OutFile::create(path)?;
    write!(file, "{{\"displayTimeUnit\":\"ns\",\"traceEvents\":[")?;
    for (worker, plan) in plan.workers.iter().enumerate() {
        let comma = if worker == 0 { "" } else { "," };
        let name = format!("{{\"name\":\"{}\"}}", plan.name);
        write!(file, "{comma}\n{{\"ph\":\"M\",\"pid\":1,\"tid\":{worker},\"name\":\"thread_name\",\"args\":{name}}}")?;
    }
    for span in statistics.spans() {
        let (start, length) = (span.start.as_secs_f64() * 1e6, span.length.as_secs_f64() * 1e6);
        write!(
            file,
            ",\n{{\"ph\":\"X\",\"pid\":1,\"tid\":{},\"ts\":{start:.3},\"dur\":{length:.3},\"name\":\"step {}\",\
             \"args\":{{\"phase\":{}}}}}",
            span.worker, span.step, span.phase
        )?;
    }
    writeln!(file, "\n]}}")?;
    file.commit()
}

//! Where the time of a run went: as a table, and as a trace that opens in Perfetto.

use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::Path;
use std::time::Duration;

use lockstep::Plan;
use processes::{Snapshot, Statistics};

use crate::files::OutFile;
use crate::terminal::table::{Left, Right, Table};
use crate::terminal::{columns, wrapped};

/// Last runs of every process that go into a trace.
pub const TRACED_RUNS: u32 = 2000;

/// What the columns of the table mean.
pub(crate) const LEGEND: &str = "compute: from the start of a process to its arrival; wake-up: from the opening of its barrier to its \
    start; waiting: until the others have arrived; last: share of steps in which the others waited for it. Times of processes that \
    share a core include each other's.";

/// Where the time of one process went.
pub(crate) struct Usage {
    pub(crate) participant: String,
    /// Computing, waking up and waiting in a step, us.
    pub(crate) per_step: [f64; 3],
    /// In which share of its runs the others waited for it, 0 to 1.
    pub(crate) last: f64,
}

/// A line for each process.
pub(crate) fn usage_table(rows: impl Iterator<Item = Usage>) -> String {
    let head = [("participant", Left), ("compute", Right), ("wake-up", Right), ("waiting", Right), ("last", Right)];
    let mut table = Table::new(head);
    for Usage { participant, per_step, last } in rows {
        let [compute, waking, waiting] = per_step.map(|time| format!("{time:.2} us"));
        table.row([participant, compute, waking, waiting, format!("{:.1} %", 100.0 * last)]);
    }
    table.text(columns())
}

/// The table of a run that took `wall` seconds.
pub fn table(snapshot: &Snapshot, wall: f64) -> String {
    let steps = snapshot.completed.max(1) as f64;
    let per_step = |time: Duration| time.as_secs_f64() / steps * 1e6;
    let rows = snapshot.workers.iter().map(|worker| Usage {
        participant: worker.name.clone(),
        per_step: [worker.compute, worker.waking, worker.waiting].map(per_step),
        last: worker.last as f64 / worker.runs.max(1) as f64,
    });
    let mut text = usage_table(rows);
    let phases: Vec<String> = snapshot.phases.iter().map(|phase| format!("{:.2}", per_step(phase.lasted))).collect();
    let path: f64 = snapshot.phases.iter().map(|phase| per_step(phase.lasted)).sum();
    let _ = writeln!(
        text,
        "\nper step: {:.2} us, of which {path:.2} us in its phases ({} us); the rest is between steps",
        wall / steps * 1e6,
        phases.join(" + ")
    );
    let _ = writeln!(text, "{}", wrapped(LEGEND, columns()));
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

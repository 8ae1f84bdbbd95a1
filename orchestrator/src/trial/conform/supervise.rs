//! A process between the conductor and a tested program: it records how the program ends, how much it prints and which processes
//! it leaves behind.

use std::ffi::OsString;
use std::io::{self, PipeReader, Read, Write};
use std::path::Path;
use std::process::{Command, ExitCode, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, WaitId, WaitIdOptions};
use serde::{Deserialize, Serialize};

/// How long processes that the program has started may outlive it: they may be ending already.
const LAST_MOMENT: Duration = Duration::from_millis(500);
/// What is passed on of what the program prints, bytes.
const PASSED_ON: u64 = 1 << 16;

/// How a program ended.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct End {
    /// Why it could not be started.
    pub(super) not_started: Option<String>,
    /// The exit code that it returned.
    pub(super) code: Option<i32>,
    /// The signal that ended it.
    pub(super) signal: Option<i32>,
    /// How many processes it left behind.
    pub(super) left: usize,
    /// How much it printed, bytes.
    pub(super) printed: u64,
}

impl End {
    pub(super) fn of(status: ExitStatus) -> Self {
        use std::os::unix::process::ExitStatusExt;
        Self { code: status.code(), signal: status.signal(), ..Self::default() }
    }

    /// In words.
    pub(super) fn describe(&self) -> String {
        match (&self.not_started, self.code, self.signal) {
            (Some(reason), ..) => format!("it cannot be started: {reason}"),
            (_, Some(code), _) => format!("it ended with exit code {code}"),
            (_, _, Some(signal)) => format!("it was killed by signal {signal}"),
            _ => "it is not known how it ended".into(),
        }
    }

    /// Reads what [`supervise`] wrote; `None` if it has not written yet.
    pub(super) fn read(path: &Path) -> Option<Self> {
        serde_json::from_slice(&std::fs::read(path).ok()?).ok()
    }

    fn write(&self, path: &Path) -> io::Result<()> {
        let draft = path.with_extension("draft");
        std::fs::write(&draft, serde_json::to_vec(self)?)?;
        std::fs::rename(draft, path)
    }
}

/// Runs a command, and writes into the file `status` how it ended. Its exit code is that of the command.
pub fn supervise(status: &Path, command: &[OsString]) -> ExitCode {
    match watch(command).and_then(|end| end.write(status).map(|()| end)) {
        Ok(End { code: Some(code), .. }) => ExitCode::from(code as u8),
        Ok(End { signal: Some(signal), .. }) => ExitCode::from(128 + signal as u8),
        Ok(_) => ExitCode::from(127),
        Err(error) => {
            eprintln!("cannot supervise: {error}");
            ExitCode::FAILURE
        }
    }
}

fn watch(command: &[OsString]) -> io::Result<End> {
    let Some((program, arguments)) = command.split_first() else { return Err(io::ErrorKind::InvalidInput.into()) };
    // A descendant that loses its parent becomes a child of this process, also in another process group or session.
    rustix::process::set_child_subreaper(rustix::process::Pid::from_raw(1))?;
    let (reader, writer) = io::pipe()?;
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null()).stdout(writer.try_clone()?).stderr(writer);
    let child = command.spawn();
    drop(command);
    let mut child = match child {
        Ok(child) => child,
        Err(error) => return Ok(End { not_started: Some(error.to_string()), ..End::default() }),
    };
    let printed = Arc::new(AtomicU64::new(0));
    let count = Arc::clone(&printed);
    let pump = thread::spawn(move || pass_on(reader, &count));
    let status = child.wait()?;
    let left = survivors();
    // All processes that held the other end of the pipe have ended.
    let _ = pump.join();
    Ok(End { left, printed: printed.load(Ordering::Relaxed), ..End::of(status) })
}

fn pass_on(mut reader: PipeReader, count: &AtomicU64) {
    let mut buffer = [0; 4096];
    while let Ok(read @ 1..) = reader.read(&mut buffer) {
        let before = count.fetch_add(read as u64, Ordering::Relaxed);
        if before < PASSED_ON {
            // If stderr is closed, the output is dropped.
            let _ = io::stderr().write_all(&buffer[..read]);
        }
    }
}

/// Ends what the program has left, and counts it.
fn survivors() -> usize {
    let start = Instant::now();
    let mut killed = Vec::new();
    loop {
        let any = WaitIdOptions::EXITED | WaitIdOptions::NOHANG;
        match rustix::process::waitid(WaitId::All, any) {
            // No process is left.
            Err(_) => return killed.len(),
            // One process has ended; others may have ended, too.
            Ok(Some(_)) => continue,
            Ok(None) => {}
        }
        if start.elapsed() >= LAST_MOMENT {
            for pid in children() {
                if !killed.contains(&pid) {
                    killed.push(pid);
                }
                // It may end by itself in this moment.
                let _ = rustix::process::kill_process(pid, Signal::KILL);
            }
        }
        thread::sleep(Duration::from_millis(5));
    }
}

/// The processes whose parent is this one.
fn children() -> Vec<Pid> {
    let me = std::process::id().to_string();
    let parent_is_me = |pid: &i32| {
        let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
        // The name in brackets may hold any character; the parent is the second word behind it.
        stat.rsplit(") ").next().and_then(|rest| rest.split(' ').nth(1)) == Some(me.as_str())
    };
    let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let pids = entries.filter_map(|entry| entry.file_name().to_str()?.parse::<i32>().ok());
    pids.filter(parent_is_me).filter_map(Pid::from_raw).collect()
}

//! A program that is started outside any run.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal};

use super::supervise::End;
use crate::failure::Failure;

/// The environment in which a conductor starts its workers.
const RUN_DIRECTORY: &str = "PHALANX_RUN_DIR";
const WORKER: &str = "PHALANX_WORKER";
const PAGE_FD: &str = "PHALANX_PAGE_FD";

/// Bytes that are read of the output of a program, of which the first line is shown.
const SHOWN: u64 = 1 << 16;

/// What a program does outside a run.
pub(super) struct StandaloneRun {
    /// How it ended; `None` if it did not.
    pub(super) end: Option<End>,
    /// How what it printed begins.
    pub(super) printed: String,
    /// How long it was waited for.
    lasted: Duration,
    /// Processor time that it used, if it had to be ended.
    computed: Duration,
}

impl StandaloneRun {
    /// Whether it refused in words, and ended by itself.
    pub(super) fn refused(&self) -> bool {
        let code = self.end.as_ref().and_then(|end| end.code);
        code.is_some_and(|code| code != 0) && !self.printed.trim().is_empty()
    }

    /// What it did, in words.
    pub(super) fn describe(&self) -> String {
        let first = self.printed.trim().lines().next().unwrap_or_default();
        match &self.end {
            None => format!(
                "it does not end; killed after {:.1} s, of which it computed for {:.1} s",
                self.lasted.as_secs_f64(),
                self.computed.as_secs_f64()
            ),
            Some(end) if first.is_empty() => format!("{}, without a word", end.describe()),
            Some(end) => format!("{}: \"{first}\"", end.describe()),
        }
    }
}

/// Starts `words` with the plan in `directory`, or without a plan, and waits for its end.
pub(super) fn run_standalone(
    words: &[String],
    directory: Option<&Path>,
    folder: &Path,
    patience: Duration,
) -> Result<StandaloneRun, Failure> {
    let path = folder.join("printed.txt");
    let failed = || Failure::system(format!("write {}", path.display()));
    let file = File::create(&path).map_err(failed())?;
    let mut command = Command::new(&words[0]);
    command.args(&words[1..]).stdin(Stdio::null()).stderr(file.try_clone().map_err(failed())?).stdout(file);
    match directory {
        // The shared page is the empty stdin: a program that maps it finds that it is not a page.
        Some(directory) => command.env(RUN_DIRECTORY, directory).env(WORKER, "0").env(PAGE_FD, "0"),
        None => command.env_remove(RUN_DIRECTORY).env_remove(WORKER).env_remove(PAGE_FD),
    };
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let mut child = match command.spawn() {
        Ok(child) => child,
        Err(error) => {
            let end = End { not_started: Some(error.to_string()), ..End::default() };
            return Ok(StandaloneRun {
                end: Some(end),
                printed: String::new(),
                lasted: Duration::ZERO,
                computed: Duration::ZERO,
            });
        }
    };
    let (pid, mut waiting) = (Pid::from_child(&child), Waiting::new(patience));
    let mut end = None;
    while end.is_none() && waiting.goes_on(&|| processor_time(child.id())) {
        thread::sleep(Duration::from_millis(5));
        end = child.try_wait().map_err(Failure::system("wait for a program"))?.map(End::of);
    }
    let lasted = waiting.start.elapsed();
    let mut computed = Duration::ZERO;
    if end.is_none() {
        computed = processor_time(child.id());
        // With all that it has started. Not reaped yet, so the number is still its own.
        let _ = rustix::process::kill_process_group(pid, Signal::KILL);
        child.wait().map_err(Failure::system("wait for a program"))?;
    }
    let mut printed = Vec::new();
    File::open(&path).and_then(|file| file.take(SHOWN).read_to_end(&mut printed)).map_err(failed())?;
    let printed = String::from_utf8_lossy(&printed).into_owned();
    Ok(StandaloneRun { end, printed, lasted, computed })
}

/// For how long a program is waited for: as long as it was said, and on a busy machine until it has computed for half of that, as
/// long as it computes at all.
struct Waiting {
    patience: Duration,
    start: Instant,
    /// When the processor time was looked at last, and what it was.
    seen: (Instant, Duration),
}

impl Waiting {
    /// Most multiples of the patience.
    const MOST: u32 = 6;
    /// How long a program may rest once the patience is over.
    const REST: Duration = Duration::from_secs(1);

    fn new(patience: Duration) -> Self {
        let start = Instant::now();
        Self { patience, start, seen: (start, Duration::ZERO) }
    }

    fn goes_on(&mut self, computed: &dyn Fn() -> Duration) -> bool {
        let lasted = self.start.elapsed();
        if lasted < self.patience {
            if self.seen.0.elapsed() >= Self::REST {
                self.seen = (Instant::now(), computed());
            }
            return true;
        }
        let now = computed();
        if now * 2 >= self.patience || lasted >= self.patience * Self::MOST {
            return false;
        }
        if self.seen.0.elapsed() < Self::REST {
            return true;
        }
        let before = std::mem::replace(&mut self.seen, (Instant::now(), now)).1;
        now > before
    }
}

/// What the kernel counts for a process; nothing if it does not tell.
fn processor_time(pid: u32) -> Duration {
    let text = std::fs::read_to_string(format!("/proc/{pid}/schedstat")).unwrap_or_default();
    Duration::from_nanos(text.split(' ').next().and_then(|word| word.parse().ok()).unwrap_or(0))
}

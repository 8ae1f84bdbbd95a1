//! The control socket of a run: one line of text in, one line of JSON out.

use std::fs::{self, Permissions};
use std::io::{self, BufRead, BufReader, Write};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use processes::Gauge;
use serde_json::{Value, json};

use super::Stop;
use crate::run::swap::Swap;

/// Its name in the run directory.
pub(crate) const SOCKET: &str = "control.sock";
/// Between the words of a swap and the folder that its names of files are meant in.
pub(crate) const FOLDER_MARK: char = '\t';
/// Longest command, bytes.
const LONGEST_LINE: u64 = 8192;
/// How long a client may take for its line.
const PATIENCE: Duration = Duration::from_secs(2);

/// How long a program may take to catch up with the run.
pub(crate) const SWAP_PATIENCE: Duration = Duration::from_secs(60);

/// What a status tells about the run besides its counters.
#[derive(Clone, Debug)]
pub(crate) struct About {
    pub(crate) run: String,
    pub(crate) scenario: String,
    pub(crate) variant: String,
    pub(crate) dt: f64,
    pub(crate) periods: u64,
    pub(crate) processes: usize,
    /// Names of the participants.
    pub(crate) participants: Vec<String>,
}

/// Serves the socket until it is dropped.
pub(crate) struct Server {
    path: PathBuf,
    end: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Starts to listen in the directory of a run.
    pub(crate) fn start(directory: &Path, about: About, stop: Stop, gauge: Gauge) -> io::Result<Self> {
        let path = directory.join(SOCKET);
        let listener = UnixListener::bind(&path)?;
        fs::set_permissions(&path, Permissions::from_mode(0o600))?;
        let end = Arc::new(AtomicBool::new(false));
        let desk = Desk { about, stop, gauge, start: Instant::now() };
        let ended = end.clone();
        let serve = move || {
            for stream in listener.incoming() {
                if ended.load(SeqCst) {
                    return;
                }
                // A client that goes away in the middle has its own reasons.
                let _ = stream.and_then(|stream| desk.serve(stream));
            }
        };
        let thread = thread::Builder::new().name("control".into()).spawn(serve)?;
        Ok(Self { path, end, thread: Some(thread) })
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.end.store(true, SeqCst);
        // Wakes the thread; if that is not possible, it ends with the process.
        if UnixStream::connect(&self.path).is_ok()
            && let Some(thread) = self.thread.take()
        {
            let _ = thread.join();
        }
        let _ = fs::remove_file(&self.path);
    }
}

struct Desk {
    about: About,
    stop: Stop,
    gauge: Gauge,
    start: Instant,
}

impl Desk {
    fn serve(&self, stream: UnixStream) -> io::Result<()> {
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let mut line = String::new();
        BufReader::new(io::Read::take(&stream, LONGEST_LINE)).read_line(&mut line)?;
        if let Some(text) = line.trim().strip_prefix("swap ") {
            return self.swap(&stream, text);
        }
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["pause"] => self.stop.pause(),
            ["resume"] => self.stop.resume(),
            ["stop"] => self.stop.request(),
            ["estop"] => self.stop.emergency(),
            ["status"] => {}
            ["step", count] => match count.parse() {
                Ok(steps) => self.stop.advance(steps),
                Err(_) => return answer(&stream, &json!({"error": "expected a number of steps"})),
            },
            _ => {
                let expected = "expected pause, resume, step N, swap NODE=COMMAND, stop, estop or status";
                return answer(&stream, &json!({ "error": expected }));
            }
        }
        answer(&stream, &self.status())
    }

    fn swap(&self, stream: &UnixStream, text: &str) -> io::Result<()> {
        let names: Vec<&str> = self.about.participants.iter().map(String::as_str).collect();
        let (text, folder) = match text.rsplit_once(FOLDER_MARK) {
            Some((text, folder)) => (text, Some(Path::new(folder))),
            None => (text, None),
        };
        let swap = match Swap::parse(text, &names) {
            Ok(swap) if swap.robot().is_none() => folder.into_iter().fold(swap, Swap::meant_in),
            Ok(_) => return answer(stream, &json!({ "error": "a robot takes part from the start or not at all" })),
            Err(reason) => return answer(stream, &json!({ "error": reason })),
        };
        match self.stop.swap(swap).recv_timeout(SWAP_PATIENCE) {
            Ok(Ok(step)) => {
                let mut status = self.status();
                status["swapped_at"] = step.into();
                answer(stream, &status)
            }
            Ok(Err(reason)) => answer(stream, &json!({ "error": reason })),
            Err(_) => answer(stream, &json!({ "error": "the run has not come to its next step yet" })),
        }
    }

    fn status(&self) -> Value {
        let About { run, scenario, variant, dt, periods, processes, .. } = &self.about;
        let done = self.stop.steps_done();
        let snapshot = self.gauge.read();
        let workers: Vec<Value> = snapshot
            .workers
            .iter()
            .map(|worker| {
                json!({
                    "name": worker.name, "runs": worker.runs, "last": worker.last,
                    "compute_s": worker.compute.as_secs_f64(),
                    "waking_s": worker.waking.as_secs_f64(), "waiting_s": worker.waiting.as_secs_f64(),
                })
            })
            .collect();
        json!({
            "run": run, "scenario": scenario, "variant": variant, "pid": std::process::id(), "processes": processes,
            "paused": self.stop.is_paused(), "stopping": self.stop.is_requested(),
            "steps": done, "of": periods + 1, "dt": dt, "time": done as f64 * dt,
            "wall_s": self.start.elapsed().as_secs_f64(), "awaited": snapshot.awaited, "workers": workers,
        })
    }
}

fn answer(mut stream: &UnixStream, value: &Value) -> io::Result<()> {
    stream.write_all(format!("{value}\n").as_bytes())
}

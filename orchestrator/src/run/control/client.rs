//! Asking a run through its control socket. Nothing here needs the lock of the directory of all runs.

use std::io::{self, BufRead, BufReader, ErrorKind, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use processes::RunDirectory;
use rustix::net::sockopt::{Timeout, set_socket_timeout, socket_peercred};
use rustix::net::{AddressFamily, SocketAddrUnix, SocketFlags, SocketType, connect, socket_with};

use super::message::{Answer, Request, Status};
use super::server::{SOCKET, SWAP_PATIENCE};
use crate::unanswered::{PATIENCE, Unanswered};

/// How long a run that has just begun may take until it can be asked.
const START_PATIENCE: Duration = Duration::from_secs(2);
/// Time between two attempts to ask it.
const RETRY: Duration = Duration::from_millis(10);

/// Asks a run for something and returns its status after that.
///
/// # Errors
/// [`Unanswered`].
pub(crate) fn ask(run: &str, request: &Request) -> Result<Status, Unanswered> {
    let name = || run.to_string();
    let system = |source| Unanswered::System { run: name(), source };
    let stream = reach(run)?;
    // Before anything is sent: the run may be over when the answer is missing.
    let pid = socket_peercred(&stream).ok().map(|peer| peer.pid.as_raw_nonzero().get());
    let patience = if matches!(request, Request::Swap(..)) { SWAP_PATIENCE + PATIENCE } else { PATIENCE };
    stream.set_read_timeout(Some(patience)).map_err(system)?;
    let mut line = String::new();
    let sent = (&stream).write_all(format!("{request}\n").as_bytes());
    match sent.and_then(|()| BufReader::new(&stream).read_line(&mut line)) {
        Ok(0) => return Err(closed(run)),
        Ok(_) => {}
        Err(error) if is_late(&error) => return Err(silent(run, pid)),
        Err(error) if has_hung_up(&error) => return Err(closed(run)),
        Err(error) => return Err(system(error)),
    }
    match serde_json::from_str(&line).map_err(|error| system(error.into()))? {
        Answer::Status(status) => Ok(*status),
        Answer::Error { error } => Err(Unanswered::Refused { run: name(), reason: error }),
    }
}

/// Connects to the control socket of a run, which may not be there yet.
fn reach(run: &str) -> Result<UnixStream, Unanswered> {
    let path = RunDirectory::path_of(run).join(SOCKET);
    let start = Instant::now();
    loop {
        match open(&path) {
            Ok(stream) => return Ok(stream),
            Err(error) if is_late(&error) => return Err(silent(run, None)),
            Err(error) if error.kind() == ErrorKind::NotFound || has_hung_up(&error) => {
                if start.elapsed() > START_PATIENCE || !is_there(run) {
                    return Err(closed(run));
                }
                thread::sleep(RETRY);
            }
            Err(source) => return Err(Unanswered::System { run: run.into(), source }),
        }
    }
}

/// As [`UnixStream::connect`], which waits for ever if too many others wait for a process that is stopped.
fn open(path: &Path) -> io::Result<UnixStream> {
    let socket = socket_with(AddressFamily::UNIX, SocketType::STREAM, SocketFlags::CLOEXEC, None)?;
    set_socket_timeout(&socket, Timeout::Send, Some(PATIENCE))?;
    connect(&socket, &SocketAddrUnix::new(path)?)?;
    Ok(socket.into())
}

fn is_there(run: &str) -> bool {
    // If that cannot be found out, the error of the connection is the one to be reported.
    RunDirectory::list().is_ok_and(|runs| runs.iter().any(|name| name == run))
}

fn is_late(error: &io::Error) -> bool {
    [ErrorKind::WouldBlock, ErrorKind::TimedOut].contains(&error.kind())
}

fn has_hung_up(error: &io::Error) -> bool {
    [ErrorKind::ConnectionRefused, ErrorKind::ConnectionReset, ErrorKind::BrokenPipe].contains(&error.kind())
}

fn closed(run: &str) -> Unanswered {
    if is_there(run) { Unanswered::Closed(run.into()) } else { Unanswered::Over(run.into()) }
}

/// A run that keeps silent: stopped, or short of processor time.
fn silent(run: &str, pid: Option<i32>) -> Unanswered {
    let run = run.to_string();
    match pid.filter(|&pid| is_stopped(pid)) {
        Some(pid) => Unanswered::Stopped { run, pid },
        None => Unanswered::Silent { run, pid },
    }
}

/// Whether the kernel says that a process is stopped.
fn is_stopped(pid: i32) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    // The name is in brackets and may itself contain any character.
    let state = stat.rsplit_once(") ").and_then(|(_, rest)| rest.chars().next());
    matches!(state, Some('T' | 't'))
}

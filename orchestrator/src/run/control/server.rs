//! The control socket of a run.
//!
//! One thread serves all clients at once and never waits for any of them, nor for the run: an emergency stop, a stop and a
//! status are answered by this thread alone. A client that keeps silent, sends its request byte by byte or does not read its
//! answer loses its connection after [`PATIENCE`], or earlier if others come.

mod client;

use std::fs::{self, Permissions};
use std::io::{self, ErrorKind};
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::UnixListener;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, OnceLock};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use processes::Statistics;
use rustix::event::{EventfdFlags, PollFd, PollFlags, Timespec, eventfd, poll};

use super::RunControl;
use super::message::{Answer, Request, State, Status, WorkerStatus};
use crate::run::swap::Swap;
use client::{Client, Step};

/// Its name in the run directory.
pub(crate) const SOCKET: &str = "control.sock";
/// How long a client may take to send its request, and to read its answer.
const PATIENCE: Duration = Duration::from_secs(2);
/// How long a client may wait until the program that it has asked for plays.
pub(crate) const SWAP_PATIENCE: Duration = Duration::from_secs(60);
/// What it learns then.
const TOO_LONG: &str =
    "the program does not play yet, and the run waits for it; `phalanx ctl status` shows what becomes of it";
/// Clients that are served at once. One more takes the place of the one that has kept the server waiting for longest.
const MOST_CLIENTS: usize = 64;
/// How long to leave new clients alone when there is no file descriptor for them.
const SHORTAGE: Duration = Duration::from_millis(20);

/// What a status says about the run besides its counters.
#[derive(Clone, Debug)]
pub(crate) struct About {
    pub(crate) run: String,
    pub(crate) scenario: String,
    pub(crate) variant: String,
    pub(crate) dt: f64,
    pub(crate) periods: u64,
    pub(crate) processes: usize,
    /// Where its log will be, from the root; `None` if it is not recorded.
    pub(crate) log: Option<PathBuf>,
    /// Names of the participants.
    pub(crate) participants: Vec<String>,
}

/// Serves the socket until it is dropped, which takes no longer than the answer in progress.
pub(crate) struct Server {
    path: PathBuf,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// What the server's thread shares with others.
struct Shared {
    end: AtomicBool,
    /// Wakes the thread.
    bell: OwnedFd,
    /// The counters of the run, once its processes are there.
    statistics: OnceLock<Statistics>,
}

impl Shared {
    fn ring(&self) {
        // It fails only if it was rung 2^64 times and not heard.
        let _ = rustix::io::write(&self.bell, &1u64.to_ne_bytes());
    }
}

impl Server {
    /// Starts to listen in the directory of a run.
    ///
    /// # Errors
    /// Of the operating system; a run without a server cannot be controlled, but runs.
    pub(crate) fn start(directory: &Path, about: About, stop: RunControl) -> io::Result<Self> {
        let path = directory.join(SOCKET);
        let listener = UnixListener::bind(&path)?;
        fs::set_permissions(&path, Permissions::from_mode(0o600))?;
        listener.set_nonblocking(true)?;
        let bell = eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?;
        let shared = Arc::new(Shared { end: AtomicBool::new(false), bell, statistics: OnceLock::new() });
        let handler = RequestHandler { about, stop, shared: shared.clone(), start: Instant::now() };
        let (done, results) = channel();
        let hall = Hall { listener, handler, clients: Vec::new(), next: 0, done, results, closed_until: None };
        let thread = thread::Builder::new().name("control".into()).spawn(move || hall.serve())?;
        Ok(Self { path, shared, thread: Some(thread) })
    }

    /// The processes are there: from now on a status has their counters.
    pub(crate) fn attach(&self, statistics: Statistics) {
        // A run has one set of processes.
        let _ = self.shared.statistics.set(statistics);
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.shared.end.store(true, SeqCst);
        self.shared.ring();
        if let Some(thread) = self.thread.take() {
            // A panic in it has been printed.
            let _ = thread.join();
        }
        // It went with the directory of the run if that is removed already.
        let _ = fs::remove_file(&self.path);
    }
}

/// The clients, and what serves them.
struct Hall {
    listener: UnixListener,
    handler: RequestHandler,
    clients: Vec<Client>,
    /// The number of the next client.
    next: u64,
    done: Sender<(u64, Answer)>,
    /// What became of swaps, with the numbers of the clients that asked.
    results: Receiver<(u64, Answer)>,
    /// Until when no client is accepted, since there are no file descriptors.
    closed_until: Option<Instant>,
}

impl Hall {
    fn serve(mut self) {
        while !self.handler.shared.end.load(SeqCst) {
            let ready = self.wait();
            if ready.bell {
                // Read to be silent again; how often it was rung does not matter.
                let _ = rustix::io::read(&self.handler.shared.bell, &mut [0; 8]);
            }
            self.pass_results_on();
            self.attend(&ready.clients);
            if ready.newcomers {
                self.let_in();
            }
            self.send_away();
        }
        self.handler.stop.refuse_swaps();
        self.pass_results_on();
    }

    /// Waits until there is something to be done.
    fn wait(&mut self) -> Ready {
        let now = Instant::now();
        self.closed_until = self.closed_until.filter(|until| *until > now);
        let deadlines = self.clients.iter().map(|client| client.deadline).chain(self.closed_until);
        let patience = deadlines.min().map(|deadline| timespec(deadline.saturating_duration_since(now)));
        let mut files = vec![PollFd::new(&self.handler.shared.bell, PollFlags::IN)];
        let door = if self.closed_until.is_none() { PollFlags::IN } else { PollFlags::empty() };
        files.push(PollFd::new(&self.listener, door));
        files.extend(
            self.clients.iter().map(|client| PollFd::from_borrowed_fd(client.stream.as_fd(), client.interest())),
        );
        if poll(&mut files, patience.as_ref()).is_err() {
            return Ready::default();
        }
        let mut happened = files.iter().map(|file| !file.revents().is_empty());
        let (bell, newcomers) = (happened.next() == Some(true), happened.next() == Some(true));
        Ready { bell, newcomers, clients: happened.collect() }
    }

    /// Serves the clients that have sent something, or that can take more of their answers.
    fn attend(&mut self, ready: &[bool]) {
        let mut ready = ready.iter().copied();
        let (handler, done) = (&self.handler, &self.done);
        self.clients.retain_mut(|client| ready.next() != Some(true) || proceed(client, handler, done));
    }

    /// Accepts all clients that wait.
    fn let_in(&mut self) {
        // As many as there is room for; then the connected clients come first.
        for _ in 0..MOST_CLIENTS {
            match self.listener.accept() {
                Ok((stream, _)) => {
                    if self.clients.len() >= MOST_CLIENTS {
                        self.show_out();
                    }
                    let Ok(mut client) = Client::new(stream, self.next) else { continue };
                    self.next += 1;
                    // Mostly its request is there already.
                    if proceed(&mut client, &self.handler, &self.done) {
                        self.clients.push(client);
                    }
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => return,
                Err(_) => {
                    // Too few file descriptors, most likely: an idle client gives its own.
                    if !self.show_out() {
                        self.closed_until = Some(Instant::now() + SHORTAGE);
                        return;
                    }
                }
            }
        }
    }

    /// Closes the connection of a client: of one that has not said what it wants, if there is any; else of the oldest.
    fn show_out(&mut self) -> bool {
        let oldest = self.clients.iter().enumerate().min_by_key(|(_, client)| (client.is_waiting(), client.number));
        let Some(index) = oldest.map(|(index, _)| index) else { return false };
        self.clients.remove(index);
        true
    }

    /// Closes the connections of clients that take too long, and answers those whose swap waits for a program that does.
    fn send_away(&mut self) {
        let now = Instant::now();
        let late = || Answer::Error { error: TOO_LONG.into() };
        self.clients.retain_mut(|client| client.deadline > now || client.is_waiting() && client.answer(&late()));
    }

    /// Answers those whose swaps have come to something.
    fn pass_results_on(&mut self) {
        while let Ok((number, answer)) = self.results.try_recv() {
            if let Some(index) = self.clients.iter().position(|client| client.number == number)
                && !self.clients[index].answer(&answer)
            {
                self.clients.remove(index);
            }
        }
    }
}

/// Does what can be done for a client without waiting; `false` if that was all.
fn proceed(client: &mut Client, handler: &RequestHandler, done: &Sender<(u64, Answer)>) -> bool {
    match client.proceed() {
        Step::Pending => true,
        Step::Over => false,
        Step::Request(line) => match handler.carry_out(&line, client.number, done) {
            Some(answer) => client.answer(&answer),
            None => {
                client.wait_for_swap();
                true
            }
        },
    }
}

/// What is to be done.
#[derive(Default)]
struct Ready {
    bell: bool,
    newcomers: bool,
    /// Of each client, whether anything happened.
    clients: Vec<bool>,
}

/// Carries requests out.
struct RequestHandler {
    about: About,
    stop: RunControl,
    shared: Arc<Shared>,
    start: Instant,
}

impl RequestHandler {
    /// The answer to a request; `None` if it comes later, through `done`.
    fn carry_out(&self, line: &str, client: u64, done: &Sender<(u64, Answer)>) -> Option<Answer> {
        match line.parse() {
            Ok(Request::Pause) => self.stop.pause(),
            Ok(Request::Resume) => self.stop.resume(),
            Ok(Request::Step(steps)) => self.stop.advance(steps),
            Ok(Request::Stop) => self.stop.request(),
            Ok(Request::Estop) => self.stop.emergency(),
            Ok(Request::Status) => {}
            Ok(Request::Swap(text, folder)) => match self.swap(&text, folder.as_deref()) {
                Ok(swap) => {
                    self.ask_for(swap, client, done.clone());
                    return None;
                }
                Err(error) => return Some(Answer::Error { error }),
            },
            Err(error) => return Some(Answer::Error { error: error.to_string() }),
        }
        Some(Answer::Status(Box::new(self.status())))
    }

    fn swap(&self, text: &str, folder: Option<&Path>) -> Result<Swap, String> {
        let names: Vec<&str> = self.about.participants.iter().map(String::as_str).collect();
        let swap = Swap::parse(text, &names)?;
        if swap.robot().is_some() {
            return Err("a robot takes part from the start or not at all".into());
        }
        Ok(folder.into_iter().fold(swap, Swap::meant_in))
    }

    /// Asks the run for a swap; the answer comes when it is done, or when it is certain that it will not be.
    fn ask_for(&self, swap: Swap, client: u64, done: Sender<(u64, Answer)>) {
        let (about, stop, shared, start) = (self.about.clone(), self.stop.clone(), self.shared.clone(), self.start);
        self.stop.swap(swap, move |result| {
            let handler = RequestHandler { about, stop, shared, start };
            let answer = match result {
                Ok(step) => Answer::Status(Box::new(Status { swapped_at: Some(step), ..handler.status() })),
                Err(error) => Answer::Error { error },
            };
            // Without a server the client has gone, too.
            let _ = done.send((client, answer));
            handler.shared.ring();
        });
    }

    fn status(&self) -> Status {
        let About { run, scenario, variant, dt, periods, processes, log, .. } = self.about.clone();
        let steps = self.stop.steps_done();
        let (awaited, workers) = self
            .shared
            .statistics
            .get()
            .map(Statistics::read)
            .map_or_else(Default::default, |now| (now.awaited, now.workers));
        let workers = workers.into_iter().map(|worker| WorkerStatus {
            name: worker.name,
            runs: worker.runs,
            last: worker.last,
            compute_s: worker.compute.as_secs_f64(),
            waking_s: worker.waking.as_secs_f64(),
            waiting_s: worker.waiting.as_secs_f64(),
        });
        Status {
            run,
            scenario,
            variant,
            pid: std::process::id(),
            processes: processes as u64,
            state: self.state(),
            paused: self.stop.is_paused(),
            stopping: self.stop.is_requested(),
            steps,
            of: periods + 1,
            dt,
            time: steps as f64 * dt,
            wall_s: self.start.elapsed().as_secs_f64(),
            log,
            awaited,
            workers: workers.collect(),
            swapped_at: None,
        }
    }

    fn state(&self) -> State {
        if self.stop.is_requested() {
            State::Stopping
        } else if self.shared.statistics.get().is_none() {
            State::Starting
        } else if self.stop.is_swapping() {
            State::Swapping
        } else if self.stop.is_paused() {
            State::Paused
        } else {
            State::Running
        }
    }
}

fn timespec(duration: Duration) -> Timespec {
    // Rounded up, so that the deadline is over when the time is.
    let duration = duration + Duration::from_micros(1);
    Timespec { tv_sec: duration.as_secs() as i64, tv_nsec: duration.subsec_nanos().into() }
}

#[cfg(test)]
mod tests;

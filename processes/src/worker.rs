//! What a process of a run does: connect, then run its participants whenever a gate opens.

mod jitter;
mod link;
mod panics;
mod phase_share;
mod replacement;

use std::env;
use std::fmt::Display;
use std::os::fd::{BorrowedFd, FromRawFd, OwnedFd, RawFd};
use std::path::PathBuf;
use std::process::ExitCode;

pub use link::{DueNode, Link};
use replacement::CatchUp;
pub use replacement::Replacement;
pub(crate) use replacement::{REPLACEMENT, ReplacementOrder};
use rustix::io::{FdFlags, fcntl_getfd, fcntl_setfd};

use crate::board::Boards;
use crate::service::ServiceError;
use phase_share::PhaseShare;

use crate::page::{Events, FaultKind, Page, Report};
use lockstep::{Fault, Participant, Plan, Wake};

/// Environment variable with the path of the run directory.
pub(crate) const RUN_DIRECTORY: &str = "PHALANX_RUN_DIR";
/// Environment variable with the number of the worker.
pub(crate) const WORKER: &str = "PHALANX_WORKER";
/// Environment variable with the file descriptor of the shared page.
pub(crate) const PAGE_FD: &str = "PHALANX_PAGE_FD";

/// Exit code of a process that was not given a place in a run.
const NOT_A_WORKER: u8 = 2;

/// Serves as the worker process that a [`Conductor`](crate::Conductor) spawned: the whole `main` of such a program.
///
/// `build` is given the plan and the numbers of the nodes to host, and returns their participants in the same order, or says
/// why it cannot.
///
/// The exit code is 0 after the last step or when the conductor ended the run, and 1 if the conductor was told what went
/// wrong: a refusal of `build`, a service that cannot be opened, a fault or a panic of a participant. It is 2, with a line on
/// stderr, if the process was not spawned by a conductor.
pub fn serve<F>(build: F) -> ExitCode
where
    F: FnOnce(&Plan, &[usize]) -> Result<Vec<Box<dyn Participant>>, String>,
{
    let worker = match Worker::join() {
        Ok(worker) => worker,
        Err(reason) => {
            eprintln!("{reason}");
            return ExitCode::from(NOT_A_WORKER);
        }
    };
    match work(worker, build) {
        Ok(()) => ExitCode::SUCCESS,
        // The conductor has been told.
        Err(Fault(_)) => ExitCode::FAILURE,
    }
}

fn work<F>(worker: Worker, build: F) -> Result<(), Fault>
where
    F: FnOnce(&Plan, &[usize]) -> Result<Vec<Box<dyn Participant>>, String>,
{
    panics::remember_those_of_this_thread();
    if worker.holds() {
        let ended = worker.connect()?.next()?;
        debug_assert!(ended.is_none(), "a process that holds its samples has no nodes to run");
        return Ok(());
    }
    let built = panics::catch(|| build(worker.plan(), worker.nodes())).and_then(|result| result);
    let mut participants = built.map_err(|reason| worker.refuse(reason))?;
    let (built, wanted) = (participants.len(), worker.nodes().len());
    if built != wanted {
        return Err(worker.refuse(format!("{built} participants were built for {wanted} nodes")));
    }
    let mut link = worker.connect()?;
    while let Some(due) = link.next()? {
        let participant = &mut participants[due.number];
        let Some(mut io) = link.io() else { break };
        let computed = panics::catch(|| participant.step(&due.step, &mut io));
        match computed.and_then(|result| result.map_err(|fault| fault.0)) {
            Ok(()) => link.done()?,
            Err(message) => return Err(link.fail(message)),
        }
    }
    Ok(())
}

/// A process that has no place in a run.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not a worker of a run: {0}")]
pub struct NotAWorker(pub String);

/// This process's place in a run, for programs that ask for their steps; [`serve`] is for those that are called.
///
/// ```no_run
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let worker = processes::Worker::join()?;
/// let mut link = worker.connect()?;
/// while let Some(due) = link.next()? {
///     if let Some(io) = link.io() { /* read, compute, write */ }
///     link.done()?;
/// }
/// # Ok(())
/// # }
/// ```
pub struct Worker {
    directory: PathBuf,
    plan: Plan,
    number: usize,
    page: Page,
    /// Set if it takes the place of another process.
    order: Option<ReplacementOrder>,
}

impl Worker {
    /// Finds the place that the conductor gave this process, and reads the plan of the run. To be called once.
    ///
    /// # Errors
    /// [`NotAWorker`] if the process was not spawned by a conductor.
    pub fn join() -> Result<Self, NotAWorker> {
        Self::find().map_err(NotAWorker)
    }

    fn find() -> Result<Self, String> {
        let directory = PathBuf::from(variable(RUN_DIRECTORY)?);
        let plan = Plan::read(&directory).map_err(|error| error.to_string())?;
        let number: usize = self::number(WORKER)?;
        if number >= plan.workers.len() {
            return Err(format!("{WORKER} is {number}, but the run has {} workers", plan.workers.len()));
        }
        let page = adopt(self::number(PAGE_FD)?).and_then(|file| Page::open(file, &plan));
        let page = page.map_err(|error| format!("{PAGE_FD} is not the page of the run: {error}"))?;
        page.take_place(number, std::process::id()).map_err(|other| {
            let name = &plan.workers[number].name;
            format!("process {other} is {name} of this run already; {name} was started twice")
        })?;
        Ok(Self { directory, plan, number, page, order: ReplacementOrder::find()? })
    }

    /// What every process of the run knows.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The numbers of the nodes that this process hosts.
    pub fn nodes(&self) -> &[usize] {
        &self.plan.workers[self.number].nodes
    }

    /// Whether this process only holds the last samples of one that has failed: it has no nodes to run.
    pub fn holds(&self) -> bool {
        self.order.is_some_and(|order| order.replacement == Replacement::Hold)
    }

    /// Opens all channels and tells the conductor that this process is ready; one that takes the place of another process
    /// does so as soon as it has caught up.
    ///
    /// # Errors
    /// A service that cannot be opened. The conductor has been told.
    pub fn connect(self) -> Result<Link, Fault> {
        match self.open() {
            Ok((boards, replacements, shares, catch_up)) => Ok(Link::new(self, boards, replacements, shares, catch_up)),
            Err(reason) => Err(self.refuse(reason)),
        }
    }

    fn open(&self) -> Result<(Boards, u32, Vec<PhaseShare>, Option<CatchUp>), String> {
        let (plan, page) = (&self.plan, &self.page);
        let failed = |error: ServiceError| error.to_string();
        let boards = Boards::join(&self.directory, &plan.run, &plan.workers[self.number].name).map_err(failed)?;
        if plan.wake == Wake::Events {
            page.use_events(Some(Events::join(&self.directory, plan, self.number).map_err(failed)?));
        }
        // Noted before the look at which process serves as which worker, so that a later replacement is noticed.
        let replacements = page.replacements();
        let incarnation = self.order.map_or(0, |order| order.incarnation);
        let shares = phase_share::take(plan, self.number, incarnation, &boards, page).map_err(failed)?;
        let catch_up = self.order.map(|order| CatchUp::open(self, order, &boards, &shares)).transpose()?;
        Ok((boards, replacements, shares, catch_up))
    }

    /// Tells the conductor why this process cannot start; it should end after that. Returns the reason.
    pub fn refuse(&self, reason: impl Display) -> Fault {
        let message = reason.to_string();
        self.leave(Report { kind: FaultKind::Refusal, node: 0, step: 0, message })
    }

    /// Leaves a report for the conductor and returns its message.
    fn leave(&self, report: Report) -> Fault {
        self.page.leave(self.number, &report);
        Fault(report.message)
    }
}

fn variable(name: &str) -> Result<String, String> {
    env::var(name).map_err(|error| format!("{name}: {error}"))
}

fn number<N: std::str::FromStr<Err: Display>>(name: &str) -> Result<N, String> {
    variable(name)?.parse().map_err(|error| format!("{name}: {error}"))
}

/// Takes over an inherited file descriptor, and keeps it from programs that a participant may start.
fn adopt(number: RawFd) -> std::io::Result<OwnedFd> {
    if number < 0 {
        return Err(std::io::ErrorKind::InvalidInput.into());
    }
    // SAFETY: only asked whether it is open, which the kernel answers for any number.
    let flags = fcntl_getfd(unsafe { BorrowedFd::borrow_raw(number) })?;
    // SAFETY: it is open, and it was handed to this process to be its page; nothing else in it uses that number.
    let file = unsafe { OwnedFd::from_raw_fd(number) };
    fcntl_setfd(&file, flags | FdFlags::CLOEXEC)?;
    Ok(file)
}

//! What a process of a run does: connect, then run its participants whenever a gate opens.

mod comeback;
mod jitter;
mod panics;
mod seat;

use std::env;
use std::fmt::Display;
use std::os::fd::{BorrowedFd, FromRawFd, OwnedFd, RawFd};
use std::path::PathBuf;
use std::process::ExitCode;

pub use comeback::Comeback;
pub(crate) use comeback::{COMEBACK, Orders};
use jitter::Jitter;
use rustix::io::{FdFlags, fcntl_getfd, fcntl_setfd};

use crate::board::Hub;
use crate::page::{FaultKind, Page, Report, Watch};
use crate::{Participant, Plan, Step, Store};

/// Environment variable with the path of the run directory.
pub(crate) const RUN_DIRECTORY: &str = "PHALANX_RUN_DIR";
/// Environment variable with the number of the worker.
pub(crate) const WORKER: &str = "PHALANX_WORKER";
/// Environment variable with the file descriptor of the shared page.
pub(crate) const PAGE_FD: &str = "PHALANX_PAGE_FD";

/// Exit code of a process that nobody gave a place in a run.
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
    let post = match Post::find() {
        Ok(post) => post,
        Err(reason) => {
            eprintln!("not a worker of a run: {reason}");
            return ExitCode::from(NOT_A_WORKER);
        }
    };
    match post.work(build) {
        Ok(()) => ExitCode::SUCCESS,
        Err(report) => {
            post.page.leave(post.worker, &report);
            ExitCode::FAILURE
        }
    }
}

/// This process's place in a run.
struct Post {
    directory: PathBuf,
    plan: Plan,
    worker: usize,
    page: Page,
    /// Set if it takes the place of another process.
    orders: Option<Orders>,
}

impl Post {
    fn find() -> Result<Self, String> {
        let directory = PathBuf::from(variable(RUN_DIRECTORY)?);
        let plan = Plan::read(&directory).map_err(|error| error.to_string())?;
        let worker: usize = number(WORKER)?;
        if worker >= plan.workers.len() {
            return Err(format!("{WORKER} is {worker}, but the run has {} workers", plan.workers.len()));
        }
        let page = adopt(number(PAGE_FD)?).and_then(|file| Page::open(file, &plan));
        let page = page.map_err(|error| format!("{PAGE_FD} is not the page of the run: {error}"))?;
        Ok(Self { directory, plan, worker, page, orders: Orders::find()? })
    }

    fn participants<F>(&self, build: F) -> Result<Vec<Option<Box<dyn Participant>>>, Report>
    where
        F: FnOnce(&Plan, &[usize]) -> Result<Vec<Box<dyn Participant>>, String>,
    {
        let nodes = &self.plan.workers[self.worker].nodes;
        let built = panics::catch(|| build(&self.plan, nodes)).and_then(|result| result).map_err(refusal)?;
        if built.len() != nodes.len() {
            return Err(refusal(format!("{} participants were built for {} nodes", built.len(), nodes.len())));
        }
        Ok(built.into_iter().map(Some).collect())
    }

    fn work<F>(&self, build: F) -> Result<(), Report>
    where
        F: FnOnce(&Plan, &[usize]) -> Result<Vec<Box<dyn Participant>>, String>,
    {
        panics::remember_those_of_this_thread();
        let (plan, page, worker) = (&self.plan, &self.page, self.worker);
        let me = &plan.workers[worker];
        let orders = self.orders.as_ref();
        let participants = match orders {
            Some(Orders { comeback: Comeback::Hold, .. }) => me.nodes.iter().map(|_| None).collect(),
            _ => self.participants(build)?,
        };
        let hub = Hub::join(&self.directory, &plan.run, &me.name).map_err(refusal)?;
        let incarnation = orders.map_or(0, |orders| orders.incarnation);
        let mut changes = page.changes();
        let mut seats = seat::take(plan, worker, incarnation, (&hub, page), participants).map_err(refusal)?;
        let mut store = Store::new(plan.network.channels.iter().map(|channel| &channel.layout));
        let (mut first, mut skipped) = (0, 0);
        if let Some(orders) = orders {
            comeback::catch_up(plan, worker, orders, (&hub, page), (&mut seats, &mut store))?;
            page.take_over(worker, incarnation);
            (first, skipped) = (orders.step, orders.place);
        }
        let mut watch = Watch::new(worker, page);
        let mut jitter = Jitter::from_environment(worker);
        page.mark_ready(worker);
        for index in first..plan.steps {
            let step = Step { index, dt: plan.dt };
            for place in std::mem::take(&mut skipped)..seats.len() {
                if !page.await_gate(worker, seats[place].phase, index) {
                    return Ok(());
                }
                if page.changes() != changes {
                    // Noted before the look at who was replaced, so that whoever is later is noticed the next time.
                    changes = page.changes();
                    seat::follow(&hub, page, plan, &mut seats).map_err(refusal)?;
                }
                let seat = &mut seats[place];
                let start = watch.start(page, seat.phase);
                jitter.as_mut().map(Jitter::delay);
                seat.run(plan, &mut store, &step)?;
                let end = watch.end(page, seat.phase, index, start);
                let last = page.arrive(worker, seat.phase, seat.position, index);
                watch.arrived(page, seat.phase, end, last);
            }
        }
        Ok(())
    }
}

fn refusal(reason: impl Display) -> Report {
    Report { kind: FaultKind::Refusal, node: 0, step: 0, message: reason.to_string() }
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
    // SAFETY: it is open, and it was handed to this process to be its page; nobody else here knows of it.
    let file = unsafe { OwnedFd::from_raw_fd(number) };
    fcntl_setfd(&file, flags | FdFlags::CLOEXEC)?;
    Ok(file)
}

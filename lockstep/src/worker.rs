//! What a process of a run does: connect, then run its participants whenever a gate opens.

mod jitter;
mod panics;
mod seat;

use std::env;
use std::fmt::Display;
use std::os::fd::{BorrowedFd, FromRawFd, OwnedFd, RawFd};
use std::path::PathBuf;
use std::process::ExitCode;

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
        Ok(Self { directory, plan, worker, page })
    }

    fn work<F>(&self, build: F) -> Result<(), Report>
    where
        F: FnOnce(&Plan, &[usize]) -> Result<Vec<Box<dyn Participant>>, String>,
    {
        panics::remember_those_of_this_thread();
        let plan = &self.plan;
        let me = &plan.workers[self.worker];
        let participants = panics::catch(|| build(plan, &me.nodes)).and_then(|result| result).map_err(refusal)?;
        if participants.len() != me.nodes.len() {
            let (built, wanted) = (participants.len(), me.nodes.len());
            return Err(refusal(format!("{built} participants were built for {wanted} nodes")));
        }
        let hub = Hub::join(&self.directory, &plan.run, &me.name).map_err(refusal)?;
        let mut seats = seat::take(plan, self.worker, &hub, participants).map_err(refusal)?;
        let mut store = Store::new(plan.network.channels.iter().map(|channel| &channel.layout));
        let mut watch = Watch::new(self.worker);
        let mut jitter = Jitter::from_environment(self.worker);
        self.page.mark_ready(self.worker);
        for index in 0..plan.steps {
            let step = Step { index, dt: plan.dt };
            for seat in &mut seats {
                if !self.page.await_gate(seat.phase, index) {
                    return Ok(());
                }
                let start = watch.start(&self.page, seat.phase);
                jitter.as_mut().map(Jitter::delay);
                seat.run(plan, &mut store, &step)?;
                let end = watch.end(&self.page, seat.phase, index, start);
                let last = self.page.arrive(seat.phase, seat.position, index);
                watch.arrived(&self.page, seat.phase, end, last);
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
